//! The node hierarchy (glTF 2.0 §3.5), lights, cameras and skins.

use super::error::{Fault, Warnings, place};
use super::extras;
use super::source::Source;
use crate::scene::{Lens, Light, LightKind, Mesh, Node, Skin};
use glam::{Mat4, Quat, Vec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::scene::Transform;
use std::f32::consts::{FRAC_PI_2, PI};

/// The nodes of a file in our order.
pub(super) struct Nodes {
    /// Parents before children.
    pub(super) nodes: Vec<Node>,
    /// From the file's index of a node to ours.
    pub(super) ours: Vec<usize>,
    /// Whether the first camera's lens came without a distance in focus.
    pub(super) focus_missing: bool,
    /// Height of the view of an orthographic first camera, metres.
    pub(super) orthographic: Option<f32>,
}

/// Converts all nodes: first those of the file's scene, depth first; then the others, which carry
/// transforms only (a skin may refer to them).
pub(super) fn load(source: &Source, warnings: &mut Warnings) -> Result<Nodes, Fault> {
    let order = order(source)?;
    let mut ours = vec![0; order.len()];
    for (index, visit) in order.iter().enumerate() {
        ours[visit.node.index()] = index;
    }
    let mut all = Nodes {
        nodes: Vec::new(),
        ours,
        focus_missing: false,
        orthographic: None,
    };
    for visit in &order {
        let node = &visit.node;
        let at = place("node", node.index(), node.name());
        let (translation, rotation, scale) = transform(node, &at, warnings)?;
        let mut converted = Node {
            name: node.name().map_or_else(|| at.clone(), str::to_owned),
            parent: visit.parent.map(|parent| all.ours[parent]),
            translation,
            rotation,
            scale,
            ..Node::default()
        };
        if visit.shown {
            converted.mesh = node.mesh().map(|mesh| mesh.index());
            converted.skin = node.skin().map(|skin| skin.index());
            converted.light = node.light().map(|l| light(&l, &at, warnings)).transpose()?;
            if let Some(camera) = node.camera() {
                let first = all.nodes.iter().all(|n: &Node| n.camera.is_none());
                converted.camera = Some(lens(&camera, node, first, &mut all, &at, warnings)?);
            }
        }
        all.nodes.push(converted);
    }
    Ok(all)
}

/// A node in the order of the hierarchy.
struct Visit<'a> {
    node: gltf::Node<'a>,
    parent: Option<usize>,
    shown: bool,
}

fn order(source: &Source) -> Result<Vec<Visit<'_>>, Fault> {
    let document = &source.document;
    let count = document.nodes().len();
    let mut is_child = vec![false; count];
    for node in document.nodes() {
        for child in node.children() {
            is_child[child.index()] = true;
        }
    }
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let roots = |shown: bool| {
        document
            .nodes()
            .filter(|n| !is_child[n.index()])
            .map(move |n| (n, shown))
    };
    let mut starts: Vec<_> = match &scene {
        Some(scene) => scene.nodes().map(|node| (node, true)).collect(),
        None => roots(true).collect(),
    };
    let listed = starts.len();
    starts.extend(roots(false));
    let mut order = Vec::with_capacity(count);
    let mut visited = vec![false; count];
    for (i, (start, shown)) in starts.into_iter().enumerate() {
        if i >= listed && visited[start.index()] {
            continue;
        }
        let mut stack = vec![Visit {
            node: start,
            parent: None,
            shown,
        }];
        while let Some(visit) = stack.pop() {
            let index = visit.node.index();
            if std::mem::replace(&mut visited[index], true) {
                return Err(Fault::new(
                    place("node", index, visit.node.name()),
                    "has two parents or is its own ancestor; node hierarchies are trees",
                ));
            }
            let children: Vec<_> = visit.node.children().collect();
            for child in children.into_iter().rev() {
                stack.push(Visit {
                    node: child,
                    parent: Some(index),
                    shown: visit.shown,
                });
            }
            order.push(visit);
        }
    }
    match visited.iter().position(|v| !v) {
        Some(index) => Err(Fault::new(
            place("node", index, None),
            "is its own ancestor",
        )),
        None => Ok(order),
    }
}

fn transform(
    node: &gltf::Node,
    at: &str,
    warnings: &mut Warnings,
) -> Result<(Vec3, Quat, Vec3), Fault> {
    let (translation, rotation, scale) = match node.transform() {
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => (
            Vec3::from(translation),
            Quat::from_array(rotation),
            Vec3::from(scale),
        ),
        Transform::Matrix { matrix } => {
            let matrix = Mat4::from_cols_array_2d(&matrix);
            if !matrix.is_finite() {
                return Err(Fault::new(at, "its matrix is not finite"));
            }
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            if !(rotation.is_finite() && scale.is_finite()) {
                warnings.add(at, "its matrix is singular: its rotation is left out");
                let lengths = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|a| a.length());
                return Ok((translation, Quat::IDENTITY, Vec3::from(lengths)));
            }
            let rebuilt = Mat4::from_scale_rotation_translation(scale, rotation, translation);
            let size = scale.abs().max_element();
            if !rebuilt.abs_diff_eq(matrix, 1e-3 * size.max(translation.abs().max_element())) {
                warnings.add(
                    at,
                    "its matrix shears: only its rotation and scale are kept",
                );
            }
            (translation, rotation, scale)
        }
    };
    if !(translation.is_finite() && rotation.is_finite() && scale.is_finite()) {
        return Err(Fault::new(at, "its transform is not finite"));
    }
    Ok((translation, unit(rotation), scale))
}

