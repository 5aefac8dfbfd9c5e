//! Where the bytes and bits of a stream went.

use crate::packet::Kind;

/// Bits in the payloads of Samples packets, by what they say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleBits {
    /// Places.
    pub place: u64,
    /// Colours.
    pub colour: u64,
    /// Runs of object ids.
    pub object: u64,
    /// Code parameters.
    pub parameters: u64,
    /// Shares of the lamps.
    pub shares: u64,
}

/// Bits in the payloads of Tiles packets, by what they say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileBits {
    /// The shape of the tree.
    pub tree: u64,
    /// The leaves' log codes.
    pub codes: u64,
    /// Leaves (not bits).
    pub leaves: u64,
}

/// Totals of a [`crate::Writer`]. What [`SampleBits`] and [`TileBits`] leave of the bytes of
/// their packets is overhead: type, sequence, time, padding, CRC, COBS and delimiter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ledger {
    /// Packets by [`Kind::index`].
    pub packets: [u64; Kind::ALL.len()],
    /// Bytes on the wire by [`Kind::index`], framing included.
    pub bytes: [u64; Kind::ALL.len()],
    /// Samples.
    pub samples: u64,
    /// Inside Samples packets.
    pub sample_bits: SampleBits,
    /// Inside Tiles packets.
    pub tile_bits: TileBits,
}

impl Ledger {
    pub(crate) fn count(&mut self, kind: Kind, bytes: u64) {
        if let Some(n) = self.packets.get_mut(kind.index()) {
            *n += 1;
        }
        if let Some(n) = self.bytes.get_mut(kind.index()) {
            *n += bytes;
        }
    }

    pub(crate) fn add_samples(&mut self, samples: usize, bits: SampleBits) {
        self.samples += samples as u64;
        self.sample_bits.place += bits.place;
        self.sample_bits.colour += bits.colour;
        self.sample_bits.object += bits.object;
        self.sample_bits.parameters += bits.parameters;
        self.sample_bits.shares += bits.shares;
    }

    pub(crate) fn add_tiles(&mut self, bits: TileBits) {
        self.tile_bits.tree += bits.tree;
        self.tile_bits.codes += bits.codes;
        self.tile_bits.leaves += bits.leaves;
    }

    /// Packets of one kind.
    #[must_use]
    pub fn packets_of(&self, kind: Kind) -> u64 {
        self.packets.get(kind.index()).copied().unwrap_or(0)
    }

    /// Bytes of one kind on the wire.
    #[must_use]
    pub fn bytes_of(&self, kind: Kind) -> u64 {
        self.bytes.get(kind.index()).copied().unwrap_or(0)
    }

    /// All packets.
    #[must_use]
    pub fn total_packets(&self) -> u64 {
        self.packets.iter().sum()
    }

    /// All bytes on the wire.
    #[must_use]
    pub fn total_bytes(&self) -> u64 {
        self.bytes.iter().sum()
    }
}
