//! `walkthrough`: the camera never stops. It goes along an arcade, past a wall so close that
//! single bricks fill the image, around columns, along railings and back.
//!
//! What hurts: continuous parallax everywhere, arches and bars that uncover what is behind them,
//! grazing views of fine patterns, a mirror sphere passed at 0.3 m, a fan whose shadow sweeps
//! over the walls.

use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3};

use super::shapes::Shape;
use super::stage::{Stage, view};
use crate::scene::model::{Procedural, Scene, Sky};

/// Seconds of one round.
const ROUND: f64 = 8.0;
/// Half-width and height of the court, metres.
const HALF: f32 = 7.0;
const HEIGHT: f32 = 3.6;

pub(super) fn scene() -> Scene {
    let ambient = Vec3::new(0.17, 0.18, 0.22);
    let zenith = Vec3::new(0.15, 0.3, 0.7);
    let sky = Sky {
        zenith,
        horizon: Vec3::new(0.8, 0.8, 0.75),
        ambient,
    };
    let mut stage = Stage::new("walkthrough", ROUND, sky);
    court(&mut stage);
    arcade(&mut stage);
    stairs(&mut stage);
    things(&mut stage);
    stage.point_light(None, Vec3::new(0.6, 5.2, -0.8), [70.0, 64.0, 52.0]);
    stage.point_light(None, Vec3::new(-5.4, 2.7, 3.0), [7.0, 6.0, 4.5]);
    stage.camera(
        &[
            view(0.0, [4.6, 1.6, 4.6], [0.0, 1.5, 2.6]),
            view(1.0, [2.4, 1.5, 2.0], [-2.0, 1.2, 0.6]),
            view(2.0, [-0.4, 1.15, 1.45], [-3.6, 1.3, 0.2]),
            view(3.0, [-3.2, 1.5, 1.9], [-6.0, 1.4, -2.4]),
            view(4.0, [-6.5, 1.6, -0.6], [-5.6, 1.5, -5.0]),
            view(5.0, [-5.0, 1.5, -4.4], [0.0, 1.3, -5.2]),
            view(6.0, [-1.0, 1.3, -3.9], [3.4, 1.0, -2.2]),
            view(7.0, [3.1, 1.5, -0.6], [4.2, 1.4, 3.4]),
            view(8.0, [4.6, 1.6, 4.6], [0.0, 1.5, 2.6]),
        ],
        false,
    );
    stage.done()
}

/// Floor and outer walls, open to the sky.
fn court(stage: &mut Stage) {
    let floor = stage.patterned(
        "floor",
        [0.75, 0.72, 0.66],
        Procedural::Checker {
            size: 0.4,
            other: Vec3::new(0.3, 0.14, 0.12),
        },
    );
    let brick = stage.patterned(
        "brick",
        [0.66, 0.3, 0.18],
        Procedural::Brick {
            size: Vec2::new(0.32, 0.12),
            joint: 0.02,
            mortar: Vec3::new(0.55, 0.6, 0.65),
        },
    );
    let tiles = stage.patterned(
        "tiles",
        [0.8, 0.82, 0.8],
        Procedural::Checker {
            size: 0.15,
            other: Vec3::new(0.12, 0.35, 0.55),
        },
    );
    let (w, h) = (2.0 * HALF, HEIGHT);
    let corner = Vec3::new(-HALF, 0.0, -HALF);
    let walls = Shape::of(brick)
        .quad(corner, Vec3::X * w, Vec3::Y * h)
        .quad(corner + Vec3::Z * w, Vec3::NEG_Z * w, Vec3::Y * h);
    let tiled = Shape::of(tiles)
        .quad(corner + Vec3::new(w, 0.0, w), Vec3::NEG_X * w, Vec3::Y * h)
        .quad(corner + Vec3::X * w, Vec3::Z * w, Vec3::Y * h);
    let ground = Shape::of(floor).quad(corner + Vec3::Z * w, Vec3::X * w, Vec3::NEG_Z * w);
    stage.solid(
        "court",
        None,
        Vec3::ZERO,
        vec![ground.done(), walls.done(), tiled.done()],
    );
}

/// Columns in two rows with arches between them.
fn arcade(stage: &mut Stage) {
    let stripes = stage.patterned(
        "column",
        [0.85, 0.83, 0.78],
        Procedural::Stripes {
            period: 0.17,
            other: Vec3::new(0.25, 0.35, 0.3),
        },
    );
    let stone = stage.matt("stone", [0.62, 0.58, 0.5]);
    let banded = stage.patterned(
        "arch",
        [0.85, 0.8, 0.7],
        Procedural::Stripes {
            period: 0.3,
            other: Vec3::new(0.75, 0.2, 0.15),
        },
    );
    let shaft = Shape::of(stripes)
        .cone(Vec3::Y * 0.2, Vec3::Y * 2.1, 0.2, 0.16, 20)
        .done();
    let ends = Shape::of(stone)
        .cuboid(Vec3::Y * 0.1, Vec3::new(0.55, 0.2, 0.55))
        .cuboid(Vec3::Y * 2.17, Vec3::new(0.5, 0.14, 0.5))
        .done();
    let span = 2.2;
    let mut column = None;
    let (mut arches, mut top) = (Shape::of(banded), Shape::of(stone));
    for z in [-2.6, 0.2] {
        for i in 0..5 {
            let foot = Vec3::new(-4.6 + span * i as f32, 0.0, z);
            column = Some(match column {
                Some(model) => stage.copy(model, None, foot),
                None => stage.solid("column", None, foot, vec![shaft.clone(), ends.clone()]),
            });
            if i < 4 {
                let crown = foot + Vec3::new(span / 2.0, 2.2, 0.0);
                arches = arches.arch(crown, span / 2.0 - 0.1, 0.16, 20);
            }
        }
        let middle = Vec3::new(-4.6 + 2.0 * span, 3.5, z);
        top = top.cuboid(middle, Vec3::new(4.0 * span + 0.6, 0.12, 0.4));
    }
    stage.solid("arches", None, Vec3::ZERO, vec![arches.done(), top.done()]);
}

