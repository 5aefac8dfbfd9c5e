//! `toycar`: a camera at rest watches a toy car that drives around on a polished floor.
//!
//! What hurts: wheels with spokes and stripes that spin ten times a second, their shadow and
//! their mirror image in the floor, a fence in front, a striped backdrop
//! that the car uncovers. Most of the image stands still and should become perfect.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3};

use super::shapes::Shape;
use super::stage::{Stage, view};
use crate::scene::model::{Interpolation, Procedural, Scene, Sky, Track};

/// Seconds of one lap.
const LAP: f32 = 6.0;
/// The lap is an ellipse with these half-axes, metres.
const LAP_X: f32 = 1.75;
const LAP_Z: f32 = 0.95;
/// Radius of the wheels, metres.
const WHEEL: f32 = 0.2;

pub(super) fn scene() -> Scene {
    let ambient = Vec3::new(0.17, 0.18, 0.21);
    let zenith = Vec3::new(0.25, 0.4, 0.75);
    let sky = Sky {
        zenith,
        horizon: Vec3::new(0.75, 0.8, 0.85),
        ambient,
    };
    let mut stage = Stage::new("toycar", f64::from(LAP), sky);
    table(&mut stage);
    props(&mut stage);
    car(&mut stage);
    stage.point_light(None, Vec3::new(-1.8, 4.0, 2.2), [42.0, 40.0, 36.0]);
    stage.point_light(None, Vec3::new(2.8, 2.4, 0.4), [7.0, 8.0, 10.0]);
    stage.camera(&[view(0.0, [0.1, 1.5, 3.05], [0.0, 0.3, -0.1])], true);
    stage.done()
}

/// The floor, half of its squares polished, and a backdrop.
fn table(stage: &mut Stage) {
    let polished = stage.mirror("polished", [0.75, 0.78, 0.85], 0.7);
    let ivory = stage.patterned(
        "ivory",
        [0.85, 0.8, 0.68],
        Procedural::Checker {
            size: 0.1,
            other: Vec3::new(0.55, 0.5, 0.45),
        },
    );
    let backdrop = stage.patterned(
        "backdrop",
        [0.85, 0.75, 0.45],
        Procedural::Stripes {
            period: 0.3,
            other: Vec3::new(0.2, 0.35, 0.6),
        },
    );
    let brick = stage.patterned(
        "brick",
        [0.62, 0.24, 0.14],
        Procedural::Brick {
            size: Vec2::new(0.24, 0.09),
            joint: 0.015,
            mortar: Vec3::new(0.55, 0.6, 0.65),
        },
    );
    let (mut mirrors, mut others) = (Shape::of(polished), Shape::of(ivory));
    let side = 0.5;
    for i in 0..16 {
        for k in 0..14 {
            let corner = Vec3::new(-4.0 + side * i as f32, 0.0, -3.0 + side * (k + 1) as f32);
            let (u, v) = (Vec3::X * side, Vec3::NEG_Z * side);
            if (i + k) % 2 == 0 {
                mirrors = mirrors.quad(corner, u, v);
            } else {
                others = others.quad(corner, u, v);
            }
        }
    }
    let back = Shape::of(backdrop).quad(Vec3::new(-4.0, 0.0, -2.2), Vec3::X * 8.0, Vec3::Y * 1.5);
    let side = Shape::of(brick).quad(Vec3::new(-3.2, 0.0, 3.0), Vec3::Z * -5.2, Vec3::Y * 1.1);
    let parts = vec![mirrors.done(), others.done(), back.done(), side.done()];
    stage.solid("table", None, Vec3::ZERO, parts);
}

