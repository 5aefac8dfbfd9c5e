//! The stream between a frameless host and its display (`docs/STREAM.md`).
//!
//! Layers, bottom up:
//! - [`repr`]: what each packet means, in plain types.
//! - `bytes`, `bits`: total readers and writers of fixed fields and of bit-packed codes.
//! - [`frame`]: COBS framing and the CRC. [`schema`]: version and schema hash.
//! - `fixed`, [`tiles`], [`samples`]: the payload of each packet kind.
//! - [`Receiver`]: bytes in, [`Packet`]s out; counts what is lost or damaged.
//! - [`Writer`]: meanings in, frames out; keeps a [`ledger`] of where the bits went.
//! - `recording` and `fault` (feature `std`): `.ufs` files, and a seeded bad link for tests.
//!
//! Without the feature `std` the crate needs neither an allocator nor an operating system. Every
//! byte sequence is a legal input of [`Receiver::push`], the work for each byte is bounded.
#![no_std]

#[cfg(feature = "std")]
extern crate std;

mod bits;
mod bytes;
mod fixed;
mod packet;
mod receiver;
mod writer;

pub mod frame;
pub mod ledger;
pub mod repr;
pub mod samples;
pub mod schema;
pub mod tiles;

#[cfg(feature = "std")]
pub mod fault;
#[cfg(feature = "std")]
pub mod recording;

pub use fixed::{
    IndexBlock, IndexEntry, IndexKind, Lamps, MAX_INDEX_ENTRIES, MAX_POSES, Poses, Shape, Trailer,
};
pub use frame::{MAX_FRAME, MAX_PACKET};
pub use packet::{Kind, Packet};
pub use receiver::{Counters, Damage, Receiver};
pub use repr::*;
pub use samples::{MAX_SAMPLES, ScreenSamples, WorldSamples};
pub use tiles::{Axis, TileNode, Tiles};
pub use writer::{EncodeError, Writer};
