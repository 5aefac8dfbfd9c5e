//! Bad links: nothing panics, damage is counted, the next good packet is found.

use crate::common::*;
use crate::room::{Rng, samples};
use proptest::collection::vec;
use proptest::prelude::*;
use std::sync::OnceLock;
use unframed_wire::fault::{Faults, LinkFault};
use unframed_wire::*;

/// The frames of a short stream with every kind of packet, over the wrap of the clock.
pub(crate) fn frames() -> Vec<Vec<u8>> {
    static FRAMES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FRAMES.get_or_init(make_frames).clone()
}

fn make_frames() -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    let mut sink = |frame: &[u8]| out.push(frame.to_vec());
    let mut w = Writer::new();
    let mut rng = Rng(3);
    let tile = |x, w| {
        TileNode::Leaf(Tile {
            rect: Rect { x, y: 0, w, h: 256 },
            ..Tile::default()
        })
    };
    for i in 0..20u32 {
        let time = Tick(u32::MAX - 100_000).after(i * 16_667);
        w.hello(&lit(1), &mut sink).unwrap();
        let view = View {
            time,
            eye: [1, 2, 3],
            rows: [[4; 3]; 3],
            frac_bits: 16,
        };
        w.view(&view, &mut sink).unwrap();
        let pose = Pose {
            object: 1,
            matrix: [[9; 3]; 3],
            frac_bits: 8,
            translation: [7; 3],
        };
        w.poses(time, &[pose; 3], &mut sink).unwrap();
        w.lamps(time, &[LAMP], &mut sink).unwrap();
        let corners = [[1, 2, 3], [-1, 0, 500], [40, i16::MIN, 7]];
        w.shape(1, 2, 3, &corners, &[[0, 1, 2], [2, 1, 0]], &mut sink)
            .unwrap();
        let nodes = [TileNode::Split(Axis::X), tile(0, 128), tile(128, 128)];
        w.tiles(
            time,
            Rect {
                x: 0,
                y: 0,
                w: 256,
                h: 256,
            },
            &nodes,
            &mut sink,
        )
        .unwrap();
        for _ in 0..4 {
            let (mut world, _) = samples(&mut rng, 40, 0.0, 0.0, true);
            world.iter_mut().for_each(|s| s.shares = smooth(s.place, 1));
            w.world_samples(time, &world, &mut sink).unwrap();
        }
        w.refresh(Refresh { time, index: i }, &mut sink).unwrap();
    }
    w.end(Tick(u32::MAX - 100_000).after(20 * 16_667), &mut sink)
        .unwrap();
    out
}

/// Decodes everything, iterators included; all values must be in range.
fn drain(bytes: &[u8]) -> (usize, Counters) {
    let mut receiver = Receiver::new();
    let mut input = bytes;
    let mut items = 0;
    let mut announced_lamps = 0;
    while let Some(packet) = receiver.push(&mut input) {
        match packet {
            Packet::Hello(hello) => {
                announced_lamps = hello.lamps;
                items += 1;
            }
            Packet::World(s) => {
                let announced = s.len();
                let beyond = |s: &WorldSample| u32::from(s.shares.0) >> (4 * announced_lamps);
                let n = s.inspect(|s| assert_eq!(beyond(s), 0)).count();
                assert!(n <= announced && announced <= MAX_SAMPLES);
                items += n;
            }
            Packet::Screen(s) => {
                items += s.inspect(|s| assert!(s.x < 4096 && s.y < 4096)).count();
            }
            Packet::Tiles(tiles) => {
                let r = tiles.region();
                for Tile { rect: t, .. } in tiles {
                    assert!(t.w > 0 && t.x >= r.x && t.x + t.w <= r.x + r.w);
                    assert!(t.h > 0 && t.y >= r.y && t.y + t.h <= r.y + r.h);
                    items += 1;
                }
            }
            Packet::Lamps(lamps) => {
                assert_eq!(lamps.len(), usize::from(announced_lamps));
                let valid = lamps.inspect(|lamp| assert!(lamp.is_valid()));
                items += valid.count();
            }
            Packet::Shape(shape) => {
                assert!((1..SKY).contains(&shape.object()));
                assert!(u16::from(shape.part()) < shape.parts());
                let announced = shape.len();
                assert_eq!(shape.count(), announced);
                items += announced;
            }
            _ => items += 1,
        }
    }
    (items, *receiver.counters())
}

/// A frame around any payload, with good CRC: contents chosen by an enemy.
fn forged(kind: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut packet = vec![kind];
    packet.extend(sequence.to_le_bytes());
    packet.extend(payload);
    packet.extend(frame::checksum(&packet).to_le_bytes());
    let mut out = vec![0xA5; cobs::max_encoding_length(packet.len()) + 1];
    let n = cobs::encode(&packet, &mut out);
    out.truncate(n);
    out.push(0);
    out
}

