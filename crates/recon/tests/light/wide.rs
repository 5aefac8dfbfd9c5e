//! Places, shares and shapes, and what no host sends.

use crate::rays::{as_seen, cross, dot, longest};
use crate::room::*;
use proptest::prelude::*;
use unframed_recon::deep::{Stored, slot};
use unframed_recon::light::WHOLE;
use unframed_recon::light::facets::{CASTERS, Facet, Facets, PARTS, Taken};
use unframed_recon::light::map::WINDOWS;
use unframed_recon::light::toward::{Aim, Toward};
use unframed_wire::{LAMPS, Lamp, LampKind, Pose, Shares};

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
