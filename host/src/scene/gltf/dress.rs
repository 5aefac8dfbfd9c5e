//! What a file leaves open, so that any file shows something: a camera that frames the scene and
//! orbits it, a neutral sky, the distance in focus, a sensible exposure of its lights.

use super::error::{Fault, Warnings};
use crate::scene::animate::Animation;
use crate::scene::{Channel, Interpolation, Lens, Light, LightKind, Node, Scene, Sky, Track};
use glam::{Quat, Vec3};
use std::f32::consts::{PI, TAU};

/// Seconds of one turn of the camera around a scene without one.
pub const ORBIT_SECONDS: f32 = 12.0;
/// Vertical field of view of that camera, radians (45°).
pub const ORBIT_YFOV: f32 = PI / 4.0;
/// How far that camera looks down, radians (15°).
pub const ORBIT_ELEVATION: f32 = PI / 12.0;
/// How much farther away it is than a tight fit.
const ORBIT_MARGIN: f32 = 1.2;
/// Light of a scene without any: a key light that lights a white surface facing it to 0.65, a
/// little to the right of and above the first view, and ambient light in its shadows.
const KEY_IRRADIANCE: f32 = 0.65 * PI;
const NEUTRAL_SKY: Sky = Sky {
    zenith: Vec3::new(0.30, 0.38, 0.50),
    horizon: Vec3::new(0.66, 0.70, 0.74),
    ambient: Vec3::new(0.28, 0.30, 0.33),
};
/// Stands for the light between surfaces, which is not traced, where a file has its own lights.
const INDIRECT_AMBIENT: f32 = 0.1;
/// Irradiance at the centre of the scene above which punctual lights are taken to be in
/// photometric units (lux of daylight, candela of lamps) and are scaled down, W/m². At π a white
/// surface shows as white; a lamp near a small scene may well be a few times that.
const BRIGHTEST_IRRADIANCE: f32 = 8.0 * PI;
/// Instants at which an animated scene is measured.
const MEASURED_INSTANTS: usize = 24;

/// Shows every vertex in the world, at all of some instants of the animation.
fn vertices(scene: &Scene, animation: &Animation, mut show: impl FnMut(Vec3)) {
    let moving = (0..scene.nodes.len()).any(|node| animation.moves(node));
    let instants = if moving { MEASURED_INSTANTS } else { 1 };
    let mut worlds = Vec::new();
    for instant in 0..instants {
        let t = scene.duration * instant as f64 / instants as f64;
        animation.world_all(scene, t, &mut worlds);
        for (node, world) in scene.nodes.iter().zip(&worlds) {
            let Some(mesh) = node.mesh.map(|mesh| &scene.meshes[mesh]) else {
                continue;
            };
            let skin = node.skin.map(|skin| &scene.skins[skin]);
            for p in &mesh.primitives {
                let Some(skin) = skin.filter(|_| !p.joints.is_empty()) else {
                    p.positions
                        .iter()
                        .for_each(|&v| show(world.transform_point3(v)));
                    continue;
                };
                for ((&v, joints), weights) in p.positions.iter().zip(&p.joints).zip(&p.weights) {
                    // Linear blend skinning, glTF 2.0 §3.7.3.3: the node itself has no say.
                    let influence = |(&joint, &weight): (&u16, &f32)| {
                        let joint = usize::from(joint);
                        let bound = skin.inverse_bind[joint].transform_point3(v);
                        worlds[skin.joints[joint]].transform_point3(bound) * weight
                    };
                    show(joints.iter().zip(weights).map(influence).sum());
                }
            }
        }
    }
}

/// The box around all vertices over the animation.
pub(super) fn bounds(scene: &Scene, animation: &Animation) -> (Vec3, Vec3) {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    vertices(scene, animation, |p| {
        (low, high) = (low.min(p), high.max(p))
    });
    (low, high)
}

/// Completes a scene; a fault if it has no finite size. `own_sky` says that the file brought its sky, and with it its exposure.
pub(super) fn complete(
    scene: &mut Scene,
    own_sky: bool,
    focus_missing: bool,
    orthographic: Option<f32>,
    warnings: &mut Warnings,
) -> Result<(), Fault> {
    let animation = Animation::new(scene);
    let (low, high) = bounds(scene, &animation);
    if !((high - low).is_finite() && (high - low).length().is_finite()) {
        let reason = "its vertices leave the range of numbers; check the scales of its nodes";
        return Err(Fault::new("scene", reason));
    }
    let centre = (low + high) * 0.5;
    let camera = scene.nodes.iter().position(|node| node.camera.is_some());
    match camera {
        Some(camera) => {
            let world = animation.world(scene, camera, 0.0);
            let axis = -Vec3::from(world.matrix3.z_axis).normalize_or(Vec3::Z);
            let along = axis.dot(centre - Vec3::from(world.translation));
            let size = (high - low).length().max(1e-3);
            let distance = if along > 1e-3 * size { along } else { size };
            if let Some(lens) = &mut scene.nodes[camera].camera {
                if focus_missing {
                    lens.focus = distance;
                }
                if let Some(height) = orthographic {
                    lens.yfov = 2.0 * (0.5 * height / distance).atan();
                }
            }
        }
        None => orbit(scene, &animation, low, high),
    }
    if !own_sky {
        light(
            scene,
            &animation,
            centre,
            0.1 * (high - low).length(),
            warnings,
        );
    }
    Ok(())
}

