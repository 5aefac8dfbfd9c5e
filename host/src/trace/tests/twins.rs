//! What rays meet: against brute force, against the projection, any-hit against closest.

use glam::{Vec2, Vec3};
use unframed_wire::SKY;

use super::{Random, brute_force, world};
use crate::scene::builtin::{ANIMATIONS, BUILTIN};
use crate::trace::Hit;

#[test]
fn nearest_hits_equal_brute_force_at_any_instant() {
    for name in BUILTIN {
        let mut world = world(name);
        let scene = world.scene().clone();
        let (mut random, mut movers, mut wrong) = (Random(7), 0, 0);
        for round in 0..6 {
            let t0 = scene.duration * f64::from(random.next());
            world.prepare(t0, t0 + 2e-3);
            for i in 0..24 {
                let t = t0 + 2e-3 * f64::from(random.next());
                let moment = world.moment(t);
                let camera = *moment.camera();
                // Aimed: half of the rays at a mover.
                let direction = match (world.object_count() - 1, i % 2) {
                    (movers @ 1.., 0) => {
                        let object = 1 + (round + i / 2) % movers;
                        let b = world.bounds(object as u8);
                        let s = Vec3::new(random.next(), random.next(), random.next());
                        let local = Vec3::from(b.min) + Vec3::from(b.max - b.min) * s;
                        world.pose(object as u8, t).transform_point3(local) - camera.eye
                    }
                    _ => camera.direction(random.pixel()),
                };
                let hit = moment.look_along(direction, 0);
                let slow = brute_force(&scene, t, camera.eye, direction);
                let along = camera.forward.dot(direction);
                let same = match slow {
                    None => hit.object == SKY,
                    Some((s, _)) => {
                        hit.object != SKY && (f64::from(hit.depth / along) / s - 1.0).abs() < 1e-3
                    }
                };
                wrong += u32::from(!same);
                movers += u32::from(hit.object != 0 && hit.object != SKY);
            }
        }
        // Edges within rounding (or within the 15 µm of the blend) may go either way.
        assert!(wrong <= 1, "{name}: {wrong} of 144 rays differ");
        assert!(movers >= 10, "{name}: only {movers} rays met a mover");
    }
}

#[test]
fn hits_project_to_their_pixel_through_the_pose() {
    for name in BUILTIN {
        let mut world = world(name);
        let mut random = Random(3);
        for k in 0..8 {
            let t0 = f64::from(k) * 0.83;
            world.prepare(t0, t0 + 1e-3);
            for _ in 0..60 {
                let t = t0 + 1e-3 * f64::from(random.next());
                let pixel = random.pixel();
                let hit = world.moment(t).look(pixel, 0);
                let at = world.pose(hit.object, t).transform_point3(hit.local);
                let (back, depth) = world.camera(t).project(at).unwrap();
                assert!(
                    back.distance(pixel) < 0.02,
                    "{name} {t}: {pixel} {back} {hit:?}"
                );
                if hit.object == SKY {
                    assert!(hit.depth.is_infinite());
                } else {
                    assert!((depth / hit.depth - 1.0).abs() < 1e-3);
                    let b = world.bounds(hit.object);
                    let slack = (b.max - b.min) * 1e-3 + 1e-3;
                    let local = glam::Vec3A::from(hit.local);
                    assert!(b.min.cmple(local + slack).all() && b.max.cmpge(local - slack).all());
                }
            }
        }
    }
}

#[test]
fn a_ray_is_blocked_exactly_where_something_is_nearer() {
    for name in ANIMATIONS {
        let mut world = world(name);
        let mut random = Random(11);
        let (mut blocked, mut free, mut checked) = (0, 0, 0);
        for k in 0..10 {
            let t = 0.37 + 0.71 * f64::from(k);
            world.prepare(t, t + 1e-3);
            let moment = world.moment(t + 5e-4);
            for _ in 0..60 {
                let unit =
                    |r: &mut Random| Vec3::new(r.next() - 0.5, r.next() - 0.5, r.next() - 0.5);
                let origin = moment.camera().eye + unit(&mut random) * 2.0;
                let direction = unit(&mut random).normalize_or(Vec3::Y);
                let reach = random.next() * 6.0;
                let nearest = moment
                    .closest(origin, direction)
                    .map_or(f32::INFINITY, |s| s.t);
                if (nearest - reach).abs() < 1e-3 {
                    continue;
                }
                checked += 1;
                let expected = nearest < reach;
                assert_eq!(moment.blocked(origin, direction, reach), expected, "{name}");
                if expected { blocked += 1 } else { free += 1 }
            }
        }
        assert!(
            blocked > checked / 20 && free > checked / 20,
            "{name}: {blocked} {free}"
        );
    }
}

#[test]
fn a_moment_does_not_depend_on_the_epoch_around_it() {
    let mut world = world("toycar");
    let mut random = Random(5);
    let pixels: Vec<Vec2> = (0..400).map(|_| random.pixel()).collect();
    let t = 1.2345;
    let mut look = |t0: f64, t1: f64| -> Vec<Hit> {
        world.prepare(t0, t1);
        let moment = world.moment(t);
        pixels.iter().map(|&p| moment.look(p, 0)).collect()
    };
    let exact = look(t, t);
    for (t0, t1) in [(t - 4e-4, t + 6e-4), (t - 0.01, t + 0.007)] {
        let other = look(t0, t1);
        let same = exact
            .iter()
            .zip(&other)
            .filter(|(a, b)| a.object == b.object && a.colour.distance(b.colour) < 0.01);
        assert!(same.count() >= 397);
    }
}
