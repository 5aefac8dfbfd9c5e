//! Skinned meshes: posed once an epoch, at its middle (glTF 2.0 §3.7.3).
//!
//! So a skinned vertex is off by its motion over half an epoch. For the display each triangle
//! belongs to one joint, the one with most weight on it, and is reprojected with that joint.

use glam::{Affine3A, Mat4, Vec3, Vec3A, Vec4};

use crate::scene::model::{Primitive, Scene};

/// Vertices that joints move.
#[derive(Clone)]
pub(crate) struct Skinned {
    parts: Vec<Part>,
}

/// One primitive of one skinned node.
#[derive(Clone)]
struct Part {
    skin: usize,
    mesh: usize,
    primitive: usize,
}

impl Skinned {
    /// All skinned primitives of the scene; `None` without.
    pub(crate) fn new(scene: &Scene) -> Option<Self> {
        let mut parts = Vec::new();
        for node in &scene.nodes {
            let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else {
                continue;
            };
            for (primitive, p) in scene.meshes[mesh].primitives.iter().enumerate() {
                if !p.indices.is_empty() {
                    parts.push(Part {
                        skin,
                        mesh,
                        primitive,
                    });
                }
            }
        }
        (!parts.is_empty()).then_some(Self { parts })
    }

    /// Each part's primitive, and the node of the dominant joint of each of its triangles.
    pub(crate) fn owners<'a>(
        &'a self,
        scene: &'a Scene,
    ) -> impl Iterator<Item = (&'a Primitive, Vec<usize>)> {
        self.parts.iter().map(|part| {
            let primitive = &scene.meshes[part.mesh].primitives[part.primitive];
            let joints = &scene.skins[part.skin].joints;
            let owner = |t: &[u32; 3]| joints[usize::from(dominant(primitive, t))];
            (primitive, primitive.indices.iter().map(owner).collect())
        })
    }

    /// Corners and normals of all triangles, in the order of [`Self::owners`], when the nodes
    /// stand at `poses`.
    pub(crate) fn pose(
        &self,
        scene: &Scene,
        poses: &[Affine3A],
        corners: &mut Vec<[Vec3A; 3]>,
        normals: &mut Vec<[Vec3; 3]>,
    ) {
        corners.clear();
        normals.clear();
        for part in &self.parts {
            let primitive = &scene.meshes[part.mesh].primitives[part.primitive];
            let skin = &scene.skins[part.skin];
            let matrices: Vec<Mat4> = skin
                .joints
                .iter()
                .zip(&skin.inverse_bind)
                .map(|(&joint, bind)| Mat4::from(poses[joint]) * *bind)
                .collect();
            let moved: Vec<(Vec3A, Vec3)> = (0..primitive.positions.len())
                .map(|v| vertex(primitive, v, &matrices))
                .collect();
            for t in &primitive.indices {
                let t = t.map(|i| moved[i as usize]);
                corners.push(t.map(|v| v.0));
                normals.push(t.map(|v| v.1));
            }
        }
    }
}

fn vertex(primitive: &Primitive, v: usize, matrices: &[Mat4]) -> (Vec3A, Vec3) {
    let mut blend = Mat4::ZERO;
    match (primitive.joints.get(v), primitive.weights.get(v)) {
        (Some(joints), Some(weights)) => {
            for (&joint, &weight) in joints.iter().zip(weights) {
                if weight > 0.0 {
                    blend += matrices[usize::from(joint)] * weight;
                }
            }
        }
        _ => blend = matrices[0],
    }
    if blend.w_axis.w <= 0.0 {
        // No weights at all: glTF forbids it, files do it; the first joint takes the vertex.
        blend = matrices[0];
    }
    // Weights that do not sum to 1 scale w with the rest.
    let at = blend * Vec4::from((primitive.positions[v], 1.0));
    let normal = primitive.normals.get(v).map_or(Vec3::ZERO, |&n| {
        blend.transform_vector3(n).normalize_or_zero()
    });
    (Vec3A::from_vec4(at / at.w), normal)
}

/// The joint (index into the skin) with most weight on a triangle; the lowest of equals.
fn dominant(primitive: &Primitive, triangle: &[u32; 3]) -> u16 {
    let mut sums: [(u16, f32); 12] = [(0, 0.0); 12];
    let mut used = 0;
    for &v in triangle {
        let v = v as usize;
        let (Some(joints), Some(weights)) = (primitive.joints.get(v), primitive.weights.get(v))
        else {
            return 0;
        };
        for (&joint, &weight) in joints.iter().zip(weights) {
            if let Some(sum) = sums[..used].iter_mut().find(|s| s.0 == joint) {
                sum.1 += weight;
            } else {
                sums[used] = (joint, weight);
                used += 1;
            }
        }
    }
    let mut best = sums[0];
    for &sum in &sums[1..used] {
        if sum.1 > best.1 || (sum.1 == best.1 && sum.0 < best.0) {
            best = sum;
        }
    }
    best.0
}
