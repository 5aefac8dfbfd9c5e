//! Light of the instant: lamps and what stands before them, equal at every refresh.

use super::stream::{Rng, Stream, octahedron};
use super::{ADAPTIVE, Case, adapter_or_skip, check, difference};
use unframed_recon::config::{Extents, Fit, Light};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed, Player};
use unframed_sim::twin::Tables;
use unframed_wire::{Lamp, LampKind, Layout, LogCode, Pose, Shares, Tick, View, WorldSample};

const SIZE: (u16, u16) = (60, 44);
/// World units of a lattice step: half of what lamps tell apart.
const STEP: i32 = 128;
/// Refreshes in motion, then at rest.
const MOVES: u32 = 7;
const RESTS: u32 = 9;

/// What is left out of a stream.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Without {
    Nothing,
    Lamps,
    Shapes,
    Shares,
}

/// Of an object that is turned about the vertical axis, at lattice steps of the world.
fn pose(object: u8, angle: f64, at: [i32; 3]) -> Pose {
    let (s, c) = angle.sin_cos();
    let q = |v: f64| (v * f64::from(STEP << 16)) as i32;
    Pose {
        object,
        matrix: [[q(c), 0, q(s)], [0, q(1.0), 0], [q(-s), 0, q(c)]],
        frac_bits: 16,
        translation: at.map(|v| STEP * v),
    }
}

/// Looks at the origin from 20,000 steps before it.
fn view(time: u32) -> View {
    let [w, h] = [SIZE.0, SIZE.1].map(f64::from);
    let q = |v: f64| (v * f64::from(1 << 18)) as i32;
    View {
        time: Tick(time),
        eye: [0, 0, -20_000 * STEP],
        rows: [[q(w), 0, q(w / 2.0)], [0, q(w), q(h / 2.0)], [0, 0, q(1.0)]],
        frac_bits: 18,
    }
}

/// A box without its sides along z: something may be within.
fn tube(x: i16, y: i16, z: i16) -> Vec<[[i16; 3]; 3]> {
    let quad = |a: [i16; 3], b: [i16; 3]| {
        let [near, far] = [-z, z].map(|z| [[a[0], a[1], z], [b[0], b[1], z]]);
        [[near[0], near[1], far[0]], [far[1], far[0], near[1]]]
    };
    let corners = [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]];
    let sides = (0..4).flat_map(|i| quad(corners[i], corners[(i + 1) % 4]));
    sides.collect()
}

/// A place of a wall behind everything, a floor, or a triangle of a shape.
fn sample(rng: &mut Rng, shapes: &[(u8, Vec<[[i16; 3]; 3]>)], without: Without) -> WorldSample {
    let mut within = |edge: i16| ((rng.unit() - 0.5) * 2.0 * f64::from(edge)) as i16;
    let (a, b) = (within(16_000), within(12_000));
    let (place, object) = match rng.below(5) {
        0 | 1 => ([a, b, 14_000], 0),
        2 => ([a, 9000, b], 0),
        _ => {
            let (object, triangles) = &shapes[rng.below(shapes.len() as u64) as usize];
            let triangle = triangles[rng.below(triangles.len() as u64) as usize];
            let (mut u, mut v) = (rng.unit(), rng.unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [p, q, r] = triangle.map(|corner| corner.map(f64::from));
            let place = [0, 1, 2].map(|k| p[k] + u * (q[k] - p[k]) + v * (r[k] - p[k]));
            (place.map(|v| v as i16), *object)
        }
    };
    let shares = Shares::new([rng.below(16) as u8, rng.below(16) as u8]);
    WorldSample {
        place,
        rgb: [rng.below(256) as u8, 200, rng.below(60) as u8 + 150],
        object,
        shares: match (without, rng.below(10)) {
            (Without::Shares, _) | (_, 0) => Shares::default(),
            _ => shares,
        },
    }
}

/// A room with an octahedron that passes before the lamps, and a tube about the nearer of them;
/// first all moves, the lamps too, then all rests.
fn stream(without: Without) -> Vec<u8> {
    let mut stream = Stream::lit(SIZE, Layout::World, 8, 2);
    let mut rng = Rng(8);
    let shapes = [(1, octahedron(3000)), (7, tube(2500, 1500, 4000))];
    let mut time = 0u32.wrapping_sub(50_000);
    for index in 0..MOVES + RESTS {
        let phase = f64::from(index.min(MOVES)) * 0.2;
        if index <= MOVES {
            stream.any_view(&view(time));
            let across = (phase * 6000.0) as i32;
            stream.any_poses(
                time,
                &[
                    pose(0, 0.0, [0; 3]),
                    pose(1, phase, [across - 4000, across / 3 - 1000, 3000]),
                    pose(7, 0.3 - phase, [500, -4000, across / 4 - 2000]),
                ],
            );
            if without != Without::Lamps {
                let near = Lamp {
                    kind: LampKind::Point,
                    place: [600, -4200, -1500].map(|v| STEP * (v + across / 20)),
                    tint: [300, 200],
                };
                let far = Lamp {
                    kind: LampKind::Directional,
                    place: [-300_000_000, -800_000_000, (phase * -3e8) as i32],
                    tint: [220, 400],
                };
                stream.lamps(time, &[near, far]);
            }
        }
        // The lamps are there before the shapes; these come again and again.
        if without != Without::Shapes && index % 4 == 1 {
            for (object, triangles) in &shapes {
                stream.shape(*object, triangles);
            }
        }
        let span = if index < MOVES { 16_000 } else { 200_000 };
        stream.tiles_but(time, 60, |tile| {
            tile.lifetime = LogCode(if index < MOVES { 120 } else { 255 });
        });
        for _ in 0..40 {
            let samples: Vec<_> = (0..30)
                .map(|_| sample(&mut rng, &shapes, without))
                .collect();
            stream.world_samples(time, &samples);
            time = time.wrapping_add(span / 40);
        }
        stream.refresh(time, index);
    }
    stream.bytes
}

fn case(config: Config) -> Case {
    Case {
        config,
        size: SIZE,
        samples: 6000,
    }
}

/// The pictures of all refreshes, by the processor.
fn pictures(bytes: &[u8]) -> Vec<Vec<[u8; 3]>> {
    let case = case(ADAPTIVE);
    let mut storage = HeapStorage::new(SIZE.0, SIZE.1, case.samples);
    let display = Display::<Fixed>::new(case.config, SIZE.0, SIZE.1, storage.memory());
    let mut player = Player::new(display.expect("it fits"));
    let mut pictures = Vec::new();
    let mut input = bytes;
    while player.push(&mut input).is_some() {
        pictures.push(player.display().picture().to_vec());
    }
    let counts = player.display().counts();
    assert_eq!((counts.refused, counts.unplaced), (0, 0), "{counts:?}");
    pictures
}

#[test]
fn every_shadow_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of shadows") else {
        return;
    };
    let bytes = stream(Without::Nothing);
    let own = Config {
        extents: Extents::Pixel,
        fit: Fit::Constant,
        hidden: false,
        ..ADAPTIVE
    };
    let encoded = Config {
        light: Light::Encoded,
        ..ADAPTIVE
    };
    let still = Config {
        reproject: false,
        ..ADAPTIVE
    };
    for config in [ADAPTIVE, own, encoded, still, Config::NEWEST] {
        check(&gpu, case(config), &bytes);
    }
}

