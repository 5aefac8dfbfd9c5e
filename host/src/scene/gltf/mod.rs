//! glTF 2.0 files as scenes, and scenes as glTF files.
//!
//! # What is read
//! Triangles, strips and fans with 8, 16 and 32-bit indices, sparse accessors, normalised
//! integers; the node hierarchy of the default scene; skins with four joints a vertex; STEP,
//! LINEAR and CUBICSPLINE keyframes of translation, rotation and scale on any node, the camera
//! too; base-colour and emissive textures (PNG, JPEG; files, `data:` URIs or buffer views),
//! vertex colours, metallic-roughness factors, alpha masks; `KHR_lights_punctual`,
//! `KHR_materials_emissive_strength`, `KHR_materials_transmission`, `KHR_materials_ior`,
//! `KHR_materials_unlit`, `KHR_texture_transform`.
//!
//! From `extras`: of the root `medium = {aabb, sigma_s, sigma_a, g}` (per metre) and
//! `unframed.sky = {zenith, horizon, ambient}`; of a camera or its node `aperture` and `focus`
//! (metres); of an animation `period` (seconds, the length of its loop).
//!
//! # What is replaced, with a [`Warning`]
//! Normal, occlusion and transmission textures are not used; a metallic-roughness texture counts
//! as its mean; alpha blending becomes transmission or a mask; morph targets stay at rest;
//! points and lines are left out; an orthographic camera is shown in perspective.
//!
//! # Units
//! Metres. Intensities of lights are taken as they stand: candela as W/sr, lux as W/m², nits of
//! emissive surfaces as W/(m²·sr), all on a display that shows radiance 1 as white. If that
//! would overexpose the scene's centre many times (files in photometric units), all punctual
//! lights are scaled by one factor.
//!
//! # Trust
//! A file is untrusted input: every index, offset and count is checked before use, allocations
//! are bounded by the size of the file (or a stated limit), and faults are errors that name the
//! place.

mod accessor;
mod animation;
mod dress;
mod error;
mod export;
mod extras;
mod material;
mod mesh;
mod nodes;
mod source;

pub use dress::{ORBIT_ELEVATION, ORBIT_SECONDS, ORBIT_YFOV};
pub use error::{Fault, LoadError, Warning};
pub use export::{ExportError, export};

use super::Scene;
use error::Warnings;
use source::Source;
use std::path::Path;

/// A scene from a file, and what in it is shown differently from what its author meant.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene, complete: it has a camera and light.
    pub scene: Scene,
    /// In the order of the file.
    pub warnings: Vec<Warning>,
}

/// Loads a `.glb` or `.gltf` file.
///
/// All its clips play together from time 0, each looping at its own length, unless `clip` names
/// one; see [`animation`](self::animation) for clips that exclude each other. A file without a
/// camera gets one that orbits it, a file without light a neutral sky and a key light.
///
/// # Errors
/// The file cannot be read, is broken, requires an extension that is not supported, has no clip
/// of that name, or shows nothing. Never panics, whatever the bytes.
pub fn load(path: &Path, clip: Option<&str>) -> Result<Loaded, LoadError> {
    convert(&Source::open(path)?, path, clip)
}

/// The same from bytes in memory; `path` is for messages and the folder of relative URIs.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(bytes: &[u8], path: &Path, clip: Option<&str>) -> Result<Loaded, LoadError> {
    let base = path.parent().map(Path::to_owned).unwrap_or_default();
    convert(&Source::from_bytes(bytes, path, base)?, path, clip)
}

fn convert(source: &Source, file: &Path, clip: Option<&str>) -> Result<Loaded, LoadError> {
    let content = |fault| LoadError::Content {
        file: file.to_owned(),
        fault,
    };
    let names = animation::names(source);
    let only =
        match clip {
            None => None,
            Some(wanted) => Some(names.iter().position(|name| name == wanted).ok_or_else(
                || LoadError::Clip {
                    file: file.to_owned(),
                    wanted: wanted.to_owned(),
                    names: names.clone(),
                },
            )?),
        };
    let mut warnings = Warnings::default();
    let (mut scene, open) = assemble(source, only, file, &mut warnings).map_err(content)?;
    if !scene.nodes.iter().any(|n| {
        n.mesh
            .is_some_and(|m| !scene.meshes[m].primitives.is_empty())
    }) {
        return Err(LoadError::Empty {
            file: file.to_owned(),
        });
    }
    dress::complete(
        &mut scene,
        open.own_sky,
        open.focus_missing,
        open.orthographic,
        &mut warnings,
    )
    .map_err(content)?;
    Ok(Loaded {
        scene,
        warnings: warnings.0,
    })
}

/// What [`dress::complete`] needs to know besides the scene.
struct Open {
    own_sky: bool,
    focus_missing: bool,
    orthographic: Option<f32>,
}

fn assemble(
    source: &Source,
    clip: Option<usize>,
    file: &Path,
    warnings: &mut Warnings,
) -> Result<(Scene, Open), Fault> {
    let known = gltf::json::extensions::ENABLED_EXTENSIONS;
    for extension in source
        .document
        .extensions_used()
        .filter(|name| !known.contains(name))
    {
        warnings.add("extensionsUsed", format!("{extension} is ignored"));
    }
    let mut materials = material::Materials::load(source, warnings)?;
    let meshes = mesh::load(source, &mut materials, warnings)?;
    let mut nodes = nodes::load(source, warnings)?;
    let skins = nodes::load_skins(source, &mut nodes, &meshes)?;
    let channels = animation::load(source, &mut nodes, clip, warnings)?;
    let root = extras::parse(&source.document.as_json().extras);
    let sky = extras::sky(&root)?;
    let open = Open {
        own_sky: sky.is_some(),
        focus_missing: nodes.focus_missing,
        orthographic: nodes.orthographic,
    };
    let name = file
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let duration = channels
        .iter()
        .map(|c| f64::from(c.period))
        .fold(0.0, f64::max);
    let scene = Scene {
        name,
        nodes: nodes.nodes,
        meshes,
        materials: materials.materials,
        textures: materials.textures,
        skins,
        channels,
        duration,
        sky: sky.unwrap_or_default(),
        medium: extras::medium(&root)?,
        indirect: extras::indirect(&root),
    };
    Ok((scene, open))
}

#[cfg(test)]
mod tests;