proptest! {
    #[test]
    fn any_bytes_are_legal(bytes in vec(prop_oneof![3 => any::<u8>(), 1 => Just(0u8)], 0..8000)) {
        let (_, counters) = drain(&bytes);
        prop_assert_eq!(counters.bytes, bytes.len() as u64);
    }

    #[test]
    fn forged_contents_stay_in_range(kind in 0u8..16, screen in any::<bool>(), lamps in 0u8..=2, payload in vec(any::<u8>(), 0..2000), head in any::<[u8; 4]>()) {
        let layout = if screen { Layout::Screen } else { Layout::World };
        let lamps = if screen { 0 } else { lamps };
        let greeting = Hello { lamps, ..hello(layout, !screen) };
        let mut bytes = written(|w, mut sink| w.hello(&greeting, &mut sink).unwrap());
        bytes.extend(forged(kind, 1, &payload));
        // A region that is legal, so that the tree is reached.
        let mut tiles = vec![head[0], 0, 0, 0, 0, 0, 0, 0, head[1].max(1), 0, head[2].max(1), 0, head[3] & 7];
        tiles.extend(&payload[..payload.len().min(1900)]);
        bytes.extend(forged(4, 2, &tiles));
        // One run, so that the samples are reached.
        let mut world = vec![1, 2, 3, 4, 0, 0, head[0]];
        world.extend(&payload[..payload.len().min(1900)]);
        bytes.extend(forged(5, 3, &world));
        // Lamps of the right length, and places that are small enough now and then.
        let mut bright = vec![0; 4];
        for lamp in payload.chunks_exact(17).take(usize::from(lamps)) {
            bright.extend([lamp[0] & 1]);
            lamp[1..13].chunks_exact(4).for_each(|c| bright.extend([c[0], c[1], c[2], head[0]]));
            bright.extend(&lamp[13..]);
        }
        bytes.extend(forged(13, 4, &bright));
        // A shape of the right length, whose indices are small.
        let (vertices, triangles) = (usize::from(head[1] & 127) + 1, usize::from(head[2] & 127) + 1);
        let mut shape = vec![head[0], head[3] >> 1, head[3], vertices as u8 - 1, triangles as u8 - 1];
        shape.extend(payload.iter().cycle().take(6 * vertices));
        shape.extend(payload.iter().map(|b| b & head[1] & 127).cycle().take(3 * triangles));
        bytes.extend(forged(14, 5, &shape));
        let (items, counters) = drain(&bytes);
        prop_assert!(items >= 1);
        prop_assert_eq!(counters.lost, 0);
        let sum = counters.received + counters.damaged + counters.unknown;
        prop_assert_eq!(sum, 6);
    }

    #[test]
    fn one_bad_frame_is_counted_and_the_next_is_found(which in 0usize..100, at in any::<prop::sample::Index>(), bit in 0u8..8) {
        let mut frames = frames();
        let total = frames.len() as u64;
        let which = 1 + which % (frames.len() - 2);
        let frame = &mut frames[which];
        let at = at.index(frame.len());
        frame[at] ^= 1 << bit;
        let split = frame[at] == 0;
        let merged = at == frame.len() - 1;
        let (_, c) = drain(&frames.concat());
        let expected_lost = if merged { 2 } else { 1 };
        prop_assert_eq!(c.lost, expected_lost, "at {} of {}", at, which);
        prop_assert_eq!(c.received, total - expected_lost);
        // A flipped byte that became a delimiter makes two frames of one.
        let most = if split { 2 } else { 1 };
        prop_assert!((1..=most).contains(&c.damaged), "{} damaged", c.damaged);
    }

    #[test]
    fn a_bad_link_is_survived(seed in any::<u64>(), drop in 0u32..2000, flip in 0u32..2000, duplicate in 0u32..2000, truncate in 0u32..100_000) {
        let mut link = LinkFault::new(seed, Faults { drop, flip, duplicate, truncate });
        let frames = frames();
        let mut bytes = Vec::new();
        frames.iter().for_each(|frame| link.pass(frame, &mut bytes));
        // The delimiter ends what debris there may be.
        bytes.push(0);
        let (_, faulty) = drain(&bytes);
        let (sent, _) = receive(&frames.concat(), 1 << 20);
        let (arrived, _) = receive(&bytes, 1 << 20);
        let mut rest = sent.iter();
        for packet in &arrived {
            prop_assert!(rest.any(|p| p == packet), "a packet that was not sent, or not in this order");
        }
        if link.struck() == 0 {
            prop_assert_eq!((faulty.lost, faulty.damaged), (0, 0));
            prop_assert_eq!(faulty.received, frames.len() as u64);
        }
        // After the trouble every packet of a new round is accounted for.
        bytes.extend(frames.concat());
        let (_, c) = drain(&bytes);
        let accounted = |c: &Counters| c.received + c.stale + c.early;
        prop_assert_eq!(accounted(&c) - accounted(&faulty), frames.len() as u64);
        prop_assert_eq!(c.damaged, faulty.damaged);
    }
}