/// The unit quaternion along `q`; the identity where that has no direction.
pub(super) fn unit(q: Quat) -> Quat {
    let length = q.length();
    if length > 1e-12 && length.is_finite() {
        q / length
    } else {
        Quat::IDENTITY
    }
}

fn light(
    light: &gltf::khr_lights_punctual::Light,
    at: &str,
    warnings: &mut Warnings,
) -> Result<Light, Fault> {
    let intensity = Vec3::from(light.color()) * light.intensity();
    let kind = match light.kind() {
        Kind::Point => LightKind::Point,
        Kind::Directional => LightKind::Directional,
        Kind::Spot {
            inner_cone_angle: inner,
            outer_cone_angle: outer,
        } => {
            if !(inner >= 0.0 && inner <= outer && outer <= FRAC_PI_2 && outer > 0.0) {
                warnings.add(
                    at,
                    "the angles of its spot light are clamped to 0 ≤ inner ≤ outer ≤ π/2",
                );
            }
            let sane = |angle: f32| if angle.is_finite() { angle } else { 0.0 };
            let outer = sane(outer).clamp(1e-3, FRAC_PI_2);
            LightKind::Spot {
                inner: sane(inner).clamp(0.0, outer),
                outer,
            }
        }
    };
    let range = light.range().filter(|r| *r > 0.0).unwrap_or(f32::INFINITY);
    if !(intensity.is_finite() && intensity.min_element() >= 0.0) {
        return Err(Fault::new(
            at,
            "its light's colour times intensity is negative or not finite",
        ));
    }
    Ok(Light {
        kind,
        intensity,
        range,
    })
}

fn lens(
    camera: &gltf::Camera,
    node: &gltf::Node,
    first: bool,
    all: &mut Nodes,
    at: &str,
    warnings: &mut Warnings,
) -> Result<Lens, Fault> {
    // The aperture belongs to the camera, but tools often put extras on its node.
    let (camera_extras, node_extras) =
        (extras::parse(camera.extras()), extras::parse(node.extras()));
    let find = |key| extras::number(&camera_extras, key).or(extras::number(&node_extras, key));
    let aperture = find("aperture").unwrap_or(0.0);
    let focus = find("focus");
    if aperture < 0.0 || focus.is_some_and(|f| f <= 0.0) {
        return Err(Fault::new(
            at,
            "extras.aperture must be 0 or more and extras.focus above 0",
        ));
    }
    let yfov = match camera.projection() {
        Projection::Perspective(p) => p.yfov(),
        Projection::Orthographic(o) => {
            let height = 2.0 * o.ymag().abs();
            if !(height > 0.0 && height.is_finite()) {
                return Err(Fault::new(
                    at,
                    "the ymag of its orthographic camera is not a height",
                ));
            }
            if first {
                all.orthographic = Some(height);
            }
            warnings.add(at, "its orthographic camera is shown in perspective");
            PI / 4.0
        }
    };
    if !(yfov > 0.0 && yfov < PI) {
        return Err(Fault::new(
            at,
            format!("a yfov of {yfov} is not between 0 and π"),
        ));
    }
    all.focus_missing |= first && focus.is_none();
    Ok(Lens {
        yfov,
        aperture,
        focus: focus.unwrap_or(1.0),
    })
}

/// Converts all skins and checks that every skinned mesh stays within the joints of its skin.
pub(super) fn load_skins(
    source: &Source,
    all: &mut Nodes,
    meshes: &[Mesh],
) -> Result<Vec<Skin>, Fault> {
    let mut skins = Vec::new();
    for skin in source.document.skins() {
        let at = place("skin", skin.index(), skin.name());
        let joints: Vec<usize> = skin.joints().map(|joint| all.ours[joint.index()]).collect();
        if joints.is_empty() {
            return Err(Fault::new(at, "has no joints"));
        }
        let inverse_bind = match skin.inverse_bind_matrices() {
            Some(accessor) => source
                .floats::<16>(&accessor, &format!("{at}, inverseBindMatrices"))?
                .iter()
                .map(Mat4::from_cols_array)
                .collect(),
            None => vec![Mat4::IDENTITY; joints.len()],
        };
        if inverse_bind.len() < joints.len() {
            let reason = format!(
                "{} inverse bind matrices for {} joints",
                inverse_bind.len(),
                joints.len()
            );
            return Err(Fault::new(at, reason));
        }
        let inverse_bind = inverse_bind[..joints.len()].to_vec();
        skins.push(Skin {
            joints,
            inverse_bind,
        });
    }
    for node in &mut all.nodes {
        let (Some(skin), Some(mesh)) = (node.skin, node.mesh.map(|mesh| &meshes[mesh])) else {
            node.skin = None;
            continue;
        };
        let joints = skins[skin].joints.len();
        let used = mesh
            .primitives
            .iter()
            .flat_map(|p| p.joints.iter().flatten())
            .max();
        match used {
            None => node.skin = None,
            Some(&joint) if usize::from(joint) >= joints => {
                return Err(Fault::new(
                    format!("mesh {:?}", mesh.name),
                    format!("refers to joint {joint} and its skin {skin} has {joints}"),
                ));
            }
            Some(_) => {}
        }
    }
    Ok(skins)
}
