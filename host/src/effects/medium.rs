//! Single scattering in a homogeneous medium within a box (Dubla et al. 2009, §3.4; Pharr, Jakob
//! and Humphreys 2023, §11).
//!
//! Light loses exp(−σt·s) over s metres, on the way to the eye and on the way from a lamp. On
//! the way to the eye it gains what lamps throw in: σs·p(cos θ)·E, with the phase function of
//! Henyey and Greenstein (1941). Light that is scattered twice is lost.

use std::f32::consts::PI;

use glam::Vec3;

use crate::scene::model::Medium;

/// Part of a ray inside the medium, as ray parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) from: f32,
    pub(crate) to: f32,
}

impl Stretch {
    pub(crate) fn length(self) -> f32 {
        self.to - self.from
    }
}

impl Medium {
    /// Extinction σt, 1/m.
    pub(crate) fn extinction(&self) -> f32 {
        self.sigma_s + self.sigma_a
    }

    /// Where the ray `origin + direction·0..end` is inside; `direction` has unit length.
    pub(crate) fn stretch(&self, origin: Vec3, direction: Vec3, end: f32) -> Option<Stretch> {
        let a = (self.min - origin) / direction;
        let b = (self.max - origin) / direction;
        // Division by zero gives infinities of the right sign; 0/0, in the plane of a face,
        // gives NaN, which min and max drop.
        let from = a.min(b).to_array().into_iter().fold(0.0, f32::max);
        let to = a.max(b).to_array().into_iter().fold(end, f32::min);
        (to > from).then_some(Stretch { from, to })
    }

    /// What passes through `metres` of it.
    pub(crate) fn transmittance(&self, metres: f32) -> f32 {
        (-self.extinction() * metres).exp()
    }

    /// What passes from `origin` to `origin + direction·end`.
    pub(crate) fn between(&self, origin: Vec3, direction: Vec3, end: f32) -> f32 {
        let inside = self.stretch(origin, direction, end);
        inside.map_or(1.0, |s| self.transmittance(s.length()))
    }

    /// Henyey–Greenstein phase function, 1/sr; `cos` between the directions of flight before
    /// and after.
    pub(crate) fn phase(&self, cos: f32) -> f32 {
        let g = self.g;
        let d = (1.0 + g * g - 2.0 * g * cos).max(1e-6);
        (1.0 - g * g) / (4.0 * PI * d * d.sqrt())
    }

    /// A distance into a stretch of `length` metres with density ∝ exp(−σt·s), from a number in
    /// 0..1, and the integral of exp(−σt·s) over the stretch: the weight of what is found there.
    pub(crate) fn distance(&self, length: f32, at: f32) -> (f32, f32) {
        let extinction = self.extinction();
        if extinction * length < 1e-4 {
            return (at * length, length);
        }
        let lost = -(-extinction * length).exp_m1();
        let s = -(-at * lost).ln_1p() / extinction;
        (s.min(length), lost / extinction)
    }
}
