//! Object-local places to pixels at one instant.

use glam::{Mat3A, Vec2, Vec3, Vec3A};

use crate::sampler::Eye;

/// Nearest depth at which a place is seen, metres.
const NEAR: f32 = 0.0005;
/// Depth given to the sky, metres: beyond everything, yet finite.
pub(super) const SKY_DEPTH: f32 = 1e30;

/// The view and all poses of an instant as one matrix an object, made when first needed.
#[derive(Clone, Debug)]
pub(in crate::sampler) struct Projection {
    time: f64,
    scale: f32,
    objects: Vec<Option<(Mat3A, Vec3A)>>,
}

impl Projection {
    /// For an instant, seconds, to pixels of the image.
    pub(in crate::sampler) fn new(time: f64) -> Self {
        Self::scaled(time, 1.0)
    }

    /// For an instant, seconds, to pixels of which `scale` are as wide as one of the image.
    pub(in crate::sampler) fn scaled(time: f64, scale: f32) -> Self {
        Self {
            time,
            scale,
            objects: vec![None; 256],
        }
    }

    /// The instant, seconds.
    pub(in crate::sampler) fn time(&self) -> f64 {
        self.time
    }

    /// Whether the objects that either knows are where they are in the other.
    pub(in crate::sampler) fn agrees(&self, other: &Self) -> bool {
        self.objects == other.objects
    }

    /// Whether an object was prepared.
    pub(in crate::sampler) fn knows(&self, object: u8) -> bool {
        self.objects[usize::from(object)].is_some()
    }

    /// Prepares an object.
    pub(in crate::sampler) fn prepare(&mut self, object: u8, eye: &dyn Eye) {
        let entry = &mut self.objects[usize::from(object)];
        if entry.is_none() {
            let camera = eye.camera(self.time);
            let pose = eye.pose(object, self.time);
            let x = camera.right * camera.focal + camera.forward * camera.centre.x;
            let y = camera.down * camera.focal + camera.forward * camera.centre.y;
            let [x, y] = [x, y].map(|axis| (axis * self.scale).into());
            let view = Mat3A::from_cols(x, y, camera.forward.into()).transpose();
            let origin = view * (pose.translation - Vec3A::from(camera.eye));
            *entry = Some((view * pose.matrix3, origin));
        }
    }

    /// Pixel coordinates and depth in metres of a place of a prepared object; `None` behind the
    /// eye, too near, or of an object that was not prepared.
    pub(in crate::sampler) fn project(&self, object: u8, local: Vec3) -> Option<(Vec2, f32)> {
        let (matrix, origin) = self.objects[usize::from(object)].as_ref()?;
        let p = *matrix * Vec3A::from(local) + *origin;
        if p.z <= NEAR {
            return None;
        }
        let pixel = Vec2::new(p.x, p.y) / p.z;
        Some((
            pixel,
            if object == unframed_wire::SKY {
                SKY_DEPTH
            } else {
                p.z
            },
        ))
    }
}

/// Whether two depths (metres) are of one surface, as far as a pixel can tell.
pub(super) fn same_depth(a: f32, b: f32) -> bool {
    (a - b).abs() <= 0.05 * a.min(b) + 0.003
}
