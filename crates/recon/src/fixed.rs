//! The deployed arithmetic: integers alone. Formats and bounds are in `docs/NUMERICS.md`.

use crate::arith::{ANCHOR_BITS, Aligned, Arith, GUARD, Moments, Panel, Sums, Texel};
use crate::config::TimeKernel;
use crate::extents;
use crate::glance::Seen;
use crate::lanes::{self, Along, Factor, LANES, Pair, Pixel, Row};
use crate::num::{Divider, log2_q11};
use crate::sight::{DEPTH_FIRST, Sight};
use crate::solve::LEAN_BITS;
use crate::tables::{TIME, TIME_FIRST, TIME_LEN};
use crate::taps::{self, DISTANCE_BITS, Taps};
use crate::tiles::{CELL, CELL_BITS, Cell, TileMap};
use crate::transform::Transform;
use unframed_wire::{LogCode, Pose, View};

/// Fixed point: coordinates with [`Panel::frac_bits`], depths as log2 with 11, weights and
/// confidences with 15 fractional bits, light with 16 bits, sums with 64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fixed;

/// One, with 15 fractional bits.
const ONE: u32 = 1 << 15;
/// log2 of 10^6 with 11 fractional bits: microseconds in a second.
const LOG2_MICROS: i32 = 40820;
/// Weight at which a pixel is known well enough: 0.3.
const ENOUGH: u64 = 9830;
/// The most that one pixel's mass counts: 64 samples, where σ is at its least anyway.
const MASS_LIMIT: u32 = 64 << 15;
/// The least ridge on the plane's slopes, px² with 20 fractional bits, see [`crate::solve`].
const RIDGE: i64 = crate::solve::RIDGE_Q20;

/// The pixel of the panel in which a lattice point is seen, exactly. Seldom called.
#[inline(never)]
fn look(transform: &Transform, panel: &Panel, place: [i16; 3]) -> Option<usize> {
    let (x, y, _) = Fixed::project(transform, panel, place)?;
    Fixed::within(panel, x, y)
}

/// A coordinate's place in distance units from the guard's edge: the middle of its step.
#[inline]
fn middle(panel: &Panel, v: u16) -> i32 {
    (2 * i32::from(v) + 1) << (DISTANCE_BITS - 1 - u32::from(panel.frac_bits))
}

/// Where a coordinate lies between the centres of `cells` cells, beyond the outermost as on them:
/// the cell before, and the way to the next in 1/512.
#[inline]
fn between_cells(panel: &Panel, cells: usize, v: u16) -> (usize, i32) {
    let bits = u32::from(panel.frac_bits);
    let from_centre = i32::from(v) - ((GUARD + (1 << CELL_BITS >> 1)) << bits);
    let last = (cells as i32 - 1) << (bits + CELL_BITS);
    let from_centre = from_centre.min(last).max(0);
    let rest = from_centre & ((1 << (bits + CELL_BITS)) - 1);
    let cell = from_centre >> (bits + CELL_BITS);
    (cell as usize, rest << (9 - bits - CELL_BITS))
}

/// A tile quantity, bilinear between cells: log2 with 11 fractional bits.
#[inline]
fn bilinear(cells: &[Cell; 4], fx: i32, fy: i32, of: impl Fn(&Cell) -> LogCode) -> i32 {
    let code = |i: usize| i32::from(of(&cells[i]).0);
    let (a, b, c, d) = (code(0), code(1), code(2), code(3));
    let top = (a << 9) + (b - a) * fx;
    let bottom = (c << 9) + (d - c) * fx;
    // Below 2^8, times 2^18; a code is an eighth of an octave, and 128 is 1.
    (((top << 9) + (bottom - top) * fy + (1 << 9)) >> 10) - (128 << 8)
}

/// The cells around a place, and the way from the first to the others in 1/512.
#[inline]
fn cells_around(map: &TileMap<'_>, panel: &Panel, x: u16, y: u16) -> ([Cell; 4], i32, i32) {
    let (columns, rows) = map.size();
    let (column, fx) = between_cells(panel, columns, x);
    let (row, fy) = between_cells(panel, rows, y);
    (map.corner(column, row), fx, fy)
}

