// The newest of the samples that fell into a pixel claims it: first half of Mode::Newest.

@group(0) @binding(2) var<uniform> items: vec4<u32>;
@group(0) @binding(3) var<storage, read> pending: array<Stored>;
@group(0) @binding(4) var<storage, read> placed: array<u32>;
// All zero before.
@group(0) @binding(5) var<storage, read_write> claims: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= items.x || placed[i] == 0u { return; }
    let at = pending[i].y;
    let pixel = (at >> 20u) * u32(params.width) + (low16(at) >> 4u);
    atomicMax(&claims[pixel], i + 1u);
}
