//! Light of the instant against `f64`: places, maps, what shares take away; and what no host sends.

#![cfg(feature = "light")]

use proptest::prelude::*;
use unframed_recon::Fixed;
use unframed_recon::deep::{Placing, Stored, slot};
use unframed_recon::light::facets::{CASTERS, Facet, Facets, PARTS, Taken};
use unframed_recon::light::map::{WINDOWS, Window};
use unframed_recon::light::toward::{Aim, Toward};
use unframed_recon::light::{Lights, Memory, WHOLE};
use unframed_recon::memory::Slot;
use unframed_wire::{
    ColourEncoding, Hello, LAMPS, Lamp, LampKind, Layout, Packet, Pose, Receiver, Shape, Shares,
    TileFields, WorldFrame, Writer,
};

type Point = [f64; 3];
type Triangle = [[i16; 3]; 3];

/// World units in a unit of places.
const UNIT: i32 = 256;
/// Units in a step of the depths of maps.
const DEPTH: f64 = 4.0;
/// Half the side of a face of a cube, as maps count it.
const FACE: f64 = 16384.0;

/// The splitmix64 generator: seeded test data.
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform within ±edge.
    fn within(&mut self, edge: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * edge
    }
}

/// Shapes come after one.
const HELLO: Hello = Hello {
    width: 8,
    height: 8,
    layout: Layout::World,
    objects: true,
    tile_fields: TileFields {
        gradients: false,
        lifetime: false,
        density: false,
    },
    encoding: ColourEncoding::Srgb8,
    rate: 1000,
    refresh_millihertz: 60_000,
    world: WorldFrame {
        origin: [0.0; 3],
        unit: 0.001,
    },
    lamps: LAMPS as u8,
};

/// Storage for lights.
struct Room {
    facets: Vec<Facet>,
    towards: Vec<[Toward; LAMPS]>,
    texels: Vec<u16>,
    windows: Vec<Window>,
}

impl Room {
    fn new(facets: usize, texels: usize) -> Room {
        Room {
            facets: vec![Facet::EMPTY; facets],
            towards: vec![[Toward::ZERO; LAMPS]; 256],
            texels: vec![0; texels],
            windows: vec![Window::EMPTY; WINDOWS],
        }
    }

    fn lights(&mut self) -> Lights<'_> {
        Lights::new(Memory {
            facets: &mut self.facets,
            towards: &mut self.towards,
            texels: &mut self.texels,
            windows: &mut self.windows,
        })
    }
}

