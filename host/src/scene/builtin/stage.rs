//! Puts a built-in scene together: materials, nodes, tracks.

use glam::{Quat, Vec3};

use crate::scene::model::{
    Channel, Interpolation, Lens, Light, LightKind, Material, Medium, Mesh, Node, Primitive,
    Procedural, Scene, Sky, Track,
};

/// A scene under construction.
pub(super) struct Stage(Scene);

/// A viewpoint that the camera passes.
pub(super) struct View {
    /// When, seconds.
    pub(super) at: f32,
    /// The eye, metres.
    pub(super) eye: Vec3,
    /// What is in the middle of the image, metres.
    pub(super) target: Vec3,
}

/// Shorthand for a viewpoint.
pub(super) fn view(at: f32, eye: [f32; 3], target: [f32; 3]) -> View {
    View {
        at,
        eye: eye.into(),
        target: target.into(),
    }
}

impl Stage {
    pub(super) fn new(name: &str, duration: f64, sky: Sky) -> Self {
        Self(Scene {
            name: name.into(),
            duration,
            sky,
            ..Scene::default()
        })
    }

    pub(super) fn done(self) -> Scene {
        self.0
    }

    pub(super) fn material(&mut self, material: Material) -> usize {
        self.0.materials.push(material);
        self.0.materials.len() - 1
    }

    /// A matt material.
    pub(super) fn matt(&mut self, name: &str, colour: [f32; 3]) -> usize {
        let base_colour = Vec3::from(colour).extend(1.0);
        self.material(Material {
            name: name.into(),
            base_colour,
            ..Material::default()
        })
    }

    /// A matt material with a pattern.
    pub(super) fn patterned(&mut self, name: &str, colour: [f32; 3], p: Procedural) -> usize {
        let material = self.matt(name, colour);
        self.0.materials[material].procedural = Some(p);
        material
    }

    /// A mirror, tinted, reflecting the share `metallic`.
    pub(super) fn mirror(&mut self, name: &str, colour: [f32; 3], metallic: f32) -> usize {
        let material = self.matt(name, colour);
        self.0.materials[material].metallic = metallic;
        self.0.materials[material].roughness = 0.0;
        material
    }

    /// A matt material that shines with `radiance`, W/(m²·sr): its meshes are area lights, from their
    /// front.
    pub(super) fn glow(&mut self, name: &str, radiance: [f32; 3]) -> usize {
        let material = self.matt(name, [0.0; 3]);
        self.0.materials[material].emissive = radiance.into();
        self.0.materials[material].double_sided = false;
        material
    }

    /// Fills a box with a medium that scatters `scattering` 1/m and absorbs a tenth of that, asymmetry `g`.
    pub(super) fn medium(&mut self, min: Vec3, max: Vec3, scattering: f32, g: f32) {
        self.0.medium = Some(Medium {
            min,
            max,
            sigma_s: scattering,
            sigma_a: 0.1 * scattering,
            g,
        });
    }

    /// Calls for light between matt surfaces.
    pub(super) fn indirect(&mut self) {
        self.0.indirect = true;
    }

    /// A node without anything on it.
    pub(super) fn node(&mut self, name: &str, parent: Option<usize>, at: Vec3) -> usize {
        let node = Node {
            name: name.into(),
            parent,
            translation: at,
            ..Node::default()
        };
        self.0.nodes.push(node);
        self.0.nodes.len() - 1
    }

    /// A node with a mesh.
    pub(super) fn solid(
        &mut self,
        name: &str,
        parent: Option<usize>,
        at: Vec3,
        primitives: Vec<Primitive>,
    ) -> usize {
        self.0.meshes.push(Mesh {
            name: name.into(),
            primitives,
        });
        let node = self.node(name, parent, at);
        self.0.nodes[node].mesh = Some(self.0.meshes.len() - 1);
        node
    }

    /// Another node with the mesh of `model`.
    pub(super) fn copy(&mut self, model: usize, parent: Option<usize>, at: Vec3) -> usize {
        let name = self.0.nodes[model].name.clone();
        let node = self.node(&name, parent, at);
        self.0.nodes[node].mesh = self.0.nodes[model].mesh;
        node
    }

    /// A point light of `candela` W/sr.
    pub(super) fn point_light(&mut self, parent: Option<usize>, at: Vec3, candela: [f32; 3]) {
        let node = self.node("light", parent, at);
        self.0.nodes[node].light = Some(Light {
            kind: LightKind::Point,
            intensity: candela.into(),
            range: f32::INFINITY,
        });
    }

    /// Parallel light along `direction`, of `irradiance` W/m² on what faces it.
    pub(super) fn sun(&mut self, direction: Vec3, irradiance: [f32; 3]) {
        let node = self.node("sun", None, Vec3::ZERO);
        self.0.nodes[node].rotation = towards(direction);
        self.0.nodes[node].light = Some(Light {
            kind: LightKind::Directional,
            intensity: irradiance.into(),
            range: f32::INFINITY,
        });
    }

    /// Swings a node about an axis of its own, `turns` whole times a loop, to `angle` radians
    /// either side of its middle.
    pub(super) fn swing(&mut self, node: usize, axis: Vec3, middle: f32, angle: f32, turns: u32) {
        let keys = 24 * turns.max(1);
        let at = |i: u32| i as f32 / keys as f32;
        let times = (0..=keys).map(|i| self.0.duration as f32 * at(i)).collect();
        let turn = |i| middle + angle * (std::f32::consts::TAU * turns as f32 * at(i)).sin();
        let rotations = (0..=keys).map(|i| Quat::from_axis_angle(axis, turn(i)));
        let track = Track::Rotation(rotations.collect());
        self.track(node, times, track, Interpolation::Linear);
    }

