//! Filter taps: e^(−d²/2σ²) − e^(−4.5), down to zero at 3 σ, at the pixels around a sample, one
//! axis at a time. Taps that end in a step would let a rounding of 3 σ decide whether a sample
//! counts at all.
//!
//! Densities give one of [`LEVELS`] widths, an eighth of an octave apart, so that all taps of a
//! sample come from one row of a table: by level and by where in its pixel the sample lies.

use crate::arith::REACH;
use crate::num::{exp2, exp2_negative};

/// Fractional bits of pixel distances. A coordinate is rounded down to at most 7 bits, so it
/// stands for the middle of its step and a distance needs one bit more.
pub const DISTANCE_BITS: u32 = 8;
/// Pixels that a footprint can reach along an axis: its own and [`REACH`] on each side.
pub const SPAN: usize = 2 * REACH as usize + 1;
/// Widths that densities lead to.
pub const LEVELS: usize = 15;
/// log2 of the least σ of a density, 11 fractional bits: 0.347 px. The greatest, 14 eighths of an
/// octave wider, is 1.166 px: 3 σ stay below 3.5 px, so such a footprint spans 7 pixels.
pub const LEAST: i32 = -3129;
/// log2 of the step between levels: 1/8 octave with 11 fractional bits.
pub const STEP_BITS: u32 = 8;

/// What a Gaussian is at 3 σ, e^(−4.5), with 15 fractional bits.
pub const FOOT: u32 = 364;

/// Taps of one axis.
#[derive(Clone, Copy, Debug)]
pub struct Taps<W> {
    /// Of the pixels from [`REACH`] before the sample's own to [`REACH`] after it.
    pub weights: [W; SPAN],
    /// The first and the last that are not zero, from the own pixel.
    pub first: i32,
    /// See `first`.
    pub last: i32,
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
        weights: [0; SPAN],
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
pub type Row = [u16; 8];
/// Places in a pixel that coordinates of 7 fractional bits tell apart.
pub const PLACES: usize = 128;

/// Taps of each level and each place in a pixel (the middles of 1/128 px).
pub static TABLE: [[Row; PLACES]; LEVELS] = {
    let mut table = [[[0; 8]; PLACES]; LEVELS];
    let mut level = 0;
    while level < LEVELS {
        let mut place = 0;
        while place < PLACES {
            let offset = 2 * place as i32 + 1 - PLACES as i32;
            let taps = compute(width(level), offset);
            let mut row = [0; 8];
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

/// The level nearest to log2 σ.
#[inline]
#[must_use]
pub const fn level(log: i32) -> usize {
    let level = (log - LEAST + (1 << (STEP_BITS - 1))) >> STEP_BITS;
    if level < 0 {
        0
    } else if level >= LEVELS as i32 {
        LEVELS - 1
    } else {
        level as usize
    }
}

/// Taps of a width for a sample at `place` of `1 << bits` places in its pixel.
#[inline]
#[must_use]
pub fn taps(width: i16, place: u32, bits: u32) -> Taps<u16> {
    let above = i32::from(width) - LEAST;
    let level = (above >> STEP_BITS) as usize;
    if bits == 7
        && above & ((1 << STEP_BITS) - 1) == 0
        && let Some(row) = TABLE
            .get(level)
            .and_then(|rows| rows.get(place as usize & (PLACES - 1)))
    {
        let [a, b, c, d, e, f, g, ends] = *row;
        Taps {
            weights: [0, a, b, c, d, e, f, g, 0],
            first: i32::from(ends & 15) - 3,
            last: i32::from(ends >> 4) - 3,
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
    fn the_table_holds_what_is_computed() {
        for level in 0..LEVELS {
            for place in 0..PLACES as u32 {
                let table = taps(width(level), place, 7);
                let computed = compute(width(level), 2 * place as i32 + 1 - 128);
                assert_eq!(table.weights, computed.weights);
                assert_eq!((table.first, table.last), (computed.first, computed.last));
                assert!(table.first <= 0 && table.last >= 0);
            }
        }
    }

    #[test]
    fn taps_follow_the_formula() {
        for level in 0..LEVELS {
            let sigma = (f64::from(width(level)) / 2048.0).exp2();
            for offset in -127..128 {
                let taps = compute(width(level), offset);
                for (i, tap) in taps.weights.iter().enumerate() {
                    let d = f64::from(offset) / 256.0 - (i as f64 - f64::from(REACH));
                    let exact = if d.abs() < 3.0 * sigma {
                        ((-0.5 * (d / sigma).powi(2)).exp() - (-4.5f64).exp()) * 32768.0
                    } else {
                        0.0
                    };
                    let error = (f64::from(*tap) - exact).abs();
                    assert!(error < 12.0, "{level} {offset} {i}: {error}");
                }
            }
        }
    }

    #[test]
    fn levels_are_the_nearest() {
        for log in -4000..1500 {
            let nearest = (0..LEVELS)
                .min_by_key(|l| (log - i32::from(width(*l))).abs())
                .expect("levels");
            let far = (log - i32::from(width(level(log)))).abs();
            assert_eq!(far, (log - i32::from(width(nearest))).abs());
        }
    }
}
