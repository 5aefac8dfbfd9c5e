//! "No reprojection in the sampler" (Dayal et al. 2005 §7, Figure 8): any sampler, told that
//! camera and objects stand as they did at time 0.
//!
//! What it remembers of a place then stays at the pixel where it was seen, and what it takes for
//! a place seen again is that pixel seen again: image-space residuals and gradients. What it finds
//! goes to the display as it is, so that the display still reprojects.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use glam::{Affine3A, UVec2, Vec2, Vec3};
use unframed_host::effects::care::{Care, Told};
use unframed_host::sampler::{Effort, Eye, Sampler, Shot, Span};
use unframed_host::trace::Hit;
use unframed_host::trace::camera::Camera;
use unframed_wire::{SKY, Status, TileFields, TileNode};

/// A sampler that does not know of motion.
pub struct Unmoved {
    inner: Box<dyn Sampler>,
    size: UVec2,
    camera: Option<Camera>,
}

impl Unmoved {
    /// Keeps motion from `inner`, which samples an image of `size` pixels.
    #[must_use]
    pub fn new(inner: Box<dyn Sampler>, size: UVec2) -> Self {
        Self {
            inner,
            size,
            camera: None,
        }
    }
}

impl Sampler for Unmoved {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        let camera = *self.camera.get_or_insert_with(|| eye.camera(0.0));
        let still = StillEye {
            eye,
            camera,
            size: self.size,
            found: Mutex::default(),
        };
        let before = out.len();
        self.inner.epoch(span, &still, out);
        let found = still
            .found
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        for shot in &mut out[before..] {
            if let Some((pixel, hit)) = found.get(&shot.time.to_bits()) {
                (shot.pixel, shot.hit) = (*pixel, *hit);
            }
        }
    }

    fn preferred_span(&self) -> f64 {
        self.inner.preferred_span()
    }

    fn tiles(&mut self, fields: TileFields, out: &mut Vec<TileNode>) {
        self.inner.tiles(fields, out);
    }

    fn take_cut(&mut self) -> Option<f64> {
        self.inner.take_cut()
    }

    fn looks_ahead(&self) -> bool {
        self.inner.looks_ahead()
    }

    fn effort(&self) -> Option<Effort> {
        self.inner.effort()
    }

    fn status(&mut self, status: &Status) {
        self.inner.status(status);
    }
}

/// Sees the world through a camera that never moves: each pixel is a place at the depth found.
struct StillEye<'a> {
    eye: &'a dyn Eye,
    camera: Camera,
    size: UVec2,
    /// What was really found, by the instant of the shot: no two shots share one.
    found: Mutex<BTreeMap<u64, (Vec2, Hit)>>,
}

impl Eye for StillEye<'_> {
    fn camera(&self, _: f64) -> Camera {
        self.camera
    }

    fn pose(&self, object: u8, _: f64) -> Affine3A {
        if object == SKY {
            Affine3A::from_translation(self.camera.eye)
        } else {
            Affine3A::IDENTITY
        }
    }

    fn as_of(&self, time: f64) -> f64 {
        self.eye.as_of(time)
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        self.look_with(time, pixel, seed, Care::default()).0
    }

    fn look_with(&self, time: f64, pixel: Vec2, seed: u32, care: Care) -> (Hit, Told) {
        let (hit, told) = self.eye.look_with(time, pixel, seed, care);
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        found.insert(time.to_bits(), (pixel, hit));
        drop(found);
        let direction = self.camera.direction(pixel);
        let still = if hit.object == SKY {
            Hit {
                local: direction.normalize(),
                ..hit
            }
        } else {
            Hit {
                object: 0,
                local: self.camera.eye + direction * hit.depth,
                ..hit
            }
        };
        (still, told)
    }

    fn look_along(&self, time: f64, direction: Vec3, seed: u32) -> Hit {
        self.look_along_with(time, direction, seed, Care::default())
            .0
    }

    fn look_along_with(&self, time: f64, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        let last = Vec2::new(
            (self.size.x as f32).next_down(),
            (self.size.y as f32).next_down(),
        );
        let pixel = match self.camera.project_direction(direction) {
            Some((pixel, _)) => pixel.clamp(Vec2::ZERO, last),
            None => self.camera.centre,
        };
        self.look_with(time, pixel, seed, care)
    }
}
