//! `atelier`: a workshop by day. The camera drifts along an arc, dwells, and swings over to the
//! other side. Made after the samplers were tuned, and not tuned on.
//!
//! What hurts: sunlight through a barred window that draws slanted shadows over everything, a
//! lamp that swings with its light, a potter's wheel with a glazed vase, an arm of three joints,
//! a pendulum, glass, and polished copper.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Quat, Vec2, Vec3};

use super::shapes::Shape;
use super::stage::{Stage, view};
use crate::scene::model::{Material, Procedural, Scene, Sky};

/// Half-width (x), half-depth (z) and height of the room, metres.
const X: f32 = 3.6;
const Z: f32 = 2.8;
const HEIGHT: f32 = 3.0;

pub(super) fn scene() -> Scene {
    let sky = Sky {
        zenith: Vec3::new(0.3, 0.5, 0.9),
        horizon: Vec3::new(0.85, 0.88, 0.9),
        ambient: Vec3::new(0.18, 0.18, 0.19),
    };
    let mut stage = Stage::new("atelier", 10.0, sky);
    room(&mut stage);
    furniture(&mut stage);
    arm(&mut stage);
    things(&mut stage);
    lamp(&mut stage);
    stage.sun(Vec3::new(0.8, -0.42, 0.2), [4.6, 4.1, 3.3]);
    let (wheel, bench) = ([0.3, 0.8, 0.2], [-1.6, 1.0, -1.4]);
    stage.camera(
        &[
            view(0.0, [2.6, 1.6, 2.1], wheel),
            view(1.5, [1.5, 1.5, 2.3], wheel),
            view(3.0, [0.2, 1.4, 2.2], bench),
            view(4.4, [-0.9, 1.3, 1.4], bench),
            view(5.4, [-0.9, 1.3, 1.4], bench),
            view(6.2, [-0.7, 1.4, 1.5], [2.6, 1.1, 0.4]),
            view(8.0, [0.6, 1.7, 1.9], [3.0, 1.2, -1.2]),
            view(9.2, [2.2, 1.7, 2.2], wheel),
            view(10.0, [2.6, 1.6, 2.1], wheel),
        ],
        false,
    );
    stage.done()
}

/// Planks, walls, a window to the left with bars.
fn room(stage: &mut Stage) {
    let planks = stage.patterned(
        "planks",
        [0.5, 0.33, 0.19],
        Procedural::Brick {
            size: Vec2::new(1.6, 0.2),
            joint: 0.012,
            mortar: Vec3::new(0.4, 0.35, 0.3),
        },
    );
    let plaster = stage.matt("plaster", [0.78, 0.74, 0.66]);
    let panel = stage.patterned(
        "panel",
        [0.2, 0.36, 0.33],
        Procedural::Stripes {
            period: 0.5,
            other: Vec3::new(0.75, 0.8, 0.8),
        },
    );
    let ceiling = stage.matt("ceiling", [0.8, 0.8, 0.78]);
    let frame = stage.matt("frame", [0.85, 0.83, 0.78]);
    let (w, d) = (2.0 * X, 2.0 * Z);
    let floor = Shape::of(planks).quad(Vec3::new(-X, 0.0, Z), Vec3::X * w, Vec3::NEG_Z * d);
    let top = Shape::of(ceiling).quad(Vec3::new(-X, HEIGHT, -Z), Vec3::X * w, Vec3::Z * d);
    // The wall at −x has a hole from 0.9 to 2.4 m, 2.4 m wide.
    let (low, high, side) = (0.9, 2.4, 1.2);
    let left = |y0: f32, y1: f32, z0: f32, z1: f32| {
        let corner = Vec3::new(-X, y0, z1);
        (corner, Vec3::Z * (z0 - z1), Vec3::Y * (y1 - y0))
    };
    let mut walls = Shape::of(plaster)
        .quad(
            Vec3::new(-X, 1.0, -Z),
            Vec3::X * w,
            Vec3::Y * (HEIGHT - 1.0),
        )
        .quad(
            Vec3::new(X, 1.0, Z),
            Vec3::NEG_X * w,
            Vec3::Y * (HEIGHT - 1.0),
        )
        .quad(Vec3::new(X, 1.0, -Z), Vec3::Z * d, Vec3::Y * (HEIGHT - 1.0));
    for (corner, u, v) in [
        left(0.0, low, -Z, Z),
        left(high, HEIGHT, -Z, Z),
        left(low, high, -Z, -side),
        left(low, high, side, Z),
    ] {
        walls = walls.quad(corner, u, v);
    }
    let lower = Shape::of(panel)
        .quad(Vec3::new(-X, 0.0, -Z), Vec3::X * w, Vec3::Y)
        .quad(Vec3::new(X, 0.0, Z), Vec3::NEG_X * w, Vec3::Y)
        .quad(Vec3::new(X, 0.0, -Z), Vec3::Z * d, Vec3::Y);
    let mut bars = Shape::of(frame).cuboid(
        Vec3::new(-X, low - 0.03, 0.0),
        Vec3::new(0.3, 0.06, 2.0 * side + 0.2),
    );
    for i in 0..=4 {
        let z = -side + 0.5 * side * i as f32;
        bars = bars.cuboid(Vec3::new(-X, 1.65, z), Vec3::new(0.06, high - low, 0.07));
    }
    bars = bars.cuboid(Vec3::new(-X, 1.75, 0.0), Vec3::new(0.06, 0.07, 2.0 * side));
    let parts = [floor, top, walls, lower, bars].map(Shape::done);
    stage.solid("room", None, Vec3::ZERO, parts.into());
}

