//! What components ask of an instant: light at a place, light leaving a lamp.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::BUILT_IN;
use crate::scene::model::Medium;
use crate::trace::moment::{Moment, Struck};

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

    /// At a place in the medium: radiance a metre that lamps throw into the unit `direction`
    /// against which the eye looks, the share of lamps that are hidden, and the distance of the
    /// nearest, metres. `point` says where on area lights.
    pub(crate) fn thrown(
        &self,
        place: Vec3,
        direction: Vec3,
        point: [f32; 2],
        rays: &mut u32,
    ) -> (Vec3, f32, f32) {
        let Some(medium) = self.medium() else {
            return (Vec3::ZERO, 0.0, f32::INFINITY);
        };
        let (mut light, mut hidden, mut nearest) = (Vec3::ZERO, 0.0, f32::INFINITY);
        for (i, lamp) in self.world.lamps.iter().enumerate() {
            let pose = || (point, self.lamp_pose(i));
            let Some(lit) = lamp.incoming(&self.lamp(i), place, pose) else {
                continue;
            };
            *rays += 1;
            nearest = nearest.min(lit.distance);
            if self.blocked(place, lit.towards, lit.distance * 0.9999) {
                hidden += 1.0;
                continue;
            }
            let passing = medium.between(place, lit.towards, lit.distance);
            let phase = medium.phase(direction.dot(lit.towards));
            light += lit.irradiance * (medium.sigma_s * passing * phase);
        }
        (light, hidden / self.lamp_count().max(1) as f32, nearest)
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
