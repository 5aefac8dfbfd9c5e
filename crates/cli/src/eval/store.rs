//! Files that outlive the program: keys and atomic writes.

use std::fmt::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use unframed_host::scene::Scene;

/// FNV-1a (Fowler, Noll & Vo), 64 bits: the same on every machine and in every version.
#[derive(Clone, Copy, Debug)]
pub struct Key(u64);

impl Default for Key {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Key {
    /// The key of a scene: of everything in it.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        Self::default().with(format_args!("{scene:?}"))
    }

    /// The key of bytes.
    #[must_use]
    pub fn of_bytes(bytes: &[u8]) -> Self {
        let mut key = Self::default();
        key.add(bytes);
        key
    }

    /// The key of this and of something else.
    #[must_use]
    pub fn with(mut self, what: fmt::Arguments<'_>) -> Self {
        // A separator, so that "a" and "bc" are not "ab" and "c".
        self.add(&[0xff]);
        // Writing into a key cannot fail.
        let _ = self.write_fmt(what);
        self
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

impl Write for Key {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.add(text.as_bytes());
        Ok(())
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// A name that any file system takes, from a scene's name or path.
#[must_use]
pub fn slug(scene: &str) -> String {
    let stem = Path::new(scene)
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into());
    let safe = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    stem.chars().take(40).map(safe).collect()
}

/// Writes a file whole or not at all: whoever is interrupted leaves no half of one behind.
///
/// # Errors
/// Names the file.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let unfinished = path.with_extension("part");
    let failed = || {
        format!(
            "cannot write {}: make room or choose another --out",
            path.display()
        )
    };
    std::fs::write(&unfinished, bytes).with_context(failed)?;
    std::fs::rename(&unfinished, path).with_context(failed)
}