impl Arith for Fixed {
    type Coord = u16;
    type Depth = u16;
    type Weight = u16;
    type Mass = u32;
    type Log = i16;
    type Sum = i64;
    type Features = [Pair; 8];
    type Factor = Factor;
    type Row = Row;
    type Along = Along;
    type Light = u16;
    type Confidence = u16;
    type Transform = Transform;
    type Sight = Sight;

    const FAR: u16 = u16::MAX;

    fn compose(view: &View, pose: &Pose) -> Transform {
        Transform::compose(view, pose)
    }

    #[inline(always)]
    fn sight(transform: &Transform, panel: &Panel, place: [i16; 3]) -> (Sight, bool) {
        Sight::of(transform, panel, place)
    }

    #[inline(always)]
    fn seen(panel: &Panel, sight: &Sight) -> (u16, u16, u16) {
        sight.place(panel)
    }

    #[inline]
    fn falls(transform: &Transform, panel: &Panel, place: [i16; 3]) -> Option<usize> {
        match transform.glance.at(panel, place) {
            Seen::At(column, row) => {
                Some(row as usize * usize::from(panel.width) + column as usize)
            }
            Seen::Outside => None,
            Seen::Unsure => look(transform, panel, place),
        }
    }

    #[inline]
    fn from_sixteenths(panel: &Panel, v: u16) -> u16 {
        let v = u32::from(v) + ((GUARD as u32) << 4);
        ((v << panel.frac_bits) >> 4).min(u32::from(u16::MAX)) as u16
    }

    fn to_sixteenths(panel: &Panel, v: u16) -> i32 {
        ((i32::from(v) << 4) >> panel.frac_bits) - (GUARD << 4)
    }

    #[inline(always)]
    fn pixel(panel: &Panel, v: u16) -> i32 {
        i32::from(v >> panel.frac_bits) - GUARD
    }

    #[inline]
    fn nearest(panel: &Panel, x: u16, y: u16) -> Pixel {
        let last = [panel.width, panel.height].map(|size| size.saturating_sub(1));
        Pixel::of([x, y], panel.frac_bits.into()).less(GUARD as u16, last)
    }

    #[inline]
    fn centre(panel: &Panel, pixel: i32) -> u16 {
        (((2 * (pixel + GUARD) + 1) << panel.frac_bits) >> 1) as u16
    }

    #[inline]
    fn behind(depth: u16, cell: u32) -> u16 {
        // log2(1.05), log2(1.1), log2(2.6) with 11 fractional bits.
        depth.saturating_add(match cell {
            1 => 144,
            2 => 282,
            _ => 2823,
        })
    }

    #[inline]
    fn nearer(depth: u16) -> u16 {
        // log2(1.03) with 11 fractional bits.
        depth.saturating_sub(87)
    }

    fn depth_of_log(q11: i32) -> u16 {
        q11.saturating_sub(DEPTH_FIRST * 2048).clamp(0, 65534) as u16
    }

    #[inline]
    fn lifetime(map: &TileMap<'_>, panel: &Panel, x: u16, y: u16) -> i16 {
        let (cells, fx, fy) = cells_around(map, panel, x, y);
        // From 2^−16 s to a second.
        bilinear(&cells, fx, fy, Cell::weighed) as i16
    }

    fn lifetimes(map: &TileMap<'_>, panel: &Panel, row: usize, out: &mut [i16]) {
        const HALF: usize = CELL / 2;
        let (_, rows) = map.size();
        let (cell, fy) = between_cells(panel, rows, Self::centre(panel, row as i32));
        // As `bilinear` has it, across before along: nothing is rounded in between.
        let across = |column: usize| {
            let code = |row: usize| i32::from(map.at(column as i32, row as i32).weighed().0);
            let (a, b) = (code(cell), code(cell + 1));
            (a << 9) + (b - a) * fy
        };
        let along = |a: i32, b: i32, f: i32| {
            ((((a << 9) + (b - a) * f + (1 << 9)) >> 10) - (128 << 8)) as i16
        };
        // The first cell's centre lies half a cell from the border.
        let mut left = across(0);
        let border = HALF.min(out.len());
        let (border, inner) = out.split_at_mut_checked(border).unwrap_or_default();
        border.fill(along(left, left, 0));
        for (column, pixels) in (1..).zip(inner.chunks_mut(CELL)) {
            let right = across(column);
            for (pixel, out) in (0..).zip(pixels) {
                *out = along(left, right, (2 * pixel + 1) << (8 - CELL_BITS));
            }
            left = right;
        }
    }

