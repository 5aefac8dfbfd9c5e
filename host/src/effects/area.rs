//! Soft shadows: emissive meshes as area lights, sampled point by point.
//!
//! An estimate from one point is L·A·cos/d² towards it (Shirley, Wang and Zimmerman 1996, §3.1:
//! points uniform over the area). Emitters cast no shadow themselves. A mesh that is closed or
//! whose material is not double-sided shines from its front alone.

use glam::{Affine3A, Vec3};

use crate::scene::model::Primitive;

/// Below this share of its area, the area vector of a mesh says that it is closed.
const CLOSED: f32 = 1e-3;

/// The surface of an emissive mesh, in its node's coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    facets: Vec<Facet>,
    /// Area, m².
    pub(crate) total: f32,
    /// Mean place.
    pub(crate) centroid: Vec3,
    /// Shines from the front alone.
    pub(crate) one_sided: bool,
}

#[derive(Clone, Copy, Debug)]
struct Facet {
    corner: Vec3,
    sides: [Vec3; 2],
    /// Share of the area up to this facet, inclusive.
    until: f32,
}

impl Surface {
    /// The triangles of a primitive; `None` without area.
    pub(crate) fn new(primitive: &Primitive, double_sided: bool) -> Option<Self> {
        let mut facets = Vec::new();
        let (mut centroid, mut vector, mut total) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for triangle in &primitive.indices {
            let [a, b, c] = triangle.map(|i| primitive.positions[i as usize]);
            let half = (b - a).cross(c - a) * 0.5;
            let area = half.length();
            if area <= 0.0 {
                continue;
            }
            centroid += (a + b + c) / 3.0 * area;
            vector += half;
            total += area;
            facets.push(Facet {
                corner: a,
                sides: [b - a, c - a],
                until: total,
            });
        }
        if facets.is_empty() {
            return None;
        }
        facets.iter_mut().for_each(|f| f.until /= total);
        Some(Self {
            facets,
            total,
            centroid: centroid / total,
            one_sided: !double_sided || vector.length() < CLOSED * total,
        })
    }

    /// The point at `at` (two numbers in 0..1, equal areas to equal areas) under `pose`, and the
    /// unit normal there.
    pub(crate) fn point(&self, at: [f32; 2], pose: &Affine3A) -> (Vec3, Vec3) {
        let i = self.facets.partition_point(|f| f.until <= at[0]);
        let i = i.min(self.facets.len() - 1);
        let from = if i > 0 { self.facets[i - 1].until } else { 0.0 };
        let facet = &self.facets[i];
        let within = ((at[0] - from) / (facet.until - from)).clamp(0.0, 1.0);
        // Uniform over a triangle (Turk 1990).
        let root = within.sqrt();
        let (u, v) = (1.0 - root, at[1] * root);
        let place = facet.corner + facet.sides[0] * u + facet.sides[1] * v;
        let [a, b] = facet.sides.map(|s| pose.transform_vector3(s));
        (
            pose.transform_point3(place),
            a.cross(b).normalize_or(Vec3::Y),
        )
    }

    /// The offset from `from` to the point at `at`, and the light that it stands for: irradiance
    /// for unit radiance on a surface that faces it, when the whole area is `total` m². `None`
    /// from behind one that shines from the front alone.
    pub(crate) fn seen(
        &self,
        at: [f32; 2],
        pose: &Affine3A,
        total: f32,
        from: Vec3,
    ) -> Option<(Vec3, f32)> {
        let (place, normal) = self.point(at, pose);
        let offset = place - from;
        let d2 = offset.length_squared().max(1e-6);
        let cos = -normal.dot(offset) / d2.sqrt();
        if self.one_sided && cos <= 0.0 {
            return None;
        }
        Some((offset, cos.abs() * total / d2))
    }
}
