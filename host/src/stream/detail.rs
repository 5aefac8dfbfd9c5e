//! How finely a stream tells what it tells: bytes against error.

/// What the stream spends its bits on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    /// Bits of a lattice coordinate of a sample, 4..=16. Fewer make a packet shorter by that much.
    pub place_bits: u8,
    /// Bits of each channel of a colour that are told apart, 1..=8. The format codes eight, of
    /// which the lowest then repeat the highest.
    pub colour_bits: u8,
    /// Refreshes from one tiling to the next, at least 1.
    pub tiles_every: u32,
    /// Whether samples tell the shares of lamps where [`super::sender::Promise::lamps`] says so; else
    /// all shadows are in them.
    pub lamps: bool,
}

impl Default for Detail {
    /// All of it.
    fn default() -> Self {
        Self {
            place_bits: 16,
            colour_bits: 8,
            tiles_every: 1,
            lamps: true,
        }
    }
}

impl Detail {
    /// Steps from one end of a lattice to the other.
    pub(super) fn steps(&self) -> f64 {
        f64::from((1u32 << self.place_bits.clamp(4, 16)) - 2)
    }

    /// A colour with as many bits as are told apart: the nearest such level.
    pub(super) fn colour(&self, rgb: [u8; 3]) -> [u8; 3] {
        let most = (1u16 << self.colour_bits.clamp(1, 8)) - 1;
        rgb.map(|code| {
            let level = (u16::from(code) * most + 127) / 255;
            ((level * 255 + most / 2) / most) as u8
        })
    }

    /// Whether refresh `index` brings a tiling.
    pub(super) fn tiles_at(&self, index: u32) -> bool {
        index.is_multiple_of(self.tiles_every.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_detail_changes_nothing_and_less_stays_near() {
        for code in 0..=255u8 {
            let all = Detail::default();
            assert_eq!(all.colour([code; 3]), [code; 3]);
            for bits in 1..=8 {
                let detail = Detail {
                    colour_bits: bits,
                    ..all
                };
                let [told, ..] = detail.colour([code; 3]);
                let step = 255.0 / f64::from((1u16 << bits) - 1);
                assert!(
                    f64::from(told.abs_diff(code)) <= 0.5 * step + 0.5,
                    "{bits} bits: {code} is told as {told}"
                );
                assert_eq!(detail.colour([told; 3]), [told; 3], "{bits} bits: {code}");
            }
        }
    }
}
