//! Meshes (glTF 2.0 §3.7): triangles, strips and fans become lists of vertex indices in range.

use super::error::{Fault, Warnings, place};
use super::material::Materials;
use super::source::Source;
use crate::scene::{Mesh, Primitive};
use glam::{Vec2, Vec3, Vec4};
use gltf::Semantic;
use gltf::mesh::Mode;

/// Converts all meshes of a file. A mesh whose primitives are all left out stays, empty, so that
/// indices hold.
pub(super) fn load(
    source: &Source,
    materials: &mut Materials,
    warnings: &mut Warnings,
) -> Result<Vec<Mesh>, Fault> {
    let mut meshes = Vec::new();
    for mesh in source.document.meshes() {
        let at = place("mesh", mesh.index(), mesh.name());
        if mesh.weights().is_some() {
            warnings.add(&at, "morph targets are left at rest");
        }
        let mut primitives = Vec::new();
        for primitive in mesh.primitives() {
            let at = format!("{at}, primitive {}", primitive.index());
            if primitive
                .attributes()
                .any(|(_, accessor)| accessor.count() == 0)
            {
                warnings.add(&at, "has no vertices and is left out");
                continue;
            }
            primitives.extend(load_primitive(
                source, &primitive, materials, &at, warnings,
            )?);
        }
        let name = mesh.name().map_or_else(|| at.clone(), str::to_owned);
        meshes.push(Mesh { name, primitives });
    }
    Ok(meshes)
}

fn load_primitive(
    source: &Source,
    primitive: &gltf::Primitive,
    materials: &mut Materials,
    at: &str,
    warnings: &mut Warnings,
) -> Result<Option<Primitive>, Fault> {
    let mode = primitive.mode();
    if !matches!(
        mode,
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
    ) {
        warnings.add(at, format!("{mode:?} are not surfaces and are left out"));
        return Ok(None);
    }
    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        warnings.add(at, "has no POSITION and is left out");
        return Ok(None);
    };
    let positions: Vec<Vec3> = source
        .floats::<3>(&accessor, &format!("{at}, POSITION"))?
        .into_iter()
        .map(Vec3::from)
        .collect();
    let indices = triangles(source, primitive, positions.len(), at)?;
    if indices.is_empty() {
        warnings.add(at, "has no triangle and is left out");
        return Ok(None);
    }
    let material = match primitive.material().index() {
        Some(index) => index,
        None => materials.default_material(),
    };
    let mut loaded = Primitive {
        positions,
        indices,
        material,
        ..Primitive::default()
    };
    load_attributes(source, primitive, materials, &mut loaded, at, warnings)?;
    Ok(Some(loaded))
}

fn load_attributes(
    source: &Source,
    primitive: &gltf::Primitive,
    materials: &Materials,
    loaded: &mut Primitive,
    at: &str,
    warnings: &mut Warnings,
) -> Result<(), Fault> {
    let count = loaded.positions.len();
    let find = |semantic: Semantic, name: &str| -> Result<_, Fault> {
        let at = format!("{at}, {name}");
        match primitive.get(&semantic) {
            Some(a) if a.count() != count => {
                let reason = format!("has {} elements for {count} vertices", a.count());
                Err(Fault::new(at, reason))
            }
            Some(accessor) => Ok(Some((accessor, at))),
            None => Ok(None),
        }
    };
    if let Some((accessor, at)) = find(Semantic::Normals, "NORMAL")? {
        let normals = source.floats::<3>(&accessor, &at)?;
        loaded.normals = normals
            .into_iter()
            .map(|n| Vec3::from(n).normalize_or_zero())
            .collect();
        mend_normals(loaded);
    }
    let coordinates = materials.coordinates[loaded.material];
    let set = coordinates.set;
    let textured = {
        let material = &materials.materials[loaded.material];
        material.base_texture.is_some() || material.emissive_texture.is_some()
    };
    match find(Semantic::TexCoords(set), &format!("TEXCOORD_{set}"))? {
        Some((accessor, at)) => {
            let place_uv = |uv: [f32; 2]| match coordinates.baked {
                Some((matrix, offset)) => matrix * Vec2::from(uv) + offset,
                None => Vec2::from(uv),
            };
            loaded.uvs = source
                .floats::<2>(&accessor, &at)?
                .into_iter()
                .map(place_uv)
                .collect();
        }
        None if textured => {
            warnings.add(at, format!("is textured but has no TEXCOORD_{set}"));
        }
        None => {}
    }
    if let Some((accessor, at)) = find(Semantic::Colors(0), "COLOR_0")? {
        loaded.colours = if accessor.dimensions().multiplicity() == 3 {
            let colours = source.floats::<3>(&accessor, &at)?;
            colours
                .into_iter()
                .map(|c| Vec3::from(c).extend(1.0))
                .collect()
        } else {
            source
                .floats::<4>(&accessor, &at)?
                .into_iter()
                .map(Vec4::from)
                .collect()
        };
    }
    let joints = find(Semantic::Joints(0), "JOINTS_0")?;
    let weights = find(Semantic::Weights(0), "WEIGHTS_0")?;
    if let (Some((joints, joints_at)), Some((weights, weights_at))) = (joints, weights) {
        let joints = source.integers::<4>(&joints, &joints_at)?;
        let weights = source.floats::<4>(&weights, &weights_at)?;
        for (joints, weights) in joints.into_iter().zip(weights) {
            let (joints, weights) = influences(joints, weights);
            loaded.joints.push(joints);
            loaded.weights.push(weights);
        }
        if primitive.get(&Semantic::Joints(1)).is_some() {
            warnings.add(at, "only the first four joints of a vertex are used");
        }
    }
    if primitive.morph_targets().len() > 0 {
        warnings.add(at, "morph targets are left at rest");
    }
    Ok(())
}

