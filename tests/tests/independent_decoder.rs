//! The stream means what `docs/STREAM.md` says: a decoder written from that document alone gets
//! out of it what the host put in.

mod independent;
#[path = "../../crates/wire/tests/wire/room.rs"]
mod room;

use independent::{Decoded, decode};
use room::Rng;
use unframed_wire::*;

fn hello(layout: Layout, lamps: u8) -> Hello {
    Hello {
        width: 256,
        height: 256,
        layout,
        objects: layout == Layout::World,
        tile_fields: TileFields {
            gradients: true,
            lifetime: false,
            density: true,
        },
        encoding: ColourEncoding::Srgb8,
        rate: 400_000,
        refresh_millihertz: 60_000,
        world: WorldFrame {
            origin: [0.5, -1.0, 2.0],
            unit: 0.001,
        },
        lamps,
    }
}

/// Random halves down to small tiles, in preorder.
fn tree(rng: &mut Rng, region: Rect, out: &mut Vec<TileNode>) {
    let axis = if rng.bits() & 1 == 0 {
        Axis::X
    } else {
        Axis::Y
    };
    if rng.unit() > 32.0 / (f64::from(region.w) * f64::from(region.h))
        && let Some((a, b)) = tiles::split(region, axis)
    {
        out.push(TileNode::Split(axis));
        tree(rng, a, out);
        tree(rng, b, out);
        return;
    }
    let neutral = LogCode(128);
    let mut code = || LogCode(120u8.wrapping_add((rng.bits() % 30) as u8));
    let (gx, gy, gt, density) = (code(), code(), code(), code());
    out.push(TileNode::Leaf(Tile {
        rect: region,
        gx,
        gy,
        gt,
        lifetime: neutral,
        density,
    }));
}

/// A lamp of either kind, anywhere.
fn lamp(rng: &mut Rng) -> Lamp {
    let (kind, edge) = match rng.bits() & 1 {
        0 => (LampKind::Point, Lamp::MAX_PLACE),
        _ => (LampKind::Directional, Lamp::UNIT),
    };
    let mut along = || ((2.0 * rng.unit() - 1.0) * f64::from(edge)) as i32;
    Lamp {
        kind,
        place: [along(), along(), -edge],
        tint: [1 + (along() & 0x7fff) as u16, 1],
    }
}

/// Vertices and triangles, as many as a packet holds.
fn surface(rng: &mut Rng) -> (Vec<[i16; 3]>, Vec<[u8; 3]>) {
    let vertices = 1 + rng.bits() as usize % 256;
    let triangles = (1..=256).rev().find(|&n| Shape::fits(vertices, n)).unwrap();
    let mut any = |below: usize| rng.bits() as usize % below;
    let vertices: Vec<_> = (0..vertices)
        .map(|_| [0; 3].map(|_: u8| any(65_536) as i16))
        .collect();
    let corners = vertices.len();
    let triangles = (0..triangles)
        .map(|_| [0; 3].map(|_: u8| any(corners) as u8))
        .collect();
    (vertices, triangles)
}

/// A stream of both kinds of regular and irregular samples, and what went into it.
struct Sent {
    bytes: Vec<u8>,
    samples: Vec<independent::Sample>,
    tiles: Vec<independent::Tile>,
    views: Vec<independent::View>,
    poses: Vec<independent::Pose>,
    lamps: Vec<independent::Lamp>,
    shapes: Vec<independent::Shape>,
    refreshes: Vec<(u32, u32)>,
    packets: u64,
}

