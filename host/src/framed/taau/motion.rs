//! How surfaces move over the image, and where what is seen now was.

use glam::{Affine3A, UVec2, Vec2, Vec3A};

use super::history::{SAME_DEPTH, Surface};
use crate::trace::World;
use crate::trace::camera::Camera;

/// How surfaces move over the image from one instant to another.
pub(super) struct Motion {
    /// For each object, its coordinates' movement through the world.
    objects: Vec<Affine3A>,
    from: Camera,
    to: Camera,
}

impl Motion {
    pub(super) fn new(world: &World, from: (&Camera, f64), to: (&Camera, f64)) -> Self {
        let objects = (0..world.object_count())
            .map(|object| {
                let (now, then) = (
                    world.pose(object as u8, from.1),
                    world.pose(object as u8, to.1),
                );
                if object == 0 || !now.matrix3.determinant().is_normal() {
                    Affine3A::IDENTITY
                } else {
                    then * now.inverse()
                }
            })
            .collect();
        Self {
            objects,
            from: *from.0,
            to: *to.0,
        }
    }

    /// Where a surface seen at a place of the one view is in the other, and its inverse depth.
    pub(super) fn carry(&self, at: Vec2, surface: Surface) -> Option<(Vec2, f32)> {
        let direction = Vec3A::from(self.from.direction(at));
        // The place is eye + direction/w; times w, so that the sky needs no case of its own.
        let w = surface.inverse_depth;
        let offset = match self.objects.get(usize::from(surface.object)) {
            Some(moved) => {
                let eye = moved.transform_point3a(self.from.eye.into());
                moved.matrix3 * direction + (eye - Vec3A::from(self.to.eye)) * w
            }
            None => direction,
        };
        let (pixel, depth) = self.to.project_direction(offset.into())?;
        Some((pixel, w / depth))
    }
}

/// Where in the history the surface lies that is seen at a place now: a fixed point of the
/// motion, from several starts, for near surfaces move over far ones.
pub(super) fn find_source(at: Vec2, moved: &[Option<(Vec2, f32)>], size: UVec2) -> Vec2 {
    let last = size.as_vec2() - 1.0;
    let look = |q: Vec2| {
        let pixel = (q - 0.5).round().clamp(Vec2::ZERO, last);
        let target = moved[pixel.y as usize * size.x as usize + pixel.x as usize];
        target.map(|(to, inverse_depth)| (to - pixel - 0.5, inverse_depth))
    };
    const STARTS: [Vec2; 5] = [
        Vec2::ZERO,
        Vec2::new(3.0, 0.0),
        Vec2::new(-3.0, 0.0),
        Vec2::new(0.0, 3.0),
        Vec2::new(0.0, -3.0),
    ];
    let mut best = (f32::INFINITY, 0.0, at);
    for start in STARTS {
        let mut q = at + start;
        for _ in 0..3 {
            if let Some((motion, _)) = look(q) {
                q = at - motion;
            }
        }
        let Some((motion, inverse_depth)) = look(q) else {
            continue;
        };
        let off = (q + motion - at).length();
        // Among surfaces that do arrive here the nearest one is seen.
        let arrives = off < 0.75;
        let best_arrives = best.0 < 0.75;
        let better = match (arrives, best_arrives) {
            (true, true) => inverse_depth > best.1 * (1.0 + SAME_DEPTH),
            (false, false) => off < best.0,
            (arrives, _) => arrives,
        };
        if better {
            best = (off, inverse_depth, q);
        }
    }
    best.2
}
