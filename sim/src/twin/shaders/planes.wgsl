// Solves every pixel by its plane. Twin of solve::planes and Fixed::plane.

@group(0) @binding(2) var<storage, read> sums: array<array<W64, 4>>;
@group(0) @binding(3) var<storage, read> moments: array<array<W64, 11>>;
@group(0) @binding(4) var<storage, read_write> texels: array<Texel>;

// The least ridge on the slopes, px² with 20 fractional bits: 0.02.
const RIDGE: u32 = 20972u;
// log2 of what of the offset's square is added: an eighth.
const LEAN_BITS: u32 = 3u;

fn average(d: Divider, v: W64, bits: i32) -> W64 { return w64_from_i32(ratio(d, v, bits)); }

// a·b − c·d
fn cross2(a: W64, b: W64, c: W64, d: W64) -> W64 {
    return w64_sub(w64_mul(a, b), w64_mul(c, d));
}

fn plane(s: array<W64, 4>, m: array<W64, 11>) -> Texel {
    if w64_is_negative(s[0]) || w64_eq(s[0], W64(0u, 0u)) { return Texel(0u, 0u); }
    let d = divider(s[0]);
    // Lights with 15 fractional bits; x, y in px with 20; squares in px² with 20.
    let x = w64_shr_i(average(d, m[0], 11i), 8u);
    let y = w64_shr_i(average(d, m[1], 11i), 8u);
    let offset2 = w64_add(w64_mul(x, x), w64_mul(y, y));
    let ridge = w64_add(w64_from_u32(RIDGE), w64_shr_i(offset2, 20u + LEAN_BITS));
    let xx2 = w64_shr_i(average(d, m[2], 22i), 5u);
    let xy2 = w64_shr_i(average(d, m[3], 22i), 5u);
    let yy2 = w64_shr_i(average(d, m[4], 22i), 5u);
    let xx = w64_add(w64_sub(xx2, w64_shr_i(w64_mul(x, x), 20u)), ridge);
    let xy = w64_sub(xy2, w64_shr_i(w64_mul(x, y), 20u));
    let yy = w64_add(w64_sub(yy2, w64_shr_i(w64_mul(y, y), 20u)), ridge);
    var determinant = cross2(xx, yy, xy, xy);
    let least = w64_from_u32(RIDGE * (RIDGE / 4u));
    if w64_lt_i(determinant, least) { determinant = least; }
    let by = divider(determinant);
    let hx = w64_shr_i(average(by, w64_shr_i(cross2(yy, x, xy, y), 12u), -4i), 11u);
    let hy = w64_shr_i(average(by, w64_shr_i(cross2(xx, y, xy, x), 12u), -4i), 11u);
    var light: vec3<u32>;
    for (var k = 0u; k < 3u; k++) {
        let c = average(d, s[k + 1u], 16i);
        let cx = w64_sub(average(d, m[k + 5u], 27i), w64_shr_i(w64_mul(c, x), 23u));
        let cy = w64_sub(average(d, m[k + 8u], 27i), w64_shr_i(w64_mul(c, y), 23u));
        let slope = w64_add(w64_mul(cx, hx), w64_mul(cy, hy));
        light[k] = to_light(w64_sub(c, w64_shr_i(slope, 9u)));
    }
    return texel(light, confidence(s[0]));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i < pixels() { texels[i] = plane(sums[i], moments[i]); }
}
