// A picture on a surface: each of its pixels a square of `scale` pixels, black around it. Reads
// by integer address, so that every byte arrives as it left.

struct Placement {
    // Where the picture's top left corner lies on the surface, pixels; negative when cropped.
    origin: vec2<i32>,
    // Surface pixels a picture pixel, 1 or more.
    scale: i32,
    padding: i32,
}

@group(0) @binding(0) var<uniform> placement: Placement;
@group(0) @binding(1) var picture: texture_2d<f32>;

// One triangle that covers the surface.
@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn paint(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let place = vec2<i32>(position.xy) - placement.origin;
    let size = vec2<i32>(textureDimensions(picture));
    if any(place < vec2<i32>(0)) || any(place >= size * placement.scale) {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    return textureLoad(picture, place / placement.scale, 0);
}
