// Twin of unframed_recon::arith::Texel: light and confidence as 16 bits each, red and green in the
// first word, blue and confidence in the second.

alias Texel = vec2<u32>;

// Weight at which a pixel is known well enough: 0.3.
const ENOUGH: u32 = 9830u;

fn texel(light: vec3<u32>, confidence: u32) -> Texel {
    return Texel(pack16(light.x, light.y), pack16(light.z, confidence));
}

fn light_of(t: Texel) -> vec3<u32> { return vec3<u32>(low16(t.x), t.x >> 16u, low16(t.y)); }
fn confidence_of(t: Texel) -> u32 { return t.y >> 16u; }

// A light of 15 fractional bits, rounded and clamped.
fn to_light(v: W64) -> u32 {
    return u32(clamp(w64_clamp_i32(w64_shr_round_i(v, 15u)), 0i, 65535i));
}

// min(1, weight/0.3).
fn confidence(weight: W64) -> u32 {
    let narrow = select(min(weight.x, ENOUGH), ENOUGH, weight.y != 0u);
    return (narrow * ONE) / ENOUGH;
}
