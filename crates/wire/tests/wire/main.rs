//! The wire format from outside the crate.

mod common;
mod measure;
mod room;
mod round_trip;