    fn log(q8: i16) -> i16 {
        q8.saturating_mul(8)
    }

    #[inline]
    fn extents(map: &TileMap<'_>, panel: &Panel, x: u16, y: u16) -> (i16, i16, i16) {
        let (cells, fx, fy) = cells_around(map, panel, x, y);
        let log = |of: fn(&Cell) -> LogCode| (bilinear(&cells, fx, fy, of) + 4) >> 3;
        let (ex, ey, et) = extents::extents(
            log(|cell| cell.gx),
            log(|cell| cell.gy),
            log(|cell| cell.gt),
            log(|cell| cell.density),
        );
        let width = |extent| Self::width(extents::sigma_of_extent(extent));
        ((et << 3) as i16, width(ex), width(ey))
    }

    #[inline]
    fn log_of_age(age: u32) -> i16 {
        (log2_q11(u64::from(age)) - LOG2_MICROS).max(i16::MIN.into()) as i16
    }

    #[inline(always)]
    fn decline(kernel: TimeKernel, cutoff: u16, age: i16, lifetime: i16) -> u16 {
        let table = &TIME[kernel as usize];
        let u = i32::from(age) - 8 * TIME_FIRST - i32::from(lifetime);
        let u = u.max(0) as usize;
        // Chosen afterwards: many samples of a busy tile are beyond the table, in no order.
        let last = TIME_LEN - 2;
        let at = (u >> 3).min(last);
        let (a, b) = (table[at], table[at + 1]);
        // Declining: a ≥ b.
        let weight = a - (((a - b) * (u & 7) as u16 + 4) >> 3);
        if u >> 3 > last {
            0
        } else {
            weight.saturating_sub(cutoff)
        }
    }

    #[inline]
    fn counts(weight: u16) -> bool {
        weight != 0
    }

    #[inline]
    fn gather(mass: &mut u32, weight: u16) {
        *mass = (*mass + u32::from(weight)).min(MASS_LIMIT);
    }

    #[inline]
    fn add_mass(a: u32, b: u32) -> u32 {
        a + b
    }

    #[inline]
    fn width_of(mass: u32) -> i16 {
        // log2(0.5 · 3) is 1198; a mass has 15 fractional bits.
        let sigma = 1198 - ((log2_q11(u64::from(mass.max(1))) - 15 * 2048) >> 1);
        sigma.clamp(taps::LEAST, taps::MOST) as i16
    }

    fn width(q8: i32) -> i16 {
        (q8.clamp(-512, 512) << 3) as i16
    }

    #[inline]
    fn taps(panel: &Panel, width: i16, v: u16) -> Taps<u16> {
        let bits = u32::from(panel.frac_bits);
        taps::taps(width, u32::from(v) & ((1 << bits) - 1), bits)
    }

    #[inline]
    fn times(a: u16, b: u16) -> u16 {
        ((u32::from(a) * u32::from(b) + (ONE >> 1)) >> 15) as u16
    }

    #[inline]
    fn light(v: u16) -> u16 {
        v
    }

    #[inline]
    fn features(panel: &Panel, light: [u16; 3], at: (u16, u16), anchor: (i32, i32)) -> [Pair; 8] {
        // The square and a guard on both sides: below 2^16, products below 2^32.
        let from =
            |v, anchor| (middle(panel, v) - (anchor << (ANCHOR_BITS + DISTANCE_BITS))) as u32;
        let (x, y) = (from(at.0, anchor.0), from(at.1, anchor.1));
        let [r, g, b] = light.map(u32::from);
        let times = u32::wrapping_mul;
        [
            Pair::new(1, r),
            Pair::new(g, b),
            Pair::new(x, y),
            Pair::new(times(x, x), times(x, y)),
            Pair::new(times(y, y), times(x, r)),
            Pair::new(times(x, g), times(x, b)),
            Pair::new(times(y, r), times(y, g)),
            Pair::new(times(y, b), 0),
        ]
    }

    #[inline]
    fn factor(weight: u16) -> Factor {
        Factor::new(weight)
    }

