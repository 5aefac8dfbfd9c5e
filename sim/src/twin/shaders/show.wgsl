// A pixel shows the sample that claimed it: second half of Mode::Newest.

@group(0) @binding(2) var<storage, read> pending: array<Stored>;
@group(0) @binding(3) var<storage, read> claims: array<u32>;
@group(0) @binding(4) var<storage, read_write> picture: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= pixels() || claims[i] == 0u { return; }
    let code = rgb(pending[claims[i] - 1u]);
    picture[i] = code.x | (code.y << 8u) | (code.z << 16u);
}
