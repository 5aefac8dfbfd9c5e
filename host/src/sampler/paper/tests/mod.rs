//! The sampler against oracles and on a small scene.

mod loops;
mod reprojection;
mod tiling;
mod visibility;

use glam::{UVec2, Vec3};

use super::crosshair::{Crosshair, Point};
use crate::sampler::noise::Random;

const SIZE: UVec2 = UVec2::new(61, 40);

/// A crosshair at a random pixel.
fn crosshair(random: &mut Random, time: f64) -> Crosshair {
    let pixel = random.below(SIZE.element_product());
    let unit = || Vec3::ZERO;
    Crosshair {
        time,
        centre: Point {
            object: 0,
            local: unit(),
            luminance: random.unit(),
        },
        arms: [None; 4],
        gradients: [random.unit(), random.unit(), 3.0 * random.unit()],
        occluded: random.below(5) == 0,
        pixel,
    }
}