#[test]
fn sequence_numbers_wrap_and_repeats_are_stale() {
    let mut bytes = written(|w, mut sink| {
        w.resume_after(65_533);
        w.hello(&hello(Layout::World, true), &mut sink).unwrap();
        (0..5).for_each(|i| w.cut(Tick(i), &mut sink).unwrap());
    });
    let frames: Vec<Vec<u8>> = bytes
        .split_inclusive(|&b| b == 0)
        .map(<[u8]>::to_vec)
        .collect();
    // Lose one across the wrap, repeat the last.
    bytes = [
        &frames[0], &frames[1], &frames[3], &frames[4], &frames[5], &frames[5],
    ]
    .into_iter()
    .flatten()
    .copied()
    .collect();
    let (packets, c) = receive(&bytes, 1);
    assert_eq!((packets.len(), c.received, c.lost, c.stale), (5, 5, 1, 1));
}

#[test]
fn a_restarted_sender_is_followed() {
    let one = frames().concat();
    let long: Vec<u8> = written(|w, mut sink| {
        w.hello(&hello(Layout::World, true), &mut sink).unwrap();
        (0..300).for_each(|i| w.cut(Tick(i), &mut sink).unwrap());
    });
    let (_, c) = drain(&[long, one].concat());
    assert_eq!(
        (c.received, c.lost, c.stale),
        (301 + frames().len() as u64, 0, 0)
    );
}

#[test]
fn packets_before_the_first_hello_are_not_guessed_at() {
    let frames = frames();
    let (packets, c) = receive(&frames[1..].concat(), 64);
    assert!(matches!(packets[0], Owned::Hello(_)));
    assert_eq!((c.early, c.lost, c.damaged), (10, 0, 0));
}

#[test]
fn another_version_or_schema_is_a_typed_error() {
    let hello = written(|w, mut sink| w.hello(&hello(Layout::World, true), &mut sink).unwrap());
    let payload = &payload_of(&hello)[..];
    let damage = |payload: &[u8]| {
        let frame = forged(1, 0, payload);
        let mut receiver = Receiver::new();
        assert!(receiver.push(&mut &frame[..]).is_none());
        assert_eq!(receiver.counters().damaged, 1);
        receiver.last_damage()
    };
    let with = |at: usize, value: u8| {
        let mut p = payload.to_vec();
        p[at] = value;
        p
    };
    assert_eq!(damage(&with(0, b'X')), Some(Damage::Contents));
    assert_eq!(damage(&with(4, 2)), Some(Damage::Version(2)));
    let flipped = schema::HASH ^ 1;
    assert_eq!(
        damage(&with(5, flipped as u8)),
        Some(Damage::Schema(flipped))
    );
    assert_eq!(damage(&[payload, &[0]].concat()), Some(Damage::Contents));
    assert_eq!(
        damage(&payload[..payload.len() - 1]),
        Some(Damage::Contents)
    );
    // Width 256 is 00 01: without the high byte it is 0.
    assert_eq!(damage(&with(10, 0)), Some(Damage::Contents));
    // Three lamps, or one on the screen.
    assert_eq!(damage(&with(40, 3)), Some(Damage::Contents));
    let mut screen = with(13, 0);
    screen[40] = 1;
    assert_eq!(damage(&screen), Some(Damage::Contents));
}

/// The payload of a whole frame.
fn payload_of(frame: &[u8]) -> Vec<u8> {
    let mut packet = vec![0xA5; frame.len()];
    let n = cobs::decode(&frame[..frame.len() - 1], &mut packet)
        .unwrap()
        .frame_size();
    packet[3..n - 4].to_vec()
}

/// What a receiver that has seen `greeting` thinks of a packet.
fn judged(greeting: &Hello, kind: Kind, payload: &[u8]) -> Result<Owned, Option<Damage>> {
    let mut bytes = written(|w, mut sink| w.hello(greeting, &mut sink).unwrap());
    bytes.extend(forged(kind as u8, 1, payload));
    let mut receiver = Receiver::new();
    let mut input = &bytes[..];
    assert!(matches!(receiver.push(&mut input), Some(Packet::Hello(_))));
    let packet = receiver.push(&mut input).map(Owned::from);
    packet.ok_or_else(|| receiver.last_damage())
}

