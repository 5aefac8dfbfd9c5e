//! Any bytes as a stream, shown in both arithmetics: the body of the fuzz target `oracle`, which
//! includes this file, and of a test over seeded bytes.
//!
//! Bytes choose the display and then one thing after another that a stream can say, each within
//! what the wire can carry: cameras and views that no camera has, poses that scale and shear,
//! places from a point to all of the lattice, clocks that jump. (Bytes that are no packets are for
//! the fuzz target `receiver`.)

use crate::accuracy::{Accuracy, CLOSE_BORDER, Setting, compare};
use crate::stream::{DEPTH, Rng, Stream, flat, pose, tile};
use unframed_recon::config::{Config, Extents, Fit, NAMED};
use unframed_wire::{
    LAMPS, Lamp, LampKind, Layout, LogCode, Pose, SKY, ScreenSample, Shares, Tick, View,
    WorldSample,
};

/// Panels: of 7 and of 6 fractional bits, odd, of one row, of one pixel.
const SIZES: [(u16, u16); 5] = [(24, 24), (33, 17), (64, 5), (500, 3), (1, 1)];
/// Samples a stream may hold: what a run may cost.
const MOST: usize = 20_000;

/// Bytes taken one by one; zeros after the last.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (byte, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *byte
    }

    fn below(&mut self, end: u8) -> u8 {
        self.byte() % end
    }

    /// Small as often as large: 32 bits shifted right by at least `by`.
    fn int(&mut self, by: u8) -> i32 {
        let v = i32::from_le_bytes([(); 4].map(|()| self.byte()));
        v >> (by + self.below(32 - by))
    }
}

/// The stream and the display that bytes ask for.
#[must_use]
pub fn stream(data: &[u8]) -> (Vec<u8>, Setting) {
    let mut data = Bytes(data);
    let mut config = NAMED[usize::from(data.below(4))].1;
    config.hidden ^= data.below(4) == 0;
    if data.below(4) == 0 {
        config.extents = match data.byte() {
            width if width % 4 == 0 => Extents::Pixel,
            width => Extents::Constant(i16::from(width) * 4 - 512),
        };
    }
    let size = SIZES[usize::from(data.below(5))];
    let setting = Setting {
        config,
        size,
        samples: 256 << data.below(5),
    };
    let on_screen = data.below(8) == 0;
    let mut stream = if on_screen {
        Stream::new(size, Layout::Screen, 1000)
    } else {
        Stream::of_the_plane_lit(size, LAMPS as u8)
    };
    let (mut now, mut sent) = (0, 0);
    while !data.0.is_empty() && sent < MOST {
        let what = data.byte();
        if !on_screen {
            // Of the same bytes as what comes next, which so stays what it would be without.
            let ahead = &mut Bytes(data.0);
            match what / 10 {
                0..3 => stream.lamps(now, &[(); LAMPS].map(|()| lamp(ahead))),
                3..6 => {
                    let (object, part) = (1 + ahead.below(2), ahead.below(4));
                    stream.shape(object, part, &shape(ahead));
                }
                _ => {}
            }
        }
        match what % 10 {
            0 => stream.look(&view(&mut data, now, size)),
            1 if !on_screen => stream.poses(now, &[any_pose(&mut data)]),
            2 => {
                let (leaf, base, spread) = (data.byte(), data.byte(), data.below(4) + 1);
                let mut rng = Rng(u64::from(data.byte()));
                let mut code = || base.saturating_add(rng.range(0, i64::from(spread)) as u8);
                let density = LogCode(code());
                stream.tiles(now, u32::from(leaf) + 1, |rect| unframed_wire::Tile {
                    density,
                    ..tile(rect, [(); 4].map(|()| code()))
                });
            }
            3 => now = now.wrapping_add(data.int(1).unsigned_abs()),
            4 | 5 => {
                now = now.wrapping_add(u32::from(data.byte()) << 7);
                stream.refresh(now);
            }
            6 if data.below(8) == 0 => stream.cut(now),
            _ if on_screen => {
                let samples = screen_samples(&mut data, size);
                stream.screen(now, &samples);
                sent += samples.len();
            }
            _ => {
                let samples = samples(&mut data);
                let age = u32::from(data.byte()) << data.below(16);
                stream.world(now.wrapping_sub(age), &samples);
                sent += samples.len();
            }
        }
    }
    stream.refresh(now);
    (stream.bytes, setting)
}

/// Samples of one object: a cloud of places.
fn samples(data: &mut Bytes<'_>) -> Vec<WorldSample> {
    let object = [0, 0, 0, 1, 2, SKY][usize::from(data.below(6))];
    let (count, by) = (data.byte(), data.below(16));
    let centre = [(); 3].map(|()| data.int(16) as i16);
    let mut rng = Rng(u64::from(data.byte()) << 8 | u64::from(data.byte()));
    (0..=count)
        .map(|_| {
            let bits = rng.bits().to_le_bytes();
            let away = |k: usize| i16::from_le_bytes([bits[2 * k], bits[2 * k + 1]]) >> by;
            let colour = rng.bits().to_le_bytes();
            WorldSample {
                place: [0, 1, 2].map(|k| centre[k].wrapping_add(away(k))),
                rgb: [colour[0], colour[1], colour[2]],
                object,
                shares: Shares(colour[3]),
            }
        })
        .collect()
}

