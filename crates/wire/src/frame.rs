//! Framing: `COBS(type, sequence, payload, CRC) 00`.
//!
//! - S. Cheshire, M. Baker, "Consistent Overhead Byte Stuffing", SIGCOMM 1997: no zero inside a
//!   frame, one byte in 254 of overhead, so a receiver finds the next packet at the next zero.
//! - CRC-32C (Castagnoli 1993; CRC-32/ISCSI, check value 0xE3069283). A 16-bit CRC would let one
//!   damaged packet in 65536 through, at thousands of packets a second one every few seconds on a
//!   bad link, and a wrong sample stays visible for its lifetime. The two bytes more cost 0.02
//!   bytes a sample. Castagnoli's polynomial keeps Hamming distance 6 up to 655 bytes and 4 far
//!   beyond our packets.

use crc::{CRC_32_ISCSI, Crc};

/// Longest packet before COBS: type, sequence, payload and CRC, bytes.
pub const MAX_PACKET: usize = 2048;

/// Longest frame: a packet, one COBS code for each started 254 bytes, the delimiter.
pub const MAX_FRAME: usize = MAX_PACKET + MAX_PACKET.div_ceil(254) + 1;

/// Bytes of a packet that are not payload: type 1, sequence 2, CRC 4.
pub const OVERHEAD: usize = 7;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// CRC-32C of `bytes`.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Frames `packet` (at most [`MAX_PACKET`] bytes) into `frame`; the length, or `None` if it does
/// not fit.
pub(crate) fn encode(packet: &[u8], frame: &mut [u8; MAX_FRAME]) -> Option<usize> {
    let mut code_at = 0;
    let mut at = 1;
    let mut code = 1u8;
    for &byte in packet {
        if byte != 0 {
            *frame.get_mut(at)? = byte;
            at += 1;
            code += 1;
        }
        if byte == 0 || code == 0xff {
            *frame.get_mut(code_at)? = code;
            code_at = at;
            at += 1;
            code = 1;
        }
    }
    *frame.get_mut(code_at)? = code;
    *frame.get_mut(at)? = 0;
    Some(at + 1)
}

/// What a byte completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Nothing yet.
    More,
    /// An empty frame: a delimiter after a delimiter.
    Empty,
    /// A frame that decodes to so many bytes.
    Whole(usize),
    /// A frame whose codes run past its end, or that is longer than any packet.
    Bad,
}

/// Streaming COBS decoder into a buffer of one packet.
#[derive(Clone, Debug)]
pub(crate) struct Deframer {
    buffer: [u8; MAX_PACKET],
    len: usize,
    /// Data bytes until the next code.
    until_code: u8,
    /// Whether that code is preceded by a zero of the packet.
    zero_next: bool,
    started: bool,
    bad: bool,
}

impl Deframer {
    pub(crate) const fn new() -> Self {
        Deframer {
            buffer: [0; MAX_PACKET],
            len: 0,
            until_code: 0,
            zero_next: false,
            started: false,
            bad: false,
        }
    }

    /// Takes the data bytes at the front of `input` that are due before the next code, as far as
    /// they go in one piece; their number. The bytes after them are for [`Deframer::push`].
    pub(crate) fn run(&mut self, input: &[u8]) -> usize {
        let due = input.len().min(usize::from(self.until_code));
        let room = self.buffer.get_mut(self.len..).unwrap_or_default();
        let mut taken = 0;
        for (place, byte) in room.iter_mut().zip(input.get(..due).unwrap_or_default()) {
            if *byte == 0 {
                break;
            }
            *place = *byte;
            taken += 1;
        }
        self.len += taken;
        self.until_code -= taken as u8;
        taken
    }

    pub(crate) fn push(&mut self, byte: u8) -> Step {
        if byte == 0 {
            let step = match (self.started, self.bad || self.until_code > 0) {
                (false, _) => Step::Empty,
                (true, true) => Step::Bad,
                (true, false) => Step::Whole(self.len),
            };
            self.len = 0;
            self.until_code = 0;
            self.zero_next = false;
            self.started = false;
            self.bad = false;
            return step;
        }
        self.started = true;
        if self.until_code == 0 {
            if self.zero_next {
                self.store(0);
            }
            self.until_code = byte - 1;
            self.zero_next = byte != 0xff;
        } else {
            self.until_code -= 1;
            self.store(byte);
        }
        Step::More
    }

