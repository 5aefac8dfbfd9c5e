//! Scenes as binary glTF 2.0 files (one `.glb`, nothing external).
//!
//! Everything that [`super::load`] reads is written, so that a round trip keeps the scene.
//! Procedural patterns become textures ([`bake`]); what glTF has no place for goes to the root
//! `extras`: the medium, and the sky under `unframed`. Each period of the animation becomes a
//! clip, padded so that other programs loop it at the same length.

mod animation;
mod bake;
mod buffer;
mod material;

use crate::scene::{LightKind, Node, Primitive, Scene};
use buffer::{Buffer, Component};
use glam::Vec3;
use serde_json::{Value, json};

/// Why a scene cannot be written as glTF.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// An index points beyond the list it is for.
    #[error("scene {scene:?}, {place}: index {index} is out of range; mend the scene")]
    Index {
        /// Name of the scene.
        scene: String,
        /// Where the index stands.
        place: String,
        /// The index.
        index: usize,
    },
    /// A material with both an image and a pattern, which one glTF texture cannot say.
    #[error("material {0:?} has both a base texture and a procedural pattern; keep one")]
    TwoTextures(String),
    /// A texture whose size does not fit its texels, or that PNG cannot hold.
    #[error("texture {name:?} cannot be written as PNG: {reason}")]
    Texture {
        /// Name of the texture or material.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// The limit of the GLB container.
    #[error("the scene has {0} bytes of data, a .glb holds less than 4 GiB; split it")]
    TooLarge(usize),
}

/// Writes a scene as a `.glb`.
///
/// # Errors
/// The scene contradicts itself or does not fit the container.
pub fn export(scene: &Scene) -> Result<Vec<u8>, ExportError> {
    check_indices(scene)?;
    let mut writer = Writer::default();
    for material in &scene.materials {
        writer.material(scene, material)?;
    }
    let meshes: Vec<Value> = scene
        .meshes
        .iter()
        .map(|mesh| {
            let primitives: Vec<Value> = mesh
                .primitives
                .iter()
                .filter_map(|p| writer.primitive(p))
                .collect();
            (mesh, primitives)
        })
        .map(|(mesh, primitives)| json!({ "name": mesh.name, "primitives": primitives }))
        .collect();
    // glTF has no empty meshes; nodes that refer to one refer to nothing.
    let kept: Vec<Option<usize>> = numbered(&meshes, |mesh| mesh["primitives"] != json!([]));
    let meshes: Vec<Value> = meshes
        .into_iter()
        .zip(&kept)
        .filter(|(_, k)| k.is_some())
        .map(|(m, _)| m)
        .collect();
    let nodes: Vec<Value> = scene
        .nodes
        .iter()
        .enumerate()
        .map(|(index, node)| writer.node(scene, index, node, &kept))
        .collect();
    let skins: Vec<Value> = scene
        .skins
        .iter()
        .map(|skin| {
            let matrices: Vec<f32> = skin
                .inverse_bind
                .iter()
                .flat_map(|m| m.to_cols_array())
                .collect();
            let accessor = writer.buffer.floats(&matrices, "MAT4", false);
            json!({ "joints": skin.joints, "inverseBindMatrices": accessor })
        })
        .collect();
    let animations = writer.animations(&scene.channels);
    let roots: Vec<usize> = (0..scene.nodes.len())
        .filter(|&n| scene.nodes[n].parent.is_none())
        .collect();
    let sky = &scene.sky;
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "unframed" },
        "scene": 0,
        "scenes": [{ "name": scene.name, "nodes": roots }],
        "extras": { "unframed": { "sky": {
            "zenith": sky.zenith.to_array(),
            "horizon": sky.horizon.to_array(),
            "ambient": sky.ambient.to_array(),
        } } },
    });
    if scene.indirect {
        root["extras"]["indirect"] = json!(true);
    }
    if let Some(m) = &scene.medium {
        root["extras"]["medium"] = json!({
            "aabb": [m.min.to_array(), m.max.to_array()],
            "sigma_s": m.sigma_s, "sigma_a": m.sigma_a, "g": m.g,
        });
    }
    let lists = [
        ("nodes", nodes),
        ("meshes", meshes),
        ("skins", skins),
        ("animations", animations),
        ("materials", writer.materials),
        ("textures", writer.textures),
        ("images", writer.images),
        ("samplers", writer.samplers),
        ("cameras", writer.cameras),
    ];
    // glTF forbids empty lists.
    for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
        root[name] = Value::Array(list);
    }
    if !writer.lights.is_empty() {
        root["extensions"] = json!({ "KHR_lights_punctual": { "lights": writer.lights } });
        writer.extensions.push("KHR_lights_punctual");
    }
    writer.extensions.sort_unstable();
    writer.extensions.dedup();
    if !writer.extensions.is_empty() {
        root["extensionsUsed"] = json!(writer.extensions);
    }
    writer.buffer.into_glb(root)
}

/// The new index of each item that is kept.
fn numbered<T>(items: &[T], keep: impl Fn(&T) -> bool) -> Vec<Option<usize>> {
    let mut next = 0..;
    items
        .iter()
        .map(|item| if keep(item) { next.next() } else { None })
        .collect()
}