/// A bench along the back, shelves, an easel with a picture.
fn furniture(stage: &mut Stage) {
    let oak = stage.matt("oak", [0.45, 0.28, 0.14]);
    let picture = stage.patterned(
        "picture",
        [0.9, 0.6, 0.2],
        Procedural::Checker {
            size: 0.16,
            other: Vec3::new(0.2, 0.5, 1.0),
        },
    );
    let mut wood = Shape::of(oak).cuboid(Vec3::new(-1.2, 0.82, -2.2), Vec3::new(3.4, 0.08, 0.9));
    for x in [-2.75, 0.35] {
        for z in [-2.5, -1.9] {
            wood = wood.cuboid(Vec3::new(x, 0.4, z), Vec3::new(0.12, 0.8, 0.12));
        }
    }
    for y in [1.35, 1.85] {
        wood = wood.cuboid(Vec3::new(3.35, y, -0.8), Vec3::new(0.4, 0.05, 2.2));
    }
    // The easel leans back on its third leg.
    let easel = Shape::of(oak)
        .cuboid(Vec3::new(-0.3, 0.8, 0.0), Vec3::new(0.07, 1.6, 0.06))
        .cuboid(Vec3::new(0.3, 0.8, 0.0), Vec3::new(0.07, 1.6, 0.06))
        .cuboid(Vec3::new(0.0, 0.62, 0.05), Vec3::new(0.9, 0.06, 0.12));
    let canvas = Shape::of(picture).cuboid(Vec3::new(0.0, 1.15, 0.05), Vec3::new(0.96, 0.96, 0.04));
    let lean = Quat::from_rotation_y(-0.7) * Quat::from_rotation_x(-0.16);
    let parts = vec![
        wood.done(),
        easel.turned(lean).done(),
        canvas.turned(lean).done(),
    ];
    let [wood, easel, canvas]: [_; 3] = parts.try_into().expect("three parts");
    stage.solid("bench", None, Vec3::ZERO, vec![wood]);
    stage.solid(
        "easel",
        None,
        Vec3::new(2.3, 0.0, -1.9),
        vec![easel, canvas],
    );
}

/// An arm on the bench: base, upper arm, forearm, each turning in the one before.
fn arm(stage: &mut Stage) {
    let yellow = stage.matt("arm", [0.9, 0.6, 0.05]);
    let grey = stage.matt("joint", [0.2, 0.21, 0.23]);
    let base = stage.solid(
        "base",
        None,
        Vec3::new(-1.6, 0.86, -2.1),
        vec![
            Shape::of(grey)
                .cone(Vec3::ZERO, Vec3::Y * 0.2, 0.22, 0.15, 20)
                .disc(Vec3::Y * 0.2, Vec3::Y, 0.15, 20)
                .done(),
        ],
    );
    stage.swing(base, Vec3::Y, 0.2, 1.1, 2);
    let link = |length: f32, thick: f32| {
        vec![
            Shape::of(yellow)
                .cuboid(
                    Vec3::Y * (length / 2.0),
                    Vec3::new(thick, length, thick * 0.8),
                )
                .done(),
            Shape::of(grey).sphere(Vec3::ZERO, thick * 0.8, 10).done(),
        ]
    };
    let upper = stage.solid("upper arm", Some(base), Vec3::Y * 0.25, link(0.65, 0.14));
    stage.swing(upper, Vec3::X, 0.3, 0.35, 3);
    let fore = stage.solid("forearm", Some(upper), Vec3::Y * 0.65, link(0.5, 0.1));
    stage.swing(fore, Vec3::X, 1.2, 0.6, 5);
}

