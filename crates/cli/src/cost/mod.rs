//! What accuracy costs: every knob that trades error for time, bytes or RAM, turned and measured.
//!
//! [`knobs`] (what is turned, presets; number formats are in [`formats`]) → [`stream`] (one recording for all displays of a rate) →
//! [`point`] (error, split by cause; seconds, bytes, [`ram`]) → [`front`] (what is beaten by
//! nothing) → [`table`] (JSON, CSV, what a decibel costs) → [`page`]. [`study`] does all in order,
//! on all cores, and nothing twice.
//!
//! Small cores: [`effort`] counts work and knows what it costs, [`cores`] finds that out on an
//! emulator, [`forecast`] counts the work of another panel, [`budget`] finds the best preset for a
//! machine, which [`answer`] puts into words. [`scaling`] shows how cost grows, [`adapter`] what
//! the presets take on a graphics adapter.

pub mod adapter;
pub mod answer;
pub mod budget;
pub mod cores;
pub mod effects;
pub mod effort;
pub mod forecast;
pub mod formats;
pub mod front;
pub mod knobs;
pub mod page;
pub mod point;
pub mod ram;
pub mod scaling;
pub mod stream;
pub mod study;
pub mod table;

pub use crate::eval::page::short;
