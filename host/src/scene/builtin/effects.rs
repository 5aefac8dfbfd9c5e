//! Scenes that call for effects: soft shadows from emissive meshes, and media. After the scenes
//! of Dubla et al. 2009 (Figs 6 and 7) in kind: a Cornell box, an office, a forest of occluders,
//! light through slats. In each a thing moves and the camera rests.

use glam::{Quat, Vec2, Vec3};

use super::shapes::Shape;
use super::stage::{Stage, view};
use crate::scene::model::{Procedural, Scene, Sky};

/// No light but the lamps', and a little in the shadows.
fn dim(ambient: f32) -> Sky {
    Sky {
        zenith: Vec3::splat(0.02),
        horizon: Vec3::splat(0.02),
        ambient: Vec3::splat(ambient),
    }
}

/// A box of 2 m, red to the left and green to the right, with a lamp in its ceiling.
pub(super) fn cornell(name: &str, mist: bool) -> Scene {
    let mut stage = Stage::new(name, 4.0, dim(0.03));
    stage.indirect();
    let white = stage.matt("white", [0.73, 0.73, 0.73]);
    let red = stage.matt("red", [0.65, 0.05, 0.05]);
    let green = stage.matt("green", [0.12, 0.45, 0.15]);
    let lamp = stage.glow("lamp", [17.0, 14.0, 10.0]);
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let corner = Vec3::new(-1.0, 0.0, -1.0);
    let walls = vec![
        Shape::of(white)
            .quad(corner + z, x, -z)
            .quad(corner + y, x, z)
            .quad(corner, x, y)
            .done(),
        Shape::of(red).quad(corner + z, -z, y).done(),
        Shape::of(green).quad(corner + x, z, y).done(),
        Shape::of(lamp)
            .quad(Vec3::new(-0.25, 1.98, -0.25), Vec3::X * 0.5, Vec3::Z * 0.5)
            .done(),
    ];
    stage.solid("room", None, Vec3::ZERO, walls);
    let tall = Shape::of(white)
        .cuboid(Vec3::Y * 0.6, Vec3::new(0.58, 1.2, 0.58))
        .turned(Quat::from_rotation_y(0.3));
    stage.solid(
        "tall",
        None,
        Vec3::new(-0.35, 0.0, -0.35),
        vec![tall.done()],
    );
    let short = Shape::of(white).cuboid(Vec3::Y * 0.3, Vec3::splat(0.6));
    let short = stage.solid("short", None, Vec3::new(0.38, 0.0, 0.3), vec![short.done()]);
    stage.spin(short, Vec3::Y, 1);
    if mist {
        stage.medium(
            Vec3::new(-1.0, 0.0, -1.0),
            Vec3::new(1.0, 2.0, 1.0),
            0.35,
            0.0,
        );
    }
    stage.camera(&[view(0.0, [0.0, 1.0, 3.0], [0.0, 0.97, 0.0])], true);
    stage.done()
}

/// Desks and shelves under two long lamps.
pub(super) fn office() -> Scene {
    let mut stage = Stage::new("office", 6.0, dim(0.05));
    stage.indirect();
    let carpet = stage.patterned(
        "carpet",
        [0.3, 0.33, 0.4],
        Procedural::Checker {
            size: 0.5,
            other: Vec3::splat(0.75),
        },
    );
    let wall = stage.matt("wall", [0.75, 0.72, 0.66]);
    let wood = stage.matt("wood", [0.5, 0.33, 0.18]);
    let dark = stage.matt("dark", [0.08, 0.08, 0.1]);
    let book = stage.patterned(
        "books",
        [0.7, 0.25, 0.15],
        Procedural::Stripes {
            period: 0.14,
            other: Vec3::new(0.3, 1.2, 2.0),
        },
    );
    let lamp = stage.glow("tube", [20.0, 20.0, 19.0]);
    let corner = Vec3::new(-2.5, 0.0, -2.0);
    let (x, y, z) = (Vec3::X * 5.0, Vec3::Y * 2.7, Vec3::Z * 5.0);
    let mut furniture = Shape::of(wood);
    let mut metal = Shape::of(dark);
    for (cx, cz) in [(-1.2, -0.6), (0.9, -0.9), (0.1, 0.9)] {
        let at = Vec3::new(cx, 0.0, cz);
        furniture = furniture.cuboid(at + Vec3::Y * 0.72, Vec3::new(1.4, 0.05, 0.7));
        for leg in [(-0.62, -0.28), (0.62, -0.28), (-0.62, 0.28), (0.62, 0.28)] {
            let foot = at + Vec3::new(leg.0, 0.35, leg.1);
            metal = metal.cuboid(foot, Vec3::new(0.05, 0.7, 0.05));
        }
        metal = metal
            .cuboid(
                at + Vec3::new(0.2, 1.02, -0.15),
                Vec3::new(0.55, 0.36, 0.03),
            )
            .cuboid(at + Vec3::new(0.2, 0.8, -0.15), Vec3::new(0.06, 0.12, 0.03));
    }
    for i in 0..4 {
        let y = 0.5 + 0.45 * i as f32;
        furniture = furniture.cuboid(Vec3::new(1.9, y, -1.82), Vec3::new(1.1, 0.04, 0.34));
    }
    let books = (0..3).fold(Shape::of(book), |shape, i| {
        let size = Vec3::new(0.8 - 0.15 * i as f32, 0.28, 0.22);
        shape.cuboid(Vec3::new(1.85, 0.66 + 0.45 * i as f32, -1.82), size)
    });
    let tubes = [-1.1, 1.1].into_iter().fold(Shape::of(lamp), |shape, x| {
        shape.quad(Vec3::new(x - 0.15, 2.6, -0.9), Vec3::X * 0.3, Vec3::Z * 1.6)
    });
    let parts = vec![
        Shape::of(carpet).quad(corner + z, x, -z).done(),
        Shape::of(wall)
            .quad(corner + y, x, z)
            .quad(corner, x, y)
            .quad(corner + z, -z, y)
            .quad(corner + x, z, y)
            .done(),
        furniture.done(),
        metal.done(),
        books.done(),
        tubes.done(),
    ];
    stage.solid("office", None, Vec3::ZERO, parts);
    let chair = Shape::of(dark)
        .cuboid(Vec3::Y * 0.45, Vec3::new(0.45, 0.06, 0.45))
        .cuboid(Vec3::new(0.0, 0.75, 0.2), Vec3::new(0.42, 0.5, 0.05))
        .bar(Vec3::ZERO, Vec3::Y * 0.45, 0.04, 8);
    let chair = stage.solid(
        "chair",
        None,
        Vec3::new(-1.1, 0.0, 0.15),
        vec![chair.done()],
    );
    stage.spin(chair, Vec3::Y, 1);
    stage.camera(&[view(0.0, [-0.6, 1.75, 2.9], [0.2, 0.8, -0.8])], true);
    stage.done()
}

