//! Bytes in, packets out.

use core::fmt;

use crate::bytes::Cursor;
use crate::frame::{self, Deframer, Step};
use crate::packet::{Kind, Packet};
use crate::repr::{Hello, Status, Tick};

/// Backward steps of the sequence number up to this are late or repeated packets; longer ones
/// mean that the sender started anew.
const STALE_WINDOW: u16 = 64;

/// Why a frame was thrown away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// COBS codes ran past the delimiter, or the frame is longer than any packet.
    Framing,
    /// The CRC does not match.
    Check,
    /// The contents are not what the type says, or out of range.
    Contents,
    /// A Hello of another version of the format, given here.
    Version(u8),
    /// A Hello whose schema hash, given here, is not [`crate::schema::HASH`].
    Schema(u32),
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Damage::Framing => f.write_str("broken framing"),
            Damage::Check => f.write_str("CRC mismatch"),
            Damage::Contents => f.write_str("contents out of range"),
            Damage::Version(v) => {
                write!(
                    f,
                    "stream version {v}, this program speaks {}",
                    crate::schema::VERSION
                )
            }
            Damage::Schema(hash) => {
                write!(
                    f,
                    "schema {hash:#010x}, this program has {:#010x}",
                    crate::schema::HASH
                )
            }
        }
    }
}

impl core::error::Error for Damage {}

/// What a receiver has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Bytes pushed.
    pub bytes: u64,
    /// Good packets handed out.
    pub received: u64,
    /// Packets missing by their sequence numbers, the damaged ones included.
    pub lost: u64,
    /// Frames thrown away, see [`Damage`].
    pub damaged: u64,
    /// Good packets that came late or twice, and were ignored.
    pub stale: u64,
    /// Good packets before the first Hello, and were ignored.
    pub early: u64,
    /// Good packets of a type that this version does not know, and were ignored.
    pub unknown: u64,
}

impl Counters {
    /// The report to the host of a display that shows the refresh of `refresh_time` and holds
    /// `buffered` samples; counts saturate.
    #[must_use]
    pub fn status(&self, refresh_time: Tick, buffered: usize) -> Status {
        let narrow = |v: u64| u32::try_from(v).unwrap_or(u32::MAX);
        Status {
            refresh_time,
            received: narrow(self.received),
            lost: narrow(self.lost),
            damaged: narrow(self.damaged),
            buffered: narrow(buffered as u64),
        }
    }
}

