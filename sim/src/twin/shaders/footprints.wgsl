// What the taps of each sorted sample need of its widths, and how many pixels a pixel's samples
// reach at most. Not for one width everywhere. Twin of the second half of Display::set_widths.

@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> sorted: array<vec4<u32>>;
// Of each pixel: width (as i32 bits) and footprint.
@group(0) @binding(4) var<storage, read> widths: array<vec2<u32>>;
// In x and y.
@group(0) @binding(5) var<storage, read_write> footprints: array<vec2<u32>>;
// Pixels beyond the own one and 1 for the own; all zero before.
@group(0) @binding(6) var<storage, read_write> reaches: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let k = linear(group, groups, local);
    if k >= starts[bin_columns() * bin_rows()] { return; }
    let sample = sorted[k];
    let x = pixel(low16(sample.x));
    let y = pixel(sample.x >> 16u);
    var own: vec2<u32>;
    if params.extents == EXTENTS_DENSITY {
        own = vec2<u32>(widths[nearest_pixel(x, y)].y);
    } else {
        own = vec2<u32>(footprint(signed_low16(sample.w)), footprint(signed_high16(sample.w)));
    }
    footprints[k] = own;
    let farther = max(whole_reach(own.x), whole_reach(own.y));
    atomicMax(&reaches[bin_at(x, y)], u32(farther) + 1u);
}
