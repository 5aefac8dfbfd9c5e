// Light, filtered or averaged, to the panel's codes; pixels of which nothing is known keep what they
// show. Twin of Display::encode and rest::blend.

@group(0) @binding(2) var<storage, read> texels: array<Texel>;
// Red, green, blue in the bytes of a word, red lowest.
@group(0) @binding(3) var<storage, read_write> picture: array<u32>;
@group(0) @binding(4) var<storage, read> means: array<Mean>;

fn code(light: u32) -> u32 {
    if params.encoded != 0u { return ((light + 128u) / 257u) & 0xffu; }
    return linear_to_srgb(light);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= pixels() { return; }
    let known = confidence_of(texels[i]) != 0u;
    var mean = Mean(0u);
    if params.averages != 0u { mean = means[i]; }
    if !known && mean.w == 0u { return; }
    var light = light_of(texels[i]);
    if !known {
        light = mean.xyz / vec3<u32>(mean.w);
    } else if mean.w != 0u {
        light = (mean.xyz + PRIOR * light) / vec3<u32>(mean.w + PRIOR);
    }
    picture[i] = code(light.x) | (code(light.y) << 8u) | (code(light.z) << 16u);
}