/// A lamp near the plane or anywhere, or any direction.
fn lamp(data: &mut Bytes<'_>) -> Lamp {
    let (kind, by) = match data.below(3) {
        0 => (LampKind::Directional, 1),
        1 => (LampKind::Point, 2),
        _ => (LampKind::Point, 12),
    };
    let place = [(); 3].map(|()| data.int(by).max(1 - (1 << 29)));
    Lamp {
        kind,
        place: if place == [0; 3] { [0, 0, 1] } else { place },
        tint: [(); 2].map(|()| 1 + u16::from(data.byte())),
    }
}

/// Corners of triangles about a place.
fn shape(data: &mut Bytes<'_>) -> Vec<[i16; 3]> {
    let (count, by) = (1 + data.below(20), data.below(16));
    let centre = [(); 3].map(|()| data.int(16) as i16);
    let mut rng = Rng(u64::from(data.byte()));
    (0..3 * count)
        .map(|_| {
            let bits = rng.bits().to_le_bytes();
            let away = |k: usize| i16::from_le_bytes([bits[2 * k], bits[2 * k + 1]]) >> by;
            [0, 1, 2].map(|k| centre[k].wrapping_add(away(k)))
        })
        .collect()
}

/// Samples on the screen.
fn screen_samples(data: &mut Bytes<'_>, size: (u16, u16)) -> Vec<ScreenSample> {
    let (count, mut rng) = (data.byte(), Rng(data.byte().into()));
    let mut below = |pixels: u16| rng.range(0, 16 * i64::from(pixels)) as u16;
    (0..=count)
        .map(|_| ScreenSample {
            x: below(size.0),
            y: below(size.1),
            rgb: [(); 3].map(|()| below(16) as u8),
        })
        .collect()
}

/// A camera before the plane, or any nine numbers.
fn view(data: &mut Bytes<'_>, now: u32, size: (u16, u16)) -> View {
    let eye = [(); 3].map(|()| data.int(2));
    match data.below(3) {
        0 => View {
            time: Tick(now),
            eye,
            rows: [(); 3].map(|()| [(); 3].map(|()| data.int(1))),
            frac_bits: data.below(31),
        },
        1 => View {
            eye: [eye[0] >> 18, eye[1] >> 18, -DEPTH + (eye[2] >> 16)],
            ..flat(now, size)
        },
        _ => {
            // Turned about the vertical axis; the panel's centre stays in the middle.
            let focal = f64::from(1 << data.below(11));
            let (sin, cos) = (f64::from(data.byte()) / 256.0 * std::f64::consts::TAU).sin_cos();
            let q = |v: f64| (v * f64::from(1 << 18)).round() as i32;
            let half = |pixels: u16| f64::from(pixels) / 2.0;
            let row = |axis: [f64; 3], centre: f64| {
                let forward = [sin, 0.0, cos];
                [0, 1, 2].map(|k| q(focal * axis[k] + centre * forward[k]))
            };
            View {
                time: Tick(now),
                eye,
                rows: [
                    row([cos, 0.0, -sin], half(size.0)),
                    row([0.0, 1.0, 0.0], half(size.1)),
                    [q(sin), 0, q(cos)],
                ],
                frac_bits: 18,
            }
        }
    }
}

/// An object moved and scaled, or sheared as no object is.
fn any_pose(data: &mut Bytes<'_>) -> Pose {
    let object = [0, 1, 2, SKY][usize::from(data.below(4))];
    let translation = [(); 3].map(|()| data.int(2));
    if data.below(2) == 0 {
        Pose {
            object,
            matrix: [(); 3].map(|()| [(); 3].map(|()| data.int(1))),
            frac_bits: data.below(32),
            translation,
        }
    } else {
        let scale = (f64::from(data.below(128)) / 16.0 - 4.0).exp2();
        pose(object, scale, translation.map(|v| v >> 14))
    }
}

/// Whether all filters end in zero: those wider than 4/3 px end in a step where a footprint ends.
fn ends_in_zero(config: &Config) -> bool {
    match config.extents {
        Extents::Density | Extents::Pixel => true,
        Extents::Constant(log) => log <= 106,
        Extents::Gradient => false,
    }
}

/// Shows the stream of `data` in both arithmetics.
///
/// # Panics
/// When they differ by more than rounding explains: an unexplained flip; half a step of a coordinate
/// and the quotient's error; 1.25/2048 octave of depth; 3 % of the brightest light where no flip
/// reaches, a whole sample's weight is known and filters end in zero, or 15 % where planes are
/// fitted, which enlarge half a step.
#[must_use]
pub fn check(data: &[u8]) -> Accuracy {
    let (bytes, setting) = stream(data);
    let found = compare(&bytes, &setting);
    let (flips, errors, config) = (&found.flips, &found.errors, &setting.config);
    assert_eq!(flips.unexplained, 0, "{setting:?}: {flips:?} {errors:?}");
    let most = match config.fit {
        Fit::Constant => 0.03,
        Fit::Linear => 0.15,
    };
    let near = errors.place <= 0.5 + CLOSE_BORDER && errors.depth <= 1.25;
    assert!(near, "{setting:?}: {errors:?}");
    let alike = errors.light <= most || !ends_in_zero(config);
    assert!(alike, "{setting:?}: {errors:?}");
    found
}