/// The potter's wheel with its vase, glass and copper, a pendulum clock.
fn things(stage: &mut Stage) {
    let clay = stage.matt("wheel", [0.4, 0.32, 0.28]);
    let glaze = stage.patterned(
        "glaze",
        [0.15, 0.3, 0.65],
        Procedural::Stripes {
            period: PI * 0.44 / 7.0,
            other: Vec3::new(5.0, 2.6, 1.2),
        },
    );
    let glass = stage.material(Material {
        name: "glass".into(),
        roughness: 0.0,
        transmission: 1.0,
        ..Material::default()
    });
    let copper = stage.mirror("copper", [0.95, 0.6, 0.45], 0.85);
    let stand = Shape::of(clay)
        .cone(Vec3::ZERO, Vec3::Y * 0.55, 0.3, 0.22, 20)
        .done();
    stage.solid("stand", None, Vec3::new(0.3, 0.0, 0.2), vec![stand]);
    let plate = Shape::of(clay)
        .cone(Vec3::ZERO, Vec3::Y * 0.05, 0.42, 0.42, 32)
        .disc(Vec3::Y * 0.05, Vec3::Y, 0.42, 32)
        .done();
    let vase = Shape::of(glaze)
        .cone(Vec3::Y * 0.05, Vec3::Y * 0.3, 0.1, 0.22, 28)
        .cone(Vec3::Y * 0.3, Vec3::Y * 0.52, 0.22, 0.09, 28)
        .cone(Vec3::Y * 0.52, Vec3::Y * 0.64, 0.09, 0.15, 28)
        .done();
    let wheel = stage.solid("plate", None, Vec3::new(0.3, 0.55, 0.2), vec![plate, vase]);
    stage.spin(wheel, Vec3::Y, 8);

    let ball = Shape::of(glass).sphere(Vec3::ZERO, 0.2, 24).done();
    stage.solid("glass", None, Vec3::new(-0.4, 1.06, -2.1), vec![ball]);
    let pot = Shape::of(copper)
        .sphere(Vec3::Y * 0.3, 0.3, 24)
        .cone(Vec3::Y * 0.55, Vec3::Y * 0.7, 0.14, 0.2, 24)
        .done();
    stage.solid("pot", None, Vec3::new(-2.3, 0.0, 0.2), vec![pot]);
    let mut jars = Vec::new();
    for (i, colour) in [[0.7, 0.15, 0.1], [0.85, 0.75, 0.3], [0.2, 0.45, 0.25]]
        .into_iter()
        .enumerate()
    {
        let paint = stage.matt("jar", colour);
        let foot = Vec3::new(3.35, 1.375, -1.5 + 0.6 * i as f32);
        let jar = Shape::of(paint)
            .cone(foot, foot + Vec3::Y * 0.26, 0.12, 0.14, 18)
            .disc(foot + Vec3::Y * 0.26, Vec3::Y, 0.14, 18);
        jars.push(jar.done());
    }
    stage.solid("jars", None, Vec3::ZERO, jars);

    let case = stage.matt("case", [0.25, 0.12, 0.06]);
    let brass = stage.matt("brass", [0.8, 0.55, 0.15]);
    let face = stage.matt("face", [0.9, 0.88, 0.8]);
    let body = Shape::of(case).cuboid(Vec3::Y * 0.1, Vec3::new(0.5, 0.5, 0.12));
    let dial = Shape::of(face).disc(Vec3::new(0.0, 0.1, 0.07), Vec3::Z, 0.2, 28);
    let clock = Vec3::new(0.9, 2.1, -Z + 0.07);
    stage.solid("clock", None, clock, vec![body.done(), dial.done()]);
    let bob = Shape::of(brass)
        .cuboid(Vec3::Y * -0.3, Vec3::new(0.04, 0.6, 0.03))
        .disc(Vec3::new(0.0, -0.62, 0.025), Vec3::Z, 0.12, 24)
        .done();
    let pendulum = stage.solid(
        "pendulum",
        None,
        clock + Vec3::new(0.0, -0.1, 0.09),
        vec![bob],
    );
    stage.swing(pendulum, Vec3::Z, 0.0, 0.35, 10);
}

/// A shade that hangs from the ceiling and swings with its light.
fn lamp(stage: &mut Stage) {
    let enamel = stage.matt("shade", [0.1, 0.3, 0.22]);
    let hook = stage.node("hook", None, Vec3::new(0.6, HEIGHT, -0.3));
    stage.swing(hook, Vec3::new(0.8, 0.0, 0.6), 0.0, 0.3, 4);
    let shade = Shape::of(enamel)
        .bar(Vec3::Y * -0.75, Vec3::ZERO, 0.02, 8)
        .cone(Vec3::Y * -0.95, Vec3::Y * -0.75, 0.3, 0.06, 24)
        .turned(Quat::from_rotation_y(FRAC_PI_2));
    stage.solid("lamp", Some(hook), Vec3::ZERO, vec![shade.done()]);
    stage.point_light(Some(hook), Vec3::Y * -0.92, [11.0, 9.4, 7.2]);
}
