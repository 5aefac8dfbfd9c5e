//! The stream between a frameless host and its display (`docs/STREAM.md`).
//!
//! Layers, bottom up:
//! - [`repr`]: what each packet means, in plain types.
#![no_std]

pub mod repr;
pub use repr::*;
