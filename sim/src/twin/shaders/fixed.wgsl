// Twin of unframed_recon::fixed: coordinates, projection, filter taps.

// Pixels around the panel in which a sample still reaches the picture.
const GUARD: i32 = 8i;
// How far from its centre a footprint can reach, pixels.
const REACH: i32 = 4i;
// log2 of the nearest depth that is told apart, world units.
const DEPTH_FIRST: i32 = 0i;
// Fractional bits of pixel distances.
const DISTANCE_BITS: u32 = 8u;

// View and pose composed, of one slot; twin of Transform in params.rs.
struct Transform {
    matrix: array<i32, 9>,
    exponent: i32,
    offset: array<vec2<u32>, 3>,
    // Whether there are a view and a pose to compose.
    known: u32,
    padding: u32,
}

// A stored sample, twin of unframed_recon::deep::Stored: a word each of time, the first two
// places, the third with red and green, blue with slot and placing.
alias Stored = vec4<u32>;

const PLACING_EMPTY: u32 = 0u;
const PLACING_LATTICE: u32 = 1u;
const PLACING_SCREEN: u32 = 2u;

// The slot of the static world; those of objects that move come after it.
const STATIC_SLOT: u32 = 1u;

fn placing(sample: Stored) -> u32 { return (sample.w >> 16u) & 0xffu; }
fn slot(sample: Stored) -> u32 { return (sample.w >> 8u) & 0xffu; }
fn rgb(sample: Stored) -> vec3<u32> {
    return vec3<u32>((sample.z >> 16u) & 0xffu, sample.z >> 24u, sample.w & 0xffu);
}
// Places as i16.
fn place(sample: Stored) -> vec3<i32> {
    let low = vec3<u32>(sample.y, sample.y >> 16u, sample.z) << vec3<u32>(16u);
    return bitcast<vec3<i32>>(low) >> vec3<u32>(16u);
}

// Microseconds from a sample to the refresh, by serial-number arithmetic.
fn since(sample: Stored) -> i32 { return bitcast<i32>(params.now - sample.x); }
// Samples from the future have age 0.
fn age(sample: Stored) -> u32 { return u32(max(since(sample), 0i)); }

// The ring's state: where the next sample goes, how many there are, and since the last look how
// many samples were placed and how many could not be.
struct Ring {
    next: u32,
    len: u32,
    placed: u32,
    unplaced: u32,
}

// A sample moved to the refresh instant: x and y, depth and weight, widths in x and y, each pair
// in one word, the first in the low half.
struct Projected {
    at: u32,
    depth_weight: u32,
    widths: u32,
}

fn low16(v: u32) -> u32 { return v & 0xffffu; }
fn pack16(low: u32, high: u32) -> u32 { return low16(low) | (high << 16u); }
fn signed_low16(v: u32) -> i32 { return bitcast<i32>(v << 16u) >> 16u; }
fn signed_high16(v: u32) -> i32 { return bitcast<i32>(v) >> 16u; }

// The distance of a coordinate from the centre of a pixel.
fn distance_from(v: u32, pixel: i32) -> i32 {
    let steps = 2i * i32(v) + 1i - (2i * (pixel + GUARD) + 1i) * (1i << params.frac_bits);
    return steps << (DISTANCE_BITS - 1u - params.frac_bits);
}

struct Seen {
    visible: bool,
    x: u32,
    y: u32,
    depth: u32,
}

fn numerator(transform: Transform, k: u32, q: vec3<i32>) -> W64 {
    var n = transform.offset[k];
    n = w64_add(n, w64_mul_i32_i16(transform.matrix[3u * k], q.x));
    n = w64_add(n, w64_mul_i32_i16(transform.matrix[3u * k + 1u], q.y));
    return w64_add(n, w64_mul_i32_i16(transform.matrix[3u * k + 2u], q.z));
}

fn quotient(v: W64, top: i32, inverse: u32) -> u32 {
    let extent = i32(params.extent_bits);
    let drop = 31u - params.extent_bits - params.frac_bits;
    return low16(mul_hi(shift(v, 31i - top - extent).x, inverse) >> drop);
}

fn project(transform: Transform, q: vec3<i32>) -> Seen {
    let w = numerator(transform, 2u, q);
    if w64_is_negative(w) || w64_eq(w, W64(0u, 0u)) { return Seen(false, 0u, 0u, 0u); }
    let guard = w64_mul_w64_u32(w, u32(GUARD));
    let x = w64_add(numerator(transform, 0u, q), guard);
    let y = w64_add(numerator(transform, 1u, q), guard);
    if w64_is_negative(x) || w64_is_negative(y)
        || !w64_lt_i(x, w64_mul_w64_u32(w, u32(params.width + 2i * GUARD)))
        || !w64_lt_i(y, w64_mul_w64_u32(w, u32(params.height + 2i * GUARD))) {
        return Seen(false, 0u, 0u, 0u);
    }
    let top = exponent(w);
    let inverse = reciprocal(normalise(w));
    let depth = log2_q11(w) + (transform.exponent - DEPTH_FIRST) * 2048i;
    return Seen(
        true,
        quotient(x, top, inverse),
        quotient(y, top, inverse),
        u32(clamp(depth, 0i, 65534i)),
    );
}

