//! What a ray sees at an instant.
//!
//! [`World`] is a scene made ready for rays: static geometry in one flat BVH, each mover in a BVH
//! of its own under the transform of the instant.

pub mod camera;
mod check;
mod cone;
mod epoch;
mod geometry;
mod ideal;
mod light;
mod moment;
pub mod pattern;
mod shade;
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
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rays {
    /// From the camera.
    pub primary: u32,
    /// Towards lights.
    pub shadow: u32,
    /// Mirror and glass bounces.
    pub bounce: u32,
}