const REFUSED: Result<Owned, Option<Damage>> = Err(Some(Damage::Contents));

#[test]
fn damaged_lamps_are_refused() {
    let sun = Lamp {
        kind: LampKind::Directional,
        place: [-Lamp::UNIT, 0, 1],
        tint: [65_535, 255],
    };
    let frame = written(|w, mut sink| {
        w.hello(&lit(2), &mut |_: &[u8]| {}).unwrap();
        w.lamps(Tick(5), &[LAMP, sun], &mut sink).unwrap();
    });
    let good = payload_of(&frame);
    assert_eq!(good.len(), 4 + 2 * 17);
    let judge = |payload: &[u8]| judged(&lit(2), Kind::Lamps, payload);
    let lamps = |first, second| Ok(Owned::Lamps(Tick(5), vec![first, second]));
    assert_eq!(judge(&good), lamps(LAMP, sun));
    let with = |at: usize, bytes: &[u8]| {
        let mut p = good.clone();
        p[at..at + bytes.len()].copy_from_slice(bytes);
        judge(&p)
    };
    // Another number of lamps than the Hello's, and none.
    assert_eq!(judged(&lit(1), Kind::Lamps, &good), REFUSED);
    assert_eq!(judged(&lit(0), Kind::Lamps, &good), REFUSED);
    assert_eq!(judged(&lit(0), Kind::Lamps, &good[..4]), REFUSED);
    assert_eq!(judge(&good[..21]), REFUSED);
    assert_eq!(judge(&[&good[..], &[0]].concat()), REFUSED);
    // An unknown kind; places beyond the edge, at it; no direction; no tint.
    assert_eq!(with(4, &[2]), REFUSED);
    let edge = Lamp::MAX_PLACE;
    for bad in [edge + 1, -edge - 1, i32::MAX, i32::MIN] {
        assert_eq!(with(9, &bad.to_le_bytes()), REFUSED, "{bad}");
    }
    let [x, _, z] = LAMP.place;
    let far = Lamp {
        place: [x, -edge, z],
        ..LAMP
    };
    assert_eq!(with(9, &(-edge).to_le_bytes()), lamps(far, sun));
    let unit = Lamp::UNIT;
    for bad in [unit + 1, -unit - 1] {
        assert_eq!(with(22, &bad.to_le_bytes()), REFUSED, "{bad}");
    }
    assert_eq!(with(22, &[0; 12]), REFUSED);
    for tint in [17, 19, 34, 36] {
        assert_eq!(with(tint, &[0, 0]), REFUSED, "tint at {tint}");
    }
}

#[test]
fn damaged_shapes_are_refused() {
    let vertices = [[1, 2, 3], [-4, 5, -6], [i16::MAX, i16::MIN, 0], [7, 7, 7]];
    let frame = written(|w, mut sink| {
        w.hello(&lit(0), &mut |_: &[u8]| {}).unwrap();
        w.shape(9, 1, 2, &vertices, &[[0, 1, 2], [3, 2, 1]], &mut sink)
            .unwrap();
    });
    let good = payload_of(&frame);
    assert_eq!(good.len(), 5 + 4 * 6 + 2 * 3);
    let judge = |payload: &[u8]| judged(&lit(0), Kind::Shape, payload);
    let [a, b, c, d] = vertices;
    let shape = |object, part, parts| {
        Ok(Owned::Shape(
            object,
            part,
            parts,
            vec![[a, b, c], [d, c, b]],
        ))
    };
    assert_eq!(judge(&good), shape(9, 1, 2));
    let with = |at: usize, value: u8| {
        let mut p = good.clone();
        p[at] = value;
        judge(&p)
    };
    // The static world and the sky move no shadow.
    assert_eq!(with(0, 0), REFUSED);
    assert_eq!(with(0, SKY), REFUSED);
    assert_eq!(with(0, 254), shape(254, 1, 2));
    // A part beyond the last; the most parts.
    assert_eq!(with(1, 2), REFUSED);
    assert_eq!(with(2, 0), REFUSED);
    assert_eq!(with(2, 255), shape(9, 1, 256));
    // Numbers that contradict the length; an index of no vertex.
    for at in [3, 4] {
        assert_eq!(with(at, good[at] + 1), REFUSED);
        assert_eq!(with(at, good[at] - 1), REFUSED);
    }
    for at in good.len() - 6..good.len() {
        assert_eq!(with(at, 4), REFUSED, "index at {at}");
        assert!(with(at, 0).is_ok(), "index at {at}");
    }
    for len in 0..good.len() {
        assert_eq!(judge(&good[..len]), REFUSED, "{len} bytes");
    }
    assert_eq!(judge(&[&good[..], &[0]].concat()), REFUSED);
}
