//! The reconstructor of Dayal et al. 2005 as a gather (§5.2), in f64, pixel by pixel: the reference
//! of `Config::PAPER`. It shares no code with the crate: projection from the stream's words,
//! extents by the paper's cube roots, Gaussians by their formula, sums over all samples.

use unframed_recon::heap::HeapStorage;
use unframed_recon::{Arith, Config, Display, Fixed};
use unframed_wire::{
    ColourEncoding, Hello, Layout, LogCode, Pose, Rect, Refresh, Shares, Tick, Tile, TileFields,
    View, WorldFrame, WorldSample,
};

const SIZE: u16 = 48;
/// Side of the tile map's cells, pixels.
const CELL: u16 = 4;
/// Samples, 10 µs apart.
const SAMPLES: u32 = 24_000;

/// Splitmix64.
struct Rng(u64);

impl Rng {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn code(&mut self, low: f64, high: f64) -> LogCode {
        LogCode((low + (high - low) * self.unit()) as u8)
    }
}

/// A picture's ingredients.
struct Scene {
    view: View,
    pose: Pose,
    /// One a cell, row by row.
    tiles: Vec<Tile>,
    samples: Vec<(Tick, WorldSample)>,
    now: Tick,
}

impl Scene {
    /// A wall that is looked at askew.
    fn new(seed: u64) -> Self {
        let mut rng = Rng(seed);
        let (half, focal) = (f64::from(SIZE) / 2.0, 1.1 * f64::from(SIZE));
        let (s, c) = (0.3 * rng.unit()).sin_cos();
        let q = |v: f64| (v * f64::from(1 << 20)).round() as i32;
        let (right, forward) = ([c, 0.0, -s], [s, 0.0, c]);
        let row = |axis: [f64; 3]| [0, 1, 2].map(|j| q(focal * axis[j] + half * forward[j]));
        let view = View {
            time: Tick(0),
            eye: [0, 0, -24_000],
            rows: [row(right), row([0.0, 1.0, 0.0]), forward.map(q)],
            frac_bits: 20,
        };
        let one = 1 << 20;
        let pose = Pose {
            object: 0,
            matrix: [[one, 0, 0], [0, one, 0], [0, 0, one]],
            frac_bits: 20,
            translation: [0; 3],
        };
        let mut tiles = Vec::new();
        for y in (0..SIZE).step_by(CELL.into()) {
            for x in (0..SIZE).step_by(CELL.into()) {
                let rect = Rect {
                    x,
                    y,
                    w: CELL,
                    h: CELL,
                };
                tiles.push(Tile {
                    rect,
                    // Slopes of 2^−6 to 2^−2 a pixel, 2^−4 to 2^2 a second; 2^2 to 2^7 samples.
                    gx: rng.code(80.0, 112.0),
                    gy: rng.code(80.0, 112.0),
                    gt: rng.code(96.0, 144.0),
                    lifetime: LogCode(128),
                    density: rng.code(144.0, 184.0),
                });
            }
        }
        let samples = (0..SAMPLES).map(|i| {
            let [x, y] = [0; 2].map(|_| ((rng.unit() - 0.5) * 30_000.0) as i16);
            let odd = (x.div_euclid(2500) + y.div_euclid(2500)) % 2 != 0;
            let level = if odd { 210.0 } else { 40.0 } + 20.0 * rng.unit();
            let sample = WorldSample {
                place: [x, y, 0],
                rgb: [level as u8, (0.7 * level) as u8, 250 - level as u8],
                object: 0,
                shares: Shares::default(),
            };
            (Tick(10 * i), sample)
        });
        Self {
            view,
            pose,
            tiles,
            samples: samples.collect(),
            now: Tick(10 * SAMPLES),
        }
    }

    /// What the display makes of it.
    fn shown<A: Arith>(&self, config: Config) -> Vec<[u8; 3]> {
        let mut storage = HeapStorage::<A>::new(SIZE, SIZE, SAMPLES as usize);
        let mut display = Display::new(config, SIZE, SIZE, storage.memory()).expect("it fits");
        display.hello(&Hello {
            width: SIZE,
            height: SIZE,
            layout: Layout::World,
            objects: true,
            tile_fields: TileFields {
                gradients: true,
                lifetime: false,
                density: true,
            },
            encoding: ColourEncoding::Srgb8,
            rate: 100_000,
            refresh_millihertz: 60_000,
            world: WorldFrame {
                origin: [0.0; 3],
                unit: 0.001,
            },
            lamps: 0,
        });
        display.view(&self.view);
        display.pose(&self.pose);
        self.tiles.iter().for_each(|tile| display.tile(tile));
        for (time, sample) in &self.samples {
            display.world_sample(*time, sample);
        }
        display.refresh(&Refresh {
            time: self.now,
            index: 0,
        });
        display.picture().to_vec()
    }

    /// Where a sample is seen, pixels.
    fn project(&self, place: [i16; 3]) -> [f64; 2] {
        let unit = |bits: u8| f64::from(bits).exp2().recip();
        let world: [f64; 3] = [0, 1, 2].map(|k| {
            let sum: f64 = (0..3)
                .map(|j| f64::from(self.pose.matrix[k][j]) * f64::from(place[j]))
                .sum();
            sum * unit(self.pose.frac_bits) + f64::from(self.pose.translation[k])
        });
        let seen: [f64; 3] = [0, 1, 2].map(|k| {
            (0..3)
                .map(|j| f64::from(self.view.rows[k][j]) * (world[j] - f64::from(self.view.eye[j])))
                .sum()
        });
        [seen[0] / seen[2], seen[1] / seen[2]]
    }

