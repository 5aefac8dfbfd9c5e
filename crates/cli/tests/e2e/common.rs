//! Runs the command as a user does.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output};

/// Runs `unframed` with these words.
pub(crate) fn unframed<S: AsRef<OsStr>>(words: impl IntoIterator<Item = S>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_unframed"))
        .args(words)
        .output()
        .expect("the command starts")
}

/// Runs `unframed` and demands success.
pub(crate) fn succeed<S: AsRef<OsStr>>(words: impl IntoIterator<Item = S>) -> String {
    let output = unframed(words);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8(output.stdout).expect("output is text")
}

/// The folder of real scenes: `UNFRAMED_ASSETS`, else beside the project. `None` (never in CI)
/// where there is none, after saying what is left out.
pub(crate) fn assets(left_out: &str) -> Option<PathBuf> {
    let beside = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets"
    ));
    let folder = std::env::var_os("UNFRAMED_ASSETS").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(
        std::env::var_os("CI").is_none(),
        "no folder of real scenes in CI"
    );
    eprintln!("left out: {left_out} (no folder of real scenes; set UNFRAMED_ASSETS)");
    None
}
