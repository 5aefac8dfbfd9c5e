// Samples' weights summed a pixel; those in the guard band belong to the border's pixels.
// Twin of splat::masses; saturated where it is read, in widths.wgsl.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read> projected: array<Projected>;
// Low and high half of 64 bits; all zero before.
@group(0) @binding(4) var<storage, read_write> mass: array<array<atomic<u32>, 2>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= ring.len { return; }
    let sample = projected[i];
    let weight = sample.depth_weight >> 16u;
    if weight == 0u { return; }
    let at = nearest_pixel(pixel(low16(sample.at)), pixel(sample.at >> 16u));
    let before = atomicAdd(&mass[at][0], weight);
    if before + weight < before { atomicAdd(&mass[at][1], 1u); }
}