    #[inline]
    fn rows(weight: u16, down: &[u16; LANES]) -> [Row; LANES] {
        lanes::rows(weight, down)
    }

    #[inline]
    fn along(taps: &[u16; LANES]) -> Along {
        Along::new(taps)
    }

    #[inline]
    fn factors(row: Row, along: &Along) -> [Factor; LANES] {
        along.factors(row)
    }

    #[inline]
    fn add(sums: &mut Sums<Self>, weight: Factor, features: &[Pair; 8]) {
        // A share of light is below 2^31: 2^32 samples on one pixel would fit.
        for (sums, pair) in sums.0.as_chunks_mut().0.iter_mut().zip(&features[..2]) {
            pair.add_to(weight, sums);
        }
    }

    #[inline]
    fn add_moments(moments: &mut Moments<Self>, weight: Factor, features: &[Pair; 8]) {
        // Moments about the anchor may wrap; what `centred` makes of them fits again.
        for (sums, pair) in moments.0.as_chunks_mut().0.iter_mut().zip(&features[2..]) {
            pair.add_to(weight, sums);
        }
    }

    #[inline]
    fn centred(sums: &Sums<Self>, moments: &Moments<Self>, pixel: (i32, i32)) -> Moments<Self> {
        // Anchors lie a guard before their square: see `middle`.
        let centre =
            |pixel: i32| i64::from(((pixel + GUARD) << DISTANCE_BITS) + (1 << (DISTANCE_BITS - 1)));
        let (cx, cy) = (centre(pixel.0), centre(pixel.1));
        // a − c·b, modulo 2^64.
        let less = |a: i64, c: i64, b: i64| a.wrapping_sub(c.wrapping_mul(b));
        let [w, r, g, b] = sums.0;
        let [x, y, xx, xy, yy, xr, xg, xb, yr, yg, yb, _] = moments.0;
        let (x1, y1) = (less(x, cx, w), less(y, cy, w));
        Aligned([
            x1,
            y1,
            // Σw(x−c)² = Σwx² − cΣwx − cΣw(x−c).
            less(less(xx, cx, x), cx, x1),
            less(less(xy, cx, y), cy, x1),
            less(less(yy, cy, y), cy, y1),
            less(xr, cx, r),
            less(xg, cx, g),
            less(xb, cx, b),
            less(yr, cy, r),
            less(yg, cy, g),
            less(yb, cy, b),
            0,
        ])
    }

    #[inline]
    fn mean(sums: &Sums<Self>) -> Texel<Self> {
        let sums = &sums.0;
        if sums[0] <= 0 {
            return Texel::default();
        }
        let divider = Divider::new(sums[0] as u64);
        // The mean of 16-bit lights comes with 15 fractional bits.
        let light = |c: usize| mean_light(divider.part(sums[c] as u64, 16));
        Texel {
            light: [light(1), light(2), light(3)],
            confidence: confidence(sums[0]),
        }
    }

    #[inline]
    fn plane(sums: &Sums<Self>, moments: &Moments<Self>) -> Texel<Self> {
        let sums = &sums.0;
        if sums[0] <= 0 {
            return Texel::default();
        }
        let divider = Divider::new(sums[0] as u64);
        // Means: lights with 15 fractional bits; x, y in px with 20; squares in px² with 20.
        let mean = |v: i64, bits: i32| i64::from(divider.ratio(v, bits));
        let c = [mean(sums[1], 16), mean(sums[2], 16), mean(sums[3], 16)];
        // |x| < 2^11 in 1/256 px: 20 + 8 fractional bits of a pixel.
        let x = mean(moments.0[0], 11) >> 8;
        let y = mean(moments.0[1], 11) >> 8;
        // |x²| < 2^22 in 2^−16 px²: 9 + 16 fractional bits.
        let square = |k: usize| mean(moments.0[k], 22) >> 5;
        let ridge = RIDGE + ((x * x + y * y) >> (20 + LEAN_BITS));
        let xx = square(2) - ((x * x) >> 20) + ridge;
        let xy = square(3) - ((x * y) >> 20);
        let yy = square(4) - ((y * y) >> 20) + ridge;
        // Below (4 px)² each: 2^24, products 2^48; positive since the ridge outweighs the rounding.
        let determinant = (xx * yy - xy * xy).max(RIDGE * RIDGE / 4);
        // The plane at the centre is c − cov(x, c)·hx − cov(y, c)·hy.
        let by = Divider::new(determinant as u64);
        // Numerators below 2^22·2^25 px³; |h| < 2^4 a pixel: 23 fractional bits.
        let hx = i64::from(by.ratio((yy * x - xy * y) >> 12, -4)) >> 11;
        let hy = i64::from(by.ratio((xx * y - xy * x) >> 12, -4)) >> 11;
        let light = |k: usize| {
            // |x·light| < 2^27 in 1/256 px: 4 + 8 fractional bits, as light·px with 12.
            let cx = mean(moments.0[5 + k], 27) - ((c[k] * x) >> 23);
            let cy = mean(moments.0[8 + k], 27) - ((c[k] * y) >> 23);
            to_light(c[k] - ((cx * hx + cy * hy) >> 9))
        };
        Texel {
            light: [light(0), light(1), light(2)],
            confidence: confidence(sums[0]),
        }
    }

