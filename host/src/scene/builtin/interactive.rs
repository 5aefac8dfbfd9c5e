//! `interactive`: a hall that somebody looks around in, as with mouse and keys: rest, a quick
//! turn, rest, a dash.
//!
//! What hurts: full stops and sudden starts, a checker floor and brick walls at all distances, a
//! balustrade, a mirror sphere, and a wheel of spokes that turns under the lamp and throws its
//! shadow through half of the hall.
//!
//! `stress` is the same hall with a railing, a grille and wires thinner than a pixel.

use glam::{Quat, Vec2, Vec3};

use super::shapes::Shape;
use super::stage::{Stage, view};
use crate::scene::model::{Interpolation, Procedural, Scene, Sky, Track};

/// Inner half-width and height of the hall, metres.
const HALF: f32 = 6.0;
const HEIGHT: f32 = 4.0;

pub(super) fn scene() -> Scene {
    hall("interactive", balustrade)
}

pub(super) fn stress() -> Scene {
    hall("stress", railing)
}

fn hall(name: &str, guard: fn(&mut Stage)) -> Scene {
    let ambient = Vec3::new(0.2, 0.21, 0.24);
    let sky = Sky {
        zenith: Vec3::splat(0.5),
        horizon: Vec3::splat(0.5),
        ambient,
    };
    let mut stage = Stage::new(name, 8.0, sky);
    shell(&mut stage);
    columns(&mut stage);
    guard(&mut stage);
    things(&mut stage);
    // Beside the rod of the wheel, whose spokes then cut its light.
    stage.point_light(None, Vec3::new(0.35, 3.65, 0.3), [62.0, 57.0, 48.0]);
    stage.point_light(None, Vec3::new(-4.6, 2.6, -4.4), [14.0, 16.0, 20.0]);

    let (door, near, far) = ([4.6, 1.6, 4.6], [1.6, 1.5, 1.2], [-3.4, 1.7, 2.9]);
    let (middle, left, sphere) = ([0.0, 1.2, 0.0], [-4.5, 1.4, 4.5], [2.0, 0.8, -2.4]);
    let wires = [-4.0, 2.6, -3.0];
    stage.camera(
        &[
            view(0.0, door, middle),
            view(0.6, door, middle),
            view(0.85, door, left),
            view(1.2, door, left),
            view(1.4, door, sphere),
            view(2.0, near, sphere),
            view(2.5, near, sphere),
            view(2.7, near, [4.8, 1.0, -4.0]),
            view(3.0, near, wires),
            view(3.4, near, wires),
            view(4.1, far, wires),
            view(4.7, far, wires),
            view(5.0, far, middle),
            view(5.4, far, middle),
            view(5.6, far, [3.0, 1.8, 5.0]),
            view(6.2, [1.2, 1.2, 3.0], [3.0, 1.8, 5.0]),
            view(6.7, [1.2, 1.2, 3.0], [3.0, 1.8, 5.0]),
            view(7.0, [1.2, 1.2, 3.0], sphere),
            view(7.3, [1.2, 1.2, 3.0], sphere),
            view(8.0, door, middle),
        ],
        true,
    );
    stage.done()
}

/// Floor, walls, ceiling with beams.
fn shell(stage: &mut Stage) {
    let floor = stage.patterned(
        "floor",
        [0.8, 0.78, 0.72],
        Procedural::Checker {
            size: 0.5,
            other: Vec3::new(0.06, 0.08, 0.12),
        },
    );
    let brick = stage.patterned(
        "brick",
        [0.62, 0.24, 0.14],
        Procedural::Brick {
            size: Vec2::new(0.42, 0.16),
            joint: 0.025,
            mortar: Vec3::new(0.55, 0.6, 0.65),
        },
    );
    let stripes = stage.patterned(
        "stripes",
        [0.85, 0.8, 0.65],
        Procedural::Stripes {
            period: 0.4,
            other: Vec3::new(0.12, 0.3, 0.55),
        },
    );
    let plaster = stage.matt("plaster", [0.7, 0.7, 0.68]);
    let wood = stage.matt("wood", [0.25, 0.13, 0.06]);
    let (w, h) = (2.0 * HALF, HEIGHT);
    let corner = Vec3::new(-HALF, 0.0, -HALF);
    let mut beams = Shape::of(wood);
    for i in 0..7 {
        let z = -HALF + 1.0 + 10.0 * i as f32 / 6.0;
        beams = beams.cuboid(Vec3::new(0.0, HEIGHT - 0.1, z), Vec3::new(w, 0.2, 0.15));
    }
    let primitives = vec![
        Shape::of(floor)
            .quad(corner + Vec3::Z * w, Vec3::X * w, Vec3::NEG_Z * w)
            .done(),
        Shape::of(plaster)
            .quad(corner + Vec3::Y * h, Vec3::X * w, Vec3::Z * w)
            .done(),
        Shape::of(brick)
            .quad(corner, Vec3::X * w, Vec3::Y * h)
            .quad(corner + Vec3::new(w, 0.0, w), Vec3::NEG_X * w, Vec3::Y * h)
            .done(),
        Shape::of(stripes)
            .quad(corner + Vec3::Z * w, Vec3::NEG_Z * w, Vec3::Y * h)
            .done(),
        Shape::of(brick)
            .quad(corner + Vec3::X * w, Vec3::Z * w, Vec3::Y * h)
            .done(),
        beams.done(),
    ];
    stage.solid("hall", None, Vec3::ZERO, primitives);
}

