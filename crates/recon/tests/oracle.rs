//! Fixed point against the f64 oracle on synthetic scenes, whole refreshes at a time.

use unframed_recon::config::Fit;
use unframed_recon::heap::HeapStorage;
use unframed_recon::rounded::{Bits, Deployed, Rounded};
use unframed_recon::{Arith, Config, Display, Fixed};
use unframed_wire::{
    ColourEncoding, Hello, Layout, LogCode, Pose, Rect, Refresh, Shares, Tick, Tile, TileFields,
    View, WorldFrame, WorldSample,
};

const SIZE: u16 = 64;

/// A small deterministic generator (splitmix64): tests need no more.
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn hello() -> Hello {
    Hello {
        width: SIZE,
        height: SIZE,
        layout: Layout::World,
        objects: true,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        encoding: ColourEncoding::Srgb8,
        rate: 400_000,
        refresh_millihertz: 60_000,
        world: WorldFrame {
            origin: [0.0; 3],
            unit: 0.001,
        },
        lamps: 0,
    }
}

/// A camera at height 0, looking along +z, turned a little: 60 degrees over the panel.
fn view(turn: f64) -> View {
    let f = f64::from(SIZE) / 2.0 / (30f64.to_radians()).tan();
    let c = f64::from(SIZE) / 2.0;
    let (s, k) = turn.sin_cos();
    let (right, down, forward) = ([k, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, k]);
    let q = |v: f64| (v * f64::from(1 << 22)).round() as i32;
    let row = |axis: [f64; 3]| core::array::from_fn(|j| q(f * axis[j] + c * forward[j]));
    View {
        time: Tick(0),
        eye: [0, 0, -20_000],
        rows: [row(right), row(down), forward.map(q)],
        frac_bits: 22,
    }
}

fn pose(object: u8) -> Pose {
    let one = 1 << 28;
    Pose {
        object,
        matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
        frac_bits: 28,
        translation: [0, 0, 0],
    }
}

/// A wall at z = 20000 with a checker, a sphere before it.
fn sample(rng: &mut Rng) -> WorldSample {
    let on_sphere = rng.unit() < 0.3;
    let (place, bright) = if on_sphere {
        let (u, v) = (rng.unit() * std::f64::consts::TAU, rng.unit() * 2.0 - 1.0);
        let r = (1.0 - v * v).sqrt();
        let p = [
            5000.0 * r * u.cos(),
            5000.0 * v,
            5000.0 * r * u.sin() - 4000.0,
        ];
        (p, (8.0 * v).sin() > 0.0)
    } else {
        let p = [
            (rng.unit() - 0.5) * 60_000.0,
            (rng.unit() - 0.5) * 60_000.0,
            20_000.0,
        ];
        (
            p,
            ((p[0] / 3000.0).floor() + (p[1] / 3000.0).floor()) as i64 % 2 == 0,
        )
    };
    let level = if bright { 240.0 } else { 20.0 } + rng.unit() * 10.0;
    WorldSample {
        place: place.map(|v| v.round() as i16),
        rgb: [level as u8, (level * 0.8) as u8, 255 - level as u8],
        object: u8::from(on_sphere),
        shares: Shares::default(),
    }
}

fn picture<A: Arith>(config: Config, seed: u64, samples: u32) -> Vec<[u8; 3]> {
    let mut storage = HeapStorage::<A>::new(SIZE, SIZE, samples as usize);
    let mut display = Display::new(config, SIZE, SIZE, storage.memory()).expect("it fits");
    let mut rng = Rng(seed);
    display.hello(&hello());
    display.view(&view(rng.unit() * 0.3));
    display.pose(&pose(0));
    display.pose(&pose(1));
    for y in 0..8 {
        for x in 0..8 {
            let rect = Rect {
                x: x * 8,
                y: y * 8,
                w: 8,
                h: 8,
            };
            let lifetime = LogCode(80 + (rng.next() % 48) as u8);
            display.tile(&Tile {
                rect,
                lifetime,
                ..Tile::default()
            });
        }
    }
    for i in 0..samples {
        display.world_sample(Tick(i * 10), &sample(&mut rng));
    }
    display.refresh(&Refresh {
        time: Tick(samples * 10),
        index: 0,
    });
    display.picture().to_vec()
}