    #[inline]
    fn pull(children: [Texel<Self>; 4]) -> Texel<Self> {
        let total: u32 = children.iter().map(|t| u32::from(t.confidence)).sum();
        if total == 0 {
            return Texel::default();
        }
        if total == 4 * ONE {
            // What follows, of four that are all known: halves are rounded down.
            let sum = |c: usize| children.iter().map(|t| u32::from(t.light[c])).sum::<u32>();
            let light = |c: usize| ((sum(c) + 1) >> 2) as u16;
            return Texel {
                light: [light(0), light(1), light(2)],
                confidence: ONE as u16,
            };
        }
        let divider = Divider::new(u64::from(total));
        let light = |c: usize| {
            let of = |t: &Texel<Self>| u64::from(t.light[c]) * u64::from(t.confidence);
            let sum: u64 = children.iter().map(of).sum();
            mean_light(divider.part(sum, 16))
        };
        Texel {
            light: [light(0), light(1), light(2)],
            confidence: total.min(ONE) as u16,
        }
    }

    #[inline]
    fn lacks(confidence: u16) -> bool {
        u32::from(confidence) < ONE
    }

    #[inline]
    fn push(fine: Texel<Self>, coarse: [Texel<Self>; 4]) -> Texel<Self> {
        let own = u32::from(fine.confidence).min(ONE);
        let light = |c: usize| {
            let of = |i: usize| u32::from(coarse[i].light[c]);
            let around = (9 * of(0) + 3 * of(1) + 3 * of(2) + of(3) + 8) >> 4;
            ((own * u32::from(fine.light[c]) + (ONE - own) * around + (ONE >> 1)) >> 15) as u16
        };
        Texel {
            light: [light(0), light(1), light(2)],
            confidence: ONE as u16,
        }
    }

    #[inline]
    fn to_u16(light: u16) -> u16 {
        light
    }
}

/// A light of 15 fractional bits, rounded and clamped.
#[inline]
fn to_light(v: i64) -> u16 {
    ((v + (1 << 14)) >> 15).clamp(0, 65535) as u16
}

/// The same of a mean, at most 65535 but for rounding.
#[inline]
fn mean_light(v: u32) -> u16 {
    // Below 2^31 as it is; signed, since processors have an instruction for that.
    ((v as i32 + (1 << 14)) >> 15).clamp(0, 65535) as u16
}

/// min(1, weight/0.3).
#[inline]
fn confidence(weight: i64) -> u16 {
    let weight = (weight as u64).min(ENOUGH) as u32;
    ((weight * ONE) / ENOUGH as u32) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Four texels that are all known, as any others are pulled.
        #[test]
        fn known_texels_are_pulled_as_others_are(lights in prop::array::uniform4(prop::array::uniform3(any::<u16>()))) {
            let pulled = Fixed::pull(lights.map(|light| Texel { light, confidence: ONE as u16 }));
            let divider = Divider::new(u64::from(4 * ONE));
            for c in 0..3 {
                let sum: u64 = lights.iter().map(|light| u64::from(light[c]) * u64::from(ONE)).sum();
                prop_assert_eq!(pulled.light[c], mean_light(divider.part(sum, 16)));
            }
            prop_assert_eq!(u32::from(pulled.confidence), ONE);
        }
    }
}
