// What every stage sees: the panel and its configuration, the tables, and how items are numbered.

// Set up with the display but for `now`; twin of Params in params.rs.
struct Params {
    // Pixels a row, rows.
    width: i32,
    height: i32,
    // Panel::extent_bits, Panel::frac_bits.
    extent_bits: u32,
    frac_bits: u32,
    // Columns and rows of the tile map.
    columns: i32,
    rows: i32,
    // The instant shown, microseconds modulo 2^32.
    now: u32,
    // Samples that the deep buffer holds.
    capacity: u32,
    // One of LIFETIME_…; log2 of the constant one, seconds, 11 fractional bits.
    lifetime: u32,
    lifetime_log: i32,
    // One of EXTENTS_…; log2 of the constant σ, pixels, 11 fractional bits.
    extents: u32,
    width_log: i32,
    // Whether samples behind others are dropped, whether colours are filtered as encoded.
    hidden: u32,
    encoded: u32,
    // Whether means are kept for what rests.
    averages: u32,
    cutoff: u32,
}

// The arrays of unframed_recon::tables; twin of Tables in tables.rs. Those between whose entries
// one interpolates have both ends of a chord in a word.
struct Tables {
    log2_q11: array<u32, 64>,
    exp2_q15: array<u32, 256>,
    time: array<u32, 3071>,
    light: array<u32, 256>,
    linear: array<u32, 256>,
    srgb_from: array<u32, 256>,
    srgb_guess: array<u32, 4096>,
    taps: array<u32, 6272>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> tables: Tables;

const LIFETIME_CONSTANT: u32 = 0u;
const LIFETIME_TILES: u32 = 1u;
const LIFETIME_GRADIENT: u32 = 2u;

const EXTENTS_CONSTANT: u32 = 0u;
const EXTENTS_DENSITY: u32 = 1u;
const EXTENTS_GRADIENT: u32 = 2u;
const EXTENTS_PIXEL: u32 = 3u;

// One, with 15 fractional bits.
const ONE: u32 = 32768u;

const GROUP: u32 = 64u;

// The item of an invocation, see pass::linear_grid.
fn linear(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * GROUP + local;
}

fn pixels() -> u32 { return u32(params.width * params.height); }
