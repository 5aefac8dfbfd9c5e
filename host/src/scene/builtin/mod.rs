//! Scenes made in code, after the test animations of Dayal et al. 2005 (§7): scenes that hurt.

mod interactive;
mod shapes;
mod stage;
mod toycar;
mod walkthrough;

use crate::scene::model::Scene;

/// Names of the built-in scenes.
pub const BUILTIN: [&str; 3] = ["interactive", "walkthrough", "toycar"];

/// A built-in scene by name.
#[must_use]
pub fn builtin(name: &str) -> Option<Scene> {
    match name {
        "interactive" => Some(interactive::scene()),
        "walkthrough" => Some(walkthrough::scene()),
        "toycar" => Some(toycar::scene()),
        _ => None,
    }
}
