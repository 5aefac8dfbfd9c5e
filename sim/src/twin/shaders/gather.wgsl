// Adds up the shares of all samples whose footprint holds a pixel. Twin of splat::scatter, the
// other way round: each pixel looks into the bins around, so that no sum is shared and none needs
// an atomic. PLANES (a constant put before) says whether moments are wanted too.

@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> sorted: array<vec4<u32>>;
// In x and y; used unless there is one width everywhere.
@group(0) @binding(4) var<storage, read> footprints: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> rows: array<u32>;
@group(0) @binding(6) var<storage, read_write> sums: array<array<W64, 4>>;
@group(0) @binding(7) var<storage, read_write> moments: array<array<W64, 11>>;
// The longest row that a pixel looked at, in samples; zero before.
@group(0) @binding(8) var<storage, read_write> longest: atomic<u32>;
// Which samples of each row this round looks at: from first × LOOK on.
@group(0) @binding(9) var<uniform> round: vec4<u32>;

// Samples of a row that one round looks at. lavapipe silently ends all loops of an invocation
// after 65,535 iterations; 9 rows of so many stay below.
const LOOK: u32 = 7000u;

// Within a footprint |x| < 2^10, so each term below stays under 2^26 and this many of them fit 32
// bits with sign.
const TERMS: u32 = 31u;

// Partial sums in 32 bits. Products of 16-bit light are split at bit 16 and squares at bit 10.
struct Part {
    terms: u32,
    weight: u32,
    high: vec3<u32>,
    low: vec3<u32>,
    // Σw·(x, y).
    first: vec2<i32>,
    // Σw·(x², xy, y²).
    second_high: vec3<i32>,
    second_low: vec3<i32>,
    // Σw·x·light, Σw·y·light.
    across_high: vec3<i32>,
    across_low: vec3<i32>,
    down_high: vec3<i32>,
    down_low: vec3<i32>,
}

var<private> part: Part;
var<private> sum: array<W64, 4>;
var<private> moment: array<W64, 11>;

fn add(weight: u32, light: vec3<u32>, x: i32, y: i32) {
    let share = weight * light;
    let high = share >> vec3<u32>(16u);
    let low = share & vec3<u32>(0xffffu);
    part.weight += weight;
    part.high += high;
    part.low += low;
    if PLANES {
        let w = i32(weight);
        part.first += w * vec2<i32>(x, y);
        let squares = vec3<i32>(x * x, x * y, y * y);
        part.second_high += w * (squares >> vec3<u32>(10u));
        part.second_low += w * (squares & vec3<i32>(1023i));
        part.across_high += vec3<i32>(high) * x;
        part.across_low += vec3<i32>(low) * x;
        part.down_high += vec3<i32>(high) * y;
        part.down_low += vec3<i32>(low) * y;
    }
    part.terms += 1u;
    if part.terms == TERMS { fold(); }
}

fn joined(total: W64, high: i32, low: i32, bits: u32) -> W64 {
    return w64_add(total, w64_add(w64_shl(w64_from_i32(high), bits), w64_from_i32(low)));
}

// Moves the partial sums over to those of 64 bits.
fn fold() {
    sum[0] = w64_add(sum[0], w64_from_u32(part.weight));
    sum[1] = joined(sum[1], i32(part.high.x), i32(part.low.x), 16u);
    sum[2] = joined(sum[2], i32(part.high.y), i32(part.low.y), 16u);
    sum[3] = joined(sum[3], i32(part.high.z), i32(part.low.z), 16u);
    if PLANES {
        moment[0] = w64_add(moment[0], w64_from_i32(part.first.x));
        moment[1] = w64_add(moment[1], w64_from_i32(part.first.y));
        moment[2] = joined(moment[2], part.second_high.x, part.second_low.x, 10u);
        moment[3] = joined(moment[3], part.second_high.y, part.second_low.y, 10u);
        moment[4] = joined(moment[4], part.second_high.z, part.second_low.z, 10u);
        moment[5] = joined(moment[5], part.across_high.x, part.across_low.x, 16u);
        moment[6] = joined(moment[6], part.across_high.y, part.across_low.y, 16u);
        moment[7] = joined(moment[7], part.across_high.z, part.across_low.z, 16u);
        moment[8] = joined(moment[8], part.down_high.x, part.down_low.x, 16u);
        moment[9] = joined(moment[9], part.down_high.y, part.down_low.y, 16u);
        moment[10] = joined(moment[10], part.down_high.z, part.down_low.z, 16u);
    }
    part = Part();
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= pixels() { return; }
    let x = i32(i) % params.width;
    let y = i32(i) / params.width;
    // Samples that count for their pixels alone are all in one bin.
    let alone = params.extents == EXTENTS_PIXEL;
    let everywhere = alone || params.extents == EXTENTS_CONSTANT;
    var own = vec2<u32>(footprint(params.width_log));
    var side = select(whole_reach(own.x), 0i, alone);
    var most = 0u;
    if round.x != 0u {
        sum = sums[i];
        if PLANES { moment = moments[i]; }
    }
    for (var away = -REACH; away <= REACH; away++) {
        let row = y + away;
        if !everywhere { side = i32(rows[bin_at(x, row)]) - 1i; }
        if side < abs(away) { continue; }
        // The bins of a row lie behind each other.
        let first = starts[bin_at(x - side, row)];
        let last = starts[bin_at(x + side, row) + 1u];
        most = max(most, last - first);
        let end = min(first + (round.x + 1u) * LOOK, last);
        for (var k = first + round.x * LOOK; k < end; k++) {
            let place = sorted[k].x;
            if !everywhere { own = footprints[k]; }
            let at = vec2<i32>(
                distance_from(low16(place), x),
                distance_from(place >> 16u, y),
            );
            let sample = sorted[k];
            var weight = sample.z >> 16u;
            if !alone {
                // What is just as far may be a distance nearer to a table of odd ones, see `tap`.
                if any(vec2<u32>(abs(at)) > (own & vec2<u32>(0x7fffu))) { continue; }
                weight = times(times(weight, tap(own.y, at.y)), tap(own.x, at.x));
            }
            if weight == 0u { continue; }
            let light = vec3<u32>(low16(sample.y), sample.y >> 16u, low16(sample.z));
            add(weight, light, at.x, at.y);
        }
    }
    if most > LOOK { atomicMax(&longest, most); }
    fold();
    sums[i] = sum;
    if PLANES { moments[i] = moment; }
}