/// Finds the packets in a stream of bytes. Holds one packet; any byte sequence is legal input.
///
/// Until the first good Hello only packets that stand alone come out (Hello, End, Status, Index):
/// the others cannot be checked. Since all that comes out is checked against the newest Hello, a
/// consumer may rely on the ranges that [`crate::repr`] states.
#[derive(Clone, Debug)]
pub struct Receiver {
    deframer: Deframer,
    hello: Option<Hello>,
    expected: Option<u16>,
    counters: Counters,
    damage: Option<Damage>,
    /// Bytes of the frame in progress, or of the last one, delimiter included.
    frame_bytes: u64,
    frame_done: bool,
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

impl Receiver {
    /// A receiver that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Receiver {
            deframer: Deframer::new(),
            hello: None,
            expected: None,
            counters: Counters {
                bytes: 0,
                received: 0,
                lost: 0,
                damaged: 0,
                stale: 0,
                early: 0,
                unknown: 0,
            },
            damage: None,
            frame_bytes: 0,
            frame_done: true,
        }
    }

    /// Takes bytes off the front of `input` up to the end of the next good packet, and returns
    /// it; `None` when the input is used up. Call until `None`:
    ///
    /// ```
    /// # use unframed_wire::{Receiver, Packet};
    /// # let bytes = [0u8; 3];
    /// let mut receiver = Receiver::new();
    /// let mut input = &bytes[..];
    /// while let Some(packet) = receiver.push(&mut input) {
    ///     if let Packet::World(samples) = packet {
    ///         for sample in samples { /* … */ }
    ///     }
    /// }
    /// ```
    pub fn push<'a>(&'a mut self, input: &mut &[u8]) -> Option<Packet<'a>> {
        let (kind, len) = loop {
            let run = self.deframer.run(input);
            self.counters.bytes += run as u64;
            self.frame_bytes += run as u64;
            *input = input.get(run..).unwrap_or_default();
            let (&byte, rest) = input.split_first()?;
            *input = rest;
            if let Some(found) = self.byte(byte) {
                break found;
            }
        };
        let payload = self.deframer.packet(len).get(3..len.saturating_sub(4))?;
        Packet::parse(kind, payload, self.hello.as_ref()).ok()
    }

    /// What happened so far.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The newest good Hello.
    #[must_use]
    pub fn hello(&self) -> Option<&Hello> {
        self.hello.as_ref()
    }

    /// Why the newest damaged frame was thrown away.
    #[must_use]
    pub fn last_damage(&self) -> Option<Damage> {
        self.damage
    }

    /// Bytes on the wire of the packet that `push` returned last, framing included.
    #[must_use]
    pub fn frame_bytes(&self) -> u64 {
        self.frame_bytes
    }

    /// Sequence number of the newest packet, stale ones aside.
    #[must_use]
    pub fn last_sequence(&self) -> Option<u16> {
        self.expected.map(|next| next.wrapping_sub(1))
    }

    /// Takes one byte; the kind and length of the good packet that it completes.
    fn byte(&mut self, byte: u8) -> Option<(Kind, usize)> {
        self.counters.bytes += 1;
        if self.frame_done {
            self.frame_bytes = 0;
            self.frame_done = false;
        }
        self.frame_bytes += 1;
        match self.deframer.push(byte) {
            Step::More => None,
            Step::Empty => {
                self.frame_done = true;
                None
            }
            Step::Bad => {
                self.frame_done = true;
                self.damaged(Damage::Framing)
            }
            Step::Whole(len) => {
                self.frame_done = true;
                self.frame(len)
            }
        }
    }

    fn damaged(&mut self, damage: Damage) -> Option<(Kind, usize)> {
        self.counters.damaged += 1;
        self.damage = Some(damage);
        None
    }

    fn frame(&mut self, len: usize) -> Option<(Kind, usize)> {
        let packet = self.deframer.packet(len);
        let Some((body, crc)) = packet.split_last_chunk::<4>() else {
            return self.damaged(Damage::Framing);
        };
        if frame::checksum(body) != u32::from_le_bytes(*crc) {
            return self.damaged(Damage::Check);
        }
        let mut cursor = Cursor(body);
        let (Some(kind), Some(sequence)) = (cursor.u8(), cursor.u16()) else {
            return self.damaged(Damage::Contents);
        };
        let Some(kind) = Kind::from_byte(kind) else {
            self.counters.unknown += u64::from(self.advance(sequence));
            return None;
        };
        let early = self.hello.is_none() && !kind.stands_alone();
        let parsed = match early {
            true => Ok(None),
            false => {
                Packet::parse(kind, cursor.0, self.hello.as_ref()).map(|packet| match packet {
                    Packet::Hello(hello) => Some(hello),
                    _ => None,
                })
            }
        };
        let hello = match parsed {
            Ok(hello) => hello,
            Err(damage) => {
                // Its sequence number is good: what is missing here is damaged, not lost.
                self.advance(sequence);
                return self.damaged(damage);
            }
        };
        if !self.advance(sequence) {
            return None;
        }
        if early {
            self.counters.early += 1;
            return None;
        }
        self.hello = hello.or(self.hello);
        self.counters.received += 1;
        Some((kind, len))
    }

    /// Accounts for a sequence number; whether the packet is new.
    fn advance(&mut self, sequence: u16) -> bool {
        if let Some(expected) = self.expected {
            let ahead = sequence.wrapping_sub(expected);
            if ahead < 0x8000 {
                self.counters.lost += u64::from(ahead);
            } else if ahead.wrapping_neg() <= STALE_WINDOW {
                self.counters.stale += 1;
                return false;
            }
        }
        self.expected = Some(sequence.wrapping_add(1));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_a_report_saturate() {
        let counters = Counters {
            received: 7,
            lost: u64::from(u32::MAX) + 1,
            damaged: 3,
            ..Counters::default()
        };
        let expected = Status {
            refresh_time: Tick(5),
            received: 7,
            lost: u32::MAX,
            damaged: 3,
            buffered: 9,
        };
        assert_eq!(counters.status(Tick(5), 9), expected);
    }
}
