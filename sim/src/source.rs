//! Where a window's pictures come from.

use std::sync::mpsc::{Receiver, TryRecvError};

use crate::paint::Frame;

/// What a source has at a refresh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The frame was filled.
    Picture,
    /// The picture before it stays.
    Unchanged,
    /// There is no more: the window closes.
    End,
}

/// A key for the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A letter or digit as typed, shift applied.
    Char(char),
    /// An arrow.
    Left,
    /// An arrow.
    Right,
    /// An arrow.
    Up,
    /// An arrow.
    Down,
}

/// Where pictures come from. Called on the window's thread: a source that computes for longer
/// than a refresh should do so elsewhere and hand its pictures over a channel (a [`Receiver`] of
/// frames is a source that shows the newest).
pub trait Source {
    /// Called once a refresh unless paused; `frame` is the one given last, to be reused.
    fn next(&mut self, frame: &mut Frame) -> Next;

    /// A key was pressed (overlays, camera).
    fn key(&mut self, _key: Key) {}

    /// The window was paused (true) or goes on; a source with a clock of its own stops it.
    fn pause(&mut self, _paused: bool) {}

    /// Text for the title bar, asked twice a second (rate, RMSE).
    fn status(&mut self) -> Option<String> {
        None
    }
}

impl Source for Receiver<Frame> {
    fn next(&mut self, frame: &mut Frame) -> Next {
        let mut outcome = Next::Unchanged;
        loop {
            match self.try_recv() {
                Ok(newer) => (*frame, outcome) = (newer, Next::Picture),
                Err(TryRecvError::Empty) => return outcome,
                // The last picture is shown before the end is told.
                Err(TryRecvError::Disconnected) if outcome == Next::Picture => return outcome,
                Err(TryRecvError::Disconnected) => return Next::End,
            }
        }
    }
}
