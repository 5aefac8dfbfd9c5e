//! The same algorithm in floating point: `f64` is the oracle, `f32` the comparison.
//!
//! Nothing of this decides the deployed picture; it may use library functions.

use crate::arith::{ANCHOR_BITS, Aligned, Arith, GUARD, Moments, Panel, REACH, Sums, Texel};
use crate::config::TimeKernel;
use crate::extents;
use crate::lanes::LANES;
use crate::taps::{self, PADDED, SPAN, Taps};
use crate::tiles::{CELL, Cell, TileMap};
use unframed_wire::{LogCode, Pose, View};

/// A view and a pose composed, in floating point: see [`crate::transform`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FloatTransform<F> {
    matrix: [[F; 3]; 3],
    offset: [F; 3],
}

impl FloatTransform<f64> {
    /// The unit that integers have for its numerators at most: 2^−29 of the largest entry or
    /// 2^−48 of the largest offset, see [`crate::transform::Transform::compose`].
    #[must_use]
    pub fn unit(&self) -> f64 {
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let (entry, offset) = (most(self.matrix.as_flattened()), most(&self.offset));
        (entry / f64::from(1 << 29)).max(offset / (1u64 << 48) as f64)
    }
}

macro_rules! float_arith {
    ($float:ty, $exp2:path, $log2:path, $exp:path, $floor:path, $table:literal) => {
        impl Arith for $float {
            type Coord = $float;
            type Depth = $float;
            type Weight = $float;
            type Mass = $float;
            type Log = $float;
            type Sum = $float;
            type Features = [$float; 15];
            type Factor = $float;
            type Row = $float;
            type Along = [$float; LANES];
            type Light = $float;
            type Confidence = $float;
            type Transform = FloatTransform<$float>;
            type Sight = [$float; 3];

            const FAR: $float = <$float>::INFINITY;

            fn compose(view: &View, pose: &Pose) -> Self::Transform {
                let view_unit = $exp2(-<$float>::from(view.frac_bits));
                let pose_unit = $exp2(-<$float>::from(pose.frac_bits));
                let row = |k: usize, j: usize| view.rows[k][j] as $float * view_unit;
                let matrix = core::array::from_fn(|k| {
                    core::array::from_fn(|i| {
                        (0..3)
                            .map(|j| row(k, j) * (pose.matrix[j][i] as $float * pose_unit))
                            .sum()
                    })
                });
                let offset = core::array::from_fn(|k| {
                    (0..3)
                        .map(|j| {
                            let d = i64::from(pose.translation[j]) - i64::from(view.eye[j]);
                            row(k, j) * d as $float
                        })
                        .sum()
                });
                FloatTransform { matrix, offset }
            }

            fn sight(
                transform: &Self::Transform,
                panel: &Panel,
                place: [i16; 3],
            ) -> ([$float; 3], bool) {
                let mut n = transform.offset;
                for (n, row) in n.iter_mut().zip(&transform.matrix) {
                    for (m, q) in row.iter().zip(place) {
                        *n += *m * <$float>::from(q);
                    }
                }
                let guard = GUARD as $float;
                let (x, y) = (n[0] / n[2] + guard, n[1] / n[2] + guard);
                let inside = n[2] > 0.0
                    && x >= 0.0
                    && y >= 0.0
                    && x < <$float>::from(panel.width) + 2.0 * guard
                    && y < <$float>::from(panel.height) + 2.0 * guard;
                ([x, y, n[2]], inside)
            }

            fn seen(_: &Panel, [x, y, w]: &[$float; 3]) -> ($float, $float, $float) {
                (*x, *y, $log2(*w))
            }

            fn from_sixteenths(_: &Panel, v: u16) -> $float {
                <$float>::from(v) / 16.0 + GUARD as $float
            }

            fn to_sixteenths(_: &Panel, v: $float) -> i32 {
                $floor((v - GUARD as $float) * 16.0) as i32
            }

            fn pixel(_: &Panel, v: $float) -> i32 {
                $floor(v) as i32 - GUARD
            }

            fn centre(_: &Panel, pixel: i32) -> $float {
                (pixel + GUARD) as $float + 0.5
            }

            fn behind(depth: $float, cell: u32) -> $float {
                depth
                    + $log2(match cell {
                        1 => 1.05,
                        2 => 1.1,
                        _ => 2.6,
                    })
            }

            fn nearer(depth: $float) -> $float {
                depth - $log2(1.03)
            }

            fn depth_of_log(q11: i32) -> $float {
                q11 as $float / 2048.0
            }

            fn lifetime(map: &TileMap<'_>, _: &Panel, x: $float, y: $float) -> $float {
                let (cells, fx, fy) = around(map, x as f64, y as f64);
                bilinear(&cells, fx, fy, Cell::weighed) as $float
            }

            fn log(q8: i16) -> $float {
                <$float>::from(q8) / 256.0
            }

            fn extents(
                map: &TileMap<'_>,
                _: &Panel,
                x: $float,
                y: $float,
            ) -> ($float, $float, $float) {
                let (cells, fx, fy) = around(map, x as f64, y as f64);
                let log = |of: fn(&Cell) -> LogCode| {
                    libm::round(bilinear(&cells, fx, fy, of) * 256.0) as i32
                };
                let (ex, ey, et) = extents::extents(
                    log(|cell| cell.gx),
                    log(|cell| cell.gy),
                    log(|cell| cell.gt),
                    log(|cell| cell.density),
                );
                let width = |extent| Self::width(extents::sigma_of_extent(extent));
                (et as $float / 256.0, width(ex), width(ey))
            }

            fn log_of_age(age: u32) -> $float {
                $log2(age as $float * 1e-6).max(-16.0)
            }

            fn decline(kernel: TimeKernel, cutoff: u16, age: $float, lifetime: $float) -> $float {
                let u = $exp2(age - lifetime);
                if u >= 16.0 {
                    return 0.0;
                }
                let square = u * u;
                let weight = match kernel {
                    TimeKernel::Rational => 1.0 / (1.0 + square + square * square),
                    TimeKernel::Gaussian => $exp(-0.5 * square),
                    TimeKernel::Exponential => $exp(-u),
                };
                (weight - <$float>::from(cutoff) / 32768.0).max(0.0)
            }

            fn counts(weight: $float) -> bool {
                // Half of the smallest fixed-point weight: the same samples take part.
                weight >= 0.5 / 32768.0
            }

            fn gather(mass: &mut $float, weight: $float) {
                *mass += weight;
            }

            fn add_mass(a: $float, b: $float) -> $float {
                a + b
            }

            fn width_of(mass: $float) -> $float {
                let mass = if mass < 1.0 / 32768.0 {
                    1.0 / 32768.0
                } else {
                    mass
                };
                let sigma = $log2(1.5) - 0.5 * $log2(mass);
                let end = |q11: i32| q11 as $float / 2048.0;
                sigma.clamp(end(taps::LEAST), end(taps::MOST))
            }

            fn width(q8: i32) -> $float {
                q8.clamp(-512, 512) as $float / 256.0
            }

            fn taps(_: &Panel, width: $float, v: $float) -> Taps<$float> {
                let from_middle = v - $floor(v) - 0.5;
                // The oracle interpolates between two levels of width as the table does; the
                // comparison takes the Gaussian itself.
                let above = (width * 2048.0 - taps::LEAST as $float) / 256.0;
                let levels = (taps::LEVELS - 1) as $float;
                let between = $table && above >= 0.0 && above < levels;
                let (sigma, wider, part) = if between {
                    let level = $floor(above);
                    let of =
                        |level: $float| $exp2((taps::LEAST as $float + level * 256.0) / 2048.0);
                    (of(level), of(level + 1.0), above - level)
                } else {
                    ($exp2(width), 0.0, 0.0)
                };
                let foot = $exp(-4.5);
                let tap = |d: $float, sigma: $float| {
                    if d < 3.0 * sigma && d < REACH as $float {
                        $exp(-0.5 * (d / sigma) * (d / sigma)) - foot
                    } else {
                        0.0
                    }
                };
                let mut taps = Taps {
                    weights: [0.0; PADDED],
                    first: REACH,
                    last: -REACH,
                };
                for (weight, pixel) in taps.weights[..SPAN].iter_mut().zip(-REACH..) {
                    let d = (from_middle - pixel as $float).abs();
                    *weight = (1.0 - part) * tap(d, sigma) + part * tap(d, wider);
                    if *weight > 0.0 {
                        taps.first = taps.first.min(pixel);
                        taps.last = pixel;
                    }
                }
                taps
            }

            fn times(a: $float, b: $float) -> $float {
                // Where integers have nothing, nothing: the same samples take part.
                let product = a * b;
                if Self::counts(product) { product } else { 0.0 }
            }

            fn light(v: u16) -> $float {
                <$float>::from(v)
            }

            fn features(
                _: &Panel,
                light: [$float; 3],
                at: ($float, $float),
                anchor: (i32, i32),
            ) -> [$float; 15] {
                let from = |v: $float, anchor: i32| v - (anchor << ANCHOR_BITS) as $float;
                let (x, y) = (from(at.0, anchor.0), from(at.1, anchor.1));
                let [r, g, b] = light;
                [
                    1.0,
                    r,
                    g,
                    b,
                    x,
                    y,
                    x * x,
                    x * y,
                    y * y,
                    x * r,
                    x * g,
                    x * b,
                    y * r,
                    y * g,
                    y * b,
                ]
            }

            fn factor(weight: $float) -> $float {
                weight
            }

            fn rows(weight: $float, down: &[$float; LANES]) -> [$float; LANES] {
                down.map(|tap| Self::times(weight, tap))
            }

            fn along(taps: &[$float; LANES]) -> [$float; LANES] {
                *taps
            }

            fn factors(row: $float, along: &[$float; LANES]) -> [$float; LANES] {
                along.map(|tap| Self::times(row, tap))
            }

            fn add(sums: &mut Sums<Self>, weight: $float, features: &[$float; 15]) {
                for (sum, feature) in sums.0.iter_mut().zip(features) {
                    *sum += weight * feature;
                }
            }

            fn add_moments(moments: &mut Moments<Self>, weight: $float, features: &[$float; 15]) {
                for (sum, feature) in moments.0.iter_mut().zip(&features[4..]) {
                    *sum += weight * feature;
                }
            }

            fn centred(
                sums: &Sums<Self>,
                moments: &Moments<Self>,
                pixel: (i32, i32),
            ) -> Moments<Self> {
                let centre = |pixel: i32| (pixel + GUARD) as $float + 0.5;
                let (cx, cy) = (centre(pixel.0), centre(pixel.1));
                let [w, r, g, b] = sums.0;
                let [x, y, xx, xy, yy, xr, xg, xb, yr, yg, yb, _] = moments.0;
                let (x1, y1) = (x - cx * w, y - cy * w);
                Aligned([
                    x1,
                    y1,
                    xx - cx * x - cx * x1,
                    xy - cx * y - cy * x1,
                    yy - cy * y - cy * y1,
                    xr - cx * r,
                    xg - cx * g,
                    xb - cx * b,
                    yr - cy * r,
                    yg - cy * g,
                    yb - cy * b,
                    0.0,
                ])
            }

            fn mean(sums: &Sums<Self>) -> Texel<Self> {
                let sums = sums.0;
                if sums[0] <= 0.0 {
                    return Texel::default();
                }
                Texel {
                    light: [1, 2, 3].map(|c| sums[c] / sums[0]),
                    confidence: (sums[0] / 0.3).min(1.0),
                }
            }

            fn plane(sums: &Sums<Self>, moments: &Moments<Self>) -> Texel<Self> {
                let sums = sums.0;
                if sums[0] <= 0.0 {
                    return Texel::default();
                }
                let least = crate::solve::RIDGE_Q20 as $float / 1048576.0;
                let lean = (1 << crate::solve::LEAN_BITS) as $float;
                let m = moments.0.map(|v| v / sums[0]);
                let c = [1, 2, 3].map(|k| sums[k] / sums[0]);
                let (x, y) = (m[0], m[1]);
                let ridge = least + (x * x + y * y) / lean;
                let (xx, xy, yy) = (m[2] - x * x + ridge, m[3] - x * y, m[4] - y * y + ridge);
                let determinant = xx * yy - xy * xy;
                let (hx, hy) = (
                    (yy * x - xy * y) / determinant,
                    (xx * y - xy * x) / determinant,
                );
                let light = [0, 1, 2].map(|k| {
                    let (cx, cy) = (m[5 + k] - c[k] * x, m[8 + k] - c[k] * y);
                    (c[k] - cx * hx - cy * hy).clamp(0.0, 65535.0)
                });
                Texel {
                    light,
                    confidence: (sums[0] / 0.3).min(1.0),
                }
            }

            fn pull(children: [Texel<Self>; 4]) -> Texel<Self> {
                let total: $float = children.iter().map(|t| t.confidence).sum();
                if total <= 0.0 {
                    return Texel::default();
                }
                let light = [0, 1, 2].map(|c| {
                    children
                        .iter()
                        .map(|t| t.light[c] * t.confidence)
                        .sum::<$float>()
                        / total
                });
                Texel {
                    light,
                    confidence: total.min(1.0),
                }
            }

            fn lacks(confidence: $float) -> bool {
                confidence < 1.0
            }

            fn push(fine: Texel<Self>, coarse: [Texel<Self>; 4]) -> Texel<Self> {
                let own = fine.confidence.min(1.0);
                let light = [0, 1, 2].map(|c| {
                    let around: $float = coarse
                        .iter()
                        .zip([9.0, 3.0, 3.0, 1.0])
                        .map(|(t, w)| t.light[c] * w)
                        .sum();
                    own * fine.light[c] + (1.0 - own) * around / 16.0
                });
                Texel {
                    light,
                    confidence: 1.0,
                }
            }

            fn to_u16(light: $float) -> u16 {
                (light + 0.5).clamp(0.0, 65535.0) as u16
            }
        }
    };
}

float_arith!(f64, libm::exp2, libm::log2, libm::exp, libm::floor, true);
float_arith!(
    f32,
    libm::exp2f,
    libm::log2f,
    libm::expf,
    libm::floorf,
    false
);

/// The four cells around a place and the way between their centres, 0..1.
fn around(map: &TileMap<'_>, x: f64, y: f64) -> ([Cell; 4], f64, f64) {
    let cell = CELL as f64;
    let (u, v) = (
        (x - f64::from(GUARD)) / cell - 0.5,
        (y - f64::from(GUARD)) / cell - 0.5,
    );
    let (column, row) = (libm::floor(u), libm::floor(v));
    (map.around(column as i32, row as i32), u - column, v - row)
}

/// A tile quantity, bilinear in the log2 domain.
fn bilinear(cells: &[Cell; 4], fx: f64, fy: f64, of: impl Fn(&Cell) -> LogCode) -> f64 {
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| f64::from(of(&cells[i]).log2_q8()) / 256.0);
    (a * (1.0 - fx) + b * fx) * (1.0 - fy) + (c * (1.0 - fx) + d * fx) * fy
}