    /// A track of a node; it loops with the scene.
    pub(super) fn track(
        &mut self,
        node: usize,
        times: Vec<f32>,
        track: Track,
        interpolation: Interpolation,
    ) {
        let period = self.0.duration as f32;
        self.0.channels.push(Channel {
            node,
            track,
            times,
            interpolation,
            period,
        });
    }

    /// Turns a node steadily about an axis of its own, `turns` whole times a loop.
    pub(super) fn spin(&mut self, node: usize, axis: Vec3, turns: i32) {
        // Slerp goes the short way: keys a quarter turn apart are safe.
        let keys = 4 * turns.unsigned_abs().max(1);
        let times = (0..=keys)
            .map(|i| self.0.duration as f32 * i as f32 / keys as f32)
            .collect();
        let step = std::f32::consts::FRAC_PI_2 * turns.signum() as f32;
        let rotations = (0..=keys).map(|i| Quat::from_axis_angle(axis, step * i as f32));
        let track = Track::Rotation(rotations.collect());
        self.track(node, times, track, Interpolation::Linear);
    }

    /// A camera that rests at each view and eases from one to the next: between two views that
    /// are equal it stands still. `swift` chooses cubic easing with full stops at every view;
    /// otherwise it glides through them.
    pub(super) fn camera(&mut self, views: &[View], full_stops: bool) {
        let node = self.node("camera", None, Vec3::ZERO);
        let yfov = std::f32::consts::FRAC_PI_3;
        self.0.nodes[node].camera = Some(Lens {
            yfov,
            aperture: 0.0,
            focus: 1.0,
        });
        let times: Vec<f32> = views.iter().map(|v| v.at).collect();
        let eyes: Vec<Vec3> = views.iter().map(|v| v.eye).collect();
        let mut turns: Vec<Quat> = views.iter().map(|v| towards(v.target - v.eye)).collect();
        for i in 1..turns.len() {
            if turns[i].dot(turns[i - 1]) < 0.0 {
                turns[i] = -turns[i];
            }
        }
        if let [first] = views {
            self.0.nodes[node].translation = first.eye;
            self.0.nodes[node].rotation = turns[0];
            return;
        }
        let tangents = |i: usize| {
            // Through the neighbours (Catmull–Rom); the loop closes on itself.
            let n = times.len();
            let loops = eyes[0] == eyes[n - 1] && turns[0].dot(turns[n - 1]).abs() > 0.999_999;
            let (before, after) = (
                if i > 0 {
                    (i - 1, 0.0)
                } else {
                    (n - 2, -times[n - 1])
                },
                if i + 1 < n {
                    (i + 1, 0.0)
                } else {
                    (1, times[n - 1])
                },
            );
            if full_stops || !loops && (i == 0 || i + 1 == n) {
                return (Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
            }
            let span = (times[after.0] + after.1) - (times[before.0] + before.1);
            // Quaternions of the same turn may differ in sign across the seam.
            let near = |q: Quat| if q.dot(turns[i]) < 0.0 { -q } else { q };
            (
                (eyes[after.0] - eyes[before.0]) / span,
                (near(turns[after.0]) - near(turns[before.0])) * (1.0 / span),
            )
        };
        let (mut places, mut rotations) = (Vec::new(), Vec::new());
        for i in 0..views.len() {
            let (speed, rate) = tangents(i);
            places.extend([speed, eyes[i], speed]);
            rotations.extend([rate, turns[i], rate]);
        }
        let cubic = Interpolation::CubicSpline;
        self.track(node, times.clone(), Track::Translation(places), cubic);
        self.track(node, times, Track::Rotation(rotations), cubic);
    }
}

/// The rotation of a level camera that looks along `direction`.
fn towards(direction: Vec3) -> Quat {
    let yaw = (-direction.x).atan2(-direction.z);
    let pitch = direction.y.atan2(direction.x.hypot(direction.z));
    Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::animate::Animation;

    #[test]
    fn the_camera_looks_at_its_target_and_stands_between_equal_views() {
        let mut stage = Stage::new("t", 3.0, Sky::default());
        let (a, b) = (
            ([1.0, 2.0, 3.0], [0.0, 0.5, -4.0]),
            ([2.0, 2.0, 2.0], [9.0, 2.0, 2.0]),
        );
        stage.camera(
            &[
                view(0.0, a.0, a.1),
                view(1.0, a.0, a.1),
                view(2.0, b.0, b.1),
                view(3.0, a.0, a.1),
            ],
            true,
        );
        let scene = stage.done();
        let animation = Animation::new(&scene);
        for (t, (eye, target)) in [(0.0, a), (0.7, a), (1.0, a), (2.0, b), (3.0, a)] {
            let pose = animation.world(&scene, 0, t);
            let forward = pose.transform_vector3(Vec3::NEG_Z);
            let wanted = (Vec3::from(target) - Vec3::from(eye)).normalize();
            assert!(
                (forward - wanted).length() < 1e-5,
                "{t}: {forward} {wanted}"
            );
            assert!((Vec3::from(pose.translation) - Vec3::from(eye)).length() < 1e-5);
            assert!(pose.transform_vector3(Vec3::X).y.abs() < 1e-5, "level");
        }
    }
}
