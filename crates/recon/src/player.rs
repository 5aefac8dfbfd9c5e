//! Bytes in, pictures out: a receiver and a display.

use crate::arith::Arith;
use crate::display::Display;
use crate::workers::{Alone, Workers};
use unframed_wire::{Receiver, Refresh, Status, Tick};

/// A display at the end of a link.
#[derive(Debug)]
pub struct Player<'a, A: Arith, W: Workers = Alone> {
    receiver: Receiver,
    display: Display<'a, A, W>,
    newest: Tick,
}

impl<'a, A: Arith, W: Workers> Player<'a, A, W> {
    /// A display that has received nothing yet.
    #[must_use]
    pub fn new(display: Display<'a, A, W>) -> Self {
        Self {
            receiver: Receiver::new(),
            display,
            newest: Tick(0),
        }
    }

    /// Takes bytes off the front of `input` up to the end of the next Refresh, makes its picture
    /// and hands the Refresh back; `None` when the input is used up. Call until `None`.
    pub fn push(&mut self, input: &mut &[u8]) -> Option<Refresh> {
        while let Some(packet) = self.receiver.push(input) {
            if let Some(refresh) = self.display.receive(packet) {
                self.newest = refresh.time;
                return Some(refresh);
            }
        }
        None
    }

    /// The display.
    #[must_use]
    pub fn display(&self) -> &Display<'a, A, W> {
        &self.display
    }

    /// What went through the link.
    #[must_use]
    pub fn receiver(&self) -> &Receiver {
        &self.receiver
    }

    /// The report to the host; counts saturate.
    #[must_use]
    pub fn status(&self) -> Status {
        let buffered = self.display.buffered();
        self.receiver.counters().status(self.newest, buffered)
    }
}

/// A hash of a picture (64-bit FNV-1a over R, G, B row by row): equal on every machine.
#[must_use]
pub fn frame_hash(picture: &[[u8; 3]]) -> u64 {
    picture
        .iter()
        .flatten()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
        })
}