/// Without lamps, shapes or shares there are no shadows, and with them there are many: in motion,
/// on the first pictures and the last, and in the means of what rests.
#[test]
fn shadows_show() {
    let lit = pictures(&stream(Without::Nothing));
    let bright = pictures(&stream(Without::Shares));
    for without in [Without::Lamps, Without::Shapes] {
        assert!(pictures(&stream(without)) == bright, "no shadows otherwise");
    }
    assert_eq!(lit.len(), (MOVES + RESTS) as usize);
    for (index, (lit, bright)) in lit.iter().zip(&bright).enumerate() {
        let darker = lit.iter().zip(bright).filter(|(a, b)| a[1] < b[1]).count();
        let share = darker * 100 / lit.len();
        // Before the shapes arrive nothing is in a shadow.
        let expected = if index == 0 { 0..=0 } else { 10..=90 };
        assert!(expected.contains(&share), "refresh {index}: {share} %");
    }
}

/// A stream of another description forgets lamps and shapes; they come back one after the other.
#[test]
fn a_new_stream_is_unlit() {
    let Some(gpu) = adapter_or_skip("equality of lamps that are forgotten") else {
        return;
    };
    let mut stream = Stream::lit(SIZE, Layout::World, 9, 2);
    let mut rng = Rng(9);
    let shapes = [(1, octahedron(6000))];
    let samples: Vec<_> = (0..2000)
        .map(|_| sample(&mut rng, &shapes, Without::Nothing))
        .collect();
    let lamp = Lamp {
        kind: LampKind::Point,
        place: [100, 200, -12_000].map(|v| STEP * v),
        tint: [256; 2],
    };
    let mut refreshes = 0;
    for hello in [400_000, 7, 8] {
        stream.hello(hello);
        stream.any_view(&view(0));
        stream.any_poses(0, &[pose(0, 0.0, [0; 3]), pose(1, 0.0, [0, 0, -1000])]);
        // In either order.
        for step in 0..3 {
            match (step, hello) {
                (0, _) => {}
                (1, 7) | (2, 8 | 400_000) => stream.shape(1, &shapes[0].1),
                _ => stream.lamps(0, &[lamp; 2]),
            }
            if step == 0 {
                stream.world_samples(0, &samples);
            }
            stream.refresh(10, refreshes);
            refreshes += 1;
        }
    }
    check(&gpu, case(ADAPTIVE), &stream.bytes);
    let shown = pictures(&stream.bytes);
    for shown in shown.chunks(3) {
        assert!(shown[0] == shown[1] && shown[1] != shown[2]);
    }
}

/// Twins that err by one bit are found.
#[test]
fn a_wrong_shadow_is_found() {
    let Some(gpu) = adapter_or_skip("whether the comparison of shadows can fail") else {
        return;
    };
    let mut tables = Tables::new(&ADAPTIVE);
    tables.linear.iter_mut().for_each(|v| *v ^= 1);
    let bytes = stream(Without::Nothing);
    let found = difference(&gpu, case(ADAPTIVE), &tables, &bytes);
    assert!(found.is_some(), "not found");
    let unlit = stream(Without::Shares);
    assert_eq!(difference(&gpu, case(ADAPTIVE), &tables, &unlit), None);
}
