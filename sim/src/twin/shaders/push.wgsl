// Gives each finer texel what it lacks in confidence from the filled coarser level, weights
// 9, 3, 3, 1. Twin of fill::push_level and of Fixed::push. Where the coarsest texel knows nothing,
// nothing is pushed.

@group(0) @binding(3) var<storage, read_write> texels: array<Texel>;

fn coarser(x: u32, y: u32) -> Texel {
    return texels[level.coarse_first + y * level.coarse_columns + x];
}

// The coarse neighbour on the side of fine index i, clamped.
fn beside(i: u32, len: u32) -> u32 {
    let near = i / 2u;
    if i % 2u == 0u { return max(near, 1u) - 1u; }
    return min(near + 1u, len - 1u);
}

fn push(fine: Texel, coarse: array<Texel, 4>) -> Texel {
    let own = confidence_of(fine);
    if own >= ONE { return fine; }
    let sum = 9u * light_of(coarse[0])
        + 3u * light_of(coarse[1])
        + 3u * light_of(coarse[2])
        + light_of(coarse[3]);
    let around = (sum + 8u) >> vec3<u32>(4u);
    let light = (own * light_of(fine) + (ONE - own) * around + (ONE >> 1u)) >> vec3<u32>(15u);
    return texel(light, ONE);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= level.fine_columns * level.fine_rows || confidence_of(texels[level.top]) == 0u {
        return;
    }
    let x = i % level.fine_columns;
    let y = i / level.fine_columns;
    let far_x = beside(x, level.coarse_columns);
    let far_y = beside(y, level.coarse_rows);
    let at = level.fine_first + i;
    texels[at] = push(texels[at], array<Texel, 4>(
        coarser(x / 2u, y / 2u),
        coarser(far_x, y / 2u),
        coarser(x / 2u, far_y),
        coarser(far_x, far_y),
    ));
}
