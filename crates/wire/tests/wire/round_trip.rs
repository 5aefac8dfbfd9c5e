//! What goes in comes out, for every kind of packet and any legal meaning.

use crate::common::*;
use proptest::collection::vec;
use proptest::prelude::*;
use unframed_wire::*;

fn tick() -> impl Strategy<Value = Tick> {
    any::<u32>().prop_map(Tick)
}

fn i32x3() -> impl Strategy<Value = [i32; 3]> {
    any::<[i32; 3]>()
}

prop_compose! {
    fn hellos()(width in 1u16..=4096, height in 1u16..=4096, world in any::<bool>(), objects in any::<bool>(),
        bits in 0u8..8, lamps in 0u8..=2, rate in 1u32.., refresh_millihertz in 1u32..,
        origin in any::<[f32; 3]>(), unit in any::<f32>()) -> Hello {
        let finite = |v: f32| if v.is_finite() { v } else { 1.0 };
        Hello {
            width, height,
            layout: if world { Layout::World } else { Layout::Screen },
            objects: objects && world,
            tile_fields: TileFields { gradients: bits & 1 != 0, lifetime: bits & 2 != 0, density: bits & 4 != 0 },
            encoding: ColourEncoding::Srgb8,
            rate, refresh_millihertz,
            world: WorldFrame { origin: origin.map(finite), unit: finite(unit).abs().max(1e-30) },
            lamps: if world { lamps } else { 0 },
        }
    }
}

prop_compose! {
    fn views()(time in tick(), eye in i32x3(), rows in any::<[[i32; 3]; 3]>(), frac_bits in 0u8..=30) -> View {
        View { time, eye, rows, frac_bits }
    }
}

fn lamp() -> impl Strategy<Value = Lamp> {
    let place = |edge: i32| prop_oneof![-edge..=edge, Just(edge), Just(-edge), -2..=2];
    let point = [
        place(Lamp::MAX_PLACE),
        place(Lamp::MAX_PLACE),
        place(Lamp::MAX_PLACE),
    ]
    .prop_map(|place| (LampKind::Point, place));
    let far = [place(Lamp::UNIT), place(Lamp::UNIT), place(Lamp::UNIT)].prop_map(|place| {
        let place = if place == [0; 3] { [0, 0, 1] } else { place };
        (LampKind::Directional, place)
    });
    (prop_oneof![point, far], [1u16.., 1u16..]).prop_map(|((kind, place), tint)| Lamp {
        kind,
        place,
        tint,
    })
}

/// Object, part, parts, vertices and triangles that fit into a packet.
type Part = (u8, u8, u16, Vec<[i16; 3]>, Vec<[u8; 3]>);

fn part() -> impl Strategy<Value = Part> {
    let counts = (1usize..=256, 1usize..=256)
        .prop_map(|(v, t)| if Shape::fits(v, t) { (v, t) } else { (v, 1) });
    let surface = counts.prop_flat_map(|(v, t)| {
        let corner = 0..=(v - 1) as u8;
        (
            vec(any::<[i16; 3]>(), v),
            vec([corner.clone(), corner.clone(), corner], t),
        )
    });
    (1u8..SKY, any::<u8>(), 1u16..=256, surface).prop_map(|(object, part, parts, (v, t))| {
        (object, (u16::from(part) % parts) as u8, parts, v, t)
    })
}

prop_compose! {
    fn poses()(object in any::<u8>(), matrix in any::<[[i32; 3]; 3]>(), frac_bits in 0u8..=31, translation in i32x3()) -> Pose {
        Pose { object, matrix, frac_bits, translation }
    }
}

/// Places near a few centres and anywhere, so that short and long codes both occur.
fn world_sample() -> impl Strategy<Value = WorldSample> {
    let coordinate = prop_oneof![any::<i16>(), -3i16..3, Just(i16::MIN), Just(i16::MAX)];
    let place = [coordinate.clone(), coordinate.clone(), coordinate];
    let channel = prop_oneof![any::<u8>(), 100u8..104];
    let rgb = [channel.clone(), channel.clone(), channel];
    let object = prop_oneof![Just(0u8), Just(SKY), any::<u8>()];
    let shares = prop_oneof![any::<u8>(), Just(0x87), Just(0xf0)];
    (place, rgb, object, shares).prop_map(|(place, rgb, object, shares)| WorldSample {
        place,
        rgb,
        object,
        shares: Shares(shares),
    })
}

