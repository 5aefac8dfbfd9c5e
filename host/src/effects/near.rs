//! What virtual point lights leave out because they grow no stronger near by: bias compensation
//! (Kollig and Keller 2004, "Illumination in the presence of weak singularities", §3).
//!
//! Within `near` metres a light gets the share d²/near² of its due. The rest is what a surface at
//! the distance d sends, times 1 − d²/near²: found by one ray that ends after `near` metres and
//! mostly meets nothing. What it meets is lit by lamps, by virtual lights and, again, by what these
//! leave out there.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::care::Care;
use super::vpl::{Vpls, cosine};
use crate::trace::moment::{Moment, Struck};
use crate::trace::shade::Shader;

/// Most surfaces on the way: a corner of white walls goes on for a while.
const DEPTH: u32 = 16;

impl Moment<'_> {
    /// Irradiance/π from one of `vpls`, which two numbers in 0..1 choose, in place of all. Counts
    /// the ray.
    pub(crate) fn virtual_light(
        &self,
        vpls: &Vpls,
        struck: &Struck,
        point: [f32; 2],
        rays: &mut u32,
    ) -> Vec3 {
        let Some((towards, distance, light)) = vpls.choose(struck.place, struck.smooth, point)
        else {
            return Vec3::ZERO;
        };
        *rays += 1;
        let origin = struck.clear();
        if self.blocked(origin, towards, distance * 0.999) {
            return Vec3::ZERO;
        }
        light * (self.between(origin, towards, distance) * FRAC_1_PI)
    }

    /// An estimate of the irradiance/π that `vpls` leave out. `dice` gives numbers in 0..1. Counts
    /// the rays.
    pub(crate) fn left_out(
        &self,
        vpls: &Vpls,
        struck: &Struck,
        mut dice: impl FnMut() -> [f32; 2],
        rays: &mut u32,
    ) -> Vec3 {
        let (mut sum, mut weight) = (Vec3::ZERO, Vec3::ONE);
        let mut at = *struck;
        for _ in 0..DEPTH {
            let (origin, direction) = (at.clear(), cosine(at.smooth, dice()));
            *rays += 1;
            let Some(next) = self.closest_within(origin, direction, vpls.near) else {
                return sum;
            };
            let albedo = Shader::new(self, 0, Care::default()).albedo(&next);
            let share = 1.0 - (next.t / vpls.near).powi(2);
            weight *= albedo * (share * self.between(origin, direction, next.t));
            let survives = weight.max_element().min(1.0);
            if dice()[0] >= survives {
                return sum;
            }
            weight /= survives;
            let mut light = self.punctual(&next, rays);
            for lamp in self.area_lamps() {
                let arriving = self.direct(lamp, &next, dice(), rays);
                light += arriving.unwrap_or(Vec3::ZERO) * FRAC_1_PI;
            }
            light += self.virtual_light(vpls, &next, dice(), rays);
            sum += weight * light;
            at = next;
        }
        sum
    }
}
