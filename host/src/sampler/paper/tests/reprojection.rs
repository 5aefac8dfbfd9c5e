//! Reprojection against f64.

use glam::{Affine3A, DMat3, DVec2, Quat, Vec2, Vec3};

use super::super::crosshair::{Crosshair, Point};
use super::crosshair;
use crate::sampler::Eye;
use crate::sampler::adaptive::projection::Projection;
use crate::sampler::noise::Random;
use crate::trace::camera::Camera;
use crate::trace::{Hit, Rays};

#[test]
fn reprojection_follows_f64() {
    let mut random = Random::new(4);
    let mut compared = 0;
    for _ in 0..2000 {
        let eye = Turned::new(&mut random);
        let mut unit = || random.unit() * 2.0 - 1.0;
        let points: [Vec3; 5] = std::array::from_fn(|_| Vec3::new(unit(), unit(), unit()) * 3.0);
        let mut projection = Projection::new(0.0);
        projection.prepare(1, &eye);
        let point = |local: Vec3| Point {
            object: 1,
            local,
            luminance: local.x.fract().abs(),
        };
        let crosshair = Crosshair {
            centre: point(points[0]),
            arms: [1, 2, 3, 4].map(|k| Some(point(points[k]))),
            gradients: [0.25, 0.75, 0.0],
            ..crosshair(&mut random, 0.0)
        };
        let exact = points.map(|p| eye.exact(p));
        let Some((at, _)) = projection.project(1, points[0]) else {
            assert!(exact[0].is_none_or(|(_, depth)| depth < 0.001));
            continue;
        };
        let (place, depth) = exact[0].expect("seen");
        if depth < 0.05 || place.abs().max_element() > 1e4 {
            continue;
        }
        compared += 1;
        let tolerance = 1e-5 * place.length().max(300.0) / depth.min(1.0);
        assert!(at.as_dvec2().distance(place) < tolerance, "{at} {place}");
        let slopes = crosshair.respaced(at, &projection);
        for (axis, slope) in slopes.into_iter().enumerate() {
            let mut known = Vec::new();
            for k in [2 * axis + 1, 2 * axis + 2] {
                if let Some((arm, _)) = exact[k].filter(|(_, depth)| *depth > 0.0005) {
                    let difference = point(points[k]).luminance - crosshair.centre.luminance;
                    known.push(f64::from(difference.abs()) / arm.distance(place));
                }
            }
            let expected = match known.len() {
                0 => f64::from(crosshair.gradients[axis]),
                n => known.iter().sum::<f64>() / n as f64,
            };
            let close = (f64::from(slope) - expected).abs() < 1e-3 * expected + 1e-6;
            // Arms nearer than a quarter pixel are left out.
            assert!(
                close || known.iter().any(|slope| *slope > 0.2),
                "{slope} {expected}"
            );
        }
    }
    assert!(compared > 500, "{compared}");
}

/// A camera and an object turned and moved at random.
struct Turned {
    camera: Camera,
    pose: Affine3A,
}

impl Turned {
    fn new(random: &mut Random) -> Self {
        let mut unit = || random.unit() * 2.0 - 1.0;
        let mut turn = || Quat::from_xyzw(unit(), unit(), unit(), 1.1).normalize();
        let (look, pose) = (turn(), turn());
        Self {
            camera: Camera {
                eye: Vec3::new(unit(), unit(), unit() - 4.0),
                right: look * Vec3::X,
                down: look * Vec3::Y,
                forward: look * Vec3::Z,
                focal: 220.0,
                centre: Vec2::new(128.0, 96.0),
                aperture: 0.0,
                focus: 1.0,
            },
            pose: Affine3A::from_rotation_translation(pose, Vec3::new(unit(), unit(), unit())),
        }
    }

    /// Pixel and depth in f64; `None` behind the eye.
    fn exact(&self, local: Vec3) -> Option<(DVec2, f64)> {
        let m = self.pose.matrix3;
        let pose = DMat3::from_cols(
            m.x_axis.as_dvec3(),
            m.y_axis.as_dvec3(),
            m.z_axis.as_dvec3(),
        );
        let world = pose * local.as_dvec3() + Vec3::from(self.pose.translation).as_dvec3();
        let d = world - self.camera.eye.as_dvec3();
        let along = |axis: Vec3| -> f64 { d.dot(axis.as_dvec3()) };
        let depth = along(self.camera.forward);
        let place = DVec2::new(along(self.camera.right), along(self.camera.down))
            * (f64::from(self.camera.focal) / depth);
        (depth > 0.0).then(|| (place + self.camera.centre.as_dvec2(), depth))
    }
}

impl Eye for Turned {
    fn camera(&self, _: f64) -> Camera {
        self.camera
    }

    fn pose(&self, _: u8, _: f64) -> Affine3A {
        self.pose
    }

    fn look(&self, _: f64, _: Vec2, _: u32) -> Hit {
        Hit {
            colour: Vec3::ZERO,
            object: 0,
            local: Vec3::ZERO,
            depth: 1.0,
            rays: Rays::default(),
            shares: unframed_wire::Shares::default(),
        }
    }

    fn look_along(&self, time: f64, _: Vec3, seed: u32) -> Hit {
        self.look(time, Vec2::ZERO, seed)
    }
}