/// Adds a camera that turns once around the scene in [`ORBIT_SECONDS`].
fn orbit(scene: &mut Scene, animation: &Animation, low: Vec3, high: Vec3) {
    let centre = (low + high) * 0.5;
    let half_height = (high.y - low.y) * 0.5;
    // What turns is seen as an upright cylinder; the nearest distance at which its rims are in
    // view is the same from every direction.
    let mut radius = 0.0_f32;
    vertices(scene, animation, |p| {
        radius = radius.max((p - centre).with_y(0.0).length());
    });
    let slope = (ORBIT_YFOV * 0.5).tan();
    let seen = Quat::from_rotation_x(ORBIT_ELEVATION);
    let mut distance = 1e-3_f32;
    for step in 0..64 {
        let (z, x) = (TAU * step as f32 / 64.0).sin_cos();
        for y in [-half_height, half_height] {
            let p = seen * Vec3::new(radius * x, y, radius * z);
            distance = distance.max(p.z + p.x.abs().max(p.y.abs()) / slope);
        }
    }
    distance *= ORBIT_MARGIN;
    let pivot = scene.nodes.len();
    scene.nodes.push(Node {
        name: "orbit".into(),
        translation: centre,
        ..Node::default()
    });
    scene.nodes.push(Node {
        name: "orbiting camera".into(),
        parent: Some(pivot),
        translation: Quat::from_rotation_x(-ORBIT_ELEVATION) * Vec3::new(0.0, 0.0, distance),
        rotation: Quat::from_rotation_x(-ORBIT_ELEVATION),
        camera: Some(Lens {
            yfov: ORBIT_YFOV,
            aperture: 0.0,
            focus: distance,
        }),
        ..Node::default()
    });
    let keys = [0.0, 1.0, 2.0, 3.0_f32].map(|k| k / 3.0);
    scene.channels.push(Channel {
        node: pivot,
        track: Track::Rotation(keys.map(|k| Quat::from_rotation_y(TAU * k)).to_vec()),
        times: keys.map(|k| ORBIT_SECONDS * k).to_vec(),
        interpolation: Interpolation::Linear,
        period: ORBIT_SECONDS,
    });
    scene.duration = scene.duration.max(f64::from(ORBIT_SECONDS));
}

/// Adds neutral light to a scene without any, and scales punctual lights that are far too bright
/// for a display that shows radiance 1 as white. All by one factor, so that their ratios stay.
fn light(
    scene: &mut Scene,
    animation: &Animation,
    centre: Vec3,
    nearest: f32,
    warnings: &mut Warnings,
) {
    let punctual = scene.nodes.iter().any(|node| node.light.is_some());
    let used = |node: &Node| {
        node.mesh
            .into_iter()
            .flat_map(|m| &scene.meshes[m].primitives)
    };
    let materials = || {
        scene
            .nodes
            .iter()
            .flat_map(used)
            .map(|p| &scene.materials[p.material])
    };
    let emissive = materials().any(|m| m.emissive != Vec3::ZERO);
    if !punctual && !emissive {
        scene.sky = NEUTRAL_SKY;
        if materials().any(|m| !m.unlit) {
            scene.nodes.push(Node {
                name: "key light".into(),
                rotation: Quat::from_rotation_y(0.6) * Quat::from_rotation_x(-0.8),
                light: Some(Light {
                    kind: LightKind::Directional,
                    intensity: Vec3::splat(KEY_IRRADIANCE),
                    range: f32::INFINITY,
                }),
                ..Node::default()
            });
        }
        return;
    }
    scene.sky.ambient = Vec3::splat(INDIRECT_AMBIENT);
    let irradiance = |(index, node): (usize, &Node)| {
        let Some(light) = &node.light else { return 0.0 };
        let place: Vec3 = animation.world(scene, index, 0.0).translation.into();
        let intensity = light.intensity.max_element();
        match light.kind {
            LightKind::Directional => intensity,
            _ => intensity / place.distance(centre).max(nearest).powi(2),
        }
    };
    let brightest = scene
        .nodes
        .iter()
        .enumerate()
        .map(irradiance)
        .fold(0.0, f32::max);
    if brightest > BRIGHTEST_IRRADIANCE {
        let factor = PI / brightest;
        for light in scene
            .nodes
            .iter_mut()
            .filter_map(|node| node.light.as_mut())
        {
            light.intensity *= factor;
        }
        warnings.add(
            "lights",
            format!(
                "their intensities are multiplied by {factor:.3e}: white surfaces would be \
                     {:.0} times too bright to show",
                brightest / PI
            ),
        );
    }
}