fn columns(stage: &mut Stage) {
    let stripes = stage.patterned(
        "column",
        [0.85, 0.85, 0.85],
        Procedural::Stripes {
            period: 0.22,
            other: Vec3::new(0.7, 0.1, 0.08),
        },
    );
    let stone = stage.matt("stone", [0.5, 0.48, 0.44]);
    let shaft = Shape::of(stripes)
        .bar(Vec3::Y * 0.3, Vec3::Y * 3.6, 0.28, 24)
        .done();
    let ends = Shape::of(stone)
        .cuboid(Vec3::Y * 0.15, Vec3::new(0.8, 0.3, 0.8))
        .cuboid(Vec3::Y * 3.7, Vec3::new(0.8, 0.2, 0.8))
        .done();
    let first = stage.solid(
        "column",
        None,
        Vec3::new(-3.0, 0.0, -3.2),
        vec![shaft, ends],
    );
    for (x, z) in [(3.2, -3.2), (-3.2, 1.0), (3.4, 2.4)] {
        stage.copy(first, None, Vec3::new(x, 0.0, z));
    }
}

/// Posts and a rail across one side.
fn balustrade(stage: &mut Stage) {
    let stone = stage.matt("balustrade", [0.42, 0.4, 0.37]);
    let brass = stage.matt("brass", [0.75, 0.5, 0.15]);
    let mut posts = Shape::of(stone);
    for i in 0..=10 {
        let foot = Vec3::new(-5.0 + 0.48 * i as f32, 0.0, 3.6);
        posts = posts
            .cuboid(foot + Vec3::Y * 0.04, Vec3::new(0.2, 0.08, 0.2))
            .cone(foot, foot + Vec3::Y * 0.4, 0.04, 0.09, 14)
            .cone(foot + Vec3::Y * 0.4, foot + Vec3::Y * 0.95, 0.09, 0.04, 14);
    }
    let rail = Shape::of(brass).cuboid(Vec3::new(-2.6, 1.0, 3.6), Vec3::new(5.0, 0.1, 0.16));
    stage.solid(
        "balustrade",
        None,
        Vec3::ZERO,
        vec![posts.done(), rail.done()],
    );
}

/// A railing of thin bars across one side, and wires over another.
fn railing(stage: &mut Stage) {
    let iron = stage.matt("iron", [0.03, 0.03, 0.035]);
    let brass = stage.matt("brass", [0.75, 0.5, 0.15]);
    let mut bars = Shape::of(iron);
    for i in 0..=40 {
        let x = -5.0 + 0.12 * i as f32;
        bars = bars.bar(Vec3::new(x, 0.0, 3.6), Vec3::new(x, 1.0, 3.6), 0.011, 6);
    }
    let rail = Shape::of(brass).bar(
        Vec3::new(-5.1, 1.0, 3.6),
        Vec3::new(-0.1, 1.0, 3.6),
        0.03,
        8,
    );
    let mut wires = Shape::of(iron);
    for i in 0..9 {
        let z = -5.2 + 0.35 * i as f32;
        let y = 2.7 + 0.05 * (i % 3) as f32;
        wires = wires.bar(
            Vec3::new(-5.95, y, z),
            Vec3::new(-2.0, y + 0.35, z - 0.3),
            0.006,
            5,
        );
    }
    // A grille in front of the striped wall.
    for i in 0..=12 {
        let s = 0.15 * i as f32;
        wires = wires
            .bar(
                Vec3::new(-5.7, 0.4 + s, -1.5),
                Vec3::new(-5.7, 0.4 + s, 0.3),
                0.008,
                5,
            )
            .bar(
                Vec3::new(-5.7, 0.4, -1.5 + s),
                Vec3::new(-5.7, 2.2, -1.5 + s),
                0.008,
                5,
            );
    }
    stage.solid(
        "railing",
        None,
        Vec3::ZERO,
        vec![bars.done(), rail.done(), wires.done()],
    );
}

