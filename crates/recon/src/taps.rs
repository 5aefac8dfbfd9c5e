//! Filter taps: e^(−d²/2σ²) − e^(−4.5), down to zero at 3 σ, at the pixels around a sample, one
//! axis at a time. Taps that end in a step would let a rounding of 3 σ decide whether a sample
//! counts at all.
//!
//! Densities give widths in a narrow range, whose taps come from a table: by level of width, an
//! eighth of an octave apart, and by where in its pixel a sample lies. Between levels taps are
//! interpolated, in all arithmetics, so that no rounding of a width decides between two filters.

use crate::arith::REACH;
use crate::lanes::{self, LANES};
use crate::num::{exp2, exp2_negative};

/// Fractional bits of pixel distances. A coordinate is rounded down to at most 7 bits, so it
/// stands for the middle of its step and a distance needs one bit more.
pub const DISTANCE_BITS: u32 = 8;
/// Pixels that a footprint can reach along an axis: its own and [`REACH`] on each side.
pub const SPAN: usize = 2 * REACH as usize + 1;
/// Entries kept for [`SPAN`] taps: [`LANES`] can be taken from any of them on.
pub const PADDED: usize = SPAN + LANES - 1;
/// Levels of width in the table.
pub const LEVELS: usize = 15;
/// log2 of the least σ of a density, 11 fractional bits: 0.347 px.
pub const LEAST: i32 = -3129;
/// log2 of the step between levels: 1/8 octave with 11 fractional bits.
pub const STEP_BITS: u32 = 8;
/// log2 of the greatest σ of a density, just below the last level's 1.166 px: 3 σ stay below
/// 3.5 px, so such a footprint spans 7 pixels.
pub const MOST: i32 = LEAST + ((LEVELS as i32 - 1) << STEP_BITS) - 1;
/// What a Gaussian is at 3 σ, e^(−4.5), with 15 fractional bits.
pub const FOOT: u32 = 364;

/// Taps of one axis.
#[derive(Clone, Copy, Debug)]
pub struct Taps<W> {
    /// Of the pixels from [`REACH`] before the sample's own to [`REACH`] after it, then zeros.
    pub weights: [W; PADDED],
    /// The first and the last that are not zero, from the own pixel.
    pub first: i32,
    /// See `first`.
    pub last: i32,
}

impl<W> Taps<W> {
    /// Taps from a pixel within the reach on, counted from the sample's own.
    #[inline]
    #[must_use]
    pub fn from(&self, pixel: i32) -> Option<&[W; LANES]> {
        self.weights.get((pixel + REACH) as usize..)?.first_chunk()
    }
}

/// 3 σ in units of a distance, at most [`REACH`] pixels.
#[inline]
#[must_use]
pub const fn reach(width: i16) -> u32 {
    // log2 3 is 3246.
    let reach = exp2(width as i32 + 3246, DISTANCE_BITS as i32);
    let most = (REACH as u32) << DISTANCE_BITS;
    if reach < most { reach } else { most }
}

/// Taps of a width for a sample `offset` beyond the middle of its pixel, in distance units.
#[must_use]
pub const fn compute(width: i16, offset: i32) -> Taps<u16> {
    let reach = reach(width);
    // log2(e)/2σ² with 12 fractional bits; log2 of log2(e)/2 is −965.
    let steepness = exp2(-965 - 2 * width as i32, 12);
    let mut taps = Taps {
        weights: [0; PADDED],
        first: REACH,
        last: -REACH,
    };
    let mut i = 0;
    while i < SPAN {
        let pixel = i as i32 - REACH;
        let d = (offset - (pixel << DISTANCE_BITS)).unsigned_abs();
        if d < reach {
            // Below 4.5·log2(e) with 16 + 12 fractional bits.
            let tap = exp2_negative((d * d * steepness) >> 16).saturating_sub(FOOT) as u16;
            taps.weights[i] = tap;
            if tap > 0 {
                taps.first = if pixel < taps.first {
                    pixel
                } else {
                    taps.first
                };
                taps.last = pixel;
            }
        }
        i += 1;
    }
    taps
}

/// A row of the table: taps from 3 pixels before to 3 after, then the first and the last that are
/// not zero, from 3 pixels before, in 4 bits each.
pub type Row = [u16; LANES];
/// Places in a pixel that coordinates of 7 fractional bits tell apart.
pub const PLACES: usize = 128;

/// Taps of each level and each place in a pixel (the middles of 1/128 px).
pub static TABLE: [[Row; PLACES]; LEVELS] = {
    let mut table = [[[0; LANES]; PLACES]; LEVELS];
    let mut level = 0;
    while level < LEVELS {
        let mut place = 0;
        while place < PLACES {
            let offset = 2 * place as i32 + 1 - PLACES as i32;
            let taps = compute(width(level), offset);
            let mut row = [0; LANES];
            let mut i = 0;
            while i < 7 {
                row[i] = taps.weights[i + REACH as usize - 3];
                i += 1;
            }
            row[7] = (taps.first + 3) as u16 | ((taps.last + 3) as u16) << 4;
            table[level][place] = row;
            place += 1;
        }
        level += 1;
    }
    table
};