    /// A tile quantity at a place: bilinear between the cells' centres in the log domain.
    fn quantity(&self, at: [f64; 2], of: impl Fn(&Tile) -> LogCode) -> f64 {
        let side = i64::from(SIZE / CELL);
        let [u, v] = at.map(|a| a / f64::from(CELL) - 0.5);
        let log = |x: f64, y: f64| {
            let [x, y] = [x, y].map(|c| (c as i64).clamp(0, side - 1));
            (f64::from(of(&self.tiles[(y * side + x) as usize]).0) - 128.0) / 8.0
        };
        let (x, y) = (u.floor(), v.floor());
        let row = |y: f64| log(x, y) * (1.0 - (u - x)) + log(x + 1.0, y) * (u - x);
        (row(y) * (1.0 - (v - y)) + row(y + 1.0) * (v - y)).exp2()
    }

    /// e_x, e_y (pixels) and e_t (seconds) at a place: the cube roots of §5.1, each clamp giving
    /// the rest of the volume to the others.
    fn extents(&self, at: [f64; 2]) -> [f64; 3] {
        let gx = self.quantity(at, |t| t.gx).max(0.004);
        let gy = self.quantity(at, |t| t.gy).max(0.004);
        let gt = self.quantity(at, |t| t.gt).max(0.02);
        let volume = 1.0 / self.quantity(at, |t| t.density);
        let et = (volume * gx * gy / (gt * gt)).cbrt().clamp(0.01, 1.0);
        let area = volume / et;
        let clamp = |e: f64| e.clamp(0.35, 3.0);
        let ey = clamp(area / clamp((area * gy / gx).sqrt()));
        [clamp(area / ey), ey, et]
    }

    /// The picture by gathering, sRGB levels; `None` where the weights sum up to less than three
    /// samples: there a tap where a wide footprint is cut off at 4 px makes levels of difference,
    /// and whether it is in or out is decided by the last bit of its place.
    fn gathered(&self) -> Vec<Option<[f64; 3]>> {
        let seen: Vec<_> = self
            .samples
            .iter()
            .map(|(time, sample)| {
                let at = self.project(sample.place);
                let [ex, ey, et] = self.extents(at);
                let u = f64::from(self.now.since(*time)) * 1e-6 / et;
                let light = sample.rgb.map(to_linear);
                // No display's filter is narrower.
                let sigma = [ex, ey].map(|e| (0.65 * e).max(0.25));
                (at, sigma, (-0.5 * u * u).exp(), light)
            })
            .collect();
        let pixel = |x: u16, y: u16| {
            let centre = [x, y].map(|c| f64::from(c) + 0.5);
            let (mut weight, mut sum) = (0.0, [0.0; 3]);
            for (at, sigma, tail, light) in &seen {
                let d = [0, 1].map(|k| (at[k] - centre[k]) / sigma[k]);
                let near = |k: usize| d[k].abs() < 3.0 && (at[k] - centre[k]).abs() < 4.0;
                if near(0) && near(1) {
                    // Each axis ends in zero.
                    let tap = d.map(|d| (-0.5 * d * d).exp() - (-4.5f64).exp());
                    let w = tail * tap[0] * tap[1];
                    weight += w;
                    sum.iter_mut().zip(light).for_each(|(s, l)| *s += w * l);
                }
            }
            (weight > 3.0).then(|| sum.map(|s| to_srgb(s / weight)))
        };
        (0..SIZE)
            .flat_map(|y| (0..SIZE).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect()
    }
}

fn to_linear(level: u8) -> f64 {
    let v = f64::from(level) / 255.0;
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

fn to_srgb(light: f64) -> f64 {
    255.0
        * if light <= 0.003_130_8 {
            12.92 * light
        } else {
            1.055 * light.powf(1.0 / 2.4) - 0.055
        }
}

/// Root mean square and 99th percentile of the differences.
fn difference(gathered: &[Option<[f64; 3]>], shown: &[[u8; 3]]) -> [f64; 2] {
    let mut all: Vec<f64> = gathered
        .iter()
        .zip(shown)
        .filter_map(|(exact, got)| exact.map(|exact| (exact, got)))
        .flat_map(|(exact, got)| [0, 1, 2].map(|c| (exact[c] - f64::from(got[c])).abs()))
        .collect();
    assert!(all.len() > 3 * 1000, "{} of 2304 pixels", all.len() / 3);
    all.sort_by(f64::total_cmp);
    let square = all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64;
    [square.sqrt(), all[all.len() * 99 / 100]]
}

#[test]
fn scatter_shows_what_a_gather_would() {
    let config = Config {
        fill: false,
        ..Config::PAPER
    };
    for seed in 0..2 {
        let scene = Scene::new(seed);
        let gathered = scene.gathered();
        // Rounding to a level is 0.29; extents and widths have 8 bits after the point.
        let [rms, most] = difference(&gathered, &scene.shown::<f64>(config));
        println!("f64 {rms:.3} {most:.3}");
        assert!(rms < 0.4 && most < 1.0, "f64: {rms} {most}");
        let [rms, most] = difference(&gathered, &scene.shown::<Fixed>(config));
        println!("fixed {rms:.3} {most:.3}");
        assert!(rms < 0.5 && most < 1.5, "fixed: {rms} {most}");
    }
}

#[test]
fn the_comparison_can_fail() {
    let scene = Scene::new(0);
    let other = Config {
        fill: false,
        kernel: unframed_recon::config::TimeKernel::Exponential,
        ..Config::PAPER
    };
    let [rms, _] = difference(&scene.gathered(), &scene.shown::<f64>(other));
    assert!(rms > 1.0, "{rms}");
}
