//! Soft shadows: emissive meshes as area lights, sampled point by point.
//!
//! An estimate from one point is L·A·cos/d² towards it (Shirley, Wang and Zimmerman 1996, §3.1:
//! points uniform over the area); near by, where that has no bound, points are uniform over the
//! solid angle ([`spherical`]). Emitters cast no shadow themselves. A mesh that is closed or whose
//! material is not double-sided shines from its front alone.

use glam::{Affine3A, Vec3};

use super::spherical;
use crate::scene::model::Primitive;

/// Below this share of its area, the area vector of a mesh says that it is closed.
const CLOSED: f32 = 1e-3;
/// Within so many radii of its middle a facet is near: beyond, 1/d² varies ninefold over it at most.
const NEAR: f32 = 2.0;

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

    /// The facet at `at` (0..1, equal areas to equal lengths), where in it, 0..1, and its share of
    /// the area.
    fn facet(&self, at: f32) -> (&Facet, f32, f32) {
        let i = self.facets.partition_point(|f| f.until <= at);
        let i = i.min(self.facets.len() - 1);
        let from = if i > 0 { self.facets[i - 1].until } else { 0.0 };
        let facet = &self.facets[i];
        let share = facet.until - from;
        (facet, ((at - from) / share).clamp(0.0, 1.0), share)
    }

    /// The point at `at` (two numbers in 0..1, equal areas to equal areas) under `pose`, and the
    /// unit normal there.
    pub(crate) fn point(&self, at: [f32; 2], pose: &Affine3A) -> (Vec3, Vec3) {
        let (facet, within, _) = self.facet(at[0]);
        facet.posed(pose).point([within, at[1]])
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
        let (facet, within, share) = self.facet(at[0]);
        let posed = facet.posed(pose);
        let at = [within, at[1]];
        let (offset, cos, stands_for) = match posed.seen_near(at, from) {
            Some((offset, cos, solid)) => (offset, cos, solid / share),
            None => {
                let (place, normal) = posed.point(at);
                let offset = place - from;
                let d2 = offset.length_squared().max(1e-6);
                let cos = -normal.dot(offset) / d2.sqrt();
                (offset, cos, cos.abs() * total / d2)
            }
        };
        (cos > 0.0 || !self.one_sided).then_some((offset, stands_for))
    }
}

/// A facet in the world.
struct Posed {
    corner: Vec3,
    sides: [Vec3; 2],
}

impl Facet {
    fn posed(&self, pose: &Affine3A) -> Posed {
        Posed {
            corner: pose.transform_point3(self.corner),
            sides: self.sides.map(|s| pose.transform_vector3(s)),
        }
    }
}

impl Posed {
    /// The point at two numbers in 0..1, uniform over the triangle (Turk 1990), and the unit normal.
    fn point(&self, [at, along]: [f32; 2]) -> (Vec3, Vec3) {
        let [a, b] = self.sides;
        let root = at.sqrt();
        let (u, v) = (1.0 - root, along * root);
        let place = self.corner + a * u + b * v;
        (place, a.cross(b).normalize_or(Vec3::Y))
    }

    /// From near by: the offset to a point uniform over the solid angle, the cosine at it, and the
    /// solid angle, sr.
    fn seen_near(&self, at: [f32; 2], from: Vec3) -> Option<(Vec3, f32, f32)> {
        let [a, b] = self.sides;
        let middle = (a + b) / 3.0;
        let apart = self.corner + middle - from;
        let spread = [middle, a - middle, b - middle].map(Vec3::length_squared);
        let radius2 = spread.into_iter().fold(0.0, f32::max);
        if apart.length_squared() > NEAR * NEAR * radius2 {
            return None;
        }
        let corner = self.corner - from;
        let (direction, solid) = spherical::towards([corner, corner + a, corner + b], at)?;
        let normal = a.cross(b).normalize_or(Vec3::Y);
        let cos = -normal.dot(direction);
        let distance = -normal.dot(corner) / cos;
        (distance.is_finite() && distance > 0.0).then_some((direction * distance, cos, solid))
    }
}
