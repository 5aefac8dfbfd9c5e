// Nearest depth of each pixel: the first level of minima. Twin of hidden::nearest; the buffer
// was filled with FAR.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read> projected: array<Projected>;
@group(0) @binding(4) var<storage, read_write> minima: array<atomic<u32>>;

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
    let inside = x >= 0i && x < params.width && y >= 0i && y < params.height;
    if !inside { return; }
    atomicMin(&minima[nearest_pixel(x, y)], low16(sample.depth_weight));
}
