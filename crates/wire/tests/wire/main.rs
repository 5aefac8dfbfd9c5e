//! The wire format from outside the crate.

mod common;
mod files;
mod link;
mod measure;
mod room;
mod round_trip;
mod stream_md;
