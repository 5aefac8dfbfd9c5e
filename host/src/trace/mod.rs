//! What a ray sees at an instant.
//!
//! [`World`] is a scene made ready for rays: static geometry in one flat BVH, each mover in a BVH
//! of its own under the transform of the instant.

pub mod camera;
mod casters;
mod check;
pub(crate) mod cone;
mod epoch;
mod geometry;
mod ideal;
pub(crate) mod light;
pub(crate) mod moment;
pub mod pattern;
pub(crate) mod shade;
mod skin;
pub mod srgb;
#[cfg(test)]
mod tests;
mod texture;
mod world;

pub use check::{MAX_SIZE, WorldError};
pub use ideal::ideal;
pub use moment::Moment;
pub use obvhs::aabb::Aabb;
pub use world::{MAX_OBJECTS, Motion, World};

use glam::Vec3;
use unframed_wire::Shares;

/// What one camera ray found: all that the sampler and the stream need of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Displayed colour, linear light, each channel clamped to 0..=1. The 8-bit sample on the
    /// wire is its sRGB encoding; the ideal image averages these.
    pub colour: Vec3,
    /// Object id as on the wire: 0 static, movers from 1, [`unframed_wire::SKY`].
    pub object: u8,
    /// The place in the object's own coordinates, metres (static: world; sky: unit direction).
    pub local: Vec3,
    /// Depth along the camera's axis, metres; infinite for the sky.
    pub depth: f32,
    /// Rays traced for it, of each kind.
    pub rays: Rays,
    /// With [`crate::effects::care::Care::open`] what the lamps bring whose shadows the display
    /// draws; else of nothing.
    pub shares: Shares,
}

/// Rays by what called for them; no ray is counted twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rays {
    /// From the camera.
    pub primary: u32,
    /// From surfaces towards point, spot and directional lights.
    pub shadow: u32,
    /// From surfaces towards area lights.
    pub soft: u32,
    /// From mirrors.
    pub bounce: u32,
    /// From glass, reflected and refracted.
    pub refraction: u32,
    /// From within a medium towards lights.
    pub medium: u32,
    /// From surfaces towards virtual point lights.
    pub indirect: u32,
}

impl Rays {
    /// Rays by the name of the effect that called for them (as in `scene::calls`).
    #[must_use]
    pub fn by_effect(&self) -> [(&'static str, u32); 6] {
        [
            ("hard_shadows", self.shadow),
            ("soft_shadows", self.soft),
            ("mirror", self.bounce),
            ("refraction", self.refraction),
            ("medium", self.medium),
            ("indirect_diffuse", self.indirect),
        ]
    }

    /// Rays of all kinds.
    #[must_use]
    pub fn total(&self) -> u32 {
        self.primary + self.by_effect().iter().map(|(_, n)| n).sum::<u32>()
    }
}

impl std::ops::AddAssign for Rays {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.soft += other.soft;
        self.bounce += other.bounce;
        self.refraction += other.refraction;
        self.medium += other.medium;
        self.indirect += other.indirect;
    }
}
