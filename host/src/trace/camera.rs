//! The camera at an instant.

use glam::{Vec2, Vec3};

/// A pinhole camera at an instant: the bridge between pixels and rays.
///
/// Pixel coordinates have their origin at the top left corner of the image; pixel centres lie
/// at halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, metres.
    pub eye: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector down the image.
    pub down: Vec3,
    /// Unit vector along the axis.
    pub forward: Vec3,
    /// Focal length in pixels (square pixels).
    pub focal: f32,
    /// Pixel coordinates of the axis: half the image size.
    pub centre: Vec2,
    /// Radius of the aperture, metres; 0 is a pinhole.
    pub aperture: f32,
    /// Distance in focus, metres.
    pub focus: f32,
}

impl Camera {
    /// Direction from the eye through pixel coordinates `p`; its component along the axis is 1,
    /// so that a ray parameter is a depth.
    #[must_use]
    pub fn direction(&self, p: Vec2) -> Vec3 {
        let v = (p - self.centre) / self.focal;
        self.forward + self.right * v.x + self.down * v.y
    }

    /// Pixel coordinates and depth of a point; `None` at or behind the eye's plane.
    #[must_use]
    pub fn project(&self, point: Vec3) -> Option<(Vec2, f32)> {
        self.project_direction(point - self.eye)
    }

    /// The same for a direction (a point at infinity, such as a sky sample).
    #[must_use]
    pub fn project_direction(&self, d: Vec3) -> Option<(Vec2, f32)> {
        let z = self.forward.dot(d);
        if z <= 1e-6 {
            return None;
        }
        let p = Vec2::new(self.right.dot(d), self.down.dot(d)) * (self.focal / z) + self.centre;
        Some((p, z))
    }
}