/// Hands over a part of a shape as it comes out of a stream.
fn with_shape<R>(
    (object, part): (u8, u8),
    triangles: &[Triangle],
    take: impl FnOnce(&Shape<'_>) -> R,
) -> R {
    let mut bytes = Vec::new();
    let sink = &mut |frame: &[u8]| bytes.extend_from_slice(frame);
    let corners = |i: usize| [0, 1, 2].map(|k| (3 * i + k) as u8);
    let indices: Vec<_> = (0..triangles.len()).map(corners).collect();
    let mut writer = Writer::new();
    writer.hello(&HELLO, sink).expect("a sound hello");
    writer
        .shape(object, part, 256, triangles.as_flattened(), &indices, sink)
        .expect("a sound shape");
    let (mut receiver, mut input) = (Receiver::new(), &bytes[..]);
    loop {
        match receiver.push(&mut input) {
            Some(Packet::Shape(shape)) => return take(&shape),
            Some(_) => {}
            None => panic!("no shape"),
        }
    }
}

/// Lattice steps are units of places, and so are the numbers of `at`: lamps see them exactly.
fn exact(object: u8, at: [i32; 3]) -> Pose {
    Pose {
        object,
        matrix: [[UNIT, 0, 0], [0, UNIT, 0], [0, 0, UNIT]],
        frac_bits: 0,
        translation: at.map(|v| UNIT * v),
    }
}

/// Slots with these poses.
fn slots(poses: &[Pose]) -> Vec<Slot<Fixed>> {
    let mut slots = vec![Slot::default(); 256];
    for pose in poses {
        slots[usize::from(slot(pose.object))].pose = Some(*pose);
    }
    slots
}

fn lamp(kind: LampKind, place: [i32; 3]) -> Lamp {
    Lamp {
        kind,
        place,
        tint: [256; 2],
    }
}

/// A white sample all of whose light comes from one lamp: black in its shadow.
fn sample(object: u8, place: [i16; 3], lamp: usize) -> Stored {
    let mut codes = [0; LAMPS];
    codes[lamp] = 15;
    Stored {
        time: 0,
        place,
        rgb: [255; 3],
        slot: slot(object),
        placing: Placing::Lattice,
        shares: Shares::new(codes),
    }
}

fn dark(lights: &Lights<'_>, sample: &Stored) -> bool {
    lights.relight(sample) == [0; 3]
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn cross(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// How far along a ray it meets a triangle (Möller & Trumbore 1997).
fn meets(from: Point, along: Point, [a, b, c]: [Point; 3]) -> Option<f64> {
    let (e, f) = (sub(b, a), sub(c, a));
    let p = cross(along, f);
    let det = dot(e, p);
    let t = sub(from, a);
    let u = dot(t, p) / det;
    let q = cross(t, e);
    let v = dot(along, q) / det;
    let inside = det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    inside.then(|| dot(f, q) / det)
}

/// What of a polygon is on one side: where `outside` is not positive.
fn clipped(polygon: &[Point], outside: impl Fn(Point) -> f64) -> Vec<Point> {
    let mut kept = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (p, q) = (outside(a), outside(b));
        if p <= 0.0 {
            kept.push(a);
        }
        if (p < 0.0) != (q < 0.0) && p != q {
            let t = p / (p - q);
            kept.push([0, 1, 2].map(|k| a[k] + t * (b[k] - a[k])));
        }
    }
    kept
}

/// What must become of a sample, as far as `f64` is sure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Dark,
    Lit,
    Close,
}

/// Whether a triangle stands before `place`, all as a face sees it: across, up, ahead; `margin` on
/// the face away from any edge and `depth` before or behind it.
fn verdict(kind: LampKind, triangle: [Point; 3], place: Point, margin: f64, depth: f64) -> Verdict {
    let at = match kind {
        LampKind::Point => [place[0] / place[2] * FACE, place[1] / place[2] * FACE],
        LampKind::Directional => [place[0], place[1]],
    };
    let scale = |p: Point| match kind {
        LampKind::Point => p[2] / FACE,
        LampKind::Directional => 1.0,
    };
    // What is around the way to the lamp.
    let mut around = triangle.to_vec();
    if kind == LampKind::Point {
        around = clipped(&around, |p| 1e-3 - p[2]);
    }
    for k in [0, 1] {
        around = clipped(&around, |p| p[k] - (at[k] + margin) * scale(p));
        around = clipped(&around, |p| (at[k] - margin) * scale(p) - p[k]);
    }
    let nearest = around.iter().fold(f64::MAX, |least, p| least.min(p[2]));
    if nearest > place[2] + depth {
        return Verdict::Lit;
    }
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let before = corners.iter().all(|way| {
        let [x, y] = [0, 1].map(|k| at[k] + margin * way[k]);
        let ahead = match kind {
            LampKind::Point => {
                let along = [x, y, FACE];
                meets([0.0; 3], along, triangle).and_then(|t| (t > 0.0).then_some(t * FACE))
            }
            LampKind::Directional => meets([x, y, 0.0], [0.0, 0.0, 1.0], triangle),
        };
        ahead.is_some_and(|ahead| ahead < place[2] - depth)
    });
    if before {
        Verdict::Dark
    } else {
        Verdict::Close
    }
}

/// All that a lamp sees, as the face sees it that sees `place`.
fn as_seen(kind: LampKind, lamp: Point, all: &[Point]) -> Vec<Point> {
    let place = all[0];
    let (axis, from) = match kind {
        LampKind::Point => (longest(sub(place, lamp)), lamp),
        LampKind::Directional => (longest(lamp), [0.0; 3]),
    };
    let sign = match kind {
        LampKind::Point => sub(place, lamp)[axis].signum(),
        // Depth grows away from the light.
        LampKind::Directional => -lamp[axis].signum(),
    };
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let seen = |p: &Point| {
        let mut p = sub(*p, from);
        if kind == LampKind::Directional {
            // Along the light into the plane of the two other axes.
            for k in [b, c] {
                p[k] -= p[axis] * lamp[k] / lamp[axis];
            }
        }
        [p[b], p[c], sign * p[axis]]
    };
    all.iter().map(seen).collect()
}

fn longest(v: Point) -> usize {
    let [x, y, z] = v.map(f64::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Random triangles, small and large, near the lamp and far, and random places, many of them on
/// ways through a triangle: maps are right but within 1.5 texels of an edge or 3 steps of depth.
fn agree(kind: LampKind, seed: u64) {
    let mut rng = Rng(seed);
    // Dark, lit, close.
    let mut counts = [0; 3];
    for case in 0..600 {
        let mut room = Room::new(8, [1 << 18, 1 << 14, 1 << 19][case % 3]);
        let mut lights = room.lights();
        let spread = f64::from(1 << (case % 7 + 7));
        let [at, still, place] = [(); 3].map(|()| [(); 3].map(|()| rng.within(3000.0) as i32));
        let (given, seen_from) = match kind {
            LampKind::Point => (place.map(|v| UNIT * v), place.map(f64::from)),
            LampKind::Directional => {
                let towards = [(); 3].map(|()| rng.within(f64::from(1 << 30)) as i32);
                (towards, towards.map(f64::from))
            }
        };
        assert!(lights.lamp(1, &lamp(kind, given)));
        let triangles: Vec<Triangle> = (0..case % 4 + 1)
            .map(|_| {
                let near = [0, 1, 2].map(|k| f64::from(place[k] - at[k]) + rng.within(spread));
                [(); 3].map(|()| near.map(|v| (v + rng.within(spread)) as i16))
            })
            .collect();
        assert!(with_shape((1, 0), &triangles, |shape| lights.shape(shape)));
        lights.prepare(&slots(&[exact(0, still), exact(1, at)]));
        let shift = lights.maps().windows().first().map_or(0, |w| w.shift);
        let margin = 1.5 * f64::from(1u32 << shift);
        let corners = |triangle: &Triangle| {
            triangle.map(|corner| [0, 1, 2].map(|k| f64::from(i32::from(corner[k]) + at[k])))
        };
        for _ in 0..60 {
            // Through a triangle, if the numbers allow.
            let [a, b, c] = corners(&triangles[rng.next() as usize % triangles.len()]);
            let (u, v) = (rng.unit(), rng.unit());
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            let on = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
            let by = 3.0 * rng.unit();
            let place = match kind {
                LampKind::Point => [0, 1, 2].map(|k| seen_from[k] + by * (on[k] - seen_from[k])),
                LampKind::Directional => {
                    let long = dot(seen_from, seen_from).sqrt();
                    [0, 1, 2].map(|k| on[k] + (by - 1.0) * spread * seen_from[k] / long)
                }
            };
            let place = [0, 1, 2].map(|k| (place[k] + rng.within(spread / 4.0)) as i32 - still[k]);
            let Some(place) = narrow(place) else { continue };
            let mut all = vec![[0, 1, 2].map(|k| f64::from(i32::from(place[k]) + still[k]))];
            all.extend(triangles.iter().flat_map(corners));
            let seen = as_seen(kind, seen_from, &all);
            if seen[0][2] == 0.0 && kind == LampKind::Point {
                continue;
            }
            let verdicts = seen[1..].chunks(3).map(|corners| {
                let triangle = [corners[0], corners[1], corners[2]];
                verdict(kind, triangle, seen[0], margin, 3.0 * DEPTH)
            });
            let verdicts: Vec<_> = verdicts.collect();
            let is_dark = dark(&lights, &sample(0, place, 1));
            let told = || format!("{kind:?} case {case}: {triangles:?} {seen:?} {verdicts:?}");
            if verdicts.contains(&Verdict::Dark) {
                assert!(is_dark, "lit: {}", told());
                counts[0] += 1;
            } else if verdicts.contains(&Verdict::Close) {
                counts[2] += 1;
            } else {
                assert!(!is_dark, "dark: {}", told());
                counts[1] += 1;
            }
            // Its own shadow is not seen.
            if let Some(own) = narrow([0, 1, 2].map(|k| i32::from(place[k]) + still[k] - at[k])) {
                assert!(!dark(&lights, &sample(1, own, 1)));
            }
        }
    }
    println!("{kind:?}: dark, lit, close {counts:?}");
    assert!(counts[0] > 3000 && counts[1] > 3000, "{counts:?}");
    assert!(counts[2] < 15_000, "{counts:?}");
}

fn narrow(place: [i32; 3]) -> Option<[i16; 3]> {
    let [x, y, z] = place.map(i16::try_from);
    Some([x.ok()?, y.ok()?, z.ok()?])
}

#[test]
fn a_point_lamp_sees_what_rays_meet() {
    agree(LampKind::Point, 1);
}

#[test]
fn a_directional_lamp_sees_what_rays_meet() {
    agree(LampKind::Directional, 2);
}

/// With the lamp on a corner, on an edge, on the triangle, in its plane, and a hair behind it.
#[test]
fn lamps_that_touch_triangles() {
    let triangle = [[-900, 0, -800], [1000, 0, -700], [100, 0, 1100]];
    let places = [
        triangle[0].map(i32::from),
        [50, 0, -750],
        [10, 0, 20],
        [9000, 0, 7],
        [10, 1, 20],
        [10, -1, 20],
    ];
    for (case, at) in places.into_iter().enumerate() {
        let mut room = Room::new(1, 1 << 16);
        let mut lights = room.lights();
        let point = lamp(LampKind::Point, at.map(|v| UNIT * v));
        assert!(lights.lamp(0, &point));
        assert!(with_shape((1, 0), &[triangle], |shape| lights.shape(shape)));
        lights.prepare(&slots(&[exact(0, [0; 3]), exact(1, [0; 3])]));
        // Far above and far below, and at the lamp itself.
        let [above, below] = [[30, 2000, 40], [30, -2000, 40]];
        let seen = [above, below].map(|place| dark(&lights, &sample(0, place, 0)));
        let expected = match case {
            4 => [false, true],
            5 => [true, false],
            _ => [false; 2],
        };
        assert_eq!(seen, expected, "lamp at {at:?}");
        let at = narrow(at).expect("a place of 16 bits");
        assert!(!dark(&lights, &sample(0, at, 0)), "lamp at {at:?}");
    }
}

/// A corner so far beside the lamp, a unit ahead of it, that 32 bits do not say where on the face it
/// would be.
#[test]
fn corners_far_beside_a_lamp() {
    let mut room = Room::new(1, 1 << 16);
    let mut lights = room.lights();
    assert!(lights.lamp(0, &lamp(LampKind::Point, [0; 3])));
    let triangle = [[-16383, 0, 0], [16383, -8192, 0], [0, 1000, 1000]];
    assert!(with_shape((1, 0), &[triangle], |shape| lights.shape(shape)));
    let coarse = Pose {
        matrix: exact(1, [0; 3]).matrix.map(|row| row.map(|v| 8 * v)),
        ..exact(1, [16, 0, 1])
    };
    lights.prepare(&slots(&[exact(0, [0; 3]), coarse]));
    for x in [-12_000, 0, 12_000] {
        assert!(dark(&lights, &sample(0, [x, 15_000, 30_000], 0)));
        assert!(!dark(&lights, &sample(0, [x, 31_000, 30_000], 0)));
    }
    assert!(!dark(&lights, &sample(0, [29_000, 25_000, 30_000], 0)));
}

/// Triangles without area, beside each other and in one place, throw no shadow.
#[test]
fn triangles_without_area() {
    let (a, b, c) = ([-1000, 500, 300], [1000, 500, 300], [0, 500, 300]);
    for kind in [LampKind::Point, LampKind::Directional] {
        let mut room = Room::new(8, 1 << 16);
        let mut lights = room.lights();
        let place = [0, UNIT * 3000, 0];
        assert!(lights.lamp(0, &lamp(kind, place)));
        let triangles = [[a, b, c], [a, a, b], [a, b, a], [c; 3], [[0; 3]; 3]];
        assert!(with_shape((1, 0), &triangles, |shape| lights.shape(shape)));
        lights.prepare(&slots(&[exact(0, [0; 3]), exact(1, [0; 3])]));
        for x in -50..50 {
            for z in -50..50 {
                let under = sample(0, [20 * x, -900, 20 * z], 0);
                assert!(!dark(&lights, &under), "{kind:?} {under:?}");
            }
        }
    }
}

/// A pose that turns and scales by at most a unit a step.
fn turned(object: u8) -> impl Strategy<Value = Pose> {
    let axis = prop::array::uniform3(-1.0..1.0f64);
    let at = prop::array::uniform3(-(1i32 << 22)..1 << 22);
    (axis, 0.0..6.3f64, 0.01..0.99f64, 8u8..=31, at).prop_map(
        move |(axis, angle, scale, bits, translation)| {
            let long = dot(axis, axis).sqrt().max(1e-9);
            let n = axis.map(|v| v / long);
            let (s, c) = angle.sin_cos();
            let bits = bits.min(21);
            let one = scale * f64::from(UNIT) * f64::from(1u32 << bits);
            // Rodrigues' formula.
            let entry = |i: usize, j: usize| {
                let unit = |k: usize| f64::from(u8::from(k == j));
                let e = [unit(0), unit(1), unit(2)];
                c * unit(i) + s * cross(n, e)[i] + (1.0 - c) * n[i] * n[j]
            };
            let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| (one * entry(i, j)) as i32));
            Pose {
                object,
                matrix,
                frac_bits: bits,
                translation,
            }
        },
    )
}

/// Any lamp that a stream can carry, and such as scenes have.
fn lamps() -> impl Strategy<Value = Lamp> {
    let any_kind = prop::bool::ANY.prop_map(|point| match point {
        true => LampKind::Point,
        false => LampKind::Directional,
    });
    let edge = prop_oneof![Just(1i32), Just(1 << 20), Just(1 << 23), Just(1 << 29)];
    let place = edge.prop_flat_map(|edge| prop::array::uniform3(-edge..=edge));
    (any_kind, place, prop::array::uniform2(1..=u16::MAX)).prop_map(|(kind, place, tint)| Lamp {
        kind,
        place: if place == [0; 3] { [0, 1, 0] } else { place },
        tint,
    })
}

/// Any pose that a display takes.
fn poses(object: u8) -> impl Strategy<Value = Pose> {
    let edge = |most: u32| (0..=most).prop_map(|bits| 1i32 << bits);
    let matrix = edge(30).prop_flat_map(|e| prop::array::uniform9(prop_oneof![-e..=e, Just(e)]));
    let at = edge(29).prop_flat_map(|e| prop::array::uniform3(prop_oneof![-e..=e, Just(-e)]));
    (matrix, 0..=31u8, at).prop_map(move |(m, frac_bits, translation)| Pose {
        object,
        matrix: [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]],
        frac_bits,
        translation,
    })
}

