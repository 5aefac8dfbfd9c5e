// Takes the weight of hidden samples and counts the others a pixel. Twin of Display::drop_hidden;
// the counts are the first step of sorting by pixel, which gathering needs and scattering does
// not.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read_write> projected: array<Projected>;
@group(0) @binding(4) var<storage, read> limits: array<u32>;
// All zero before.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= ring.len { return; }
    let sample = projected[i];
    if (sample.depth_weight >> 16u) == 0u { return; }
    let x = pixel(low16(sample.at));
    let y = pixel(sample.at >> 16u);
    let depth = low16(sample.depth_weight);
    if params.hidden != 0u && limits[nearest_pixel(x, y)] < depth {
        projected[i].depth_weight = depth;
        return;
    }
    atomicAdd(&counts[bin_at(x, y)], 1u);
}
