// Adds the new samples to the means of the pixels that they fall into.
// Twin of unframed_recon::rest::place and Display::average.

struct Fresh {
    // The first of them in the ring.
    first: u32,
    count: u32,
    padding: vec2<u32>,
}

@group(0) @binding(2) var<uniform> fresh: Fresh;
@group(0) @binding(3) var<storage, read> samples: array<Stored>;
@group(0) @binding(4) var<storage, read> transforms: array<Transform, 256>;
@group(0) @binding(5) var<storage, read> cells: array<vec2<u32>>;
// Four words a pixel, see Mean.
@group(0) @binding(6) var<storage, read_write> means: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read> light: Light;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = linear(group, groups, local);
    if i >= fresh.count { return; }
    let sample = samples[(fresh.first + i) % params.capacity];
    if since(sample) >= (1i << 30u) || since(sample) <= -(1i << 30u) { return; }
    var seen = Seen(false, 0u, 0u, 0u);
    if placing(sample) == PLACING_SCREEN {
        let x = from_sixteenths(low16(sample.y));
        seen = Seen(true, x, from_sixteenths(sample.y >> 16u), 0u);
    } else if placing(sample) == PLACING_LATTICE && transforms[slot(sample)].known != 0u {
        seen = project(transforms[slot(sample)], place(sample));
    }
    let x = pixel(seen.x);
    let y = pixel(seen.y);
    let inside = x >= 0i && y >= 0i && x < params.width && y < params.height;
    if !seen.visible || !inside || !rests(cells[cell_of(x, y)]) { return; }
    let code = relight(sample);
    let mean = 4u * nearest_pixel(x, y);
    atomicAdd(&means[mean], tables.light[code.x]);
    atomicAdd(&means[mean + 1u], tables.light[code.y]);
    atomicAdd(&means[mean + 2u], tables.light[code.z]);
    atomicAdd(&means[mean + 3u], 1u);
}
