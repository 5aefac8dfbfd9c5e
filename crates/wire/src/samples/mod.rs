//! Samples packets: world ([`WorldSamples`]) and screen ([`ScreenSamples`]) layouts.
//!
//! A packet is a set: its samples share one time, their order means nothing. The encoder sorts
//! them along a Z-order curve (G. M. Morton, IBM, 1966), so that a place costs only where it
//! departs from the place before, and a colour is coded against that of a near neighbour.

mod colour;
mod screen;
mod world;

pub use screen::ScreenSamples;
pub use world::WorldSamples;

pub(crate) use screen::put as put_screen;
pub(crate) use world::put as put_world;

/// Samples in one packet.
pub const MAX_SAMPLES: usize = 256;

/// So many samples fit into one packet whatever they are.
///
/// World, worst case a sample: run 2·8 + 48, suffix 9, mode 3, 47 place, 3·10 colour, at most
/// 118 bits even if each sample starts a run and pays for a suffix: 128 of them are 1888 bytes.
pub(crate) const SURE_SAMPLES: usize = 128;
const _: () = assert!(SURE_SAMPLES * (16 + 48 + 30) / 8 + 64 < crate::MAX_PACKET);
const _: () = assert!(SURE_SAMPLES * (9 + 3 + 47 + 30) / 8 + 256 + 64 < crate::MAX_PACKET);
