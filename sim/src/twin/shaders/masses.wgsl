// Samples' weights summed a pixel; those in the guard band belong to the border's pixels.
// Twin of splat::masses.

@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> sorted: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> mass: array<u32>;

// The most that one pixel's mass counts: 64 samples.
const MASS_LIMIT: u32 = 2097152u;

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
    let left = select(x, -GUARD, x == 0i);
    let right = select(x, x + GUARD, x == params.width - 1i);
    let top = select(y, -GUARD, y == 0i);
    let bottom = select(y, y + GUARD, y == params.height - 1i);
    var sum = 0u;
    for (var row = top; row <= bottom; row++) {
        let end = starts[bin_at(right, row) + 1u];
        for (var k = starts[bin_at(left, row)]; k < end && sum < MASS_LIMIT; k++) {
            sum = min(sum + (sorted[k].z >> 16u), MASS_LIMIT);
        }
    }
    mass[i] = sum;
}