fn sorted_world(mut v: Vec<WorldSample>) -> Vec<WorldSample> {
    v.sort_by_key(|s| (s.object, s.place, s.rgb, s.shares.0));
    v
}

fn sorted_screen(mut v: Vec<ScreenSample>) -> Vec<ScreenSample> {
    v.sort_by_key(|s| (s.x, s.y, s.rgb));
    v
}

/// A random tree of `region` in preorder.
fn tree(region: Rect, choices: &mut impl Iterator<Item = u32>, out: &mut Vec<TileNode>) {
    let choice = choices.next().unwrap_or(0);
    let axis = if choice & 1 == 0 { Axis::X } else { Axis::Y };
    if choice & 6 != 0
        && let Some((a, b)) = tiles::split(region, axis)
    {
        out.push(TileNode::Split(axis));
        tree(a, choices, out);
        tree(b, choices, out);
        return;
    }
    let code = |shift: u32| LogCode((choice >> shift) as u8);
    let [gx, gy, gt, lifetime, density] = [3, 8, 12, 18, 24].map(code);
    out.push(TileNode::Leaf(Tile {
        rect: region,
        gx,
        gy,
        gt,
        lifetime,
        density,
    }));
}

fn leaves(nodes: &[TileNode], fields: TileFields) -> Vec<Tile> {
    let keep = |present: bool, code: LogCode| if present { code } else { LogCode(128) };
    let leaf = |node: &TileNode| match node {
        TileNode::Split(_) => None,
        TileNode::Leaf(t) => Some(Tile {
            rect: t.rect,
            gx: keep(fields.gradients, t.gx),
            gy: keep(fields.gradients, t.gy),
            gt: keep(fields.gradients, t.gt),
            lifetime: keep(fields.lifetime, t.lifetime),
            density: keep(fields.density, t.density),
        }),
    };
    nodes.iter().filter_map(leaf).collect()
}