/// Joints and weights that sum to 1; joints without weight are set to 0 so that they cannot be
/// out of range.
fn influences(joints: [u32; 4], weights: [f32; 4]) -> ([u16; 4], [f32; 4]) {
    let weights = weights.map(|w| w.max(0.0));
    let sum: f32 = weights.iter().sum();
    let weights = if sum > 0.0 && sum.is_finite() {
        weights.map(|w| w / sum)
    } else {
        [1.0, 0.0, 0.0, 0.0]
    };
    let joint = |i: usize| {
        if weights[i] > 0.0 {
            u16::try_from(joints[i]).unwrap_or(u16::MAX)
        } else {
            0
        }
    };
    (std::array::from_fn(joint), weights)
}

/// The triangles of a primitive, with glTF's winding (§3.7.2.1), all indices below `count`.
fn triangles(
    source: &Source,
    primitive: &gltf::Primitive,
    count: usize,
    at: &str,
) -> Result<Vec<[u32; 3]>, Fault> {
    let at = format!("{at}, indices");
    let vertices: Vec<u32> = match primitive.indices() {
        Some(accessor) => source
            .integers::<1>(&accessor, &at)?
            .into_iter()
            .map(|[i]| i)
            .collect(),
        None => {
            let count = u32::try_from(count)
                .map_err(|_| Fault::new(&at, format!("{count} vertices exceed 32-bit indices")))?;
            (0..count).collect()
        }
    };
    if let Some(i) = vertices.iter().position(|&v| v as usize >= count) {
        let reason = format!("index {i} is vertex {} of {count}", vertices[i]);
        return Err(Fault::new(at, reason));
    }
    Ok(match primitive.mode() {
        Mode::TriangleStrip => vertices
            .windows(3)
            .enumerate()
            .map(|(i, v)| {
                if i % 2 == 0 {
                    [v[0], v[1], v[2]]
                } else {
                    [v[0], v[2], v[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => match vertices.split_first() {
            Some((&hub, rim)) => rim.windows(2).map(|v| [v[0], v[1], hub]).collect(),
            None => Vec::new(),
        },
        _ => vertices
            .chunks_exact(3)
            .map(|v| [v[0], v[1], v[2]])
            .collect(),
    })
}

/// Gives vertices whose normal is zero the direction of a face that uses them.
fn mend_normals(primitive: &mut Primitive) {
    if primitive.normals.iter().all(|n| *n != Vec3::ZERO) {
        return;
    }
    for triangle in &primitive.indices {
        let [a, b, c] = triangle.map(|v| primitive.positions[v as usize]);
        let face = (b - a).cross(c - a).normalize_or_zero();
        for &vertex in triangle {
            let normal = &mut primitive.normals[vertex as usize];
            if *normal == Vec3::ZERO {
                *normal = face;
            }
        }
    }
    for normal in &mut primitive.normals {
        if *normal == Vec3::ZERO {
            *normal = Vec3::Y;
        }
    }
}
