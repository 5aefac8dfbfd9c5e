//! Places, views, gradients, tiles.

use super::{BETWEEN, BRIGHT, Case, DARK, Expected, checker};
use crate::stream::{DEPTH, PIXEL, Rng, Stream, flat, pose, sample, tile, view};
use unframed_wire::{SKY, Tick, Tile, View, WorldSample};

const SIZE: (u16, u16) = (24, 24);

pub(super) fn cases() -> Vec<Case> {
    let mut cases = gradients();
    cases.extend([
        one_pixel(),
        pixel_borders(),
        behind_the_eye(),
        at_w_0(),
        far_limit(),
        inverting_view(),
        off_screen(),
        back_again(),
        small_tiles(),
        one_tile(),
        lifetimes(0, "lifetimes of zero", Expected::Black),
        lifetimes(255, "endless lifetimes", Expected::Lit),
        close_pass(),
        unsound(),
    ]);
    cases
}

/// Two refreshes of the checker under one tile map.
fn tiled(leaf: u32, mut of: impl FnMut(&mut Rng, unframed_wire::Rect) -> Tile) -> Vec<u8> {
    let mut rng = Rng(1);
    let mut stream = Stream::of_the_plane(SIZE);
    let mut tiles = rng.clone();
    stream.tiles(0, leaf, |rect| of(&mut tiles, rect));
    for round in 0..2 {
        for k in 0..20 {
            let samples = checker(&mut rng, SIZE, 60);
            stream.world(round * 16_000 + k * 800, &samples);
        }
        stream.refresh((round + 1) * 16_000);
    }
    stream.bytes
}

/// Gradients of zero (log code 0) and infinite ones (255), in one, two and three axes: extents of
/// any ratio are clamped, and a mean stays between its samples.
fn gradients() -> Vec<Case> {
    [
        ("zero gradient in x", [0, 100, 100]),
        ("zero gradients in x, y", [0, 0, 100]),
        ("zero gradients in x, y, t", [0, 0, 0]),
        ("infinite gradient in x", [255, 100, 100]),
        ("infinite gradients in x, y", [255, 255, 100]),
        ("infinite gradients in x, y, t", [255, 255, 255]),
        ("zero in x, infinite in y and t", [0, 255, 255]),
    ]
    .map(|(name, [gx, gy, gt])| {
        let bytes = tiled(64, |_, rect| tile(rect, [gx, gy, gt, 128]));
        Case::new(name, SIZE, bytes, BETWEEN).method("paper")
    })
    .into()
}

fn one_pixel() -> Case {
    let mut rng = Rng(2);
    let mut stream = Stream::of_the_plane(SIZE);
    let rgb = [200, 100, 50];
    let inside = |rng: &mut Rng| rng.range(0, i64::from(PIXEL)) as i16;
    let samples: Vec<_> = (0..3000)
        .map(|_| sample([inside(&mut rng), inside(&mut rng), 0], rgb))
        .collect();
    stream.world(0, &samples);
    stream.refresh(1000);
    Case::new(
        "all samples in one pixel",
        SIZE,
        stream.bytes,
        Expected::Colour(rgb, 0),
    )
}

/// Samples exactly on the corners of pixels, where rounding down and to nearest differ.
fn pixel_borders() -> Case {
    let mut stream = Stream::of_the_plane(SIZE);
    let half = SIZE.0 as i16 / 2;
    let mut samples = Vec::new();
    for y in -half..=half {
        for x in -half..=half {
            let rgb = if (x + y) % 2 == 0 { BRIGHT } else { DARK };
            samples.push(sample([x * PIXEL, y * PIXEL, 0], rgb));
        }
    }
    stream.world(0, &samples);
    stream.refresh(1000);
    Case::new("all samples on pixel borders", SIZE, stream.bytes, BETWEEN)
        .method("adaptive-constant")
}

/// The checker with `extra` samples (object 1 at `pose`), and without.
fn with_unseen(name: &'static str, translation: [i32; 3], extra: &[WorldSample]) -> Case {
    let stream = |unseen: bool| {
        let mut rng = Rng(3);
        let mut stream = Stream::of_the_plane(SIZE);
        stream.poses(0, &[pose(1, 1.0, translation)]);
        for k in 0..10 {
            stream.world(k * 1000, &checker(&mut rng, SIZE, 100));
            if unseen {
                stream.world(k * 1000, extra);
            }
        }
        stream.refresh(12_000);
        stream.bytes
    };
    let expected = Expected::SameAs("the same stream without those samples", stream(false));
    Case::new(name, SIZE, stream(true), expected)
}

fn moving(place: [i16; 3]) -> WorldSample {
    WorldSample {
        object: 1,
        ..sample(place, [255, 0, 255])
    }
}

fn behind_the_eye() -> Case {
    let extra: Vec<_> = (-3..=3).map(|x| moving([x * 40, x * 11, 0])).collect();
    with_unseen("samples behind the eye", [0, 0, -2 * DEPTH], &extra)
}

fn at_w_0() -> Case {
    let extra: Vec<_> = (-3..=3).map(|x| moving([x * 1000, x * 300, 0])).collect();
    with_unseen("samples at w = 0", [0, 0, -DEPTH], &extra)
}

