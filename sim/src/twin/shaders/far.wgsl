// Minima start from the farthest depth there is. Twin of the fill in hidden::nearest.

@group(0) @binding(2) var<storage, read_write> minima: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i < pixels() { minima[i] = 65535u; }
}
