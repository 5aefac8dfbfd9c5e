// Marks the pixels within one pixel of a sample of a moving object. Twin of hidden::mark_movers.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read> samples: array<Stored>;
@group(0) @binding(4) var<storage, read> projected: array<Projected>;
// All zero before.
@group(0) @binding(5) var<storage, read_write> movers: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= ring.len { return; }
    let sample = projected[i];
    if (sample.depth_weight >> 16u) == 0u || slot(samples[i]) <= STATIC_SLOT { return; }
    let x = pixel(low16(sample.at));
    let y = pixel(sample.at >> 16u);
    for (var dy = -1i; dy <= 1i; dy++) {
        for (var dx = -1i; dx <= 1i; dx++) {
            atomicStore(&movers[nearest_pixel(x + dx, y + dy)], 1u);
        }
    }
}
