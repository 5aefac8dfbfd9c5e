//! Skins, and more movers than object ids.

use glam::{Mat4, Quat, Vec2, Vec3};
use unframed_wire::SKY;

use super::{Random, SIZE, brute_force, wall};
use crate::scene::model::{Channel, Interpolation, Light, LightKind, Node, Skin, Track};
use crate::trace::{MAX_OBJECTS, World};

#[test]
fn skinned_triangles_follow_their_joints() {
    // The wall as a skinned mesh: one joint that moves 1 m/s along x, another at rest.
    let mut scene = wall();
    let p = &mut scene.meshes[0].primitives[0];
    p.joints = vec![[1, 0, 0, 0]; 4];
    p.weights = vec![[1.0, 0.0, 0.0, 0.0]; 4];
    scene.nodes[0].skin = Some(0);
    scene.nodes.push(Node::default());
    scene.nodes.push(Node {
        translation: Vec3::X,
        ..Node::default()
    });
    let inverse_bind = vec![Mat4::IDENTITY, Mat4::from_translation(-Vec3::X)];
    scene.skins.push(Skin {
        joints: vec![2, 3],
        inverse_bind,
    });
    scene.duration = 4.0;
    scene.channels.push(Channel {
        node: 3,
        track: Track::Translation(vec![Vec3::X, Vec3::X * 5.0]),
        times: vec![0.0, 4.0],
        interpolation: Interpolation::Linear,
        period: 4.0,
    });
    let mut world = World::new(scene, SIZE).unwrap();
    assert_eq!(world.object_count(), 2);
    assert!(world.moves().objects && !world.moves().view);
    for t in [0.0, 1.0, 3.0] {
        world.prepare(t, t);
        let hit = world.moment(t).look(Vec2::new(32.0, 24.0), 0);
        assert_eq!(hit.object, 1);
        // The joint's own coordinates: its origin has moved from 1 by t.
        let expected = Vec3::new(-1.0 - t as f32, 0.0, -5.0);
        assert!(hit.local.distance(expected) < 1e-5, "{t}: {}", hit.local);
        let b = world.bounds(1);
        assert!(b.contains_point(hit.local.into()));
    }
    // 5 m to the right the wall has left at t = 0 + 4: its left edge stands at −5 + t.
    world.prepare(3.9, 3.9);
    assert_eq!(
        world
            .moment(3.9)
            .look_along(Vec3::new(-1.2, 0.0, -5.0), 0)
            .object,
        SKY
    );
    world.prepare(3.7, 3.7);
    assert_eq!(
        world
            .moment(3.7)
            .look_along(Vec3::new(-1.2, 0.0, -5.0), 0)
            .object,
        1
    );
}

#[test]
fn many_movers_go_through_the_tree() {
    // 300 small quads, each animated: more than ids, and a top level tree.
    let mut scene = wall();
    scene.meshes[0].primitives[0]
        .positions
        .iter_mut()
        .for_each(|p| {
            *p = Vec3::new(p.x * 0.02, p.y * 0.02, 0.0);
        });
    scene.nodes[0].mesh = None;
    scene.duration = 1.0;
    for i in 0..300 {
        let at = Vec3::new((i % 20) as f32 - 9.5, (i / 20) as f32 - 7.0, -20.0);
        let node = scene.nodes.len();
        scene.nodes.push(Node {
            mesh: Some(0),
            ..Node::default()
        });
        scene.channels.push(Channel {
            node,
            track: Track::Translation(vec![at, at + Vec3::X * 0.5]),
            times: vec![0.0, 1.0],
            interpolation: Interpolation::Linear,
            period: 1.0,
        });
    }
    let mut world = World::new(scene.clone(), SIZE).unwrap();
    assert_eq!(world.object_count(), MAX_OBJECTS);
    let (mut random, mut met, mut zero) = (Random(1), 0, 0);
    world.prepare(0.3, 0.301);
    for i in 0..500 {
        let t = 0.3 + 1e-3 * f64::from(random.next());
        let aim = Vec3::new(
            (i % 20) as f32 - 9.5 + 0.15 + random.next() * 0.3,
            ((i / 20) % 15) as f32 - 7.0 + random.next() * 0.3 - 0.15,
            -20.0,
        );
        let hit = world.moment(t).look_along(aim, 0);
        let slow = brute_force(&scene, t, Vec3::ZERO, aim);
        assert_eq!(hit.object != SKY, slow.is_some(), "{aim}");
        met += u32::from(hit.object != SKY);
        zero += u32::from(hit.object == 0);
    }
    assert!(met > 100 && zero > 5, "{met} {zero}");
}

#[test]
fn turning_objects_turn_their_normals() {
    // The wall swings about y by 1 rad/s, squeezed along z (which its normal must not feel
    // other than by the transposed inverse); a sun shines along −z turned by 0.6.
    let mut scene = wall();
    scene.duration = 1.0;
    scene.nodes[0].scale = Vec3::new(1.5, 1.0, 0.8);
    scene.channels.push(Channel {
        node: 0,
        track: Track::Rotation(vec![Quat::IDENTITY, Quat::from_rotation_y(1.0)]),
        times: vec![0.0, 1.0],
        interpolation: Interpolation::Linear,
        period: 1.0,
    });
    let sun = Light {
        kind: LightKind::Directional,
        intensity: Vec3::ONE,
        range: f32::INFINITY,
    };
    scene.nodes.push(Node {
        light: Some(sun),
        rotation: Quat::from_rotation_y(0.6),
        ..Node::default()
    });
    let mut world = World::new(scene, SIZE).unwrap();
    world.prepare(0.0, 0.0);
    for t in [0.1, 0.45, 0.9] {
        world.prepare(t, t + 1e-3);
        let hit = world.moment(t + 5e-4).look(Vec2::new(32.0, 24.0), 0);
        assert_eq!(hit.object, 1);
        let cos = (t as f32 + 5e-4 - 0.6).cos();
        let expected = Vec3::new(0.5, 0.25, 1.0) * cos / std::f32::consts::PI;
        assert!(
            hit.colour.distance(expected) < 1e-4,
            "{t}: {} {expected}",
            hit.colour
        );
    }
}

#[test]
fn moving_lights_are_where_they_are_at_the_instant() {
    // A lamp that goes from 1 m to 4 m before the wall in a second: I/d²·albedo/π.
    let mut scene = wall();
    scene.duration = 1.0;
    let lamp = Light {
        kind: LightKind::Point,
        intensity: Vec3::ONE,
        range: f32::INFINITY,
    };
    scene.channels.push(Channel {
        node: scene.nodes.len(),
        track: Track::Translation(vec![Vec3::Z * -4.0, Vec3::Z * -1.0]),
        times: vec![0.0, 1.0],
        interpolation: Interpolation::Linear,
        period: 1.0,
    });
    scene.nodes.push(Node {
        light: Some(lamp),
        ..Node::default()
    });
    let mut world = World::new(scene, SIZE).unwrap();
    assert!(world.moves().lights && !world.moves().objects);
    world.prepare(0.1, 0.117);
    for t in [0.1, 0.1037, 0.1108, 0.117] {
        let hit = world.moment(t).look(Vec2::new(32.0, 24.0), 0);
        let d = 1.0 + 3.0 * t as f32;
        let expected = 1.0 / (d * d) / std::f32::consts::PI;
        assert!((hit.colour.z / expected - 1.0).abs() < 2e-4, "{t}");
    }
}
