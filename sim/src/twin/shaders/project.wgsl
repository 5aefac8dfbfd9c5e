// Moves every stored sample to the refresh instant and weighs it by its age.
// Twin of Display::project and of the tile map's interpolation in fixed.rs and extents.rs.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read_write> samples: array<Stored>;
@group(0) @binding(4) var<storage, read> transforms: array<Transform, 256>;
// A cell of the tile map in two words, see params.rs.
@group(0) @binding(5) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> projected: array<Projected>;

const CELL_BITS: u32 = 2u;
// log2 of 10^6 with 11 fractional bits: microseconds in a second.
const LOG2_MICROS: i32 = 40820i;
// log2 of the youngest age, seconds, with 11 fractional bits: 2^−16 s.
const YOUNGEST: i32 = -32768i;
// First entry of the table of time kernels, log2 with 8 fractional bits.
const TIME_FIRST: i32 = -2048i;
const TIME_CHORDS: u32 = 3071u;

// Of unframed_recon::extents, log2 with 8 fractional bits.
const LEAST_SPATIAL: i32 = -2039i;
const LEAST_TEMPORAL: i32 = -1445i;
const SHORTEST: i32 = -1701i;
const LONGEST: i32 = 0i;
const NARROWEST: i32 = -388i;
const WIDEST: i32 = 406i;
const SIGMA_OF_EXTENT: i32 = -159i;

// Bytes of a cell.
const GX: u32 = 0u;
const GY: u32 = 1u;
const GT: u32 = 2u;
const LIFETIME: u32 = 3u;
const DENSITY: u32 = 4u;

// The longest lifetime that samples are weighed by, as a code.
const LONGEST_CODE: u32 = 128u;

struct Between {
    cell: i32,
    // The way to the next cell in 1/512.
    rest: i32,
}

fn between_cells(v: u32) -> Between {
    let bits = params.frac_bits;
    let from_centre = i32(v) - (GUARD << bits) - ((1i << (CELL_BITS - 1u)) << bits);
    let rest = from_centre & ((1i << (bits + CELL_BITS)) - 1i);
    return Between(from_centre >> (bits + CELL_BITS), rest << (9u - bits - CELL_BITS));
}

fn at(column: i32, row: i32) -> vec2<u32> {
    let x = clamp(column, 0i, params.columns - 1i);
    let y = clamp(row, 0i, params.rows - 1i);
    return cells[y * params.columns + x];
}

// The four cells around a place and the way between them.
struct Around {
    cells: array<vec2<u32>, 4>,
    fx: i32,
    fy: i32,
}

fn around(x: u32, y: u32) -> Around {
    let across = between_cells(x);
    let down = between_cells(y);
    return Around(
        array<vec2<u32>, 4>(
            at(across.cell, down.cell),
            at(across.cell + 1i, down.cell),
            at(across.cell, down.cell + 1i),
            at(across.cell + 1i, down.cell + 1i),
        ),
        across.rest,
        down.rest,
    );
}

// The middle of the pixel of the panel that is nearest.
fn middle(v: u32, size: i32) -> u32 {
    let bits = params.frac_bits;
    let pixel = clamp(i32(v >> bits) - GUARD, 0i, size - 1i);
    return u32(((2i * (pixel + GUARD) + 1i) << bits) >> 1u);
}

fn log2_q8(cell: vec2<u32>, field: u32) -> i32 {
    let word = select(cell.x, cell.y, field >= 4u);
    var code = (word >> ((field & 3u) * 8u)) & 0xffu;
    if field == LIFETIME { code = min(code, LONGEST_CODE); }
    return (i32(code) - 128i) * 32i;
}

