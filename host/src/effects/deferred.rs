//! Deferred shading data: what a pixel sees, once, for all components (Dubla et al. 2009, §3).

use glam::{Vec2, Vec3};

use super::care::Care;
use crate::trace::Rays;
use crate::trace::cone::Cone;
use crate::trace::moment::{Moment, Struck};
use crate::trace::shade::{Path, Shader};

/// What the ray through a pixel's middle met. Light and albedo are apart, so that filtering
/// light does not blur texture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deferred {
    pub(crate) eye: Vec3,
    /// Unit direction of the ray.
    pub(crate) direction: Vec3,
    /// Metres along it; infinite for the sky.
    pub(crate) distance: f32,
    /// The surface, if any.
    pub(crate) struck: Option<Struck>,
    /// Diffuse reflectance; zero for the sky, mirrors and glass.
    pub(crate) albedo: Vec3,
    /// Light that is not reflected diffusely: emission, sky, all of mirrors and glass.
    pub(crate) own: Vec3,
}

impl Deferred {
    /// Looks through pixel coordinates `at`.
    pub(crate) fn look(moment: &Moment<'_>, at: Vec2, rays: &mut Rays) -> Self {
        rays.primary += 1;
        let camera = moment.camera();
        let direction = camera.direction(at);
        let length = direction.length();
        let direction = direction / length;
        let mut shader = Shader::new(moment, 0, Care::default());
        let Some(struck) = moment.closest(camera.eye, direction) else {
            return Self {
                eye: camera.eye,
                direction,
                distance: f32::INFINITY,
                struck: None,
                albedo: Vec3::ZERO,
                own: shader.sky(direction),
            };
        };
        let path = Path {
            direction,
            cone: Cone::of_pixel(camera, 1.0 / length).after(struck.t),
            bounces: 0,
            weight: Vec3::ONE,
        };
        let (albedo, own) = shader.split(&struck, &path);
        *rays += shader.rays;
        Self {
            eye: camera.eye,
            direction,
            distance: struck.t,
            struck: Some(struck),
            albedo,
            own,
        }
    }

    /// Whether light may be shared with another pixel: the same kind of surface, at about the
    /// same depth and slope (the discontinuity buffer of Keller 1998; thresholds as in Wald et
    /// al. 2002 in kind).
    pub(crate) fn like(&self, other: &Self) -> bool {
        match (&self.struck, &other.struck) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                let lift = (b.place - a.place).dot(a.flat).abs();
                a.smooth.dot(b.smooth) > 0.9 && lift < 0.02 * self.distance
            }
            _ => false,
        }
    }
}