/// Differences of the pictures, sorted, largest last.
fn differences(config: Config, seed: u64) -> Vec<u8> {
    let fixed = picture::<Fixed>(config, seed, 40_000);
    let oracle = picture::<f64>(config, seed, 40_000);
    let mut all: Vec<u8> = fixed
        .iter()
        .flatten()
        .zip(oracle.iter().flatten())
        .map(|(a, b)| a.abs_diff(*b))
        .collect();
    all.sort_unstable();
    all
}

fn check(name: &str, config: Config) {
    let mut all = Vec::new();
    for seed in 0..8 {
        all.extend(differences(config, seed));
    }
    all.sort_unstable();
    let at = |share: f64| all[((all.len() - 1) as f64 * share) as usize];
    let equal = all.iter().filter(|d| **d == 0).count() as f64 / all.len() as f64;
    println!(
        "{name}: equal {equal:.4}, 99 % {}, 99.9 % {}, max {}",
        at(0.99),
        at(0.999),
        at(1.0)
    );
    assert!(
        at(0.99) <= 1 && at(0.999) <= 2,
        "{name}: 99.9 % at {}",
        at(0.999)
    );
}

#[test]
fn fixed_point_follows_the_oracle() {
    let adaptive = Config::ADAPTIVE;
    check("adaptive", adaptive);
    check(
        "constant fit",
        Config {
            fit: unframed_recon::config::Fit::Constant,
            ..adaptive
        },
    );
    check(
        "no hidden-point test",
        Config {
            hidden: false,
            ..adaptive
        },
    );
    check("uniform", Config::UNIFORM);
    check("paper", Config::PAPER);
}

#[test]
fn the_comparison_can_fail() {
    let right = picture::<Fixed>(Config::ADAPTIVE, 1, 40_000);
    let other = picture::<Fixed>(
        Config {
            fill: false,
            hidden: false,
            ..Config::ADAPTIVE
        },
        1,
        40_000,
    );
    assert_ne!(right, other);
}

#[test]
fn order_does_not_matter() {
    let mut rng = Rng(7);
    let samples: Vec<_> = (0..20_000u32)
        .map(|i| (Tick(i * 20), sample(&mut rng)))
        .collect();
    let shown = |order: &[(Tick, WorldSample)]| {
        let mut storage = HeapStorage::<Fixed>::new(SIZE, SIZE, samples.len());
        let mut display =
            Display::new(Config::ADAPTIVE, SIZE, SIZE, storage.memory()).expect("it fits");
        display.hello(&hello());
        display.view(&view(0.1));
        display.pose(&pose(0));
        display.pose(&pose(1));
        for (time, sample) in order {
            display.world_sample(*time, sample);
        }
        display.refresh(&Refresh {
            time: Tick(400_000),
            index: 0,
        });
        display.picture().to_vec()
    };
    let reversed: Vec<_> = samples.iter().rev().copied().collect();
    assert_eq!(shown(&samples), shown(&reversed));
}

/// Root of the mean square of the differences of two pictures.
fn rms(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let square = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
    (a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn rounding_where_integers_round_gives_their_picture() {
    for config in [
        Config::ADAPTIVE,
        Config {
            fit: Fit::Constant,
            ..Config::ADAPTIVE
        },
    ] {
        let fixed = picture::<Fixed>(config, 5, 40_000);
        let exact = picture::<f64>(config, 5, 40_000);
        let deployed = picture::<Rounded<Deployed>>(config, 5, 40_000);
        let (off, left) = (rms(&fixed, &exact), rms(&fixed, &deployed));
        println!("{off} {left}");
        assert!(left < 0.6 * off, "{off} {left}");
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Fewer<const N: u32>;

impl<const N: u32> Bits for Fewer<N> {
    const PLACE: u32 = N;
    const WEIGHT: u32 = 2 * N;
    const LIGHT: u32 = 2 * N + 2;
}

#[test]
fn fewer_bits_err_more() {
    let exact = picture::<f64>(Config::ADAPTIVE, 6, 40_000);
    let off = [
        rms(
            &picture::<Rounded<Deployed>>(Config::ADAPTIVE, 6, 40_000),
            &exact,
        ),
        rms(
            &picture::<Rounded<Fewer<5>>>(Config::ADAPTIVE, 6, 40_000),
            &exact,
        ),
        rms(
            &picture::<Rounded<Fewer<4>>>(Config::ADAPTIVE, 6, 40_000),
            &exact,
        ),
        rms(
            &picture::<Rounded<Fewer<2>>>(Config::ADAPTIVE, 6, 40_000),
            &exact,
        ),
    ];
    println!("{off:?}");
    assert!(off.is_sorted() && off[3] > 5.0 * off[0], "{off:?}");
}
