//! Whether a scene can be traced at all: every index in range, every number finite.

use crate::effects::BUILT_IN;
use crate::scene::calls;
use crate::scene::model::{Channel, Interpolation, Primitive, Scene, Track};

/// Widest and highest image, pixels (as on the wire).
pub const MAX_SIZE: u32 = 4096;

/// Effects of the feature `effects`.
const OPTIONAL: [&str; 3] = ["soft_shadows", "indirect_diffuse", "medium"];

/// Why a scene cannot be made ready.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WorldError {
    /// The image has no pixels or too many.
    #[error("image size {0}x{1}: give a width and a height of 1 to {MAX_SIZE} pixels")]
    Size(u32, u32),
    /// The scene calls for what this program was built without.
    #[error("scene '{scene}' calls for {effect}: build with the feature `effects`")]
    LeftOut {
        /// Name of the scene.
        scene: String,
        /// The effect.
        effect: &'static str,
    },
    /// The scene contradicts itself.
    #[error("scene '{scene}', {place}: {problem}")]
    Broken {
        /// Name of the scene.
        scene: String,
        /// Which part.
        place: String,
        /// What is wrong with it.
        problem: &'static str,
    },
}

/// Checks all that the tracer relies on, so that it never has to look again.
pub(crate) fn check(scene: &Scene, size: [u32; 2]) -> Result<(), WorldError> {
    if size.iter().any(|s| !(1..=MAX_SIZE).contains(s)) {
        return Err(WorldError::Size(size[0], size[1]));
    }
    let broken = |place: String, problem| {
        Err(WorldError::Broken {
            scene: scene.name.clone(),
            place,
            problem,
        })
    };
    for (i, node) in scene.nodes.iter().enumerate() {
        let place = || format!("node {i} '{}'", node.name);
        if node.parent.is_some_and(|p| p >= i) {
            return broken(place(), "its parent does not stand before it");
        }
        if node.mesh.is_some_and(|m| m >= scene.meshes.len()) {
            return broken(place(), "there is no such mesh");
        }
        if node.skin.is_some_and(|s| s >= scene.skins.len()) {
            return broken(place(), "there is no such skin");
        }
        if !(node.translation.is_finite() && node.rotation.is_finite() && node.scale.is_finite()) {
            return broken(place(), "its transform is not finite");
        }
        if node
            .camera
            .is_some_and(|c| !(c.yfov > 0.0 && c.yfov < std::f32::consts::PI))
        {
            return broken(
                place(),
                "the field of view must be above 0 and below 180 degrees",
            );
        }
        if let (Some(mesh), Some(skin)) = (node.mesh, node.skin) {
            let joints = scene.skins[skin].joints.len();
            let all = scene.meshes[mesh]
                .primitives
                .iter()
                .flat_map(|p| &p.joints)
                .flatten();
            if joints == 0 || all.max().is_some_and(|&j| usize::from(j) >= joints) {
                return broken(place(), "a vertex names a joint that its skin lacks");
            }
        }
    }
    for (i, mesh) in scene.meshes.iter().enumerate() {
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(problem) = primitive_problem(scene, primitive) {
                return broken(format!("mesh {i} '{}', primitive {k}", mesh.name), problem);
            }
        }
    }
    for (i, skin) in scene.skins.iter().enumerate() {
        let bad = skin.joints.iter().any(|&j| j >= scene.nodes.len())
            || skin.inverse_bind.len() != skin.joints.len();
        if bad {
            return broken(format!("skin {i}"), "its joints and matrices do not match");
        }
    }
    for (i, texture) in scene.textures.iter().enumerate() {
        let pixels = u64::from(texture.width) * u64::from(texture.height);
        if pixels == 0 || pixels != texture.rgba.len() as u64 {
            let place = format!("texture {i} '{}'", texture.name);
            return broken(place, "its pixels do not fill width times height");
        }
    }
    for (i, channel) in scene.channels.iter().enumerate() {
        if let Some(problem) = channel_problem(scene, channel) {
            return broken(format!("animation channel {i}"), problem);
        }
    }
    if !BUILT_IN
        && let Some(call) =
            (calls::effects(scene).into_iter()).find(|e| e.called_for && OPTIONAL.contains(&e.name))
    {
        return Err(WorldError::LeftOut {
            scene: scene.name.clone(),
            effect: call.name,
        });
    }
    Ok(())
}

fn primitive_problem(scene: &Scene, p: &Primitive) -> Option<&'static str> {
    let vertices = p.positions.len();
    let fits = |n: usize| n == 0 || n == vertices;
    if p.material >= scene.materials.len() {
        Some("there is no such material")
    } else if p.positions.iter().any(|v| !v.is_finite()) {
        Some("a position is not finite")
    } else if p.indices.iter().flatten().any(|&i| i as usize >= vertices) {
        Some("an index points past the last vertex")
    } else if !(fits(p.normals.len()) && fits(p.uvs.len()) && fits(p.colours.len())) {
        Some("an attribute does not have one value a vertex")
    } else if !(fits(p.joints.len()) && p.joints.len() == p.weights.len()) {
        Some("joints and weights do not have one value a vertex")
    } else {
        None
    }
}

fn channel_problem(scene: &Scene, channel: &Channel) -> Option<&'static str> {
    let values = match &channel.track {
        Track::Translation(v) | Track::Scale(v) => {
            if v.iter().any(|v| !v.is_finite()) {
                return Some("a key is not finite");
            }
            v.len()
        }
        Track::Rotation(v) => {
            if v.iter().any(|q| !q.is_finite()) {
                return Some("a key is not finite");
            }
            v.len()
        }
    };
    let each = if channel.interpolation == Interpolation::CubicSpline {
        3
    } else {
        1
    };
    if channel.node >= scene.nodes.len() {
        Some("there is no such node")
    } else if channel.times.is_empty() || values != each * channel.times.len() {
        Some("it does not have the values that its key times call for")
    } else if !channel.times.iter().all(|t| t.is_finite())
        || channel.times.windows(2).any(|w| w[0] > w[1])
    {
        Some("its key times do not ascend")
    } else if !channel.period.is_finite() {
        Some("its period is not finite")
    } else {
        None
    }
}
