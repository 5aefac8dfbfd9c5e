//! What can be wrong with a file, said so that it can be mended.

use std::path::PathBuf;

/// Why a glTF file was not loaded. Every message names the file, the place in it and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file itself cannot be read.
    #[error("cannot read {}: {source}; check the path and its permissions", file.display())]
    Read {
        /// As given.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Neither a GLB container nor JSON, or cut short.
    #[error("{} is not a complete glTF 2.0 file: {reason}; export or copy it again", file.display())]
    Container {
        /// As given.
        file: PathBuf,
        /// What was expected.
        reason: String,
    },
    /// Extensions that the file cannot do without and that are not supported here.
    #[error(
        "{} requires unsupported extensions: {}; export it without them (no mesh or texture \
         compression, say)",
        file.display(),
        names.join(", ")
    )]
    Extensions {
        /// As given.
        file: PathBuf,
        /// In the order of the file.
        names: Vec<String>,
    },
    /// Something inside contradicts the specification, itself, or is missing.
    #[error("{}: {fault}", file.display())]
    Content {
        /// As given.
        file: PathBuf,
        /// Where and what.
        fault: Fault,
    },
    /// No clip has the name that was asked for.
    #[error(
        "{} has no clip {wanted:?}; {}",
        file.display(),
        if names.is_empty() { "it is not animated".into() } else { format!("its clips: {}", names.join(", ")) }
    )]
    Clip {
        /// As given.
        file: PathBuf,
        /// The name asked for.
        wanted: String,
        /// The names there are, in the order of the file.
        names: Vec<String>,
    },
    /// The scene has no triangle.
    #[error("{} shows nothing: no node of its scene has a triangle; export at least one mesh", file.display())]
    Empty {
        /// As given.
        file: PathBuf,
    },
}

/// A fault at a place inside a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct Fault {
    /// Kind, index and name of the element: `mesh 3 "door", primitive 0, POSITION`.
    pub place: String,
    /// What is wrong, and the remedy where it is not plain.
    pub reason: String,
}

impl Fault {
    /// A fault at a place.
    pub(super) fn new(place: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            place: place.into(),
            reason: reason.into(),
        }
    }
}

/// Something in the file that is shown differently from what its author meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Kind, index and name of the element.
    pub place: String,
    /// What is done instead.
    pub text: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.place, self.text)
    }
}

/// Collects warnings; the same one at many places of a kind is kept once for each place.
#[derive(Debug, Default)]
pub(super) struct Warnings(pub(super) Vec<Warning>);

impl Warnings {
    pub(super) fn add(&mut self, place: impl Into<String>, text: impl Into<String>) {
        let warning = Warning {
            place: place.into(),
            text: text.into(),
        };
        if !self.0.contains(&warning) {
            self.0.push(warning);
        }
    }
}

/// `kind index "name"`, the way places are written in messages.
pub(super) fn place(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{kind} {index} {name:?}"),
        None => format!("{kind} {index}"),
    }
}