// A tile quantity, bilinear between cells: log2 with 11 fractional bits.
fn bilinear(around: Around, field: u32) -> i32 {
    let a = log2_q8(around.cells[0], field);
    let b = log2_q8(around.cells[1], field);
    let c = log2_q8(around.cells[2], field);
    let d = log2_q8(around.cells[3], field);
    let top = a * (512i - around.fx) + b * around.fx;
    let bottom = c * (512i - around.fx) + d * around.fx;
    return (top * (512i - around.fy) + bottom * around.fy + (1i << 14u)) >> 15u;
}

struct Extents {
    // Temporal extent, log2 of seconds with 11 fractional bits.
    et: i32,
    // Widths in x and y.
    wx: i32,
    wy: i32,
}

fn extents(around: Around) -> Extents {
    let gx = max((bilinear(around, GX) + 4i) >> 3u, LEAST_SPATIAL);
    let gy = max((bilinear(around, GY) + 4i) >> 3u, LEAST_SPATIAL);
    let gt = max((bilinear(around, GT) + 4i) >> 3u, LEAST_TEMPORAL);
    let volume = -((bilinear(around, DENSITY) + 4i) >> 3u);
    let et = clamp((volume + gx + gy - 2i * gt) / 3i, SHORTEST, LONGEST);
    let area = volume - et;
    let first = clamp((area + gy - gx) / 2i, NARROWEST, WIDEST);
    let ey = clamp(area - first, NARROWEST, WIDEST);
    let ex = clamp(area - ey, NARROWEST, WIDEST);
    return Extents(
        et << 3u,
        width_from_q8(ex + SIGMA_OF_EXTENT),
        width_from_q8(ey + SIGMA_OF_EXTENT),
    );
}

// Weight of a sample `age` microseconds old.
fn decline(age: u32, lifetime: i32) -> u32 {
    let log = max(log2_q11(w64_from_u32(age)) - LOG2_MICROS, YOUNGEST);
    let u = u32(max(log - lifetime - 8i * TIME_FIRST, 0i));
    let chord = u >> 3u;
    if chord >= TIME_CHORDS { return 0u; }
    let a = low16(tables.time[chord]);
    let b = tables.time[chord] >> 16u;
    let weight = a - (((a - b) * (u & 7u) + 4u) >> 3u);
    return max(weight, params.cutoff) - params.cutoff;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= ring.len { return; }
    projected[i] = Projected(0u, 0u, 0u);
    let sample = samples[i];
    // So old that the clock's wrap would make it young again: gone.
    if since(sample) >= (1i << 30u) || since(sample) <= -(1i << 30u) {
        samples[i].w = sample.w & 0xff00ffffu;
        return;
    }
    var seen = Seen(false, 0u, 0u, 0u);
    if placing(sample) == PLACING_SCREEN {
        seen = Seen(
            true,
            from_sixteenths(low16(sample.y)),
            from_sixteenths(sample.y >> 16u),
            0u,
        );
    } else if placing(sample) == PLACING_LATTICE && transforms[slot(sample)].known != 0u {
        seen = project(transforms[slot(sample)], place(sample));
    }
    if !seen.visible { return; }
    var lifetime = 0i;
    var widths = vec2<i32>(0i);
    if params.extents == EXTENTS_GRADIENT || params.lifetime == LIFETIME_GRADIENT {
        let e = extents(around(seen.x, seen.y));
        lifetime = e.et;
        widths = vec2<i32>(e.wx, e.wy);
    }
    if params.lifetime == LIFETIME_CONSTANT { lifetime = params.lifetime_log; }
    if params.lifetime == LIFETIME_TILES {
        lifetime = bilinear(around(middle(seen.x, params.width), middle(seen.y, params.height)), LIFETIME);
    }
    if params.extents == EXTENTS_CONSTANT { widths = vec2<i32>(params.width_log); }
    let weight = decline(age(sample), lifetime);
    projected[i] = Projected(
        pack16(seen.x, seen.y),
        pack16(seen.depth, weight),
        pack16(bitcast<u32>(widths.x), bitcast<u32>(widths.y)),
    );
}