/// Corners within some bits, so that they meet often.
fn triangles() -> impl Strategy<Value = Vec<Triangle>> {
    let corner = (0u32..16).prop_flat_map(|bits| {
        prop::array::uniform3(any::<i16>()).prop_map(move |corner| corner.map(|v| v >> bits))
    });
    prop::collection::vec(prop::array::uniform3(corner), 1..40)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A step of a matrix is off by 2^−14 of a unit at most, and under a directional light once more
    /// for the way along it; so is the offset by what it was shifted along the light.
    #[test]
    fn places_are_where_lamps_see_them(
        pose in turned(1),
        lamp in lamps(),
        place in any::<[i16; 3]>(),
    ) {
        let seen = Toward::new(&lamp, &pose).place(place);
        let unit = f64::from(UNIT);
        let one = f64::from(1u32 << pose.frac_bits);
        let q = place.map(f64::from);
        let step = pose.matrix.map(|row| row.map(|v| f64::from(v) / one / unit));
        let t = pose.translation.map(|v| f64::from(v) / unit);
        let world: Point = [0, 1, 2].map(|k| t[k] + dot(step[k], q));
        let given = lamp.place.map(f64::from);
        let truth: [f64; 3];
        let mut most = q.iter().map(|v| v.abs()).sum::<f64>() / 16384.0 + 1.5;
        match lamp.kind {
            LampKind::Point => truth = [0, 1, 2].map(|k| world[k] - given[k] / unit),
            LampKind::Directional => {
                let axis = longest(given);
                let seen = as_seen(lamp.kind, given, &[world]);
                truth = seen[0];
                let along: f64 = (0..3).map(|i| step[axis][i].abs() * q[i].abs()).sum();
                most += (along + t[axis].abs()) / 16384.0;
            }
        }
        for k in 0..3 {
            let error = (f64::from(seen[k]) - truth[k]).abs();
            prop_assert!(error <= most, "{error} of {most}: {seen:?} for {truth:?}");
        }
    }

    /// Whatever a stream carries: nothing overflows or panics, whoever asks.
    #[test]
    fn anything_can_be_lit(
        lamps in prop::array::uniform2(lamps()),
        poses in (poses(0), poses(1), poses(2)),
        shapes in prop::array::uniform2(triangles()),
        texels in prop_oneof![Just(0usize), Just(1), Just(7), Just(600), Just(20_000)],
        samples in prop::collection::vec((any::<[i16; 3]>(), any::<[u8; 3]>(), any::<u8>(), 0..3u8), 60),
    ) {
        let mut room = Room::new(60, texels);
        let mut lights = room.lights();
        let slots = slots(&[poses.0, poses.1, poses.2]);
        for (object, triangles) in (1..).zip(&shapes) {
            with_shape((object, 0), triangles, |shape| lights.shape(shape));
            for (index, lamp) in lamps.iter().enumerate() {
                prop_assert!(lights.lamp(index, lamp));
            }
            prop_assert!(!lights.lamp(LAMPS, &lamps[0]));
            lights.prepare(&slots);
            for (place, rgb, shares, object) in &samples {
                let sample = Stored {
                    rgb: *rgb,
                    shares: Shares(*shares),
                    ..sample(*object, *place, 0)
                };
                let seen = lights.relight(&sample);
                prop_assert!(seen.iter().zip(rgb).all(|(a, b)| a <= b));
            }
        }
        let windows = lights.maps().windows();
        let used: usize = windows.iter().map(|w| w.size.map(usize::from).iter().product::<usize>()).sum();
        prop_assert_eq!(used, lights.maps().texels().len());
        prop_assert!(used <= texels);
    }

    /// What a lamp's absence leaves of a colour: as the formulas say, to a code.
    #[test]
    fn shares_dim_as_they_say(
        tints in prop::array::uniform2(prop::array::uniform2(1u16..2000)),
        rgb in any::<[u8; 3]>(),
        codes in prop::array::uniform2(0..16u8),
    ) {
        let mut room = Room::new(2, 1 << 14);
        let mut lights = room.lights();
        let above = [0, 3000 * UNIT, 0];
        for (index, kind) in [LampKind::Point, LampKind::Directional].into_iter().enumerate() {
            let lamp = Lamp { tint: tints[index], ..lamp(kind, above) };
            prop_assert!(lights.lamp(index, &lamp));
        }
        let roof = [[-9000, 1000, -9000], [9000, 1000, -9000], [0, 1000, 15_000]];
        with_shape((1, 0), &[roof], |shape| lights.shape(shape));
        let unlit = Stored { rgb, shares: Shares::new(codes), ..sample(0, [7, -1000, 9], 0) };
        prop_assert_eq!(lights.relight(&unlit), rgb);
        lights.prepare(&slots(&[exact(0, [0; 3]), exact(1, [0; 3])]));
        let seen = lights.relight(&unlit);
        for channel in 0..3 {
            let mut left = 1.0;
            for (lamp, code) in codes.into_iter().enumerate() {
                let [red, blue] = tints[lamp].map(f64::from);
                let tint = [red, 256.0, blue][channel] / 256.0;
                let rest = ((15.0 - f64::from(code)) / 15.0).powi(2);
                let part = tint * (1.0 - rest) / (rest + tint * (1.0 - rest));
                let told = lights.parts()[lamp][usize::from(code)][channel];
                let error = part * f64::from(WHOLE) - f64::from(told);
                prop_assert!((-1e-6..1.0).contains(&error), "{part} told as {told}");
                left -= part;
            }
            let value = f64::from(rgb[channel]) / 255.0;
            let light = if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            };
            let dim = light * left.max(0.0);
            let code = if dim <= 0.003_130_8 {
                12.92 * dim
            } else {
                1.055 * dim.powf(1.0 / 2.4) - 0.055
            };
            let error = (255.0 * code - f64::from(seen[channel])).abs();
            prop_assert!(error <= 1.0, "{rgb:?} {codes:?} {left}: {seen:?} is off by {error}");
        }
    }
}

