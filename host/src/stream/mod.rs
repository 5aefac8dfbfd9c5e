//! The way out: samples, views, poses and tiles become bytes for the display.

pub mod detail;
mod light;
pub mod quantise;
pub mod sender;

pub use detail::Detail;
pub use quantise::Quantiser;
pub use sender::{Sender, StreamError};
