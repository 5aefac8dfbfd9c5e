//! The scene of the benches: a checkered wall, three spheres that move before it, a little sky and
//! a camera that turns and travels. About half of the samples are in sight.

use unframed_recon::display::Display;
use unframed_recon::{Arith, Workers};
use unframed_wire::{
    ColourEncoding, Hello, Layout, LogCode, Pose, Rect, Refresh, SKY, Shares, Tick, Tile,
    TileFields, View, WorldFrame, WorldSample,
};

/// Moving spheres.
pub(crate) const MOVERS: u8 = 3;
/// Between refreshes, microseconds.
pub(crate) const REFRESH: u32 = 16_667;

/// The splitmix64 generator: seeded test data.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The stream's description.
pub(crate) fn hello(size: u16) -> Hello {
    Hello {
        width: size,
        height: size,
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

/// A camera 20 units before the origin, turned by `turn` radians and as many times 9 units to the
/// side: 60 degrees over the panel.
pub(crate) fn view(size: u16, turn: f64) -> View {
    let size = f64::from(size);
    let f = size / 2.0 / 30f64.to_radians().tan();
    let (s, k) = turn.sin_cos();
    let (right, down, forward) = ([k, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, k]);
    let q = |v: f64| (v * f64::from(1 << 18)).round() as i32;
    let row = |axis: [f64; 3]| std::array::from_fn(|j| q(f * axis[j] + size / 2.0 * forward[j]));
    View {
        time: Tick(0),
        eye: [(turn * 9000.0) as i32, 0, -20_000],
        rows: [row(right), row(down), forward.map(q)],
        frac_bits: 18,
    }
}

/// The poses of everything, the spheres `phase` along their ways.
pub(crate) fn poses(phase: f64) -> Vec<Pose> {
    let pose = |object, scale: f64, translation| {
        let one = (scale * f64::from(1 << 24)) as i32;
        Pose {
            object,
            matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
            frac_bits: 24,
            translation,
        }
    };
    let mut poses = vec![pose(0, 1.0, [0; 3]), pose(SKY, 40.0, [0, 0, -20_000])];
    for object in 1..=MOVERS {
        let angle = phase + f64::from(object) * 2.0;
        let at = [8000.0 * angle.cos(), 5000.0 * angle.sin(), -4000.0].map(|v| v as i32);
        poses.push(pose(object, 0.8, at));
    }
    poses
}

/// Tiles of 8 × 8 pixels with lifetimes from 1/32 to 2 seconds, or infinite ones where nothing
/// moves.
pub(crate) fn tiles(size: u16, moving: bool, rng: &mut Rng) -> Vec<Tile> {
    let along = size.div_ceil(8);
    let rects = (0..along * along).map(|i| (i % along * 8, i / along * 8));
    rects
        .map(|(x, y)| Tile {
            rect: Rect { x, y, w: 8, h: 8 },
            lifetime: LogCode(if moving {
                88 + rng.below(48) as u8
            } else {
                255
            }),
            ..Tile::default()
        })
        .collect()
}

/// One sample.
pub(crate) fn sample(rng: &mut Rng) -> WorldSample {
    let kind = rng.below(100);
    let (place, object, bright) = if kind < 5 {
        (
            [rng.next() as i16, rng.next() as i16, 30_000],
            SKY,
            kind < 2,
        )
    } else if kind < 40 {
        let (u, v) = (rng.unit() * std::f64::consts::TAU, rng.unit() * 2.0 - 1.0);
        let r = 4000.0 * (1.0 - v * v).sqrt();
        let place = [r * u.cos(), 4000.0 * v, r * u.sin()].map(|v| v as i16);
        let object = 1 + rng.below(u64::from(MOVERS)) as u8;
        (place, object, (8.0 * v).sin() > 0.0)
    } else {
        let at = [0, 1].map(|_| (rng.unit() - 0.5) * 65_000.0);
        let checker = (at[0] / 3000.0).floor() + (at[1] / 3000.0).floor();
        (
            [at[0] as i16, at[1] as i16, 20_000],
            0,
            checker as i64 % 2 == 0,
        )
    };
    let level = if bright { 240 } else { 3 } + rng.below(13) as u8;
    WorldSample {
        place,
        rgb: [level, level / 2 + 20 * (object % 4), 255 - level],
        object,
        shares: Shares::default(),
    }
}

/// A display under load: samples at a steady rate, a refresh every 1/60 s.
pub(crate) struct Show {
    rng: Rng,
    size: u16,
    arrive: usize,
    time: u32,
    index: u32,
}

impl Show {
    /// Fills the display's buffer with a second's samples, as many as it holds, and shows the first
    /// refreshes, until what rests has settled ([`unframed_recon::rest::SETTLED`]).
    pub(crate) fn begin<A: Arith, W: Workers>(
        display: &mut Display<'_, A, W>,
        samples: usize,
        moving: bool,
    ) -> Self {
        let size = display.size().0;
        let mut show = Self {
            rng: Rng(1),
            size,
            arrive: samples / 60,
            time: 0,
            index: 0,
        };
        display.hello(&hello(size));
        for tile in tiles(size, moving, &mut show.rng) {
            display.tile(&tile);
        }
        show.pose(display);
        for _ in 0..66 {
            show.next(display, moving);
            display.refresh(&show.refresh());
        }
        show
    }

    fn pose<A: Arith, W: Workers>(&self, display: &mut Display<'_, A, W>) {
        let phase = f64::from(self.index) * 0.02;
        display.view(&view(self.size, (phase * 0.3).sin() * 0.3));
        for pose in poses(phase) {
            display.pose(&pose);
        }
    }

    /// What arrives before the next refresh.
    pub(crate) fn next<A: Arith, W: Workers>(
        &mut self,
        display: &mut Display<'_, A, W>,
        moving: bool,
    ) {
        for i in 0..self.arrive {
            let after = i as u64 * u64::from(REFRESH) / self.arrive as u64;
            let sample = sample(&mut self.rng);
            display.world_sample(
                Tick(self.time.wrapping_add(after as u32 / 1000 * 1000)),
                &sample,
            );
        }
        self.time = self.time.wrapping_add(REFRESH);
        self.index += 1;
        if moving {
            self.pose(display);
        }
    }

    /// The refresh that is due.
    pub(crate) fn refresh(&self) -> Refresh {
        Refresh {
            time: Tick(self.time),
            index: self.index,
        }
    }
}
