// The filter width of each pixel, from the mass in the 3 × 3 pixels around, and what its taps
// need. Twin of splat::widths.

@group(0) @binding(2) var<storage, read> mass: array<W64>;
// Width (as i32 bits) and footprint.
@group(0) @binding(3) var<storage, read_write> widths: array<vec2<u32>>;

// The most that one pixel's mass counts: 64 samples.
const MASS_LIMIT: u32 = 2097152u;

fn saturated(mass: W64) -> u32 {
    return select(min(mass.x, MASS_LIMIT), MASS_LIMIT, mass.y != 0u);
}

fn width_of(mass: u32) -> i32 {
    // log2(0.5 · 3) is 1198; a mass has 15 fractional bits.
    let sigma = 1198i - ((log2_q11(w64_from_u32(max(mass, 1u))) - 15i * 2048i) >> 1u);
    return clamp(sigma, LEAST, MOST);
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
    var sum = 0u;
    for (var row = max(y - 1i, 0i); row < min(y + 2i, params.height); row++) {
        for (var column = max(x - 1i, 0i); column < min(x + 2i, params.width); column++) {
            sum += saturated(mass[row * params.width + column]);
        }
    }
    let width = width_of(sum);
    widths[i] = vec2<u32>(bitcast<u32>(width), footprint(width));
}
