// Takes the weight of hidden samples and counts the others a pixel. Twin of hidden::drop and
// motion::Reach::of; the counts are the first step of sorting by pixel, which gathering needs and scattering does
// not.

@group(0) @binding(2) var<storage, read> ring: Ring;
@group(0) @binding(3) var<storage, read_write> projected: array<Projected>;
@group(0) @binding(4) var<storage, read> limits: array<u32>;
@group(0) @binding(5) var<storage, read> samples: array<Stored>;
@group(0) @binding(6) var<storage, read> movers: array<u32>;
// For each bucket of ages the depth up to which an occluder can have hidden a sample: at rest,
// with moving objects.
@group(0) @binding(7) var<storage, read> reaching: array<vec2<u32>, BUCKETS>;
// All zero before.
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;

// log2(1.03) with 11 fractional bits, see Arith::nearer.
const NEARER: u32 = 87u;
// log2 of the microseconds in a bucket of ages.
const BUCKET_BITS: u32 = 12u;
// Buckets of ages; the last holds all older samples.
const BUCKETS: u32 = 64u;

fn reach_of(age: u32, moving: bool) -> u32 {
    let depths = reaching[min(age >> BUCKET_BITS, BUCKETS - 1u)];
    return select(depths.x, depths.y, moving);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= ring.len { return; }
    let sample = projected[i];
    if (sample.depth_weight >> 16u) == 0u { return; }
    let x = pixel(low16(sample.at));
    let y = pixel(sample.at >> 16u);
    let depth = low16(sample.depth_weight);
    if params.hidden != 0u {
        let nearest = nearest_pixel(x, y);
        let limit = limits[nearest];
        // A sample of a moving object may itself have moved behind something.
        let moves = slot(samples[i]) > STATIC_SLOT;
        let beside = movers[nearest] != 0u;
        var bound = limit;
        if beside && !moves { bound -= min(bound, NEARER); }
        if bound < depth && limit <= reach_of(age(samples[i]), moves || beside) {
            projected[i].depth_weight = depth;
            return;
        }
    }
    atomicAdd(&counts[bin_at(x, y)], 1u);
}
