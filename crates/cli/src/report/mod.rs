//! A run, shown to a stranger: one self-contained HTML file with numbers, plots and pictures.
//!
//! - [`picture`]: PNG, error heat maps, tilings drawn over an image, strips, enlargement;
//! - [`plot`] and [`bars`]: SVG plots, readable on light and dark paper and by the colour-blind;
//! - [`html`]: the page. No script and nothing from outside the file.
//!
//! Nothing here panics on any data: a number that is not finite is a gap in a line, a dash in a
//! table, an empty place in a bar chart.

pub mod axis;
pub mod bars;
pub mod html;
pub mod picture;
pub mod plot;

use std::path::{Path, PathBuf};

pub use axis::{Axis, Scale};
pub use bars::BarChart;
pub use html::{Figure, Report, Section, Table};
pub use picture::{Picture, Rect};
pub use plot::Plot;

/// Why a report, a plot or a picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The pixel slice does not fill the stated size, or a side is 0.
    #[error("{pixels} pixels do not make a picture of {width}x{height}")]
    PictureSize {
        /// Stated width, pixels.
        width: usize,
        /// Stated height, pixels.
        height: usize,
        /// Length of the slice.
        pixels: usize,
    },
    /// Pictures that belong together differ in size.
    #[error("a picture of {first} does not go with one of {second}: sizes must be equal")]
    SizeMismatch {
        /// Size of the first, "WxH".
        first: String,
        /// Size of the second, "WxH".
        second: String,
    },
    /// The PNG encoder failed.
    #[error("cannot encode PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// The plotting library failed.
    #[error("cannot draw the plot \"{plot}\": {reason}")]
    Plot {
        /// Title of the plot.
        plot: String,
        /// What the library says.
        reason: String,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}: choose another --out or make room", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Writes `bytes` to `path`, replacing what was there; its directory must exist.
///
/// # Errors
///
/// [`ReportError::Write`] with the path.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    std::fs::write(path, bytes).map_err(|source| ReportError::Write {
        path: path.to_owned(),
        source,
    })
}
