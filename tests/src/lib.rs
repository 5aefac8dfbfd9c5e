//! What the tests across crates share.
//!
//! | module | concern |
//! |---|---|
//! | [`accuracy`] | integers against the oracle, decision by decision |
//! | [`holes`] | what a decision reaches through holes that are filled |
//! | [`fuzzed`] | streams made of any bytes |
//! | [`stream`] | streams made by hand |
//! | [`scenes`] | streams of the built-in scenes, recorded by the host |
//! | [`backends`] | the displays that must show the same bits, and the oracle |
//! | [`cases`] | the hard cases |
//! | [`controller`] | a display controller that takes what goes over an SPI bus |
//!
//! Everything here may panic: it is for tests and for the examples that write their tables.

pub mod accuracy;
pub mod backends;
pub mod cases;
pub mod controller;
pub mod fuzzed;
pub mod holes;
pub mod scenes;
pub mod stream;