/// The farthest places that poses and lattices reach, straight ahead, beside the eye's own plane.
fn far_limit() -> Case {
    let mut stream = Stream::of_the_plane(SIZE);
    let far = 1 << 29;
    let mut object = pose(1, 100.0, [0, 0, far]);
    object.frac_bits = 10;
    object.matrix = object.matrix.map(|row| row.map(|v| v >> 1));
    stream.poses(0, &[object]);
    let rgb = [90, 120, 250];
    let samples: Vec<_> = [i16::MIN, -1, 0, 1, i16::MAX]
        .into_iter()
        .flat_map(|z| [[0, 0, z], [1, 1, z], [i16::MAX, i16::MIN, z]])
        .map(|place| WorldSample {
            object: 1,
            ..sample(place, rgb)
        })
        .collect();
    stream.world(0, &samples);
    stream.refresh(1000);
    Case::new(
        "samples at the far limit",
        SIZE,
        stream.bytes,
        Expected::Colour(rgb, 0),
    )
}

/// Left becomes right between two refreshes, and the world is seen from its back.
fn inverting_view() -> Case {
    let mut rng = Rng(4);
    let mut stream = Stream::of_the_plane(SIZE);
    for k in 0..10 {
        stream.world(k * 1000, &checker(&mut rng, SIZE, 100));
    }
    stream.refresh(12_000);
    let mut view = flat(12_000, SIZE);
    let centre = view.rows[0][2];
    view.eye = [0, 0, DEPTH];
    view.rows[0] = [-view.rows[0][0], 0, -centre];
    view.rows[1][2] = -centre;
    view.rows[2] = [0, 0, -view.rows[2][2]];
    stream.look(&view);
    stream.refresh(28_000);
    Case::new("a view that inverts", SIZE, stream.bytes, BETWEEN).method("adaptive-constant")
}

fn turned(time: u32) -> View {
    let mut view = flat(time, SIZE);
    view.rows = view.rows.map(|row| [row[0], row[1], -row[2]]);
    view
}

fn off_screen() -> Case {
    let mut rng = Rng(5);
    let mut stream = Stream::of_the_plane(SIZE);
    stream.world(0, &checker(&mut rng, SIZE, 1000));
    stream.refresh(10_000);
    stream.look(&turned(10_000));
    stream.refresh(20_000);
    Case::new(
        "a turn that leaves everything off screen",
        SIZE,
        stream.bytes,
        Expected::Kept,
    )
}

fn back_again() -> Case {
    let stream = |turn: bool| {
        let mut rng = Rng(5);
        let mut stream = Stream::of_the_plane(SIZE);
        stream.world(0, &checker(&mut rng, SIZE, 1000));
        stream.refresh(10_000);
        if turn {
            stream.look(&turned(10_000));
        }
        stream.look(&flat(10_000, SIZE));
        stream.refresh(20_000);
        stream.bytes
    };
    let expected = Expected::SameAs("the stream that never turned", stream(false));
    Case::new(
        "a turn away and back between refreshes",
        SIZE,
        stream(true),
        expected,
    )
}

fn small_tiles() -> Case {
    let bytes = tiled(1, |rng, rect| {
        let codes = [0; 4].map(|_| rng.bits() as u8);
        tile(rect, codes)
    });
    Case::new("tiles of one pixel, any codes", SIZE, bytes, BETWEEN).method("paper")
}

fn one_tile() -> Case {
    let bytes = tiled(u32::MAX, |_, rect| tile(rect, [90, 90, 90, 120]));
    Case::new("one tile for the whole screen", SIZE, bytes, Expected::Lit)
}

fn lifetimes(code: u8, name: &'static str, expected: Expected) -> Case {
    let bytes = tiled(64, |_, rect| tile(rect, [90, 90, 90, code]));
    Case::new(name, SIZE, bytes, expected)
}

/// A camera passes a sphere of 1 m radius at 5 cm (1 unit is 1 mm) while looking along it.
fn close_pass() -> Case {
    let mut rng = Rng(6);
    let mut stream = Stream::of_the_plane(SIZE);
    stream.poses(0, &[pose(0, 1.0, [0; 3]), pose(SKY, 1.0, [0; 3])]);
    for step in 0..10i32 {
        let time = step as u32 * 16_000;
        let eye = [1050, 0, -900 + 200 * step];
        let samples: Vec<_> = (0..400)
            .map(|_| {
                let (u, v) = (rng.unit() * std::f64::consts::TAU, rng.unit() * 2.0 - 1.0);
                let r = (1.0 - v * v).sqrt();
                let place = [r * u.cos(), v, r * u.sin()].map(|c| (1000.0 * c).round() as i16);
                let bright = ((8.0 * v).floor() + (8.0 * u).floor()) as i64 % 2 == 0;
                sample(place, if bright { BRIGHT } else { DARK })
            })
            .collect();
        stream.world(time, &samples);
        stream.look(&view(time, SIZE, eye, 20.0));
        stream.poses(time, &[pose(SKY, 1.0, eye)]);
        stream.refresh(time + 1000);
    }
    Case::new("a pass 5 cm from a sphere", SIZE, stream.bytes, BETWEEN).method("adaptive-constant")
}

/// Views and poses beyond their ranges are refused, what was known stays.
fn unsound() -> Case {
    let mut rng = Rng(7);
    let mut stream = Stream::of_the_plane(SIZE);
    stream.world(0, &checker(&mut rng, SIZE, 1000));
    stream.refresh(10_000);
    stream.look(&View {
        time: Tick(0),
        eye: [i32::MIN; 3],
        rows: [[i32::MIN; 3]; 3],
        frac_bits: 30,
    });
    let mut bad = pose(0, 1.0, [i32::MAX; 3]);
    bad.matrix = [[i32::MIN; 3]; 3];
    stream.poses(10_000, &[bad]);
    stream.refresh(10_000);
    Case::new(
        "views and poses out of range",
        SIZE,
        stream.bytes,
        Expected::Kept,
    )
}
