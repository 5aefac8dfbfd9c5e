//! From what a user types to a scene: a built-in name or a path.

use super::builtin::{BUILTIN, builtin};
use super::gltf::{self, LoadError, Loaded};
use std::path::Path;

/// Why a scene was not opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Neither a built-in name nor a file.
    #[error(
        "there is no scene {name:?}: it is neither a file nor built in ({})",
        BUILTIN.join(", ")
    )]
    Unknown {
        /// As given.
        name: String,
    },
    /// A clip was named for a built-in scene, which has none to choose from.
    #[error("the built-in scene {0:?} has no clips to choose from; leave out the clip")]
    Clip(String),
    /// The file is not a scene.
    #[error(transparent)]
    Load(#[from] LoadError),
}

/// Opens a built-in scene by name, or else a `.glb` or `.gltf` file by path.
///
/// A built-in name wins over a file of the same name; `./name` means the file.
///
/// # Errors
/// There is no such scene, or the file is not one.
pub fn open(scene: &str, clip: Option<&str>) -> Result<Loaded, OpenError> {
    if let Some(built) = builtin(scene) {
        return match clip {
            Some(_) => Err(OpenError::Clip(scene.to_owned())),
            None => Ok(Loaded {
                scene: built,
                warnings: Vec::new(),
            }),
        };
    }
    let path = Path::new(scene);
    // What looks like a file gets the system's reason; a bare word, the list of names.
    if path.extension().is_none() && path.components().count() < 2 && !path.exists() {
        return Err(OpenError::Unknown {
            name: scene.to_owned(),
        });
    }
    Ok(gltf::load(path, clip)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_open_built_in_scenes_and_errors_help() {
        for name in BUILTIN {
            let opened = open(name, None).expect("built in");
            assert_eq!(opened.scene.name, name);
            assert!(open(name, Some("walk")).is_err());
        }
        let error = |scene| open(scene, None).expect_err("no such scene").to_string();
        assert!(
            error("interactif").contains(BUILTIN[0]),
            "{}",
            error("interactif")
        );
        assert!(
            error("gone.glb").contains("cannot read gone.glb"),
            "{}",
            error("gone.glb")
        );
    }
}