/// The mirror sphere, the wheel under the lamp, a ball that hops, boxes.
fn things(stage: &mut Stage) {
    let silver = stage.mirror("silver", [0.92, 0.93, 0.95], 1.0);
    let stone = stage.matt("plinth", [0.3, 0.32, 0.35]);
    let dark = stage.matt("wheel", [0.12, 0.1, 0.08]);
    let beach = stage.patterned(
        "beach ball",
        [0.9, 0.85, 0.2],
        Procedural::Stripes {
            period: 0.4 * std::f32::consts::FRAC_PI_2,
            other: Vec3::new(0.1, 0.2, 1.0),
        },
    );
    let dice = stage.patterned(
        "crates",
        [0.7, 0.6, 0.25],
        Procedural::Checker {
            size: 0.15,
            other: Vec3::new(0.15, 0.25, 0.6),
        },
    );
    stage.solid(
        "sphere",
        None,
        Vec3::new(2.0, 0.0, -2.4),
        vec![
            Shape::of(silver).sphere(Vec3::Y * 1.05, 0.65, 40).done(),
            Shape::of(stone)
                .cone(Vec3::ZERO, Vec3::Y * 0.5, 0.5, 0.3, 24)
                .disc(Vec3::Y * 0.5, Vec3::Y, 0.3, 24)
                .done(),
        ],
    );
    let mut wheel = Shape::of(dark).ring(Vec3::ZERO, Vec3::Y, 0.95, 0.04, 48);
    for i in 0..9 {
        let out = Quat::from_rotation_y(std::f32::consts::TAU * i as f32 / 9.0) * Vec3::X;
        wheel = wheel.bar(Vec3::ZERO, out * 0.95, 0.03, 6);
    }
    let hub = Shape::of(dark)
        .bar(Vec3::Y * -0.1, Vec3::Y * 0.9, 0.015, 6)
        .done();
    let wheel = stage.solid(
        "wheel",
        None,
        Vec3::new(0.0, 3.0, 0.0),
        vec![wheel.done(), hub],
    );
    stage.spin(wheel, Vec3::Y, 2);

    let ball = stage.node("hop", None, Vec3::ZERO);
    let skin = stage.solid(
        "ball",
        Some(ball),
        Vec3::ZERO,
        vec![Shape::of(beach).sphere(Vec3::ZERO, 0.4, 20).done()],
    );
    stage.spin(skin, Vec3::new(0.6, 0.0, 0.8), 4);
    // Parabolas as cubic splines: a hop of 1 s, three places in turn.
    let stops = [
        [-1.5, 2.1],
        [-0.2, 1.6],
        [1.0, 2.1],
        [-0.2, 1.2],
        [-1.5, 2.1],
    ];
    let (mut times, mut keys) = (Vec::new(), Vec::new());
    for (i, stop) in stops.iter().enumerate() {
        let at = |s: [f32; 2], y: f32| Vec3::new(s[0], y, s[1]);
        let step = |a: [f32; 2], b: [f32; 2]| Vec3::new(b[0] - a[0], 0.0, b[1] - a[1]) / 2.0;
        let into = if i > 0 {
            step(stops[i - 1], *stop)
        } else {
            Vec3::ZERO
        };
        let out = stops.get(i + 1).map_or(Vec3::ZERO, |n| step(*stop, *n));
        // Height h over 2 s: speed ±4h/2 at the ground.
        let up = Vec3::Y * 2.0 * 1.1;
        times.push(2.0 * i as f32);
        keys.extend([into - up, at(*stop, 0.4), out + up]);
    }
    stage.track(
        ball,
        times,
        Track::Translation(keys),
        Interpolation::CubicSpline,
    );

    let crates = Shape::of(dice)
        .cuboid(Vec3::new(4.9, 0.45, -4.2), Vec3::splat(0.9))
        .cuboid(Vec3::new(4.8, 0.3, -3.0), Vec3::splat(0.6))
        .cuboid(Vec3::new(4.95, 1.15, -4.25), Vec3::splat(0.5))
        .cuboid(Vec3::new(-0.5, 0.3, -4.8), Vec3::splat(0.6))
        .done();
    stage.solid("crates", None, Vec3::ZERO, vec![crates]);
}
