// Minima of a coarser level from a finer one: of 2 pixels from pixels, of 4 from 2. Twin of the
// first half of hidden::limits.

@group(0) @binding(3) var<storage, read_write> minima: array<u32>;

// Deeper than anything.
const FAR: u32 = 65535u;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= level.coarse_columns * level.coarse_rows { return; }
    let left = (i % level.coarse_columns) * level.side;
    let top = (i / level.coarse_columns) * level.side;
    let right = min(left + level.side, level.fine_columns);
    let bottom = min(top + level.side, level.fine_rows);
    var cell = FAR;
    for (var row = top; row < bottom; row++) {
        for (var column = left; column < right; column++) {
            cell = min(cell, minima[level.fine_first + row * level.fine_columns + column]);
        }
    }
    minima[level.coarse_first + i] = cell;
}