/// Parts come in any order and again and again; what has no room is refused and nothing is lost for
/// it.
#[test]
fn shapes_are_kept() {
    let part = |first: i16, len: i16| -> Vec<Triangle> {
        (first..first + len)
            .map(|v| [[v, 0, 0], [0, v, 0], [0, 0, v]])
            .collect()
    };
    let mut storage = vec![Facet::EMPTY; 40];
    let mut facets = Facets::new(&mut storage);
    assert!(facets.is_empty());
    let take = |facets: &mut Facets<'_>, object: u8, at: u8, part: &[Triangle]| {
        with_shape((object, at), part, |shape| {
            facets.take(shape.object(), shape.part(), shape.len(), shape.clone())
        })
    };
    assert_eq!(take(&mut facets, 9, 1, &part(1, 10)), Taken::New);
    assert_eq!(take(&mut facets, 4, 31, &part(11, 10)), Taken::New);
    assert_eq!(take(&mut facets, 9, 1, &part(90, 10)), Taken::Known);
    assert_eq!(take(&mut facets, 9, 0, &part(21, 10)), Taken::New);
    // A part too far, and one too large.
    assert_eq!(
        take(&mut facets, 9, PARTS as u8, &part(1, 1)),
        Taken::NoRoom
    );
    assert_eq!(take(&mut facets, 9, 255, &part(1, 1)), Taken::NoRoom);
    assert_eq!(take(&mut facets, 5, 0, &part(31, 11)), Taken::NoRoom);
    assert!(!facets.knows(slot(5)));
    assert_eq!(take(&mut facets, 5, 0, &part(31, 10)), Taken::New);
    assert_eq!(take(&mut facets, 5, 1, &part(1, 1)), Taken::NoRoom);
    assert_eq!(take(&mut facets, 5, 0, &part(1, 10)), Taken::Known);
    assert!([9, 4, 5].iter().all(|object| facets.knows(slot(*object))));
    assert!(!facets.knows(slot(6)));
    let found = facets.all().iter().map(|f| (f.corners[0][0], f.slot));
    let of = |v: i16| [9, 4, 9, 5][(v as usize - 1) / 10];
    assert!(found.eq((1..41).map(|v| (v, slot(of(v))))));

    facets.clear();
    assert!(facets.is_empty() && !facets.knows(slot(9)));
    for object in 1..=CASTERS as u8 {
        assert_eq!(take(&mut facets, object, 0, &part(1, 1)), Taken::New);
    }
    let more = CASTERS as u8 + 1;
    assert_eq!(take(&mut facets, more, 0, &part(1, 1)), Taken::NoRoom);
    assert_eq!(take(&mut facets, 1, 1, &part(1, 1)), Taken::New);
    assert_eq!(facets.all().len(), CASTERS + 1);
    let casters = facets.all().iter().map(|facet| usize::from(facet.caster));
    assert!(casters.eq((0..CASTERS).chain([0])));
}