/// A gallery's steps with a railing, and trellises.
fn stairs(stage: &mut Stage) {
    let step = stage.patterned(
        "step",
        [0.6, 0.58, 0.55],
        Procedural::Stripes {
            period: 0.24,
            other: Vec3::new(0.5, 0.5, 0.55),
        },
    );
    let iron = stage.matt("iron", [0.03, 0.035, 0.03]);
    let brass = stage.matt("brass", [0.8, 0.55, 0.15]);
    let (mut steps, mut bars) = (Shape::of(step), Shape::of(iron));
    for i in 0..8 {
        let x = 1.0 + 0.45 * i as f32;
        let h = 0.18 * (i + 1) as f32;
        steps = steps.cuboid(Vec3::new(x, h / 2.0, -5.6), Vec3::new(0.45, h, 1.6));
        let foot = Vec3::new(x, h, -4.86);
        bars = bars.bar(foot, foot + Vec3::Y * 0.9, 0.03, 8);
    }
    let (low, high) = (Vec3::new(0.8, 1.1, -4.86), Vec3::new(4.4, 2.4, -4.86));
    let rail = Shape::of(brass).bar(low, high, 0.04, 10);
    for i in 0..=5 {
        let s = 0.576 * i as f32;
        bars = bars
            .cuboid(Vec3::new(0.2 + s, 1.0, 3.6), Vec3::new(0.07, 2.0, 0.07))
            .cuboid(Vec3::new(5.6, 1.1, -2.0 + s), Vec3::new(0.07, 2.2, 0.07));
        if i < 4 {
            let across = Vec3::new(5.6, 0.3 + s, -0.56);
            bars = bars.cuboid(across, Vec3::new(0.06, 0.06, 2.88));
        }
    }
    let top = Shape::of(brass).bar(Vec3::new(0.1, 2.0, 3.6), Vec3::new(3.2, 2.0, 3.6), 0.06, 10);
    let parts = vec![steps.done(), bars.done(), rail.done(), top.done()];
    stage.solid("stairs", None, Vec3::ZERO, parts);
}

/// A mirror sphere close to the way, the fan under the lamp, a top that spins.
fn things(stage: &mut Stage) {
    let silver = stage.mirror("silver", [0.93, 0.93, 0.95], 1.0);
    let blade = stage.matt("blade", [0.3, 0.2, 0.1]);
    let paint = stage.patterned(
        "paint",
        [0.95, 0.75, 0.1],
        Procedural::Stripes {
            period: TAU * 0.5 / 8.0,
            other: Vec3::new(0.1, 0.2, 1.0),
        },
    );
    let ball = Shape::of(silver)
        .sphere(Vec3::new(-0.75, 0.62, 2.15), 0.6, 40)
        .done();
    let second = Shape::of(silver)
        .sphere(Vec3::new(-3.6, 0.4, -4.0), 0.4, 32)
        .done();
    stage.solid("spheres", None, Vec3::ZERO, vec![ball, second]);

    let mut blades = Shape::of(blade).bar(Vec3::Y * -0.1, Vec3::Y * 0.1, 0.1, 10);
    for i in 0..4 {
        let turn = Quat::from_rotation_y(TAU * i as f32 / 4.0);
        let part = Shape::of(blade).cuboid(Vec3::X * 1.0, Vec3::new(1.9, 0.02, 0.22));
        blades = blades.with(part.turned(turn));
    }
    let fan = stage.solid("fan", None, Vec3::new(0.0, 4.3, -1.2), vec![blades.done()]);
    stage.spin(fan, Vec3::Y, 4);

    let top = Shape::of(paint)
        .cone(Vec3::ZERO, Vec3::Y * 0.45, 0.02, 0.45, 28)
        .cone(Vec3::Y * 0.45, Vec3::Y * 0.75, 0.45, 0.04, 28)
        .bar(Vec3::Y * 0.75, Vec3::Y * 1.0, 0.03, 8);
    let lean = stage.node("lean", None, Vec3::new(2.2, 0.0, -2.3));
    let top = stage.solid("top", Some(lean), Vec3::ZERO, vec![top.done()]);
    stage.spin(lean, Vec3::new(0.2, 1.0, 0.1).normalize(), 1);
    stage.spin(top, Vec3::Y, 10);
}
