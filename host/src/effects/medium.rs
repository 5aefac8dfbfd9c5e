//! Single scattering in a homogeneous medium within a box (Dubla et al. 2009, §3.4; Pharr, Jakob
//! and Humphreys 2023, §11).
//!
//! Light loses exp(−σt·s) over s metres, on the way to the eye and on the way from a lamp. On
//! the way to the eye it gains what lamps throw in: σs·p(cos θ)·E, with the phase function of
//! Henyey and Greenstein (1941). Light that is scattered twice is lost.
//!
//! Places on the way to the eye are taken where a lamp is seen large: equal angles at the lamp
//! (Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating
//! media", §3) cancel its 1/d². In a dense medium, where most light comes from near by, some are
//! taken with density exp(−σt·s), and both are weighed by the balance heuristic (Veach and Guibas
//! 1995).

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

/// Where light comes from, as a stretch of a ray sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// From infinitely far: equally strong everywhere.
    Far,
    /// From a place.
    Near {
        /// Where along the stretch it is nearest, metres; may lie outside.
        foot: f32,
        /// How far it is from there, metres, or its own size if that is more. Above zero.
        reach: f32,
    },
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

    /// A distance s into a stretch from which light of `source` is looked for, by a number in 0..1,
    /// and exp(−σt·s) over the density of that choice, metres.
    pub(crate) fn place(&self, length: f32, source: Source, at: f32) -> (f32, f32) {
        let Source::Near { foot, reach } = source else {
            return self.distance(length, at);
        };
        let thick = 0.5 * (1.0 - self.transmittance(length));
        let [from, to] = [-foot, length - foot].map(|s| (s / reach).atan());
        let s = if at < thick {
            self.distance(length, at / thick).0
        } else {
            let angle = from + (to - from) * (at - thick) / (1.0 - thick);
            (foot + reach * angle.tan()).clamp(0.0, length)
        };
        let passing = self.transmittance(s);
        let by_angle = reach / ((to - from) * (reach * reach + (s - foot).powi(2)));
        // thick·σt/(1 − exp(−σt·length)) is σt/2.
        let density = 0.5 * self.extinction() * passing + (1.0 - thick) * by_angle;
        (s, passing / density)
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
