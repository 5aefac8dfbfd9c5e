//! The reconstructor's tables as the shaders read them.

use bytemuck::{Pod, Zeroable};
use unframed_recon::config::{Config, Light, TimeKernel};
use unframed_recon::display::ENCODED;
use unframed_recon::tables::{
    EXP2_Q15, LOG2_Q11, SRGB_FROM, SRGB_GUESS, SRGB_TO_LINEAR, TIME, TIME_LEN,
};

/// The arrays of [`unframed_recon::tables`], an entry a word; twin of `Tables` in `common.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Tables {
    /// [`LOG2_Q11`].
    pub log2_q11: [u32; 65],
    /// [`EXP2_Q15`].
    pub exp2_q15: [u32; 257],
    /// Light of each 8-bit code: [`SRGB_TO_LINEAR`] or [`ENCODED`].
    pub light: [u32; 256],
    /// The configured kernel's row of [`TIME`].
    pub time: [u32; TIME_LEN],
    /// [`SRGB_FROM`].
    pub srgb_from: [u32; 256],
    /// [`SRGB_GUESS`].
    pub srgb_guess: [u32; 4096],
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
            log2_q11: LOG2_Q11.map(u32::from),
            exp2_q15: EXP2_Q15.map(u32::from),
            light: light.map(u32::from),
            time: time.map(u32::from),
            srgb_from: SRGB_FROM.map(u32::from),
            srgb_guess: SRGB_GUESS.map(u32::from),
        }
    }
}
