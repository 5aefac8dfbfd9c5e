//! The commands, one module each.

pub mod cost;
pub mod effects;
pub mod eval;
pub mod firmware;
pub mod inspect;
pub mod live;
pub mod play;
pub mod record;
pub mod run;
pub mod scenes;

use std::path::Path;

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};

/// Makes the directory of `--out`, and proves that it can be written before hours are spent.
///
/// # Errors
/// Names the directory and the remedy.
pub fn make_out(dir: &Path) -> Result<()> {
    let remedy = || format!("cannot write to {}: choose another --out", dir.display());
    std::fs::create_dir_all(dir).with_context(remedy)?;
    let probe = dir.join(".unframed-probe");
    std::fs::write(&probe, b"").with_context(remedy)?;
    std::fs::remove_file(&probe).with_context(remedy)
}

/// Reads a stream's file.
///
/// # Errors
/// Names the file.
pub fn read_stream(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read the stream {}", path.display()))
}

/// A progress bar on stderr, hidden where stderr is no terminal.
#[must_use]
pub fn bar(len: u64, what: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len} {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(len)
        .with_style(style)
        .with_message(what.to_owned())
}