/// Posts under a square lamp: penumbrae upon penumbrae.
pub(super) fn forest(name: &str, mist: bool) -> Scene {
    let mut stage = Stage::new(name, 6.0, dim(0.05));
    let ground = stage.matt("ground", [0.6, 0.58, 0.5]);
    let bark = stage.matt("bark", [0.45, 0.32, 0.22]);
    let leaf = stage.matt("leaf", [0.2, 0.4, 0.15]);
    let lamp = stage.glow("lamp", [38.0, 34.0, 28.0]);
    let floor = Shape::of(ground).quad(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, Vec3::Z * -10.0);
    let (mut trunks, mut crowns) = (Shape::of(bark), Shape::of(leaf));
    // Places without regularity: the additive recurrence of the plastic number.
    for i in 0..42 {
        let i = i as f32 + 0.5;
        let at = Vec2::new((0.754_878 * i).fract(), (0.569_84 * i).fract());
        let foot = Vec3::new(at.x * 6.0 - 3.0, 0.0, at.y * 5.0 - 3.4);
        let height = 0.7 + 0.6 * (0.618_034 * i).fract();
        trunks = trunks.cone(foot, foot + Vec3::Y * height, 0.06, 0.045, 10);
        crowns = crowns.sphere(foot + Vec3::Y * (height + 0.12), 0.2, 8);
    }
    let lamps = Shape::of(lamp)
        .quad(Vec3::new(-1.0, 3.2, -2.6), Vec3::X, Vec3::Z)
        .done();
    let parts = vec![floor.done(), trunks.done(), crowns.done(), lamps];
    stage.solid("forest", None, Vec3::ZERO, parts);
    let gate = Shape::of(bark).cuboid(Vec3::new(0.0, 0.5, 0.0), Vec3::new(1.6, 0.3, 0.08));
    let gate = stage.solid("gate", None, Vec3::new(0.4, 0.9, 0.6), vec![gate.done()]);
    stage.spin(gate, Vec3::Y, 1);
    if mist {
        stage.medium(
            Vec3::new(-5.0, 0.0, -5.0),
            Vec3::new(5.0, 3.4, 3.0),
            0.12,
            0.3,
        );
    }
    stage.camera(&[view(0.0, [0.6, 1.7, 3.4], [0.0, 0.6, -0.6])], true);
    stage.done()
}

/// A lamp behind slats in a hazy room: shafts of light.
pub(super) fn slats() -> Scene {
    let mut stage = Stage::new("slats", 5.0, dim(0.02));
    stage.indirect();
    let wall = stage.matt("wall", [0.6, 0.56, 0.5]);
    let slat = stage.matt("slat", [0.25, 0.2, 0.16]);
    let ball = stage.matt("ball", [0.75, 0.25, 0.15]);
    let lamp = stage.glow("lamp", [90.0, 80.0, 62.0]);
    let corner = Vec3::new(-2.0, 0.0, -1.5);
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 2.4, Vec3::Z * 4.5);
    let mut blind = Shape::of(slat);
    for i in 0..7 {
        let at = Vec3::new(-1.2, 0.5 + 0.3 * i as f32, 0.0);
        blind = blind.cuboid(at, Vec3::new(0.02, 0.16, 3.0));
    }
    let parts = vec![
        Shape::of(wall)
            .quad(corner + z, x, -z)
            .quad(corner, x, y)
            .quad(corner + x, z, y)
            .quad(corner + y, x, z)
            .quad(corner + z, -z, y)
            .done(),
        blind.done(),
        Shape::of(lamp)
            .quad(Vec3::new(-1.9, 1.5, -0.2), Vec3::Y * 0.4, Vec3::Z * 0.4)
            .done(),
    ];
    stage.solid("room", None, Vec3::ZERO, parts);
    let arm = stage.node("arm", None, Vec3::new(0.4, 0.0, 0.0));
    stage.spin(arm, Vec3::Y, 1);
    let shape = Shape::of(ball).sphere(Vec3::ZERO, 0.3, 20).done();
    stage.solid("ball", Some(arm), Vec3::new(0.5, 0.6, 0.0), vec![shape]);
    stage.medium(corner, corner + x + y + z, 0.25, 0.2);
    stage.camera(&[view(0.0, [0.9, 1.2, 2.9], [-0.1, 1.0, 0.0])], true);
    stage.done()
}