proptest! {
    #[test]
    fn fixed_packets(hello in hellos(), view in views(), time in tick(), poses in vec(poses(), 1..90),
        numbers in any::<[u32; 6]>(), step in 1usize..5000) {
        let refresh = Refresh { time, index: numbers[0] };
        let status = Status { refresh_time: time, received: numbers[1], lost: numbers[2], damaged: numbers[3], buffered: numbers[4] };
        let bytes = written(|w, mut sink| {
            w.hello(&hello, &mut sink).unwrap();
            w.view(&view, &mut sink).unwrap();
            w.poses(time, &poses, &mut sink).unwrap();
            w.refresh(refresh, &mut sink).unwrap();
            w.status(&status, &mut sink).unwrap();
            w.cut(time, &mut sink).unwrap();
            w.end(time, &mut sink).unwrap();
        });
        let mut expected = vec![Owned::Hello(hello), Owned::View(view)];
        expected.extend(poses.chunks(MAX_POSES).map(|part| Owned::Poses(time, part.to_vec())));
        expected.extend([Owned::Refresh(refresh), Owned::Status(status), Owned::Cut(time)]);
        let packets = expected.len() as u64;
        expected.push(Owned::End(End { time, samples: 0, packets }));
        let (got, counters) = receive(&bytes, step);
        prop_assert_eq!(got, expected);
        prop_assert_eq!(counters, Counters { bytes: bytes.len() as u64, received: packets + 1, ..Counters::default() });
    }

    #[test]
    fn world_samples(time in tick(), lamps in 0u8..=2, mut samples in vec(world_sample(), 1..700)) {
        let told = (1u16 << (4 * lamps)) - 1;
        samples.iter_mut().for_each(|s| s.shares.0 &= told as u8);
        let bytes = written(|w, mut sink| {
            w.hello(&lit(lamps), &mut sink).unwrap();
            w.world_samples(time, &samples, &mut sink).unwrap();
            assert_eq!(w.ledger().samples, samples.len() as u64);
            assert_eq!(w.ledger().sample_bits.shares > 0, lamps > 0);
        });
        let mut got = Vec::new();
        for packet in receive(&bytes, bytes.len()).0.into_iter().skip(1) {
            let Owned::World(t, part) = packet else { panic!("{packet:?}") };
            prop_assert_eq!(t, time);
            prop_assert!(part.len() <= MAX_SAMPLES);
            got.extend(part);
        }
        prop_assert_eq!(sorted_world(got), sorted_world(samples));
    }

    #[test]
    fn lamps_and_shapes(time in tick(), lamps in vec(lamp(), 1..=LAMPS), parts in vec(part(), 1..5)) {
        let bytes = written(|w, mut sink| {
            w.hello(&lit(lamps.len() as u8), &mut sink).unwrap();
            w.lamps(time, &lamps, &mut sink).unwrap();
            for (object, part, parts, vertices, triangles) in &parts {
                w.shape(*object, *part, *parts, vertices, triangles, &mut sink).unwrap();
            }
        });
        let mut expected = vec![Owned::Hello(lit(lamps.len() as u8)), Owned::Lamps(time, lamps)];
        expected.extend(parts.into_iter().map(|(object, part, parts, vertices, triangles)| {
            let corners = |t: [u8; 3]| t.map(|at| vertices[usize::from(at)]);
            Owned::Shape(object, part, parts, triangles.into_iter().map(corners).collect())
        }));
        prop_assert_eq!(receive(&bytes, 100).0, expected);
    }

    #[test]
    fn shares_are_two_codes(first in 0u8..=15, second in 0u8..=15, high in any::<u8>(), beyond in 2usize..) {
        let shares = Shares::new([first, second]);
        prop_assert_eq!([shares.code(0), shares.code(1), shares.code(beyond)], [first, second, 0]);
        prop_assert_eq!(shares, Shares::new([first | high << 4, second | high << 4]));
    }

    #[test]
    fn screen_samples(time in tick(), samples in vec((0u16..4096, 0u16..4096, any::<[u8; 3]>()), 1..700)) {
        let samples: Vec<_> = samples.into_iter().map(|(x, y, rgb)| ScreenSample { x, y, rgb }).collect();
        let bytes = written(|w, mut sink| {
            w.hello(&hello(Layout::Screen, false), &mut sink).unwrap();
            w.screen_samples(time, &samples, &mut sink).unwrap();
        });
        let mut got = Vec::new();
        for packet in receive(&bytes, bytes.len()).0.into_iter().skip(1) {
            let Owned::Screen(t, part) = packet else { panic!("{packet:?}") };
            prop_assert_eq!(t, time);
            got.extend(part);
        }
        prop_assert_eq!(sorted_screen(got), sorted_screen(samples));
    }

    #[test]
    fn tiles_cover_the_region_in_preorder(time in tick(), choices in vec(any::<u32>(), 0..3000), bits in 0u8..8,
        x in 0u16..100, y in 0u16..100, w in 1u16..=156, h in 1u16..=156) {
        let region = Rect { x, y, w, h };
        let mut nodes = Vec::new();
        tree(region, &mut choices.into_iter(), &mut nodes);
        let mut hello = hello(Layout::World, true);
        hello.tile_fields = TileFields { gradients: bits & 1 != 0, lifetime: bits & 2 != 0, density: bits & 4 != 0 };
        let bytes = written(|w, mut sink| {
            w.hello(&hello, &mut sink).unwrap();
            w.tiles(time, region, &nodes, &mut sink).unwrap();
        });
        let mut got = Vec::new();
        for packet in receive(&bytes, bytes.len()).0.into_iter().skip(1) {
            let Owned::Tiles(t, part, tiles) = packet else { panic!("{packet:?}") };
            prop_assert_eq!(t, time);
            let area: u64 = tiles.iter().map(|t| u64::from(t.rect.w) * u64::from(t.rect.h)).sum();
            prop_assert_eq!(area, u64::from(part.w) * u64::from(part.h));
            got.extend(tiles);
        }
        prop_assert_eq!(got, leaves(&nodes, hello.tile_fields));
    }

    #[test]
    fn index_entries(entries in vec((0u8..3, tick(), any::<u64>()), 0..400), offset in any::<u64>()) {
        let kinds = [IndexKind::Hello, IndexKind::Refresh, IndexKind::Cut];
        let entries: Vec<_> = entries.into_iter()
            .map(|(k, time, offset)| IndexEntry { kind: kinds[usize::from(k)], time, offset }).collect();
        let bytes = written(|w, mut sink| w.index(offset, &entries, &mut sink).unwrap());
        let (packets, _) = receive(&bytes, 7);
        let mut got = Vec::new();
        for packet in &packets {
            if let Owned::Index(part) = packet { got.extend(part.iter().copied()); }
        }
        prop_assert_eq!(&got, &entries);
        let trailer = Trailer { offset, entries: entries.len() as u32 };
        prop_assert_eq!(packets.last(), Some(&Owned::Trailer(trailer)));
    }
}

