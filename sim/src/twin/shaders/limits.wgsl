// The depth beyond which each pixel is hidden: behind the 7th smallest minimum of the 3 × 3 cells
// of 1 pixel, the 8th of 2 pixels, the largest of 4 pixels. Twin of hidden::limits.

@group(0) @binding(2) var<storage, read> minima: array<u32>;
@group(0) @binding(3) var<storage, read_write> limits: array<u32>;

// The three largest of the nine, smallest first.
fn top_three(values: array<u32, 9>) -> vec3<u32> {
    let lo = min(values[0], values[1]);
    let hi = max(values[0], values[1]);
    let rest_of = max(lo, values[2]);
    var third = min(lo, values[2]);
    var second = min(hi, rest_of);
    var first = max(hi, rest_of);
    for (var k = 3u; k < 9u; k++) {
        let v = values[k];
        let down = min(first, v);
        first = max(first, v);
        let down_again = min(second, down);
        second = max(second, down);
        third = max(third, down_again);
    }
    return vec3<u32>(third, second, first);
}

// The cells around that of a pixel, clamped at borders.
fn around(first: i32, side: i32, x: i32, y: i32) -> array<u32, 9> {
    let columns = (params.width + side - 1i) / side;
    let rows = (params.height + side - 1i) / side;
    var values: array<u32, 9>;
    for (var k = 0i; k < 9i; k++) {
        let column = clamp(x / side + k % 3i - 1i, 0i, columns - 1i);
        let row = clamp(y / side + k / 3i - 1i, 0i, rows - 1i);
        values[k] = minima[first + row * columns + column];
    }
    return values;
}

fn behind(depth: u32, tolerance: u32) -> u32 { return min(depth + tolerance, 65535u); }

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
    let halves = params.width * params.height;
    let blocks = halves + ((params.width + 1i) / 2i) * ((params.height + 1i) / 2i);
    // log2(1.05), log2(1.1), log2(2.6) with 11 fractional bits.
    var limit = behind(top_three(around(0i, 1i, x, y)).x, 144u);
    limit = min(limit, behind(top_three(around(halves, 2i, x, y)).y, 282u));
    limit = min(limit, behind(top_three(around(blocks, 4i, x, y)).z, 2823u));
    limits[i] = limit;
}
