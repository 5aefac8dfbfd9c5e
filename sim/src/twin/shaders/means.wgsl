// Solves every pixel by its mean. Twin of solve::means.

@group(0) @binding(2) var<storage, read> sums: array<array<W64, 4>>;
@group(0) @binding(3) var<storage, read_write> texels: array<Texel>;

fn mean(s: array<W64, 4>) -> Texel {
    if w64_is_negative(s[0]) || w64_eq(s[0], W64(0u, 0u)) { return Texel(0u, 0u); }
    let d = divider(s[0]);
    return texel(
        vec3<u32>(
            to_light(w64_from_i32(ratio(d, s[1], 16i))),
            to_light(w64_from_i32(ratio(d, s[2], 16i))),
            to_light(w64_from_i32(ratio(d, s[3], 16i))),
        ),
        confidence(s[0]),
    );
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i < pixels() { texels[i] = mean(sums[i]); }
}
