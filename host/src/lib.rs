//! The host: a renderer that never waits for a frame.
//!
//! Data flows one way: [`scene`] (what there is) → [`trace`] (what a ray sees at an instant, with the
//! [`effects`] that the scene calls for) →
//! [`sampler`] (where and when to look next) → [`stream`] (bytes for the display); [`drive`] runs
//! them in simulated time. [`framed`] renders whole frames instead, for comparison.

pub mod drive;
pub mod effects;
pub mod framed;
mod gaze;
pub mod sampler;
pub mod scene;
pub mod stream;
pub mod trace;
