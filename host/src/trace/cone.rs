//! Ray cones: how much of a surface a pixel sees (Akenine-Möller, Nilsson, Andersson,
//! Barré-Brisebois, Toth and Karras, "Texture level of detail strategies for real-time ray
//! tracing", 2019, §20.3.4; anisotropy as in Akenine-Möller et al., "Improved shader and texture
//! level of detail using ray cones", 2021, §4).
//!
//! A cone starts at the eye without width and opens by a pixel's angle. Mirrors carry it on and
//! curved ones open or close it; refraction leaves its angle as it is, and a lens counts as a
//! pinhole.

use glam::{Vec2, Vec3};

use super::camera::Camera;

/// Side of the square that texture is averaged over, pixels. Measured in `docs/RESULTS.md`,
/// "Texture filter".
const PIXELS: f32 = 1.0;
/// Below this cosine, footprints grow no longer; what is seen there is a sliver.
const GRAZING: f32 = 0.01;

/// A cone at a place on its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cone {
    /// Width across the axis, metres.
    width: f32,
    /// Growth of the width, metres a metre; negative where it closes.
    spread: f32,
}

impl Cone {
    /// The cone of a pixel at the eye, for a ray at an angle of cosine `cos` to the camera's
    /// axis: a pixel's width at any depth.
    pub(crate) fn of_pixel(camera: &Camera, cos: f32) -> Self {
        Self {
            width: 0.0,
            spread: PIXELS * cos.max(GRAZING) / camera.focal,
        }
    }

    /// The cone after `distance` metres. It passes through its focus and opens again.
    pub(crate) fn after(self, distance: f32) -> Self {
        let width = self.width + self.spread * distance;
        Self {
            width: width.abs(),
            spread: if width < 0.0 {
                -self.spread
            } else {
                self.spread
            },
        }
    }

    /// The cone behind a mirror of `curvature`, 1/m, positive where it bulges to the viewer.
    /// The geometric mean of what it does in and across the plane of incidence.
    pub(crate) fn reflected(self, curvature: f32) -> Self {
        Self {
            spread: self.spread + 2.0 * curvature * self.width,
            ..self
        }
    }

    /// What the cone covers of a plane with unit `normal`, met along the unit `direction`, in
    /// texture coordinates whose gradients are `gradients` (1/m).
    pub(crate) fn footprint(
        self,
        uv: Vec2,
        gradients: [Vec3; 2],
        normal: Vec3,
        direction: Vec3,
    ) -> Footprint {
        let cos = normal.dot(direction);
        let along = (direction - normal * cos)
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        let across = normal.cross(along);
        let on = |axis: Vec3| Vec2::new(gradients[0].dot(axis), gradients[1].dot(axis));
        Footprint {
            uv,
            long: on(along) * (self.width / cos.abs().max(GRAZING)),
            short: on(across) * self.width,
        }
    }
}

/// A parallelogram of texture coordinates to be averaged over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Its middle.
    pub(crate) uv: Vec2,
    /// The side along which the surface recedes.
    pub(crate) long: Vec2,
    /// The other side.
    pub(crate) short: Vec2,
}

impl Footprint {
    /// Nothing but a point.
    pub(crate) fn point(uv: Vec2) -> Self {
        Self {
            uv,
            long: Vec2::ZERO,
            short: Vec2::ZERO,
        }
    }

    /// Sides of the upright box with the same variance in u and in v.
    pub(crate) fn extent(&self) -> Vec2 {
        let square = self.long * self.long + self.short * self.short;
        Vec2::new(square.x.sqrt(), square.y.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone(width: f32, spread: f32) -> Cone {
        Cone { width, spread }
    }

    #[test]
    fn a_cone_opens_closes_and_passes_its_focus() {
        assert_eq!(cone(0.0, 0.25).after(4.0), cone(1.0, 0.25));
        assert_eq!(cone(0.5, -0.25).after(4.0), cone(0.5, 0.25));
        // A flat mirror changes nothing; a ball of radius 0.5 opens a beam as its focal length
        // r/2 says: width/f.
        assert_eq!(cone(0.1, 0.02).reflected(0.0), cone(0.1, 0.02));
        let opened = cone(0.1, 0.0).reflected(2.0);
        assert!((opened.spread - 0.1 / 0.25).abs() < 1e-6);
    }

    #[test]
    fn footprints_stretch_where_surfaces_recede() {
        // u runs along x, v along z, 2 and 1 a metre, on a floor seen at 60° from its normal.
        let gradients = [Vec3::X * 2.0, Vec3::Z];
        let direction = Vec3::new(0.0, -0.5, -(0.75f32.sqrt()));
        let seen = cone(0.1, 0.0).footprint(Vec2::ZERO, gradients, Vec3::Y, direction);
        assert!((seen.long.y.abs() - 0.2).abs() < 1e-6 && seen.long.x.abs() < 1e-6);
        assert!((seen.short.x.abs() - 0.2).abs() < 1e-6 && seen.short.y.abs() < 1e-6);
        assert!(seen.extent().distance(Vec2::splat(0.2)) < 1e-6);
        // Straight on, both sides are the width.
        let seen = cone(0.1, 0.0).footprint(Vec2::ZERO, gradients, Vec3::Y, Vec3::NEG_Y);
        assert!(seen.extent().distance(Vec2::new(0.2, 0.1)) < 1e-6);
    }
}
