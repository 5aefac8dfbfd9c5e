//! What is remembered: the colour and the surface of each pixel.

use glam::{UVec2, Vec2, Vec3};
use unframed_wire::SKY;

use crate::trace::Hit;

/// A pixel of the history.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texel {
    /// Linear light.
    pub(super) colour: Vec3,
    /// How many samples it counts for.
    pub(super) count: f32,
    pub(super) surface: Surface,
}

/// What a pixel shows, at its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) object: u8,
    /// 1/metres along the axis; 0 is the sky.
    pub(super) inverse_depth: f32,
}

pub(super) const NOTHING: Texel = Texel {
    colour: Vec3::ZERO,
    count: 0.0,
    surface: Surface {
        object: SKY,
        inverse_depth: 0.0,
    },
};

/// Relative difference of depth within which two places are the same surface.
pub(super) const SAME_DEPTH: f32 = 0.05;

pub(super) fn inverse_depth(hit: &Hit) -> f32 {
    if hit.object == SKY {
        0.0
    } else {
        1.0 / hit.depth.max(1e-6)
    }
}

/// Colour and count of a surface in the history at a place of its view, if the history has it.
pub(super) fn recall(
    history: &[Texel],
    size: UVec2,
    at: Vec2,
    surface: Surface,
) -> Option<(Vec3, f32)> {
    if at.cmplt(Vec2::ZERO).any() || at.cmpge(size.as_vec2()).any() {
        return None;
    }
    let corner = at - 0.5;
    let base = corner.floor();
    let f = corner - base;
    let (mut colour, mut count, mut weight, mut same) = (Vec3::ZERO, 0.0, 0.0, 0);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let texel = texel(history, size, base.x as i32 + dx, base.y as i32 + dy);
        if texel.count <= 0.0 || !is_same(texel.surface, surface) {
            continue;
        }
        let w = (if dx == 0 { 1.0 - f.x } else { f.x }) * (if dy == 0 { 1.0 - f.y } else { f.y });
        colour += texel.colour * w;
        count += texel.count * w;
        weight += w;
        same += 1;
    }
    if weight < 1e-3 {
        return None;
    }
    // Beyond an edge lies another surface: only what is of this one may be mixed.
    if same == 4 {
        colour = catmull_rom(history, size, at);
    } else {
        colour /= weight;
    }
    Some((colour, count / weight))
}

fn is_same(a: Surface, b: Surface) -> bool {
    a.object == b.object
        && (a.inverse_depth - b.inverse_depth).abs()
            <= SAME_DEPTH * a.inverse_depth.max(b.inverse_depth)
}

fn texel(history: &[Texel], size: UVec2, x: i32, y: i32) -> &Texel {
    let last = size.as_ivec2() - 1;
    &history[(y.clamp(0, last.y) * size.x as i32 + x.clamp(0, last.x)) as usize]
}

/// The history's colour at a place, interpolated over 4 × 4 texels.
pub(super) fn catmull_rom(history: &[Texel], size: UVec2, at: Vec2) -> Vec3 {
    let corner = at - 0.5;
    let base = corner.floor();
    let weights = |f: f32| {
        [
            f * (-0.5 + f * (1.0 - 0.5 * f)),
            1.0 + f * f * (-2.5 + 1.5 * f),
            f * (0.5 + f * (2.0 - 1.5 * f)),
            f * f * (-0.5 + 0.5 * f),
        ]
    };
    let (wx, wy) = (weights(corner.x - base.x), weights(corner.y - base.y));
    let mut sum = Vec3::ZERO;
    for (dy, wy) in (-1..).zip(wy) {
        for (dx, wx) in (-1..).zip(wx) {
            let texel = texel(history, size, base.x as i32 + dx, base.y as i32 + dy);
            sum += texel.colour * (wx * wy);
        }
    }
    sum
}
