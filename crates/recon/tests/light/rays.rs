//! Shadow maps against rays in `f64`.

use crate::room::*;
use unframed_wire::{LampKind, Pose};

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

pub(crate) fn cross(a: Point, b: Point) -> Point {
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
pub(crate) fn as_seen(kind: LampKind, lamp: Point, all: &[Point]) -> Vec<Point> {
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

pub(crate) fn longest(v: Point) -> usize {
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
