//! What each stage left in its buffer, for comparison with its twin in Rust.

use super::memory::Memory;
use crate::pass::Words;

/// A buffer of the display, as it is after a refresh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// 4 words a sample: `unframed_recon::deep::Stored`.
    Samples,
    /// 3 words a sample, two 16-bit values each, the first in the low half: x and y, depth and
    /// weight (0 for hidden samples), widths (0 where they come from density).
    Projected,
    /// A word a cell of each level, as in `unframed_recon::hidden`.
    Minima,
    /// A word a pixel.
    Limits,
    /// A word a pixel: whether a moving object is near.
    Movers,
    /// 2 words a pixel, of 64 bits, low half first; not yet held to the most that a mass counts.
    Masses,
    /// 2 words a pixel: the width, and what its taps need.
    Widths,
    /// 8 words a pixel: 4 sums of 64 bits, low half first.
    Sums,
    /// 22 words a pixel: 11 moments of 64 bits, low half first.
    Moments,
    /// 4 words a pixel: `unframed_recon::rest::Mean`.
    Means,
    /// 2 words a texel of the picture and of each coarser level, two 16-bit values each: red and
    /// green, blue and confidence.
    Texels,
}

impl Memory {
    pub(crate) fn probed(&self, probe: Probe) -> &Words {
        match probe {
            Probe::Samples => &self.samples,
            Probe::Projected => &self.projected,
            Probe::Minima => &self.minima,
            Probe::Limits => &self.limits,
            Probe::Movers => &self.movers,
            Probe::Masses => &self.mass,
            Probe::Widths => &self.widths,
            Probe::Sums => &self.sums,
            Probe::Moments => &self.moments,
            Probe::Means => &self.means,
            Probe::Texels => &self.texels,
        }
    }
}
