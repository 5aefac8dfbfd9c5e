//! The reconstructor's tables as the shaders read them.

use bytemuck::{Pod, Zeroable};
use unframed_recon::config::{Config, Light, TimeKernel};
use unframed_recon::encode::ENCODED;
use unframed_recon::tables::{
    EXP2_Q15, LOG2_Q11, SRGB_FROM, SRGB_GUESS, SRGB_TO_LINEAR, TIME, TIME_LEN,
};
use unframed_recon::taps::{DISTANCE_BITS, LEVELS, PLACES, TABLE};

/// The arrays of [`unframed_recon::tables`]; twin of `Tables` in `common.wgsl`. Of those between
/// whose entries one interpolates each word holds the two ends of a chord, the first in the low
/// half; of the others an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Tables {
    /// Chords of [`LOG2_Q11`].
    pub log2_q11: [u32; 64],
    /// Chords of [`EXP2_Q15`].
    pub exp2_q15: [u32; 256],
    /// Chords of the configured kernel's row of [`TIME`].
    pub time: [u32; TIME_LEN - 1],
    /// Light of each 8-bit code: [`SRGB_TO_LINEAR`] or [`ENCODED`].
    pub light: [u32; 256],
    /// [`SRGB_TO_LINEAR`], by which lamps dim whatever light is filtered as.
    pub linear: [u32; 256],
    /// [`SRGB_FROM`].
    pub srgb_from: [u32; 256],
    /// [`SRGB_GUESS`].
    pub srgb_guess: [u32; 4096],
    /// Chords between the levels of [`TABLE`], by level and distance: of the odd multiples of
    /// 1/256 px, for a tap does not depend on the side.
    pub taps: [u32; STEPS * DISTANCES],
}

impl Tables {
    /// The tables that a configuration uses.
    #[must_use]
    pub fn new(config: &Config) -> Tables {
        let light = match config.light {
            Light::Linear => &SRGB_TO_LINEAR,
            Light::Encoded => &ENCODED,
        };
        let time = match config.kernel {
            TimeKernel::Rational => &TIME[0],
            TimeKernel::Gaussian => &TIME[1],
            TimeKernel::Exponential => &TIME[2],
        };
        Tables {
            log2_q11: chords(&LOG2_Q11),
            exp2_q15: chords(&EXP2_Q15),
            time: chords(time),
            light: light.map(u32::from),
            linear: SRGB_TO_LINEAR.map(u32::from),
            srgb_from: SRGB_FROM.map(u32::from),
            srgb_guess: SRGB_GUESS.map(u32::from),
            taps: taps(),
        }
    }
}

/// Levels of [`TABLE`] that have a next.
const STEPS: usize = LEVELS - 1;
/// Distances below 3.5 px in 1/256 px, the odd ones.
pub(super) const DISTANCES: usize = 448;

/// See [`Tables::taps`].
fn taps() -> [u32; STEPS * DISTANCES] {
    std::array::from_fn(|i| {
        let (level, distance) = (i / DISTANCES, 2 * (i % DISTANCES) + 1);
        // A sample that far after the middle of a pixel: the pixel is so many before its own.
        let before = (distance + PLACES) >> DISTANCE_BITS;
        let place = (distance + PLACES - (before << DISTANCE_BITS)) / 2;
        let tap = |level: usize| u32::from(TABLE[level][place][3 - before]);
        tap(level) | tap(level + 1) << 16
    })
}

/// Neighbouring entries in one word; `N` is one less than the table's length.
fn chords<const N: usize>(table: &[u16]) -> [u32; N] {
    std::array::from_fn(|i| u32::from(table[i]) | u32::from(table[i + 1]) << 16)
}