fn send(layout: Layout, lamps: u8, seed: u64) -> Sent {
    let mut rng = Rng(seed);
    let mut bytes = Vec::new();
    let mut sink = |frame: &[u8]| bytes.extend_from_slice(frame);
    let mut w = Writer::new();
    let (mut samples, mut leaves, mut views) = (Vec::new(), Vec::new(), Vec::new());
    let (mut poses, mut refreshes) = (Vec::new(), Vec::new());
    let (mut lit, mut shapes) = (Vec::new(), Vec::new());
    let whole = Rect {
        x: 0,
        y: 0,
        w: 256,
        h: 256,
    };
    for i in 0..12u32 {
        // The clock wraps on the way.
        let time = Tick(u32::MAX - 80_000).after(16_667 * i);
        w.hello(&hello(layout, lamps), &mut sink).unwrap();
        let mut any = || rng.bits() as i32;
        let view = View {
            time,
            eye: [any(), any(), any()],
            rows: [[any(), 0, any()], [-1, any(), 256], [any(), any(), any()]],
            frac_bits: (i % 31) as u8,
        };
        w.view(&view, &mut sink).unwrap();
        let View {
            eye,
            rows,
            frac_bits,
            ..
        } = view;
        views.push(independent::View {
            time: time.0,
            eye,
            rows,
            frac_bits,
        });
        let moved: Vec<Pose> = (0..90u8)
            .map(|object| {
                let (matrix, translation) =
                    ([[any(), 0, 1], [0, any(), 2], [3, 4, any()]], [any(); 3]);
                Pose {
                    object,
                    matrix,
                    frac_bits: object % 32,
                    translation,
                }
            })
            .collect();
        w.poses(time, &moved, &mut sink).unwrap();
        poses.extend(moved.iter().map(|p| {
            let Pose {
                object,
                matrix,
                frac_bits,
                translation,
            } = *p;
            independent::Pose {
                time: time.0,
                object,
                frac_bits,
                matrix,
                translation,
            }
        }));
        let shining: Vec<Lamp> = (0..lamps).map(|_| lamp(&mut rng)).collect();
        if lamps > 0 {
            w.lamps(time, &shining, &mut sink).unwrap();
        }
        lit.extend(shining.iter().map(|lamp| independent::Lamp {
            time: time.0,
            directional: lamp.kind == LampKind::Directional,
            place: lamp.place,
            tint: lamp.tint,
        }));
        let (vertices, triangles) = surface(&mut rng);
        let (object, part) = (1 + i as u8, (2 * i) as u8);
        let parts = 24 + 21 * i as u16;
        w.shape(object, part, parts, &vertices, &triangles, &mut sink)
            .unwrap();
        let corners = |t: &[u8; 3]| t.map(|at| vertices[usize::from(at)]);
        shapes.push(independent::Shape {
            object,
            part: part.into(),
            parts,
            triangles: triangles.iter().map(corners).collect(),
        });
        let mut nodes = Vec::new();
        tree(&mut rng, whole, &mut nodes);
        w.tiles(time, whole, &nodes, &mut sink).unwrap();
        leaves.extend(nodes.iter().filter_map(|node| match node {
            TileNode::Split(_) => None,
            TileNode::Leaf(t) => Some(independent::Tile {
                time: time.0,
                rect: [t.rect.x, t.rect.y, t.rect.w, t.rect.h],
                codes: [t.gx, t.gy, t.gt, t.lifetime, t.density].map(|c| c.0),
            }),
        }));
        for part in 0..6u32 {
            let time = time.after(part * 700);
            let n = [1, 2, 40, 128, 256, 300][part as usize];
            let tilt = if i % 2 == 0 { 0.0 } else { 0.4 };
            let (mut world, mut screen) = room::samples(&mut rng, n, 0.1, tilt, i % 3 == 0);
            if i == 11 {
                // Noise: the longest codes, and packets that have to be split.
                for s in &mut world {
                    let [a, b, c, d, e, f, g, h] = rng.bits().to_le_bytes();
                    s.place = [[a, b], [c, d], [e, f]].map(i16::from_le_bytes);
                    (s.object, s.rgb) = (g % 3, [h, a ^ c, b ^ d]);
                }
                screen
                    .iter_mut()
                    .zip(&world)
                    .for_each(|(s, w)| s.rgb = w.rgb);
            }
            for s in &mut world {
                // Mostly smooth, the last packets noise.
                let far = match i {
                    11 => rng.bits() as u16,
                    _ => s.place[0].wrapping_add(s.place[2]) as u16,
                };
                let codes = [far >> 12, far >> 11].map(|c| c as u8);
                s.shares =
                    Shares::new([0, 1].map(|l| if l < lamps { codes[l as usize] } else { 0 }));
            }
            let (time, sample) = (time, |object, place, rgb, shares: Shares| {
                independent::Sample {
                    time: time.0,
                    object,
                    place,
                    rgb,
                    shares: [shares.code(0), shares.code(1)],
                }
            });
            match layout {
                Layout::World => {
                    w.world_samples(time, &world, &mut sink).unwrap();
                    samples.extend(
                        world
                            .iter()
                            .map(|s| sample(s.object, s.place.map(i32::from), s.rgb, s.shares)),
                    );
                }
                Layout::Screen => {
                    w.screen_samples(time, &screen, &mut sink).unwrap();
                    let place = |s: &ScreenSample| [i32::from(s.x), i32::from(s.y), 0];
                    samples.extend(
                        screen
                            .iter()
                            .map(|s| sample(0, place(s), s.rgb, Shares::default())),
                    );
                }
            }
        }
        w.refresh(Refresh { time, index: i }, &mut sink).unwrap();
        refreshes.push((time.0, i));
    }
    w.cut(Tick(77), &mut sink).unwrap();
    w.end(Tick(78), &mut sink).unwrap();
    let packets = w.ledger().total_packets();
    samples.sort();
    Sent {
        bytes,
        samples,
        tiles: leaves,
        views,
        poses,
        lamps: lit,
        shapes,
        refreshes,
        packets,
    }
}

