//! Deferred shading data: what a pixel sees, once, for all components (Dubla et al. 2009, §3).

use glam::{Vec2, Vec3};

use super::care::Care;
use crate::trace::Rays;
use crate::trace::cone::Cone;
use crate::trace::moment::{Moment, Struck};
use crate::trace::shade::{Path, Shader, mirrors};

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
    /// Looks through pixel coordinates `at` and the middle of the lens.
    pub(crate) fn look(moment: &Moment<'_>, at: Vec2, rays: &mut Rays) -> Self {
        Self::look_through(moment, at, Vec2::ZERO, 0, rays)
    }

    /// Looks through a place of the lens, metres from its middle to the right and down. What mirrors
    /// and glass show depends on `seed`.
    pub(crate) fn look_through(
        moment: &Moment<'_>,
        at: Vec2,
        lens: Vec2,
        seed: u32,
        rays: &mut Rays,
    ) -> Self {
        rays.primary += 1;
        let camera = moment.camera();
        let offset = camera.right * lens.x + camera.down * lens.y;
        let eye = camera.eye + offset;
        // All rays of a pixel meet in the plane of focus.
        let direction = camera.direction(at) - offset / camera.focus.max(1e-3);
        let length = direction.length();
        let direction = direction / length;
        let mut shader = Shader::new(moment, seed, Care::default());
        let Some(struck) = moment.closest(eye, direction) else {
            return Self {
                eye,
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
            eye,
            direction,
            distance: struck.t,
            struck: Some(struck),
            albedo,
            own,
        }
    }

    /// Whether no mirror and no glass is seen.
    pub(crate) fn is_matt(&self, moment: &Moment<'_>) -> bool {
        self.struck.is_none_or(|struck| {
            let material = &moment.world.scene.materials[struck.spot.material as usize];
            !mirrors(material) && material.transmission == 0.0
        })
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