#[test]
fn out_of_range_meanings_are_refused() {
    let mut w = Writer::new();
    let mut sent = 0;
    let mut sink = |_: &[u8]| sent += 1;
    let good = hello(Layout::World, false);
    let world = WorldSample::default();
    assert_eq!(
        w.world_samples(Tick(0), &[world], &mut sink),
        Err(EncodeError::Layout)
    );
    for bad in [
        Hello { width: 0, ..good },
        Hello {
            height: 4097,
            ..good
        },
        Hello { rate: 0, ..good },
        Hello {
            refresh_millihertz: 0,
            ..good
        },
        Hello { lamps: 3, ..good },
        Hello {
            lamps: 1,
            layout: Layout::Screen,
            ..good
        },
        Hello {
            world: WorldFrame {
                unit: 0.0,
                ..good.world
            },
            ..good
        },
        Hello {
            world: WorldFrame {
                origin: [0.0, f32::NAN, 0.0],
                ..good.world
            },
            ..good
        },
    ] {
        assert_eq!(
            w.hello(&bad, &mut sink),
            Err(EncodeError::Range(Kind::Hello))
        );
    }
    w.hello(&good, &mut sink).unwrap();
    let moving = WorldSample { object: 3, ..world };
    assert_eq!(
        w.world_samples(Tick(0), &[moving], &mut sink),
        Err(EncodeError::Objects)
    );
    assert_eq!(
        w.screen_samples(Tick(0), &[ScreenSample::default()], &mut sink),
        Err(EncodeError::Layout)
    );
    let leaf = |w| {
        TileNode::Leaf(Tile {
            rect: Rect {
                x: 0,
                y: 0,
                w,
                h: 2,
            },
            ..Tile::default()
        })
    };
    let region = Rect {
        x: 0,
        y: 0,
        w: 1,
        h: 2,
    };
    let split = TileNode::Split(Axis::X);
    let mut tiles = |region, nodes: &[TileNode]| w.tiles(Tick(0), region, nodes, &mut sink);
    assert_eq!(
        tiles(region, &[split, leaf(1), leaf(1)]),
        Err(EncodeError::Tree)
    );
    assert_eq!(tiles(region, &[leaf(1), leaf(1)]), Err(EncodeError::Tree));
    assert_eq!(tiles(region, &[]), Err(EncodeError::Tree));
    assert_eq!(tiles(region, &[leaf(2)]), Err(EncodeError::LeafRect));
    assert_eq!(
        tiles(Rect { x: 256, ..region }, &[leaf(1)]),
        Err(EncodeError::Range(Kind::Tiles))
    );
    assert_eq!(sent, 1);
}

