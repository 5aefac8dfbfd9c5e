// Makes each coarser texel the confidence-weighted mean of four finer ones. Twin of one round of
// fill::pull_level and of Fixed::pull.

@group(0) @binding(3) var<storage, read_write> texels: array<Texel>;

fn finer(x: u32, y: u32) -> Texel {
    if x >= level.fine_columns || y >= level.fine_rows { return Texel(0u, 0u); }
    return texels[level.fine_first + y * level.fine_columns + x];
}

fn pull(children: array<Texel, 4>) -> Texel {
    var total = 0u;
    for (var k = 0u; k < 4u; k++) { total += confidence_of(children[k]); }
    if total == 0u { return Texel(0u, 0u); }
    let d = divider(w64_from_u32(total));
    var light: vec3<u32>;
    for (var c = 0u; c < 3u; c++) {
        var sum = W64(0u, 0u);
        for (var k = 0u; k < 4u; k++) {
            // Below 2^31 each.
            let share = light_of(children[k])[c] * confidence_of(children[k]);
            sum = w64_add(sum, w64_from_u32(share));
        }
        light[c] = to_light(w64_from_i32(ratio(d, sum, 16i)));
    }
    return texel(light, min(total, ONE));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= level.coarse_columns * level.coarse_rows { return; }
    let x = 2u * (i % level.coarse_columns);
    let y = 2u * (i / level.coarse_columns);
    texels[level.coarse_first + i] = pull(array<Texel, 4>(
        finer(x, y),
        finer(x + 1u, y),
        finer(x, y + 1u),
        finer(x + 1u, y + 1u),
    ));
}
