//! Indirect diffuse light by virtual point lights (Keller 1997, "Instant radiosity").
//!
//! Paths start at the lamps, in turn, with low-discrepancy sequences that are the same at every
//! instant, so that lights move only with what they lie on. Each turn of a path has a scrambled
//! sequence of its own: one additive recurrence for all turns, in steps of the greatest depth, was
//! 8 % off however many paths there were. Each place where a path meets a
//! surface becomes a light; Russian roulette by the albedo decides whether the path goes on. A
//! sample chooses a path and then one of its lights, by power: what one path does when something
//! moves changes no other choice.

use std::f32::consts::PI;

use glam::Vec3;

use super::care::{Care, spread};
use crate::trace::moment::Moment;
use crate::trace::shade::Shader;

/// Paths in frameless rendering.
pub(crate) const PATHS: usize = 128;
/// Most surfaces that a path meets: work is bounded. With albedos of 0.8 one in a thousand gets so
/// far.
const DEPTH: u32 = 32;
/// Lights among which a sample chooses, by the light that each would send if nothing stood in
/// between (resampling: Talbot, Cline and Egbert 2005).
const CANDIDATES: usize = 8;
/// Within this distance, metres, a light grows no stronger in frameless rendering: a point that
/// stands for an area must not shine as a point from near by.
pub(crate) const NEAR: f32 = 0.3;

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
    /// `normal`, if nothing is in between; `None` where that is nothing. Within `near` metres it
    /// grows no stronger.
    pub(crate) fn incoming(
        &self,
        place: Vec3,
        normal: Vec3,
        near: f32,
    ) -> Option<(Vec3, f32, Vec3)> {
        let offset = self.place - place;
        let d2 = offset.length_squared();
        let distance = d2.sqrt().max(1e-5);
        let towards = offset / distance;
        let cos = normal.dot(towards).min(1.0);
        let leaving = -self.normal.dot(towards);
        (cos > 0.0 && leaving > 0.0).then(|| {
            let light = self.intensity * (cos * leaving / d2.max(near * near));
            (towards, distance, light)
        })
    }
}

/// The lights of an instant.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vpls {
    /// All of them, path by path.
    pub(crate) lights: Vec<Vpl>,
    /// Where each path's lights end.
    ends: Vec<usize>,
    /// Within so many metres they grow no stronger.
    pub(crate) near: f32,
    /// Rays that making them took.
    pub(crate) rays: u32,
}

impl Vpls {
    /// One light for all that shine on `place` with `normal`, from two numbers in 0..1:
    /// direction, distance, and the irradiance that arrives if nothing is in between, of all.
    pub(crate) fn choose(
        &self,
        place: Vec3,
        normal: Vec3,
        [at, by]: [f32; 2],
    ) -> Option<(Vec3, f32, Vec3)> {
        let mut best = None;
        let (mut sum, mut left) = (0.0, by);
        for i in 0..CANDIDATES {
            // Golden steps: no ray of a sample's lattice has the candidates of another.
            let at = (at + i as f32 * 0.618_034).fract();
            let Some((vpl, stands_for)) = self.by_power(at) else {
                continue;
            };
            let Some((towards, distance, light)) = vpl.incoming(place, normal, self.near) else {
                continue;
            };
            let weight = light.max_element() * stands_for;
            if weight <= 0.0 {
                continue;
            }
            // Each replaces the one before with its share of all so far; the number is stretched
            // back to 0..1 in both cases.
            sum += weight;
            let share = weight / sum;
            if left < share {
                left /= share;
                best = Some((towards, distance, light / light.max_element()));
            } else {
                left = (left - share) / (1.0 - share);
            }
        }
        let (towards, distance, hue) = best?;
        Some((towards, distance, hue * (sum / CANDIDATES as f32)))
    }

    /// One light, from a number in 0..1, and how many it stands for; `None` for a path that met
    /// nothing.
    fn by_power(&self, at: f32) -> Option<(&Vpl, f32)> {
        let paths = self.ends.len() as f32;
        let path = ((at * paths) as usize).min(self.ends.len().checked_sub(1)?);
        let first = path.checked_sub(1).map_or(0, |before| self.ends[before]);
        let lights = &self.lights[first..self.ends[path]];
        let power = |light: &Vpl| light.intensity.max_element();
        let all: f32 = lights.iter().map(power).sum();
        let mut left = (at * paths - path as f32) * all;
        let last = lights.last()?;
        let chosen = lights.iter().find(|light| {
            left -= power(light);
            left < 0.0
        });
        let chosen = chosen.unwrap_or(last);
        Some((chosen, paths * all / power(chosen)))
    }
}

/// The lights of `paths` paths at an instant, which grow no stronger within `near` metres.
pub(crate) fn scatter(moment: &Moment<'_>, paths: usize, near: f32) -> Vpls {
    let lamps = moment.lamp_count();
    let mut found = Vpls {
        near,
        ..Vpls::default()
    };
    if lamps == 0 {
        return found;
    }
    for path in 0..paths as u32 {
        let (lamp, number) = (path as usize % lamps, path / lamps as u32);
        let point = |purpose: u32| {
            let salt = purpose * lamps as u32 + lamp as u32;
            spread(number, salt)
        };
        if let Some((mut origin, mut direction, mut flux)) = moment.emit(lamp, point(0), point(1)) {
            flux *= lamps as f32 / paths as f32;
            for depth in 0..DEPTH {
                found.rays += 1;
                let Some(struck) = moment.closest(origin, direction) else {
                    break;
                };
                flux *= moment.between(origin, direction, struck.t);
                let albedo = Shader::new(moment, 0, Care::default()).albedo(&struck);
                flux *= albedo;
                if flux.max_element() <= 0.0 {
                    break;
                }
                found.lights.push(Vpl {
                    place: struck.place,
                    normal: struck.flat,
                    intensity: flux / PI,
                });
                let [roulette, _] = point(2 * depth + 2);
                let survives = albedo.max_element().min(1.0);
                if roulette >= survives {
                    break;
                }
                flux /= survives;
                origin = struck.clear();
                direction = cosine(struck.flat, point(2 * depth + 3));
            }
        }
        found.ends.push(found.lights.len());
    }
    found
}

/// A unit direction around `normal` with density cos/π, from two numbers in 0..1.
pub(crate) fn cosine(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (a, b) = normal.any_orthonormal_pair();
    let (r, angle) = (u.sqrt(), 2.0 * PI * v);
    (a * (r * angle.cos()) + b * (r * angle.sin()) + normal * (1.0 - u).max(0.0).sqrt()).normalize()
}