/// What stands around: a fence, a tower of rings, a mirror ball, cones.
fn props(stage: &mut Stage) {
    let wire = stage.matt("fence", [0.35, 0.2, 0.1]);
    let orange = stage.patterned(
        "cone",
        [0.95, 0.35, 0.05],
        Procedural::Stripes {
            period: 0.12,
            other: Vec3::new(1.0, 1.0, 1.0),
        },
    );
    let silver = stage.mirror("silver", [0.92, 0.93, 0.95], 1.0);
    let teal = stage.matt("rings", [0.05, 0.45, 0.42]);
    let mut fence = Shape::of(wire);
    for i in 0..=8 {
        let x = -2.0 + 0.5 * i as f32;
        fence = fence.cuboid(Vec3::new(x, 0.11, 1.75), Vec3::new(0.05, 0.22, 0.05));
    }
    fence = fence.cuboid(Vec3::new(0.0, 0.2, 1.75), Vec3::new(4.1, 0.05, 0.03));
    stage.solid("fence", None, Vec3::ZERO, vec![fence.done()]);

    let mut tower = Shape::of(teal);
    for i in 0..5 {
        let axis = Quat::from_rotation_x(0.25 * i as f32) * Vec3::Y;
        tower = tower.ring(
            Vec3::Y * (0.09 + 0.17 * i as f32),
            axis,
            0.3 - 0.03 * i as f32,
            0.05,
            32,
        );
    }
    stage.solid(
        "tower",
        None,
        Vec3::new(0.0, 0.0, -0.05),
        vec![tower.done()],
    );
    let ball = Shape::of(silver).sphere(Vec3::Y * 0.42, 0.42, 36).done();
    stage.solid("ball", None, Vec3::new(1.3, 0.0, -1.5), vec![ball]);
    let mut cones = Shape::of(orange);
    for x in [-2.5, -1.2, 0.1] {
        let foot = Vec3::new(x, 0.0, -1.65);
        cones = cones.cone(foot, foot + Vec3::Y * 0.45, 0.16, 0.02, 16);
    }
    stage.solid("cones", None, Vec3::ZERO, vec![cones.done()]);
}