    fn store(&mut self, byte: u8) {
        match self.buffer.get_mut(self.len) {
            Some(place) => {
                *place = byte;
                self.len += 1;
            }
            None => self.bad = true,
        }
    }

    /// The first `len` bytes of the last whole frame; valid until the next push.
    pub(crate) fn packet(&self, len: usize) -> &[u8] {
        self.buffer.get(..len).unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    #[test]
    fn crc_has_its_catalogue_check_value() {
        assert_eq!(checksum(b"123456789"), 0xE306_9283);
    }

    fn unframe(frame: &[u8]) -> Option<Vec<u8>> {
        let mut deframer = Deframer::new();
        let mut out = None;
        for &b in frame {
            if let Step::Whole(len) = deframer.push(b) {
                out = Some(deframer.packet(len).to_vec());
            }
        }
        out
    }

    proptest! {
        #[test]
        fn agrees_with_the_cobs_crate(packet in proptest::collection::vec(prop_oneof![Just(0u8), any::<u8>(), Just(7)], 1..MAX_PACKET)) {
            let mut frame = [0xA5; MAX_FRAME];
            let len = encode(&packet, &mut frame).unwrap();
            let mut theirs = [0xA5; MAX_FRAME + 8];
            let n = cobs::encode(&packet, &mut theirs);
            // At a last run of 254 the paper appends a code of 1 and the crate may not.
            let ours = &frame[..len - 1];
            prop_assert!(ours == &theirs[..n] || ours.strip_suffix(&[1]) == Some(&theirs[..n]));
            prop_assert_eq!(frame[len - 1], 0);
            let mut back = [0xA5; MAX_FRAME];
            let report = cobs::decode(ours, &mut back).unwrap();
            prop_assert_eq!(&back[..report.frame_size()], &packet[..]);
            prop_assert_eq!(unframe(&frame[..len]), Some(packet));
        }
    }

    proptest! {
        #[test]
        fn runs_are_taken_as_their_bytes_are(
            bytes in proptest::collection::vec(prop_oneof![1 => Just(0u8), 3 => 1u8..6, 12 => any::<u8>()], 0..900),
            cuts in proptest::collection::vec(0usize..40, 0..60),
        ) {
            let (mut ones, mut runs) = (Deframer::new(), Deframer::new());
            let mut rest = &bytes[..];
            let mut cuts = cuts.into_iter().chain(core::iter::repeat(usize::MAX));
            while !rest.is_empty() {
                // What has come so far may end anywhere.
                let (here, later) = rest.split_at(rest.len().min(cuts.next().unwrap_or(1)));
                let mut here = here;
                while !here.is_empty() {
                    let taken = runs.run(here);
                    for byte in &here[..taken] {
                        prop_assert_eq!(ones.push(*byte), Step::More);
                    }
                    here = &here[taken..];
                    if let Some((byte, after)) = here.split_first() {
                        let step = runs.push(*byte);
                        prop_assert_eq!(ones.push(*byte), step);
                        if let Step::Whole(len) = step {
                            prop_assert_eq!(ones.packet(len), runs.packet(len));
                        }
                        here = after;
                    }
                }
                rest = later;
            }
        }
    }

    #[test]
    fn runs_of_254_and_the_longest_packet_fit() {
        for len in [1, 253, 254, 255, 508, 509, MAX_PACKET] {
            for fill in [0u8, 1, 255] {
                let packet = std::vec![fill; len];
                let mut frame = [0xA5; MAX_FRAME];
                let n = encode(&packet, &mut frame).unwrap();
                assert!(!frame[..n - 1].contains(&0));
                assert_eq!(unframe(&frame[..n]).unwrap(), packet);
            }
        }
    }

    #[test]
    fn a_frame_beyond_the_limit_is_bad_and_the_next_is_whole() {
        let mut deframer = Deframer::new();
        for _ in 0..3 * MAX_PACKET {
            assert_eq!(deframer.push(1), Step::More);
        }
        assert_eq!(deframer.push(0), Step::Bad);
        assert_eq!(
            [2, 9, 0].map(|b| deframer.push(b)),
            [Step::More, Step::More, Step::Whole(1)]
        );
    }
}