fn from_sixteenths(v: u32) -> u32 {
    return min(((v + (u32(GUARD) << 4u)) << params.frac_bits) >> 4u, 65535u);
}

fn to_sixteenths(v: u32) -> i32 {
    return ((i32(v) << 4u) >> params.frac_bits) - (GUARD << 4u);
}

fn pixel(v: u32) -> i32 { return i32(v >> params.frac_bits) - GUARD; }

// Index of the pixel nearest to (x, y), which may lie in the guard band.
fn nearest_pixel(x: i32, y: i32) -> u32 {
    let column = clamp(x, 0i, params.width - 1i);
    let row = clamp(y, 0i, params.height - 1i);
    return u32(row * params.width + column);
}

// Samples are sorted by pixel, the guard band's pixels too.
fn bin_columns() -> i32 { return params.width + 2i * GUARD; }
fn bin_rows() -> i32 { return params.height + 2i * GUARD; }
fn bin_at(x: i32, y: i32) -> u32 {
    let column = clamp(x + GUARD, 0i, bin_columns() - 1i);
    let row = clamp(y + GUARD, 0i, bin_rows() - 1i);
    return u32(row * bin_columns() + column);
}

fn width_from_q8(q8: i32) -> i32 { return clamp(q8, -512i, 512i) << 3u; }

// 3 σ in units of a distance, at most REACH pixels.
fn reach(width: i32) -> u32 {
    return min(exp2_q(width + 3246i, i32(DISTANCE_BITS)), u32(REACH) << DISTANCE_BITS);
}

// log2 of the least and greatest width in the table of taps, twin of taps::LEAST and taps::MOST.
const LEAST: i32 = -3129i;
const MOST: i32 = 454i;
// log2 of the step between its levels, and how many distances, the odd ones, are in each.
const STEP_BITS: u32 = 8u;
const TAP_STEPS: u32 = 448u;
// Marks a footprint whose taps come from the table.
const IN_TABLE: u32 = 0x8000u;

// What a tap needs of its width. Low half: IN_TABLE and the reach. High half: in the table how far
// the width is above the least, else log2(e)/2σ² with 12 fractional bits.
fn footprint(width: i32) -> u32 {
    if width >= LEAST && width <= MOST {
        let above = u32(width - LEAST);
        let wider = LEAST + i32(((above >> STEP_BITS) + 1u) << STEP_BITS);
        return pack16(reach(wider) | IN_TABLE, above);
    }
    return pack16(reach(width), exp2_q(-965i - 2i * width, 12i));
}

// In units of a distance.
fn footprint_reach(footprint: u32) -> u32 { return footprint & 0x7fffu; }

// The farthest pixel, in pixels from that of a sample, in which it can have a share: its distance
// from that pixel's centre is more than half a pixel less.
fn whole_reach(footprint: u32) -> i32 {
    let half = 1u << (DISTANCE_BITS - 1u);
    return i32((footprint_reach(footprint) + half - 1u) >> DISTANCE_BITS);
}

// What a Gaussian is at 3 σ, with 15 fractional bits, twin of taps::FOOT.
const FOOT: u32 = 364u;

// The filter tap at a distance: e^(−d²/2σ²) − e^(−4.5), zero beyond 3 σ.
fn tap(footprint: u32, distance: i32) -> u32 {
    let high = footprint >> 16u;
    if (footprint & IN_TABLE) == 0u {
        let d = u32(abs(distance));
        if d >= footprint_reach(footprint) { return 0u; }
        return max(exp2_negative((d * d * high) >> 16u), FOOT) - FOOT;
    }
    // The middle of a step that is wider than those of the table: the place after it.
    let d = u32(abs(distance | 1i));
    if d >= footprint_reach(footprint) { return 0u; }
    let ends = tables.taps[(high >> STEP_BITS) * TAP_STEPS + (d >> 1u)];
    let part = high & ((1u << STEP_BITS) - 1u);
    return low16(ends) + ((((ends >> 16u) - low16(ends)) * part) >> STEP_BITS);
}

// Product of weights.
fn times(a: u32, b: u32) -> u32 { return (a * b + (ONE >> 1u)) >> 15u; }
