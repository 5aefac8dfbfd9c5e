// Before the new samples are averaged: what changed is forgotten, what is full makes room.
// Twin of unframed_recon::rest::prepare.

@group(0) @binding(2) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> means: array<Mean>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= pixels() { return; }
    let x = i32(i) % params.width;
    let y = i32(i) / params.width;
    if !rests(cells[cell_of(x, y)]) {
        means[i] = Mean(0u);
    } else if means[i].w >= FULL {
        means[i] = means[i] / vec4<u32>(2u);
    }
}