/// An object's own shadow is left out, that of another in the same place is not.
#[test]
fn own_samples_are_not_shadowed() {
    let mut room = Room::new(2, 1 << 14);
    let mut lights = room.lights();
    let above = [0, 3000 * UNIT, 0];
    assert!(lights.lamp(0, &lamp(LampKind::Point, above)));
    assert!(lights.lamp(1, &lamp(LampKind::Directional, above)));
    let roof = [[-9000, 1000, -9000], [9000, 1000, -9000], [0, 1000, 15_000]];
    assert!(with_shape((1, 0), &[roof], |shape| lights.shape(shape)));
    let still = slots(&[0, 1, 2].map(|object| exact(object, [0; 3])));
    lights.prepare(&still);
    for index in 0..LAMPS {
        let at = [70, -1000, 90];
        let shadows = [0, 1, 2].map(|object| dark(&lights, &sample(object, at, index)));
        assert_eq!(shadows, [true, false, true]);
    }
    // A second object before both.
    let roof = roof.map(|[x, y, z]| [x, y + 500, z]);
    assert!(with_shape((2, 0), &[roof], |shape| lights.shape(shape)));
    lights.prepare(&still);
    for index in 0..LAMPS {
        let at = [70, -1000, 90];
        let shadows = [0, 1, 2].map(|object| dark(&lights, &sample(object, at, index)));
        assert_eq!(shadows, [true; 3]);
    }
    // The upper one is not in the lower one's shadow.
    assert!(!dark(&lights, &sample(2, [70, 1500, 90], 0)));
    assert!(dark(&lights, &sample(1, [70, 1000, 90], 0)));
}