/// log2 σ of a level, 11 fractional bits.
#[must_use]
pub const fn width(level: usize) -> i16 {
    (LEAST + ((level as i32) << STEP_BITS)) as i16
}

/// Taps of a width for a sample at `place` of `1 << bits` places in its pixel, `bits` at most 7.
#[inline]
#[must_use]
pub fn taps(width: i16, place: u32, bits: u32) -> Taps<u16> {
    let above = i32::from(width) - LEAST;
    let level = (above >> STEP_BITS) as usize;
    // The middle of a step that is wider than those of the table: the place after it.
    let fine = ((2 * place + 1) << (7 - bits) >> 1) as usize;
    let row = |level: usize| TABLE.get(level).and_then(|rows| rows.get(fine));
    if (0..=MOST - LEAST).contains(&above)
        && let (Some(narrow), Some(wide)) = (row(level), row(level + 1))
    {
        let part = above as u16 & ((1 << STEP_BITS) - 1);
        // A wider filter's taps are nowhere smaller.
        let mut taps = lanes::between(narrow, wide, part);
        taps[LANES - 1] = 0;
        let mut weights = [0; PADDED];
        weights[1..SPAN].copy_from_slice(&taps);
        Taps {
            weights,
            first: i32::from(wide[7] & 15) - 3,
            last: i32::from(wide[7] >> 4) - 3,
        }
    } else {
        let steps = 2 * place as i32 + 1 - (1 << bits);
        compute(width, steps << (DISTANCE_BITS - 1 - bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_what_is_computed_and_wider_filters_are_nowhere_smaller() {
        for (level, rows) in TABLE.iter().enumerate() {
            let wider = &TABLE[(level + 1).min(LEVELS - 1)];
            for (place, (row, next)) in rows.iter().zip(wider).enumerate() {
                let computed = compute(width(level), 2 * place as i32 + 1 - 128);
                assert_eq!(row[..7], computed.weights[1..8]);
                assert_eq!((computed.weights[0], computed.weights[8]), (0, 0));
                assert!(row[..7].iter().zip(next).all(|(a, b)| a <= b));
                assert!(row[7] & 15 >= next[7] & 15 && row[7] >> 4 <= next[7] >> 4);
            }
        }
    }

    /// e^(−d²/2σ²) − e^(−4.5), zero beyond 3 σ and 4 px, with 15 fractional bits.
    fn exact(log2: f64, d: f64) -> f64 {
        let u = d / log2.exp2();
        if u.abs() < 3.0 && d.abs() < f64::from(REACH) {
            ((-0.5 * u * u).exp() - (-4.5f64).exp()) * 32768.0
        } else {
            0.0
        }
    }

    /// The same interpolated between levels.
    fn between(width: i16, d: f64) -> f64 {
        let above = f64::from(i32::from(width) - LEAST) / 256.0;
        let at = |level: f64| exact((f64::from(LEAST) + 256.0 * level) / 2048.0, d);
        at(above.floor()) + (at(above.floor() + 1.0) - at(above.floor())) * above.fract()
    }

    /// The worst difference from `exact`, in units; the taps' middle is `shift` px after that of
    /// the step.
    fn worst(
        widths: core::ops::RangeInclusive<i32>,
        (bits, shift): (u32, f64),
        exact: impl Fn(i16, f64) -> f64,
    ) -> f64 {
        let mut worst: f64 = 0.0;
        for width in widths.map(|width| width as i16) {
            for place in 0..1 << bits {
                let taps = taps(width, place, bits);
                let offset = (f64::from(place) + 0.5) / f64::from(1 << bits) - 0.5 + shift;
                for (tap, pixel) in taps.weights.iter().zip(-REACH..) {
                    let exact = exact(width, offset - f64::from(pixel));
                    worst = worst.max((f64::from(*tap) - exact).abs());
                    let within = (taps.first..=taps.last).contains(&pixel);
                    assert!(within || *tap == 0, "{width} {place} {pixel}");
                }
            }
        }
        worst
    }

    #[test]
    fn taps_follow_the_formula() {
        let gaussian = |width: i16, d: f64| exact(f64::from(width) / 2048.0, d);
        let cases = [
            (
                "from the table",
                worst(LEAST..=MOST, (7, 0.0), between),
                8.0,
            ),
            (
                "as wider steps",
                worst(LEAST..=MOST, (4, 1.0 / 256.0), between),
                8.0,
            ),
            (
                "interpolation",
                worst(LEAST..=MOST, (7, 0.0), gaussian),
                85.0,
            ),
            // Widths up to 4/3 px: wider ones end in a step at 4 px.
            (
                "computed",
                worst(-4096..=LEAST - 1, (7, 0.0), gaussian),
                20.0,
            ),
            ("computed", worst(MOST + 1..=850, (4, 0.0), gaussian), 20.0),
        ];
        for (name, worst, bound) in cases {
            std::println!("{name}: {worst} of {bound}");
            assert!(worst < bound, "{name}: {worst}");
        }
    }
}
