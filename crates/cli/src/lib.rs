//! What the `unframed` command is made of. No logic of its own: it puts host and display
//! together, joined by bytes alone, and measures them.
//!
//! - [`args`]: what a user types; [`method`]: samplers, streams and reconstructions by name;
//! - [`panel`]: the display hardware to show on; [`measure`]: a run against the ideal;
//! - [`replica`]: a display's picture made again, otherwise;
//! - [`eval`]: all methods against the ideal, cell by cell;
//! - [`cost`]: what accuracy costs, knob by knob;
//! - [`commands`]: one module a command; [`pages`], [`report`]: what they write;
//! - [`work`]: the time that it took.

pub mod args;
pub mod commands;
pub mod cost;
pub mod eval;
pub mod measure;
pub mod method;
pub mod pages;
pub mod panel;
pub mod replica;
pub mod report;
pub mod work;
