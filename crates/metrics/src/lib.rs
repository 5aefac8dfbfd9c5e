//! How far a shown picture is from the ideal one, and how old it is.
//!
//! Every comparison takes two [`Image`]s of the same size: sRGB bytes, rows from the top. Layers,
//! bottom up:
//! - [`Image`], [`MetricError`]: a checked view of a picture, and what can be wrong with it;
//! - [`difference`]: squared error, RMSE and PSNR, exact in integers;
//! - [`perceptual`]: ꟻLIP, what a viewer sees when the two pictures alternate;
//! - [`video`]: ColorVideoVDP over a whole animation, in bounded memory;
//! - [`classes`]: which kinds of pixel the squared error comes from;
//! - [`age`]: how old the shown samples are;
//! - [`scatter`]: spatial scatter, the noise that is peculiar to frameless rendering;
//! - [`sequence`]: all of it over an animation, refresh by refresh.
//!
//! Nothing here panics on any input: a wrong size is a [`MetricError`], an undefined number (the
//! PSNR of equal pictures, the mean of nothing) is infinite or `None`, and says so.

pub mod age;
pub mod classes;
pub mod difference;
mod error;
mod image;
pub mod perceptual;
pub mod scatter;
pub mod sequence;
#[cfg(test)]
mod test_pictures;
pub mod video;

pub use age::AgeHistogram;
pub use classes::{ErrorShares, PixelClass};
pub use difference::{SquaredError, psnr, rmse};
pub use error::MetricError;
pub use image::Image;
pub use perceptual::{Viewing, flip, flip_map};
pub use scatter::Scatter;
pub use sequence::{Refresh, Sequence, SequenceOptions, Totals};
pub use video::VideoMetric;
