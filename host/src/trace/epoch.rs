//! A short stretch of time made ready: everything that moves, at knots a millisecond apart.
//!
//! Between knots, cameras, lights and the *inverse* transforms of movers are blended along
//! straight lines, since a sample cannot afford to evaluate keyframes. A point at radius r that
//! turns at ω is then off by at most r(ωh)²/8 for knots h apart: for a wheel of 0.3 m at 20
//! rad/s and h = 1 ms that is 15 µm. Keys and loop ends are knots themselves, so that corners
//! stay sharp and jumps take 0.1 µs.

use glam::{Affine3A, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::camera::Camera;
use super::geometry::Boxed;
use super::light::Place;

/// Greatest distance of knots, seconds.
const SPACING: f64 = 1e-3;
/// Most knots in an epoch; longer epochs get wider spacing.
const MAX_KNOTS: f64 = 64.0;
/// How long before a corner its last knot lies, seconds.
const JUMP: f64 = 1e-7;
/// From how many movers on a tree pays.
const TREE_FROM: usize = 9;

/// All that moves, at an instant.
#[derive(Clone)]
pub(crate) struct Knot {
    /// Seconds.
    pub(crate) time: f64,
    pub(crate) camera: Camera,
    /// World to frame, one a frame.
    pub(crate) inverses: Vec<Affine3A>,
    pub(crate) lamps: Vec<Place>,
    /// Node to world, one a lamp; empty without area lights.
    pub(crate) lamp_poses: Vec<Affine3A>,
}

/// How a stretch of time is to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outlook {
    /// Each instant as it is.
    Present,
    /// Each instant as what was foreseen of the stretch's end at its beginning, or at the last corner.
    End,
}

/// The prepared stretch. Invariant: at least one knot, times ascending.
#[derive(Clone)]
pub(crate) struct Epoch {
    pub(crate) outlook: Outlook,
    pub(crate) knots: Vec<Knot>,
    /// Movers that can be seen, and what each sweeps over.
    pub(crate) swept: Vec<(u32, Aabb)>,
    /// Over `swept`, when there are many.
    pub(crate) tree: Option<Bvh2>,
}

