//! A bad link for tests: loses, flips, repeats and cuts off bytes, by a seed.

use std::vec::Vec;

/// How often each fault strikes, in a million.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Bytes that vanish.
    pub drop: u32,
    /// Bytes with one bit flipped.
    pub flip: u32,
    /// Bytes that arrive twice.
    pub duplicate: u32,
    /// Transfers cut off at a random byte.
    pub truncate: u32,
}

/// Applies [`Faults`] to what passes. The same seed and transfers give the same faults.
#[derive(Clone, Debug)]
pub struct LinkFault {
    faults: Faults,
    state: u64,
    struck: u64,
}

impl LinkFault {
    /// A link with `faults`.
    #[must_use]
    pub fn new(seed: u64, faults: Faults) -> Self {
        LinkFault {
            faults,
            state: seed,
            struck: 0,
        }
    }

    /// Faults so far.
    #[must_use]
    pub fn struck(&self) -> u64 {
        self.struck
    }

    /// Sends one transfer (a frame, or any piece of the stream); what arrives is appended.
    pub fn pass(&mut self, transfer: &[u8], arrived: &mut Vec<u8>) {
        let keep = if self.strikes(self.faults.truncate) {
            self.random() as usize % transfer.len().max(1)
        } else {
            transfer.len()
        };
        for &byte in transfer.iter().take(keep) {
            if self.strikes(self.faults.drop) {
                continue;
            }
            let flipped = match self.strikes(self.faults.flip) {
                true => byte ^ (1 << (self.random() % 8)),
                false => byte,
            };
            arrived.push(flipped);
            if self.strikes(self.faults.duplicate) {
                arrived.push(flipped);
            }
        }
    }

    fn strikes(&mut self, per_million: u32) -> bool {
        let hit = self.random() % 1_000_000 < u64::from(per_million);
        self.struck += u64::from(hit);
        hit
    }

    /// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), upper half.
    fn random(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) >> 32
    }
}