#[test]
fn lamps_and_shares_that_the_hello_does_not_name_are_refused() {
    let mut w = Writer::new();
    let mut sent = 0;
    let mut sink = |_: &[u8]| sent += 1;
    let range = Err(EncodeError::Range(Kind::Lamps));
    assert_eq!(
        w.lamps(Tick(0), &[LAMP], &mut sink),
        Err(EncodeError::Layout)
    );
    w.hello(&lit(0), &mut sink).unwrap();
    assert_eq!(w.lamps(Tick(0), &[], &mut sink), range);
    assert_eq!(w.lamps(Tick(0), &[LAMP], &mut sink), range);
    let sample = |w: &mut Writer, codes| {
        let sample = WorldSample {
            shares: Shares::new(codes),
            ..WorldSample::default()
        };
        w.world_samples(Tick(0), &[sample], &mut |_: &[u8]| {})
    };
    assert_eq!(sample(&mut w, [1, 0]), Err(EncodeError::Shares));
    assert_eq!(sample(&mut w, [0, 0]), Ok(()));
    w.hello(&lit(1), &mut sink).unwrap();
    assert_eq!(sample(&mut w, [0, 1]), Err(EncodeError::Shares));
    assert_eq!(sample(&mut w, [15, 0]), Ok(()));
    assert_eq!(w.lamps(Tick(0), &[], &mut sink), range);
    assert_eq!(w.lamps(Tick(0), &[LAMP; 2], &mut sink), range);
    for bad in [
        Lamp {
            place: [0, 0, Lamp::MAX_PLACE + 1],
            ..LAMP
        },
        Lamp {
            kind: LampKind::Directional,
            place: [0; 3],
            ..LAMP
        },
        Lamp {
            kind: LampKind::Directional,
            place: [0, -Lamp::UNIT - 1, 0],
            ..LAMP
        },
        Lamp {
            tint: [256, 0],
            ..LAMP
        },
    ] {
        assert_eq!(w.lamps(Tick(0), &[bad], &mut sink), range, "{bad:?}");
    }
    w.hello(&lit(2), &mut sink).unwrap();
    assert_eq!(sample(&mut w, [15, 15]), Ok(()));
    assert_eq!(sent, 3);
}

#[test]
fn shapes_out_of_range_are_refused() {
    let mut w = Writer::new();
    let mut sent = 0;
    let mut sink = |frame: &[u8]| sent = sent.max(frame.len());
    let (v, t) = ([[0i16; 3]; 257], [[0u8; 3]; 257]);
    let range = Err(EncodeError::Range(Kind::Shape));
    let mut shape =
        |object, part, parts, v: &[_], t: &[_]| w.shape(object, part, parts, v, t, &mut sink);
    for (object, part, parts) in [(0, 0, 1), (SKY, 0, 1), (1, 0, 0), (1, 1, 1), (1, 0, 257)] {
        assert_eq!(shape(object, part, parts, &v[..3], &t[..1]), range);
    }
    assert_eq!(shape(1, 0, 1, &[], &[]), range);
    assert_eq!(shape(1, 0, 1, &v[..3], &[]), range);
    assert_eq!(shape(1, 0, 1, &v[..3], &t), range);
    assert_eq!(shape(1, 0, 1, &v, &t[..1]), range);
    assert_eq!(shape(1, 0, 1, &v[..3], &[[0, 1, 3]]), range);
    // 5 + 256·6 + 166·3 are 2039 bytes.
    assert!(Shape::fits(256, 166) && !Shape::fits(256, 167));
    assert!(!Shape::fits(0, 1) && !Shape::fits(1, 0) && !Shape::fits(257, 1));
    assert_eq!(
        shape(1, 0, 1, &v[..256], &t[..167]),
        Err(EncodeError::TooLong)
    );
    assert_eq!(shape(1, 0, 1, &v[..256], &t[..166]), Ok(()));
    // 5 + 211·6 + 256·3 are 2039 too, with hardly a zero: the longest frame of all.
    let (v, t) = ([[-1i16; 3]; 211], [[210u8; 3]; 256]);
    assert_eq!(shape(254, 255, 256, &v, &t), Ok(()));
    assert!((2039..=MAX_FRAME).contains(&sent));
}