impl Epoch {
    /// The instants to evaluate for `t0..=t1`.
    pub(crate) fn times(t0: f64, t1: f64, corners: &[f64], outlook: Outlook) -> Vec<f64> {
        let t1 = t1.max(t0);
        let mut times = vec![t0];
        match outlook {
            Outlook::Present => {
                let steps = ((t1 - t0) / SPACING).ceil().clamp(0.0, MAX_KNOTS);
                for i in 1..=steps as u32 {
                    times.push(t0 + (t1 - t0) * f64::from(i) / steps);
                }
                for &corner in corners {
                    times.extend([(corner - JUMP).max(t0), corner]);
                }
            }
            // What is foreseen holds until something unforeseen may have happened.
            Outlook::End => times.extend(corners),
        }
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Puts the tree over the swept boxes.
    pub(crate) fn index(&mut self) {
        self.tree = (self.swept.len() >= TREE_FROM).then(|| {
            let boxes: Vec<_> = self.swept.iter().map(|&(_, b)| Boxed(b)).collect();
            build_bvh2(
                &boxes,
                BvhBuildParams::fastest_build(),
                &mut Default::default(),
            )
        });
    }

    /// The knot before `t`, and how far towards the next (0..=1). Instants outside the epoch
    /// give its ends.
    pub(crate) fn locate(&self, t: f64) -> (usize, f32) {
        let after = self.knots.partition_point(|k| k.time <= t);
        if after == 0 || after == self.knots.len() {
            return (after.saturating_sub(1), 0.0);
        }
        if self.outlook == Outlook::End {
            // What is foreseen at the next knot is not known yet.
            return (after - 1, 0.0);
        }
        let (a, b) = (self.knots[after - 1].time, self.knots[after].time);
        (after - 1, ((t - a) / (b - a)) as f32)
    }
}

/// What a box sweeps over while its frame goes through `poses`.
///
/// Between two poses a corner leaves the hull of its ends by at most the sagitta of its arc,
/// which is below a quarter of the chord for turns up to 90°. `None` if a pose is singular: the
/// thing has no volume to be seen.
pub(crate) fn sweep(local: &Aabb, poses: impl Iterator<Item = Affine3A>) -> Option<Aabb> {
    let corner = |i: u32| {
        Vec3A::new(
            if i & 1 == 0 { local.min.x } else { local.max.x },
            if i & 2 == 0 { local.min.y } else { local.max.y },
            if i & 4 == 0 { local.min.z } else { local.max.z },
        )
    };
    let mut swept = Aabb::empty();
    let mut before: Option<[Vec3A; 8]> = None;
    let mut chord = 0.0f32;
    for pose in poses {
        let determinant = pose.matrix3.determinant();
        if !determinant.is_normal() {
            return None;
        }
        let now: [Vec3A; 8] = std::array::from_fn(|i| pose.transform_point3a(corner(i as u32)));
        for (i, &p) in now.iter().enumerate() {
            swept.extend(p);
            if let Some(before) = &before {
                chord = chord.max(before[i].distance(p));
            }
        }
        before = Some(now);
    }
    before?;
    // Rounding of the boxes themselves besides.
    let pad = Vec3A::splat(0.25 * chord) + swept.min.abs().max(swept.max.abs()) * 1e-6;
    Some(Aabb::new(swept.min - pad, swept.max + pad))
}

/// The inverse; of a singular transform, which leaves nothing to be seen, zero.
pub(crate) fn inverse_or_zero(pose: &Affine3A) -> Affine3A {
    if pose.matrix3.determinant().is_normal() {
        pose.inverse()
    } else {
        Affine3A::ZERO
    }
}

/// Straight-line blend of two transforms.
#[inline]
pub(crate) fn blend(a: &Affine3A, b: &Affine3A, f: f32) -> Affine3A {
    Affine3A {
        matrix3: glam::Mat3A::from_cols(
            a.matrix3.x_axis.lerp(b.matrix3.x_axis, f),
            a.matrix3.y_axis.lerp(b.matrix3.y_axis, f),
            a.matrix3.z_axis.lerp(b.matrix3.z_axis, f),
        ),
        translation: a.translation.lerp(b.translation, f),
    }
}

/// Straight-line blend of two cameras; over a millisecond the axes stay orthonormal to 1e-5.
pub(crate) fn blend_cameras(a: &Camera, b: &Camera, f: f32) -> Camera {
    Camera {
        eye: a.eye.lerp(b.eye, f),
        right: a.right.lerp(b.right, f),
        down: a.down.lerp(b.down, f),
        forward: a.forward.lerp(b.forward, f),
        ..*a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn knots_hold_corners_and_stay_close() {
        let times = Epoch::times(1.0, 1.0035, &[1.002], Outlook::Present);
        assert_eq!((times[0], times[times.len() - 1]), (1.0, 1.0035));
        assert!(times.contains(&1.002));
        assert!(
            times
                .windows(2)
                .all(|w| w[1] > w[0] && w[1] - w[0] <= SPACING * 1.0001)
        );
        // What is foreseen holds from its beginning, and from each corner on.
        let times = Epoch::times(1.0, 1.0035, &[1.002], Outlook::End);
        assert_eq!(times, [1.0, 1.002]);
        for outlook in [Outlook::Present, Outlook::End] {
            assert_eq!(Epoch::times(2.0, 2.0, &[], outlook), [2.0]);
            assert_eq!(Epoch::times(2.0, 1.0, &[], outlook), [2.0]);
        }
    }

    #[test]
    fn a_sweep_covers_every_instant() {
        let local = Aabb::new(Vec3A::new(0.5, -0.1, -0.1), Vec3A::new(1.0, 0.1, 0.1));
        let pose = |s: f32| {
            Affine3A::from_rotation_translation(
                Quat::from_rotation_z(s * 1.5),
                glam::Vec3::new(s, 2.0 * s * s, 0.0),
            )
        };
        let swept = sweep(&local, [0.0, 1.0].into_iter().map(pose)).unwrap();
        for i in 0..=100 {
            let now = sweep(&local, std::iter::once(pose(i as f32 / 100.0))).unwrap();
            assert!(swept.union(&now) == swept, "{i}");
        }
        assert!(
            sweep(
                &local,
                std::iter::once(Affine3A::from_scale(glam::Vec3::ZERO))
            )
            .is_none()
        );
    }
}