/// What moves takes its shadow along, and what does not is not drawn again.
#[test]
fn shadows_move() {
    let mut room = Room::new(2, 1 << 14);
    let mut lights = room.lights();
    let down = lamp(LampKind::Directional, [0, 1 << 30, 0]);
    let roof = [[-900, 0, -900], [900, 0, -900], [0, 0, 1500]];
    assert!(with_shape((1, 0), &[roof], |shape| lights.shape(shape)));
    assert!(lights.lamp(0, &down));
    let places = [[0, -2000, 0], [5000, -2000, 0], [-8000, -2000, 0]];
    for x in [0, 5000, -8000] {
        for again in 0..2 {
            let drawings = lights.maps().drawings();
            lights.prepare(&slots(&[exact(0, [0; 3]), exact(1, [x, 10, 0])]));
            assert_eq!(lights.maps().drawings() - drawings, 1 - again);
        }
        for place in places {
            let here = i32::from(place[0]) == x;
            assert_eq!(dark(&lights, &sample(0, place, 0)), here);
        }
    }
    assert!(lights.lamp(0, &down));
    let drawings = lights.maps().drawings();
    // Another object's moving draws nothing; another lamp does.
    let moved = slots(&[exact(0, [0; 3]), exact(1, [-8000, 10, 0]), exact(3, [5; 3])]);
    lights.prepare(&moved);
    assert_eq!(lights.maps().drawings(), drawings);
    assert!(lights.lamp(0, &lamp(LampKind::Directional, [0, -(1 << 30), 0])));
    lights.prepare(&moved);
    assert_eq!(lights.maps().drawings(), drawings + 1);
    assert!(!dark(&lights, &sample(0, places[2], 0)));
    assert!(dark(&lights, &sample(0, [-8000, 2000, 0], 0)));
    lights.clear();
    assert!(!dark(&lights, &sample(0, [-8000, 2000, 0], 0)));
    assert!(!lights.shines());
}

