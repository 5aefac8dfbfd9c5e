//! Metres to integers: world units, lattices, fixed-point views and poses.
//!
//! The static world spans 2^23 world units along its longest side. Each object has a lattice of
//! 16 bits a coordinate (or fewer, see [`Detail`]) over its own bounds, so that small things are
//! placed finely; a lattice point is off by at most half a step: extent/131070 along each axis.

use glam::{Affine3A, DVec3, Vec3};
use unframed_wire::{Pose, SKY, Tick, View, WorldFrame};

use super::Detail;
use crate::trace::World;
use crate::trace::camera::Camera;

/// World units along the longest side of the world.
const SPAN: f64 = (1u32 << 23) as f64;
/// Distance of the sky's lattice corners from the eye, world units.
const SKY_RADIUS: f64 = (1u32 << 28) as f64;
/// Matrix entries stay below 2^`MATRIX_BITS`.
const MATRIX_BITS: i32 = 30;
/// Eyes and translations are held within this many world units.
const PLACE_LIMIT: f64 = (1u32 << 29) as f64;

/// The lattice of one object, metres in its own coordinates.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    centre: DVec3,
    step: DVec3,
}

/// Turns metres into the integers of one stream.
#[derive(Clone, Debug)]
pub struct Quantiser {
    frame: WorldFrame,
    origin: DVec3,
    unit: f64,
    /// From one end of a lattice to the other.
    steps: f64,
    lattices: Vec<Lattice>,
}

impl Quantiser {
    /// The integers for a scene: its static world gives the unit, or its largest object where
    /// nothing is static.
    #[must_use]
    pub fn new(world: &World, detail: Detail) -> Self {
        let steps = detail.steps();
        let extent = |object: u8| {
            let bounds = world.bounds(object);
            (bounds.max - bounds.min).max_element()
        };
        let objects = 0..world.object_count().max(1) as u8;
        let largest = objects.clone().map(extent).fold(0.0f32, f32::max);
        let length = if extent(0) > 0.0 { extent(0) } else { largest };
        let length = if length.is_normal() {
            f64::from(length)
        } else {
            1.0
        };
        let unit = length / SPAN;
        let bounds = world.bounds(0);
        let origin = Vec3::from((bounds.min + bounds.max) * 0.5);
        let lattices = objects
            .map(|object| {
                let bounds = world.bounds(object);
                let (min, max) = (
                    Vec3::from(bounds.min).as_dvec3(),
                    Vec3::from(bounds.max).as_dvec3(),
                );
                // A flat thing still has a lattice across: of single units.
                Lattice {
                    centre: (min + max) * 0.5,
                    step: ((max - min) / steps).max(DVec3::splat(unit)),
                }
            })
            .collect();
        let frame = WorldFrame {
            origin: origin.to_array(),
            unit: unit as f32,
        };
        Self {
            frame,
            origin: origin.as_dvec3(),
            unit,
            steps,
            lattices,
        }
    }

    /// What Hello says of it.
    #[must_use]
    pub fn frame(&self) -> WorldFrame {
        self.frame
    }

    /// The lattice point nearest to a place in an object's own coordinates (a direction for the
    /// sky); outside the bounds the nearest within.
    #[must_use]
    pub fn place(&self, object: u8, local: Vec3) -> [i16; 3] {
        let steps = match self.lattices.get(usize::from(object)) {
            Some(lattice) if object != SKY => (local.as_dvec3() - lattice.centre) / lattice.step,
            _ => local.as_dvec3() * (self.steps * 0.5),
        };
        // A cast saturates, and makes 0 of what is no number.
        steps
            .to_array()
            .map(|v| v.round().clamp(-32767.0, 32767.0) as i16)
    }

    /// The pose of an object at an instant.
    #[must_use]
    pub fn pose(&self, object: u8, pose: &Affine3A, eye: Vec3) -> Pose {
        let (matrix, translation) = match self.lattices.get(usize::from(object)) {
            Some(lattice) if object != SKY => {
                let linear = pose
                    .matrix3
                    .to_cols_array_2d()
                    .map(|c| DVec3::from(c.map(f64::from)));
                let step = lattice.step.to_array();
                let columns: [DVec3; 3] = std::array::from_fn(|j| linear[j] * step[j] / self.unit);
                let centre = lattice.centre.to_array();
                let offset: DVec3 = (0..3).map(|j| linear[j] * centre[j]).sum();
                (columns, offset + Vec3::from(pose.translation).as_dvec3())
            }
            _ => {
                let scale = SKY_RADIUS / (self.steps * 0.5);
                (
                    [DVec3::X * scale, DVec3::Y * scale, DVec3::Z * scale],
                    eye.as_dvec3(),
                )
            }
        };
        let rows: [[f64; 3]; 3] = std::array::from_fn(|k| std::array::from_fn(|j| matrix[j][k]));
        let frac_bits = frac_bits(&rows, 31);
        Pose {
            object,
            matrix: fixed(&rows, frac_bits),
            frac_bits,
            translation: self.units(translation),
        }
    }

    /// The view of a camera.
    #[must_use]
    pub fn view(&self, time: Tick, camera: &Camera) -> View {
        let [right, down, forward] =
            [camera.right, camera.down, camera.forward].map(|v| v.as_dvec3());
        let focal = f64::from(camera.focal);
        let centre = camera.centre.as_dvec2();
        let rows = [
            right * focal + forward * centre.x,
            down * focal + forward * centre.y,
            forward,
        ]
        .map(|row| row.to_array());
        let frac_bits = frac_bits(&rows, 30);
        View {
            time,
            eye: self.units(camera.eye.as_dvec3()),
            rows: fixed(&rows, frac_bits),
            frac_bits,
        }
    }

    /// A place in world coordinates, metres, in world units.
    #[must_use]
    pub fn point(&self, place: Vec3) -> [i32; 3] {
        self.units(place.as_dvec3())
    }

    fn units(&self, place: DVec3) -> [i32; 3] {
        ((place - self.origin) / self.unit)
            .to_array()
            .map(|v| v.round().clamp(-PLACE_LIMIT, PLACE_LIMIT) as i32)
    }
}

/// The most fractional bits that keep every entry below 2^30.
fn frac_bits(rows: &[[f64; 3]; 3], most: i32) -> u8 {
    let largest = rows.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
    if largest > 0.0 && largest.is_finite() {
        (MATRIX_BITS - 1 - largest.log2().floor() as i32).clamp(0, most) as u8
    } else {
        0
    }
}

fn fixed(rows: &[[f64; 3]; 3], frac_bits: u8) -> [[i32; 3]; 3] {
    let one = f64::from(frac_bits).exp2();
    let limit = f64::from(MATRIX_BITS).exp2();
    rows.map(|row| row.map(|v| (v * one).round().clamp(-limit, limit) as i32))
}
