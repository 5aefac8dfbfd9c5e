//! What can be wrong with a comparison.

/// Why a metric could not be computed. Each message names the place and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// A picture without pixels.
    #[error("a picture of {width}x{height} has no pixels: both sides must be at least 1")]
    Empty {
        /// Width asked for, pixels.
        width: usize,
        /// Height asked for, pixels.
        height: usize,
    },
    /// The pixel slice does not fill the stated size.
    #[error(
        "{pixels} pixels do not make a picture of {width}x{height}: give width times height of them"
    )]
    Length {
        /// Stated width, pixels.
        width: usize,
        /// Stated height, pixels.
        height: usize,
        /// Length of the slice.
        pixels: usize,
    },
    /// Two pictures (or a picture and a map over it) differ in size.
    #[error(
        "cannot compare {left_width}x{left_height} with {right_width}x{right_height}: sizes must be equal"
    )]
    SizeMismatch {
        /// Width of the first picture, pixels.
        left_width: usize,
        /// Height of the first picture, pixels.
        left_height: usize,
        /// Width of the second picture, pixels.
        right_width: usize,
        /// Height of the second picture, pixels.
        right_height: usize,
    },
    /// A per-pixel map (classes, ages, motion) does not have one entry a pixel.
    #[error("the {what} map has {entries} entries for {pixels} pixels: give one each")]
    MapLength {
        /// Which map.
        what: &'static str,
        /// Its length.
        entries: usize,
        /// Pixels of the picture.
        pixels: usize,
    },
    /// Nothing was pushed.
    #[error("no refresh was pushed: totals need at least one")]
    NoRefreshes,
    /// A parameter outside its range.
    #[error("{what} is {value}: it must be {range}")]
    Parameter {
        /// Which parameter.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The range it must lie in.
        range: &'static str,
    },
    /// ꟻLIP refused: the reason is flip-rs's own.
    #[error("FLIP: {0}")]
    Flip(String),
    /// ColorVideoVDP refused (it needs at least 4x4 pixels).
    #[error("ColorVideoVDP: {0}")]
    Video(#[from] colorvideovdp::Error),
}

impl From<flip_rs::FlipError> for MetricError {
    fn from(error: flip_rs::FlipError) -> Self {
        // flip-rs's error is neither `Clone` nor `PartialEq`; its message is all a caller needs.
        Self::Flip(error.to_string())
    }
}
