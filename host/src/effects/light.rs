//! What components ask of an instant: light at a place, light leaving a lamp.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::BUILT_IN;
use super::medium::Source;
use crate::scene::model::Medium;
use crate::trace::moment::{Moment, Struck};

/// Light that a lamp throws towards the eye from a place in the medium.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thrown {
    /// Radiance a metre.
    pub(crate) light: Vec3,
    /// Whether something stands in between.
    pub(crate) hidden: bool,
    /// Of the lamp, metres; infinite for directional light.
    pub(crate) distance: f32,
}

impl Moment<'_> {
    /// The medium, if the scene has one.
    pub(crate) fn medium(&self) -> Option<&Medium> {
        self.world.scene.medium.as_ref().filter(|_| BUILT_IN)
    }

    /// Whether the scene calls for indirect diffuse light.
    pub(crate) fn indirect(&self) -> bool {
        BUILT_IN && self.world.scene.indirect
    }

    /// Irradiance/π that stands for indirect light where the scene does not call for it.
    pub(crate) fn ambient(&self) -> Vec3 {
        if self.indirect() {
            Vec3::ZERO
        } else {
            self.world.scene.sky.ambient
        }
    }

    /// What the medium lets through on the way.
    pub(crate) fn between(&self, origin: Vec3, direction: Vec3, end: f32) -> f32 {
        self.medium()
            .map_or(1.0, |m| m.between(origin, direction, end))
    }

    /// Lamps of all kinds.
    pub(crate) fn lamp_count(&self) -> usize {
        self.world.lamps.len()
    }

    /// Area lights.
    pub(crate) fn area_lamps(&self) -> impl Iterator<Item = usize> {
        (0..self.lamp_count()).filter(|&i| self.world.lamps[i].is_area())
    }

    /// Irradiance at a surface from one lamp, of which `point` says where, in 0..1; `None` where
    /// it is hidden. Counts the ray.
    pub(crate) fn direct(
        &self,
        lamp: usize,
        struck: &Struck,
        point: [f32; 2],
        rays: &mut u32,
    ) -> Option<Vec3> {
        let dark = Some(Vec3::ZERO);
        let from = |l: &crate::trace::light::Lamp| {
            l.incoming(&self.lamp(lamp), struck.place, || {
                (point, self.lamp_pose(lamp))
            })
        };
        let Some(light) = from(&self.world.lamps[lamp]) else {
            return dark;
        };
        let cos = struck.smooth.dot(light.towards);
        if cos <= 0.0 || struck.flat.dot(light.towards) <= 0.0 {
            return dark;
        }
        *rays += 1;
        let origin = struck.clear();
        if self.blocked(origin, light.towards, light.distance * 0.9999) {
            return None;
        }
        Some(light.irradiance * (cos * self.between(origin, light.towards, light.distance)))
    }

    /// Irradiance/π at a surface from point, spot and directional lights.
    pub(crate) fn punctual(&self, struck: &Struck, rays: &mut u32) -> Vec3 {
        (0..self.lamp_count())
            .filter(|&i| !self.world.lamps[i].is_area())
            .filter_map(|i| self.direct(i, struck, [0.5; 2], rays))
            .sum::<Vec3>()
            * FRAC_1_PI
    }

    /// How a lamp is seen from a stretch of a medium that begins at `origin`, in a unit direction.
    pub(crate) fn source(&self, lamp: usize, origin: Vec3, direction: Vec3) -> Source {
        let Some((middle, radius)) = self.world.lamps[lamp].ball(&self.lamp(lamp)) else {
            return Source::Far;
        };
        let foot = (middle - origin).dot(direction);
        let apart = middle.distance_squared(origin + direction * foot);
        let reach = (apart + radius * radius).sqrt().max(1e-4);
        Source::Near { foot, reach }
    }

    /// At a place in the medium: radiance a metre that a lamp throws into the unit `direction`
    /// against which the eye looks; where it shines there at all. `point` says where on an area
    /// light. Counts the ray.
    pub(crate) fn thrown(
        &self,
        lamp: usize,
        place: Vec3,
        direction: Vec3,
        point: [f32; 2],
        rays: &mut u32,
    ) -> Option<Thrown> {
        let medium = self.medium()?;
        let pose = || (point, self.lamp_pose(lamp));
        let lit = self.world.lamps[lamp].incoming(&self.lamp(lamp), place, pose)?;
        *rays += 1;
        let hidden = self.blocked(place, lit.towards, lit.distance * 0.9999);
        let light = if hidden {
            Vec3::ZERO
        } else {
            let passing = medium.between(place, lit.towards, lit.distance);
            let phase = medium.phase(direction.dot(lit.towards));
            lit.irradiance * (medium.sigma_s * passing * phase)
        };
        Some(Thrown {
            light,
            hidden,
            distance: lit.distance,
        })
    }

    /// A path that leaves a lamp: origin, unit direction, and the lamp's whole flux as seen by
    /// this choice, W. `where_on` and `whither` are numbers in 0..1.
    pub(crate) fn emit(
        &self,
        lamp: usize,
        where_on: [f32; 2],
        whither: [f32; 2],
    ) -> Option<(Vec3, Vec3, Vec3)> {
        let bounds = self.world.bounds(0);
        let centre = (bounds.min + bounds.max) * 0.5;
        let ball = (centre.into(), 0.5 * bounds.diagonal().length());
        let pose = || self.lamp_pose(lamp);
        self.world.lamps[lamp].emit(&self.lamp(lamp), pose, where_on, whither, ball)
    }
}
