// How far to each side of a pixel's column the samples of one row are worth looking at: some bin
// so far away has a reach that long. 0 for none, else the distance in pixels and 1.

@group(0) @binding(2) var<storage, read> reaches: array<u32>;
@group(0) @binding(3) var<storage, read_write> rows: array<u32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= u32(bin_columns() * bin_rows()) { return; }
    let x = i32(i) % bin_columns();
    let y = i32(i) / bin_columns();
    var farthest = 0u;
    for (var away = -REACH; away <= REACH; away++) {
        let column = x + away;
        if column < 0i || column >= bin_columns() { continue; }
        let reach = reaches[y * bin_columns() + column];
        if reach > u32(abs(away)) { farthest = max(farthest, reach); }
    }
    rows[i] = farthest;
}
