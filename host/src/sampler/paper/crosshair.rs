//! Crosshairs (Dayal et al. 2005 §4.1) and what becomes of them when the view moves (§6.1).

use glam::{Vec2, Vec3};

use super::tree::Entry;
use crate::sampler::adaptive::projection::Projection;
use crate::sampler::srgb::displayed;
use crate::trace::Hit;

/// Where the arms stand from the centre, pixels: left, right, above, below.
pub(super) const ARMS: [Vec2; 4] = [Vec2::NEG_X, Vec2::X, Vec2::NEG_Y, Vec2::Y];

/// Luminance as displayed, 0..=1: Rec. 709 weights on sRGB-encoded colour, since errors are
/// measured on what is displayed.
pub(super) fn luminance(hit: &Hit) -> f32 {
    displayed(hit.colour).dot(Vec3::new(0.2126, 0.7152, 0.0722)) / 255.0
}

/// A sample of a crosshair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Whose coordinates `local` are.
    pub(super) object: u8,
    /// The place, metres in the object's own coordinates (sky: a direction).
    pub(super) local: Vec3,
    /// Luminance as displayed, 0..=1.
    pub(super) luminance: f32,
}

impl Point {
    pub(super) fn of(hit: &Hit) -> Self {
        Self {
            object: hit.object,
            local: hit.local,
            luminance: luminance(hit),
        }
    }
}

/// A sample that waits to become the old half of a crosshair's temporal gradient: (x, y, t₀).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Initial {
    /// Where on the image, pixels.
    pub(super) place: Vec2,
    /// When, seconds.
    pub(super) time: f64,
    /// What was seen, 0..=1.
    pub(super) luminance: f32,
}

/// An entry of the deep buffer: a centre, up to four cotemporal arms and their gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crosshair {
    /// When, seconds.
    pub(super) time: f64,
    pub(super) centre: Point,
    /// As [`ARMS`]; those beyond the image's edge are missing.
    pub(super) arms: [Option<Point>; 4],
    /// |dL/dx|, |dL/dy| (1/pixel) and |dL/dt| (1/s).
    pub(super) gradients: [f32; 3],
    /// Whether it took the place of an occluded one.
    pub(super) occluded: bool,
    /// The pixel in whose queue it is.
    pub(super) pixel: u32,
}

impl Crosshair {
    /// What the statistics keep of it.
    pub(super) fn entry(&self) -> Entry {
        Entry {
            time: self.time,
            luminance: self.centre.luminance,
            gradients: self.gradients,
            occluded: self.occluded,
        }
    }

    /// Spatial gradients of arms that are a pixel away: the mean |ΔL| along x and along y (the
    /// paper's ½·(|L − L₋₁| + |L − L₊₁|)); 0 along an axis without arms.
    pub(super) fn spatial(centre: &Point, arms: &[Option<Point>; 4]) -> [f32; 2] {
        let difference =
            |arm: &Option<Point>| arm.as_ref().map(|a| (a.luminance - centre.luminance).abs());
        [&arms[..2], &arms[2..]].map(|pair| mean(pair.iter().filter_map(difference)))
    }

    /// Spatial gradients where the samples are seen now: each |ΔL| is divided by how far the arm
    /// now is from the centre. Arms that are not seen, or nearer than a quarter pixel, say
    /// nothing; an axis of which nothing is known keeps what it was.
    pub(super) fn respaced(&self, at: Vec2, projection: &Projection) -> [f32; 2] {
        let slope = |arm: &Option<Point>| {
            let arm = arm.as_ref()?;
            let (place, _) = projection.project(arm.object, arm.local)?;
            let distance = place.distance(at);
            (distance >= 0.25).then(|| (arm.luminance - self.centre.luminance).abs() / distance)
        };
        let axis = |k: usize| {
            let pair = &self.arms[2 * k..2 * k + 2];
            let known = pair.iter().filter_map(slope);
            if known.clone().next().is_some() {
                mean(known)
            } else {
                self.gradients[k]
            }
        };
        [axis(0), axis(1)]
    }
}

/// The mean; 0 of nothing.
fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
