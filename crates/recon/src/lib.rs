//! The reconstructor: `no_std`, no heap, no `unsafe`, integers where it counts.
//!
//! A [`Display`] takes the packets of a stream and, at each refresh, makes the picture of that
//! instant from all stored samples: it moves them to the view and poses of the instant, drops
//! those hidden behind others, weighs each by its age and the lifetime of its place, fits a mean
//! or a plane at every pixel and fills what no sample reached. Each step is a module:
//!
//! | layer | modules |
//! |---|---|
//! | integer kernels, compile-time tables | [`num`], [`lanes`], [`tables`], [`taps`] |
//! | what arithmetic is, in integers and in floats | [`arith`], [`fixed`], `float` |
//! | what is kept | [`deep`], [`tiles`], [`memory`], `heap` |
//! | who works on which samples and pixels | [`bins`], [`workers`] |
//! | the steps of a refresh | [`transform`], [`sight`], [`project`], [`motion`], [`hidden`], [`extents`], [`splat`], [`solve`], [`fill`], [`encode`] |
//! | what replaces them when nothing moves, where nothing is filtered | [`rest`]; [`own`], [`glance`] |
//! | all together | [`config`], [`display`], [`player`], [`scanout`] |
//! | to compare arithmetics | `decisions` |
//!
//! Nothing here panics on any input: packets are checked on arrival (`transform::*_is_sound`),
//! indices are looked up, sums are bounded (`docs/NUMERICS.md`).
#![no_std]

#[cfg(feature = "heap")]
extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod arith;
pub mod bins;
pub mod config;
#[cfg(feature = "float")]
pub mod decisions;
pub mod deep;
pub mod display;
pub mod encode;
pub mod extents;
pub mod fill;
pub mod fixed;
#[cfg(feature = "float")]
pub mod float;
pub mod glance;
#[cfg(feature = "heap")]
pub mod heap;
pub mod hidden;
pub mod lanes;
pub mod light;
pub mod memory;
pub mod motion;
pub mod num;
pub mod own;
mod picture;
pub mod player;
pub mod project;
pub mod rest;
#[cfg(feature = "float")]
pub mod rounded;
pub mod scanout;
pub mod sight;
pub mod solve;
pub mod splat;
pub mod tables;
pub mod taps;
pub mod tiles;
pub mod transform;
pub mod workers;

pub use arith::{Arith, Panel};
pub use config::Config;
pub use display::Display;
pub use fixed::Fixed;
pub use player::{Player, frame_hash};
#[cfg(feature = "threads")]
pub use workers::Threads;
pub use workers::{Alone, Workers};