fn sorted(decoded: &Decoded) -> Vec<independent::Sample> {
    let mut samples = decoded.samples.clone();
    samples.sort();
    samples
}

#[test]
fn both_layouts_decode_to_what_was_sent() {
    let world = [0, 1, 2].map(|lamps| (Layout::World, lamps));
    for (seed, (layout, lamps)) in (1..).zip(world.into_iter().chain([(Layout::Screen, 0)])) {
        let sent = send(layout, lamps, seed);
        let got = decode(&sent.bytes);
        assert_eq!((got.lost, got.damaged, got.packets), (0, 0, sent.packets));
        assert_eq!(got.hellos.len(), 12);
        let h = &got.hellos[0];
        assert_eq!(
            (h.width, h.height, h.tile_fields, h.rate),
            (256, 256, 5, 400_000)
        );
        assert_eq!(
            (h.refresh_millihertz, h.origin, h.unit),
            (60_000, [0.5, -1.0, 2.0], 0.001)
        );
        assert_eq!(
            (h.world_layout, h.objects),
            (layout == Layout::World, layout == Layout::World)
        );
        assert_eq!(got.views, sent.views);
        assert_eq!(got.poses, sent.poses);
        assert!(got.hellos.iter().all(|h| h.lamps == lamps));
        assert_eq!(got.lamps, sent.lamps);
        assert_eq!(got.shapes, sent.shapes);
        assert_eq!(got.tiles, sent.tiles);
        assert_eq!(got.refreshes, sent.refreshes);
        assert_eq!(got.cuts, [77]);
        assert_eq!(
            got.end,
            Some((78, sent.samples.len() as u64, sent.packets - 1))
        );
        assert!(
            sorted(&got) == sent.samples,
            "{layout:?}, {lamps} lamps: samples differ"
        );
    }
}

#[test]
fn a_recording_decodes_with_its_index() {
    let sent = send(Layout::World, 0, 3);
    let mut recorder = recording::Recorder::new(Vec::new());
    recorder.write(&sent.bytes).unwrap();
    let file = recorder.finish().unwrap();
    let got = decode(&file);
    assert_eq!((got.lost, got.damaged), (0, 0));
    assert_eq!(sorted(&got), sent.samples);
    assert_eq!(got.trailer, Some((sent.bytes.len() as u64, 25)));
    let kinds = [0, 1, 2].map(|kind| got.index.iter().filter(|e| e.0 == kind).count());
    assert_eq!(kinds, [12, 12, 1]);
    for &(kind, _, offset) in &got.index {
        let end = offset as usize
            + file[offset as usize..]
                .iter()
                .position(|&b| b == 0)
                .unwrap();
        assert_eq!(file[end], 0);
        // The type is the second byte of a frame: the first is a COBS code.
        let expected = [1, 7, 8][usize::from(kind)];
        assert_eq!(file[offset as usize + 1], expected);
    }
}

#[test]
fn damage_is_seen_and_counted_alike() {
    let sent = send(Layout::World, 2, 4);
    let mut link = fault::LinkFault::new(
        5,
        fault::Faults {
            drop: 200,
            flip: 200,
            duplicate: 200,
            truncate: 0,
        },
    );
    let mut bytes = Vec::new();
    link.pass(&sent.bytes, &mut bytes);
    assert!(link.struck() > 20);
    let mut receiver = Receiver::new();
    let mut input = &bytes[..];
    let mut samples = 0;
    while let Some(packet) = receiver.push(&mut input) {
        if let Packet::World(s) = packet {
            samples += s.count();
        }
    }
    let got = decode(&bytes);
    let c = receiver.counters();
    assert!(c.damaged > 0 && c.lost > 0);
    assert_eq!(
        (got.packets, got.lost, got.damaged),
        (c.received, c.lost, c.damaged)
    );
    assert_eq!(got.samples.len(), samples);
}

#[test]
fn the_decoders_own_parts_are_right() {
    assert_eq!(independent::crc32c(b"123456789"), 0xE306_9283);
    // One wrong bit in a sample packet must not go unnoticed, or the comparisons above are idle.
    let mut sent = send(Layout::World, 0, 6);
    let ends = sent
        .bytes
        .iter()
        .enumerate()
        .filter(|&(_, &b)| b == 0)
        .map(|(at, _)| at);
    let world = ends
        .into_iter()
        .find(|&at| sent.bytes.get(at + 2) == Some(&5))
        .unwrap();
    sent.bytes[world + 12] ^= 4;
    let got = decode(&sent.bytes);
    assert!(got.damaged >= 1 && sorted(&got) != sent.samples);
}
