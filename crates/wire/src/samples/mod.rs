//! Samples packets: world ([`WorldSamples`]) and screen ([`ScreenSamples`]) layouts.
//!
//! A packet is a set: its samples share one time, their order means nothing. The encoder sorts
//! them along a Z-order curve (G. M. Morton, IBM, 1966), so that a place costs only where it
//! departs from the place before, and a colour is coded against that of a near neighbour (so are
//! the shares of lamps).

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
/// World, worst case a sample: either a run 2·8 + 48, or suffix 9, mode 3, 47 place; then 3·10
/// colour, 2·5 shares. The sums below are of 128 that all start runs and of 128 that none do,
/// the second with room for as many runs.
pub(crate) const SURE_SAMPLES: usize = 128;
const _: () = assert!(SURE_SAMPLES * (16 + 48 + 30 + 10) / 8 + 64 < crate::MAX_PACKET);
const _: () = assert!(SURE_SAMPLES * (9 + 3 + 47 + 30 + 10) / 8 + 256 + 64 < crate::MAX_PACKET);