/// As many objects as can throw shadows, all around two lamps: more windows than there are. Each
/// shadow that there is room for is there.
#[test]
fn more_windows_than_there_are() {
    let mut room = Room::new(CASTERS, 1 << 16);
    let mut lights = room.lights();
    for index in 0..LAMPS {
        assert!(lights.lamp(index, &lamp(LampKind::Point, [index as i32, 0, 0])));
    }
    let around = [[-900, -300, -800], [1000, 400, -700], [100, 30, 1100]];
    for object in 1..=CASTERS as u8 {
        assert!(with_shape((object, 0), &[around], |shape| lights.shape(shape)));
    }
    let still = (0..=CASTERS as u8).map(|object| exact(object, [0, i32::from(object), 0]));
    lights.prepare(&slots(&still.collect::<Vec<_>>()));
    assert_eq!(lights.maps().windows().len(), WINDOWS);
    let shadows = [[0, 9000, 0], [0, -9000, 0], [9000, 0, 0], [0, 0, 9000]];
    let shadows = shadows.map(|place| dark(&lights, &sample(0, place, 0)));
    assert_eq!(shadows, [true, false, false, false]);
}

/// Beyond the face of a directional lamp, and at a point lamp, nothing is seen.
#[test]
fn some_places_are_not_seen() {
    assert_eq!(Aim::of(LampKind::Point, [0; 3]), None);
    let far = [0, 1 << 17, 0];
    assert_eq!(Aim::of(LampKind::Directional, far), None);
    assert_eq!(Aim::of(LampKind::Directional, far.map(|v| -v)), None);
    for place in [
        [1, 0, 0],
        [0, -1, 0],
        [0, 0, 1],
        [-(1 << 23); 3],
        [(1 << 23) + (1 << 17); 3],
    ] {
        let aim = Aim::of(LampKind::Point, place).expect("it is seen");
        assert!(aim.at.iter().all(|v| v.abs() <= 1 << 14), "{aim:?}");
    }
}
