//! Indirect diffuse light by virtual point lights (Keller 1997, "Instant radiosity").
//!
//! Paths start at the lamps, in turn, with a low-discrepancy sequence that is the same at every
//! instant, so that lights move only with what they lie on. Each place where a path meets a
//! surface becomes a light. A path goes on for [`DEPTH`] surfaces.

use std::f32::consts::PI;

use glam::Vec3;

use super::sets::recurrence;
use crate::trace::moment::Moment;
use crate::trace::shade::Shader;

/// Lights that a scene gets in frameless rendering.
pub(crate) const LIGHTS: usize = 64;
/// Most surfaces that a path meets.
const DEPTH: u32 = 3;
/// Within this distance, metres, a light grows no stronger: a point that stands for an area must
/// not shine as a point from near by. Corners become a little too dark.
const NEAR: f32 = 0.25;

/// A virtual point light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vpl {
    pub(crate) place: Vec3,
    /// Unit normal of the surface.
    pub(crate) normal: Vec3,
    /// Reflected flux/π, W/sr towards the normal.
    pub(crate) intensity: Vec3,
}

impl Vpl {
    /// Direction and distance to it and the irradiance that arrives at `place` on a surface with
    /// `normal`, if nothing is in between; `None` where that is nothing.
    pub(crate) fn incoming(&self, place: Vec3, normal: Vec3) -> Option<(Vec3, f32, Vec3)> {
        let offset = self.place - place;
        let d2 = offset.length_squared();
        let distance = d2.sqrt().max(1e-5);
        let towards = offset / distance;
        let cos = normal.dot(towards).min(1.0);
        let leaving = -self.normal.dot(towards);
        (cos > 0.0 && leaving > 0.0).then(|| {
            let light = self.intensity * (cos * leaving / d2.max(NEAR * NEAR));
            (towards, distance, light)
        })
    }
}

/// At most `count` lights for an instant.
pub(crate) fn scatter(moment: &Moment<'_>, count: usize) -> Vec<Vpl> {
    let lamps = moment.lamp_count();
    let mut lights = Vec::new();
    if lamps == 0 {
        return lights;
    }
    let mut paths = 0u32;
    // Most paths meet something; the bound is for scenes in which none does.
    while lights.len() < count && paths < 4 * count as u32 {
        let [a, b, c, d] = recurrence(paths);
        let lamp = paths as usize % lamps;
        paths += 1;
        let Some((mut origin, mut direction, mut flux)) = moment.emit(lamp, [a, b], [c, d]) else {
            continue;
        };
        for depth in 0..DEPTH {
            let Some(struck) = moment.closest(origin, direction) else {
                break;
            };
            flux *= moment.between(origin, direction, struck.t);
            let albedo = Shader::new(moment, 0).albedo(&struck);
            flux *= albedo;
            if flux.max_element() <= 0.0 || lights.len() == count {
                break;
            }
            lights.push(Vpl {
                place: struck.place,
                normal: struck.flat,
                intensity: flux / PI,
            });
            let [e, f, ..] = recurrence::<6>(paths * DEPTH + depth);
            origin = struck.clear();
            direction = cosine(struck.flat, [e, f]);
        }
    }
    for light in &mut lights {
        light.intensity *= lamps as f32 / paths as f32;
    }
    lights
}

/// A unit direction around `normal` with density cos/π, from two numbers in 0..1.
pub(crate) fn cosine(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (a, b) = normal.any_orthonormal_pair();
    let (r, angle) = (u.sqrt(), 2.0 * PI * v);
    (a * (r * angle.cos()) + b * (r * angle.sin()) + normal * (1.0 - u).max(0.0).sqrt()).normalize()
}