/// The car: a node that drives, a body that leans, wheels that steer and spin.
fn car(stage: &mut Stage) {
    let red = stage.matt("red", [0.8, 0.05, 0.04]);
    let check = stage.patterned(
        "check",
        [0.95, 0.95, 0.95],
        Procedural::Checker {
            size: 0.06,
            other: Vec3::splat(0.03),
        },
    );
    let window = stage.mirror("window", [0.5, 0.6, 0.7], 0.8);
    let chrome = stage.mirror("chrome", [0.9, 0.9, 0.9], 1.0);
    let car = stage.node("car", None, Vec3::ZERO);
    drive(stage, car);

    // The car looks down −z; its origin is on the ground between the wheels.
    let chassis = Shape::of(red)
        .cuboid(Vec3::new(0.0, 0.27, 0.0), Vec3::new(0.42, 0.16, 1.0))
        .cuboid(Vec3::new(0.0, 0.37, 0.43), Vec3::new(0.46, 0.03, 0.12))
        .cone(
            Vec3::new(0.0, 0.27, -0.5),
            Vec3::new(0.0, 0.25, -0.66),
            0.18,
            0.06,
            16,
        );
    let cabin = Shape::of(window).cuboid(Vec3::new(0.0, 0.42, 0.08), Vec3::new(0.34, 0.15, 0.4));
    let roof = Shape::of(check)
        .cuboid(Vec3::new(0.0, 0.51, 0.08), Vec3::new(0.38, 0.03, 0.44))
        .cuboid(Vec3::new(0.0, 0.355, -0.27), Vec3::new(0.2, 0.012, 0.42));
    let trim = Shape::of(chrome)
        .bar(
            Vec3::new(-0.24, 0.2, -0.52),
            Vec3::new(0.24, 0.2, -0.52),
            0.025,
            10,
        )
        .bar(
            Vec3::new(-0.24, 0.2, 0.52),
            Vec3::new(0.24, 0.2, 0.52),
            0.025,
            10,
        )
        .sphere(Vec3::new(-0.15, 0.3, -0.5), 0.05, 8)
        .sphere(Vec3::new(0.15, 0.3, -0.5), 0.05, 8)
        .bar(
            Vec3::new(0.16, 0.52, 0.25),
            Vec3::new(0.16, 0.95, 0.32),
            0.006,
            5,
        );
    let body = vec![chassis.done(), cabin.done(), roof.done(), trim.done()];
    stage.solid("body", Some(car), Vec3::ZERO, body);

    let black = stage.matt("tyre", [0.03, 0.03, 0.03]);
    let yellow = stage.patterned(
        "rim",
        [0.95, 0.75, 0.1],
        Procedural::Checker {
            size: 0.05,
            other: Vec3::new(0.1, 0.1, 0.4),
        },
    );
    let mut spokes = Shape::of(yellow).ring(Vec3::ZERO, Vec3::X, WHEEL * 0.68, 0.018, 24);
    for i in 0..5 {
        let out = Quat::from_rotation_x(TAU * i as f32 / 5.0) * Vec3::Y;
        spokes = spokes.bar(Vec3::ZERO, out * WHEEL * 0.7, 0.022, 6);
    }
    let mut tyre = Shape::of(black).ring(Vec3::ZERO, Vec3::X, WHEEL - 0.035, 0.035, 32);
    // White marks on the tread, so that the spin shows from any side.
    let white = stage.matt("marks", [0.95, 0.95, 0.95]);
    let mut marks = Shape::of(white);
    for i in 0..6 {
        let turn = Quat::from_rotation_x(TAU * i as f32 / 6.0);
        let part = Shape::of(black).cuboid(Vec3::Y * (WHEEL - 0.006), Vec3::new(0.06, 0.014, 0.05));
        marks = marks.with(part.turned(turn));
    }
    tyre = tyre.with(Shape::of(black).bar(Vec3::X * -0.03, Vec3::X * 0.03, 0.05, 10));
    let wheel = vec![tyre.done(), spokes.done(), marks.done()];
    let mut first = None;
    for (x, z) in [(-0.26, -0.34), (0.26, -0.34), (-0.26, 0.34), (0.26, 0.34)] {
        let place = Vec3::new(x, WHEEL, z);
        let node = match first {
            Some(model) => stage.copy(model, Some(car), place),
            None => stage.solid("wheel", Some(car), place, wheel.clone()),
        };
        first = Some(node);
        // Rolling without slip, rounded to whole turns a lap.
        let lap =
            PI * (3.0 * (LAP_X + LAP_Z) - ((3.0 * LAP_X + LAP_Z) * (LAP_X + 3.0 * LAP_Z)).sqrt());
        stage.spin(node, Vec3::X, -(lap / (TAU * WHEEL)).round() as i32);
    }
}

/// Around the ellipse, the nose along its tangent; linear keys, 24 a second.
fn drive(stage: &mut Stage, car: usize) {
    let keys = (LAP * 24.0) as u32;
    let times: Vec<f32> = (0..=keys).map(|i| LAP * i as f32 / keys as f32).collect();
    let angle = |i: u32| TAU * i as f32 / keys as f32;
    let places = (0..=keys)
        .map(|i| Vec3::new(LAP_X * angle(i).cos(), 0.0, -LAP_Z * angle(i).sin()))
        .collect();
    let mut turns: Vec<Quat> = Vec::new();
    for i in 0..=keys {
        let tangent = Vec2::new(-LAP_X * angle(i).sin(), -LAP_Z * angle(i).cos());
        // −z to (x, z): a turn about y by atan2(−x, −z).
        let q = Quat::from_rotation_y((-tangent.x).atan2(-tangent.y));
        let flip = turns
            .last()
            .is_some_and(|before: &Quat| before.dot(q) < 0.0);
        turns.push(if flip { -q } else { q });
    }
    stage.track(
        car,
        times.clone(),
        Track::Translation(places),
        Interpolation::Linear,
    );
    stage.track(car, times, Track::Rotation(turns), Interpolation::Linear);
}
