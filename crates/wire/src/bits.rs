//! Bit-packed codes: most significant bit first, Golomb–Rice with an escape.
//!
//! R. F. Rice, "Some practical universal noiseless coding techniques", JPL 79-22, 1979. A code of
//! parameter `k` for `u` is `u >> k` ones, a zero, then the low `k` bits; from [`ESCAPE`] ones on
//! there is no zero and `u` follows in a width that both ends know.

use crate::bytes::Buffer;

/// So many ones mean that the plain value follows.
pub(crate) const ESCAPE: u32 = 12;

/// Maps 0, −1, 1, −2, … to 0, 1, 2, 3, ….
pub(crate) const fn fold(v: i32) -> u32 {
    ((v << 1) ^ (v >> 31)) as u32
}

/// The inverse of [`fold`].
pub(crate) const fn unfold(u: u32) -> i32 {
    (u >> 1) as i32 ^ -((u & 1) as i32)
}

/// Length in bits of the Rice code of `u`.
pub(crate) const fn rice_len(u: u32, k: u32, width: u32) -> u32 {
    let q = u >> k;
    if q >= ESCAPE {
        ESCAPE + width
    } else {
        q + 1 + k
    }
}

/// Reads bits, most significant first; `None` beyond the end. Each call touches at most 4 bytes.
#[derive(Clone, Debug)]
pub(crate) struct BitReader<'a> {
    data: &'a [u8],
    /// The next `have` bits, left-aligned; zeros below.
    acc: u32,
    have: u32,
}

impl<'a> BitReader<'a> {
    pub(crate) const fn new(data: &'a [u8]) -> Self {
        BitReader {
            data,
            acc: 0,
            have: 0,
        }
    }

    /// Makes `have` at least 25, or takes all there is.
    #[inline]
    fn refill(&mut self) {
        if let Some(next) = self.data.first_chunk::<4>() {
            let free = 32 - self.have;
            let next = u32::from_be_bytes(*next)
                .checked_shr(self.have)
                .unwrap_or(0);
            // Whole bytes alone.
            self.acc |= next >> (free % 8) << (free % 8);
            self.have += free & !7;
            self.data = self.data.get((free >> 3) as usize..).unwrap_or_default();
            return;
        }
        while self.have <= 24 {
            let Some((&byte, rest)) = self.data.split_first() else {
                return;
            };
            self.acc |= u32::from(byte) << (24 - self.have);
            self.have += 8;
            self.data = rest;
        }
    }

    /// The next `n` bits, `n` ≤ 24.
    #[inline]
    pub(crate) fn bits(&mut self, n: u32) -> Option<u32> {
        if n > self.have {
            self.refill();
        }
        if n > self.have || n > 24 {
            return None;
        }
        // A shift by 32 (n = 0) has no value of its own.
        let value = self.acc.checked_shr(32 - n).unwrap_or(0);
        self.acc <<= n;
        self.have -= n;
        Some(value)
    }

    /// The next `n` bits, `n` ≤ 32.
    pub(crate) fn wide(&mut self, n: u32) -> Option<u32> {
        Some((self.bits(n.saturating_sub(16))? << 16) | self.bits(n.min(16))?)
    }

    pub(crate) fn flag(&mut self) -> Option<bool> {
        self.bits(1).map(|b| b != 0)
    }

    /// A Rice code of parameter `k` ≤ 31; escaped values have `width` ≤ 32 bits.
    pub(crate) fn rice(&mut self, k: u32, width: u32) -> Option<u32> {
        // The longest start of a code, and what its last bits seldom go beyond.
        if self.have < ESCAPE + 8 {
            self.refill();
        }
        let ones = self.acc.leading_ones().min(ESCAPE);
        if ones == ESCAPE {
            self.bits(ESCAPE)?;
            self.wide(width)
        } else {
            self.bits(ones + 1)?;
            let low = if k <= 24 {
                self.bits(k)?
            } else {
                self.wide(k)?
            };
            Some((ones.checked_shl(k).unwrap_or(0)) | low)
        }
    }
}

/// Appends bits to a packet, most significant first. [`BitWriter::finish`] pads with zeros.
pub(crate) struct BitWriter<'a> {
    buffer: &'a mut Buffer,
    acc: u64,
    have: u32,
    total: u32,
}

impl<'a> BitWriter<'a> {
    pub(crate) fn new(buffer: &'a mut Buffer) -> Self {
        BitWriter {
            buffer,
            acc: 0,
            have: 0,
            total: 0,
        }
    }

    /// Bits written so far.
    pub(crate) fn total(&self) -> u32 {
        self.total
    }

    /// Appends the low `n` ≤ 32 bits of `value`.
    pub(crate) fn bits(&mut self, value: u32, n: u32) {
        let value = u64::from(value) & ((1u64 << n) - 1);
        self.acc = (self.acc << n) | value;
        self.have += n;
        self.total += n;
        while self.have >= 8 {
            self.have -= 8;
            self.buffer.u8((self.acc >> self.have) as u8);
        }
    }

    pub(crate) fn rice(&mut self, u: u32, k: u32, width: u32) {
        let q = u >> k;
        if q >= ESCAPE {
            self.bits((1 << ESCAPE) - 1, ESCAPE);
            self.bits(u, width);
        } else {
            self.bits((1 << (q + 1)) - 2, q + 1);
            self.bits(u, k);
        }
    }

    pub(crate) fn finish(mut self) {
        let pad = (8 - self.have % 8) % 8;
        self.bits(0, pad);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rice_codes_read_back_with_their_stated_length() {
        for k in 0..8 {
            for u in 0..256 {
                let mut buffer = Buffer::new();
                let mut w = BitWriter::new(&mut buffer);
                w.bits(1, 3);
                w.rice(u, k, 8);
                assert_eq!(w.total(), 3 + rice_len(u, k, 8));
                w.finish();
                let mut r = BitReader::new(buffer.as_slice());
                assert_eq!(r.bits(3), Some(1));
                assert_eq!(r.rice(k, 8), Some(u), "k {k}");
                assert!(r.bits(8).is_none());
            }
        }
    }

    #[test]
    fn wide_values_and_wide_parameters() {
        let values = [0u32, 1, 0xffff, 0x1_0000, 0x0fff_ffff, u32::MAX];
        for k in [0, 15, 16, 17, 24, 31] {
            let mut buffer = Buffer::new();
            let mut w = BitWriter::new(&mut buffer);
            values.iter().for_each(|&u| w.rice(u, k, 32));
            w.finish();
            let mut r = BitReader::new(buffer.as_slice());
            values
                .iter()
                .for_each(|&u| assert_eq!(r.rice(k, 32), Some(u), "k {k}"));
        }
    }

    #[test]
    fn fold_and_unfold_are_inverse() {
        for v in -70_000..70_000 {
            assert_eq!(unfold(fold(v)), v);
        }
        assert_eq!([0, -1, 1, -2].map(fold), [0, 1, 2, 3]);
    }
}