/// All that is written, list by list.
#[derive(Default)]
struct Writer {
    buffer: Buffer,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    extensions: Vec<&'static str>,
    /// For each of the scene's textures, its index in `textures`, once written.
    written: Vec<(usize, usize)>,
}

impl Writer {
    /// A primitive; `None` when it has no triangle, which glTF cannot say.
    fn primitive(&mut self, p: &Primitive) -> Option<Value> {
        if p.indices.is_empty() || p.positions.is_empty() {
            return None;
        }
        let buffer = &mut self.buffer;
        let flat3 = |v: &[Vec3]| v.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>();
        let mut attributes =
            json!({ "POSITION": buffer.floats(&flat3(&p.positions), "VEC3", true) });
        if !p.normals.is_empty() {
            attributes["NORMAL"] = buffer.floats(&flat3(&p.normals), "VEC3", false);
        }
        if !p.uvs.is_empty() {
            let uvs: Vec<f32> = p.uvs.iter().flat_map(|v| v.to_array()).collect();
            attributes["TEXCOORD_0"] = buffer.floats(&uvs, "VEC2", false);
        }
        if !p.colours.is_empty() {
            let colours: Vec<f32> = p.colours.iter().flat_map(|v| v.to_array()).collect();
            attributes["COLOR_0"] = buffer.floats(&colours, "VEC4", false);
        }
        if !p.joints.is_empty() {
            let joints: Vec<u8> = p
                .joints
                .iter()
                .flatten()
                .flat_map(|joint| joint.to_le_bytes())
                .collect();
            let count = p.joints.len();
            attributes["JOINTS_0"] = buffer.accessor(&joints, Component::U16, "VEC4", count);
            attributes["WEIGHTS_0"] = buffer.floats(p.weights.as_flattened(), "VEC4", false);
        }
        let indices = buffer.indices(p.indices.as_flattened(), p.positions.len());
        Some(json!({ "attributes": attributes, "indices": indices, "material": p.material }))
    }

    fn node(
        &mut self,
        scene: &Scene,
        index: usize,
        node: &Node,
        meshes: &[Option<usize>],
    ) -> Value {
        let mut written = json!({
            "name": node.name,
            "translation": node.translation.to_array(),
            "rotation": node.rotation.to_array(),
            "scale": node.scale.to_array(),
        });
        let children: Vec<usize> = (0..scene.nodes.len())
            .filter(|&n| scene.nodes[n].parent == Some(index))
            .collect();
        if !children.is_empty() {
            written["children"] = json!(children);
        }
        if let Some(mesh) = node.mesh.and_then(|mesh| meshes[mesh]) {
            written["mesh"] = json!(mesh);
            if let Some(skin) = node.skin {
                written["skin"] = json!(skin);
            }
        }
        if let Some(lens) = &node.camera {
            written["camera"] = json!(self.cameras.len());
            self.cameras.push(json!({
                "type": "perspective",
                "perspective": { "yfov": lens.yfov, "znear": 0.01 },
                "extras": { "aperture": lens.aperture, "focus": lens.focus },
            }));
        }
        if let Some(light) = &node.light {
            // The format asks for a colour of at most 1.
            let strength = light.intensity.max_element();
            let colour = if strength > 0.0 {
                light.intensity / strength
            } else {
                Vec3::ONE
            };
            let mut value = json!({ "color": colour.to_array(), "intensity": strength });
            value["type"] = json!(match light.kind {
                LightKind::Point => "point",
                LightKind::Directional => "directional",
                LightKind::Spot { inner, outer } => {
                    value["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
                    "spot"
                }
            });
            if light.range.is_finite() {
                value["range"] = json!(light.range);
            }
            written["extensions"] =
                json!({ "KHR_lights_punctual": { "light": self.lights.len() } });
            self.lights.push(value);
        }
        written
    }
}

fn check_indices(scene: &Scene) -> Result<(), ExportError> {
    let check = |place: String, index: usize, count: usize| {
        if index < count {
            return Ok(());
        }
        Err(ExportError::Index {
            scene: scene.name.clone(),
            place,
            index,
        })
    };
    for (i, node) in scene.nodes.iter().enumerate() {
        let at = || format!("node {:?}", node.name);
        node.parent
            .map_or(Ok(()), |parent| check(at(), parent, i))?;
        node.mesh
            .map_or(Ok(()), |mesh| check(at(), mesh, scene.meshes.len()))?;
        node.skin
            .map_or(Ok(()), |skin| check(at(), skin, scene.skins.len()))?;
    }
    for mesh in &scene.meshes {
        for p in &mesh.primitives {
            let at = || format!("mesh {:?}", mesh.name);
            check(at(), p.material, scene.materials.len())?;
            for &vertex in p.indices.as_flattened() {
                check(at(), vertex as usize, p.positions.len())?;
            }
        }
    }
    for material in &scene.materials {
        for used in [&material.base_texture, &material.emissive_texture]
            .into_iter()
            .flatten()
        {
            check(
                format!("material {:?}", material.name),
                used.texture,
                scene.textures.len(),
            )?;
        }
    }
    for (i, channel) in scene.channels.iter().enumerate() {
        check(format!("channel {i}"), channel.node, scene.nodes.len())?;
    }
    for (i, skin) in scene.skins.iter().enumerate() {
        for &joint in &skin.joints {
            check(format!("skin {i}"), joint, scene.nodes.len())?;
        }
    }
    Ok(())
}
