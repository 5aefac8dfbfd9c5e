//! Triangles in a BVH, in one coordinate system.
//!
//! The hierarchy is obvhs' BVH2 with the triangles laid out in leaf order. The triangle test is
//! Möller–Trumbore on precomputed edges (Möller and Trumbore 1997; edge layout after madmann's
//! "Introduction to BVHs"), with a little slack so that neighbours overlap rather than gape.

use std::time::Duration;

use glam::{Vec2, Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams, triangle};

/// Barycentric slack that closes the cracks which rounding opens between neighbours.
const SLACK: f32 = 1e-6;

/// What a triangle looks like, apart from its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Attributes {
    /// Vertex normals; all zero means flat.
    pub(crate) normals: [Vec3; 3],
    /// Texture coordinates.
    pub(crate) uvs: [Vec2; 3],
    /// Index into the materials.
    pub(crate) material: u32,
    /// Index into the vertex colours, or [`NO_COLOURS`].
    pub(crate) colours: u32,
    /// Object id on the wire.
    pub(crate) object: u8,
    /// Rays must ask the material whether they pass (alpha masks, emitters, glass).
    pub(crate) porous: bool,
    /// Has a texture or a pattern: hits need the gradients of the texture coordinates.
    pub(crate) textured: bool,
    /// Reflects rays: hits need the curvature.
    pub(crate) polished: bool,
}

/// No vertex colours.
pub(crate) const NO_COLOURS: u32 = u32::MAX;

/// A triangle made ready for the ray test.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tri {
    v0: Vec3A,
    /// v0 − v1
    e1: Vec3A,
    /// v2 − v0
    e2: Vec3A,
    /// e1 × e2, so minus the counter-clockwise normal.
    ng: Vec3A,
}

impl Tri {
    fn new([v0, v1, v2]: [Vec3A; 3]) -> Self {
        let (e1, e2) = (v0 - v1, v2 - v0);
        Self {
            v0,
            e1,
            e2,
            ng: e1.cross(e2),
        }
    }

    /// Ray parameter within the ray's limits, else infinity.
    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> f32 {
        let c = self.v0 - ray.origin;
        let r = ray.direction.cross(c);
        // A ray in the plane gives infinities or NaN, which fail the comparisons below.
        let inverse = 1.0 / self.ng.dot(ray.direction);
        let u = r.dot(self.e2) * inverse;
        let v = r.dot(self.e1) * inverse;
        if u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK {
            let t = self.ng.dot(c) * inverse;
            if t > ray.tmin && t < ray.tmax {
                return t;
            }
        }
        f32::INFINITY
    }

    /// Weights of vertices 1 and 2 where the ray's line pierces the plane.
    fn weights(&self, ray: &Ray) -> Vec2 {
        let r = ray.direction.cross(self.v0 - ray.origin);
        let w = Vec2::new(r.dot(self.e2), r.dot(self.e1)) / self.ng.dot(ray.direction);
        w.clamp(Vec2::ZERO, Vec2::ONE)
    }

    /// Gradients of u and v in the plane; zero for a triangle without area.
    fn gradients(&self, uvs: [Vec2; 3]) -> [Vec3; 2] {
        // ∇f·(v1 − v0) = f1 − f0 and ∇f·(v2 − v0) = f2 − f0, in the plane across ng.
        let inverse = 1.0 / self.ng.length_squared().max(f32::MIN_POSITIVE);
        let (p, q) = (
            self.ng.cross(self.e2) * inverse,
            self.ng.cross(self.e1) * inverse,
        );
        let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        [
            Vec3::from(p * d1.x + q * d2.x),
            Vec3::from(p * d1.y + q * d2.y),
        ]
    }

    /// Mean over the edges of the curvature that vertex normals pretend, 1/length.
    fn curvature(&self, normals: [Vec3; 3]) -> f32 {
        let v = self.vertices();
        let along = |i: usize, k: usize| {
            let edge = Vec3::from(v[k] - v[i]);
            (normals[k] - normals[i]).dot(edge) / edge.length_squared().max(f32::MIN_POSITIVE)
        };
        (along(0, 1) + along(1, 2) + along(2, 0)) / 3.0
    }

    fn vertices(&self) -> [Vec3A; 3] {
        [self.v0, self.v0 - self.e1, self.v0 + self.e2]
    }
}

/// Which triangle a ray met, and where on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    /// Ray parameter.
    pub(crate) t: f32,
    /// Position in leaf order.
    pub(crate) index: u32,
}

/// A set of triangles. Invariant: `tris` and `attributes` are in the BVH's leaf order, and
/// `source[i]` is where `tris[i]` stood in the input.
#[derive(Clone)]
pub(crate) struct Geometry {
    bvh: Bvh2,
    tris: Vec<Tri>,
    attributes: Vec<Attributes>,
    source: Vec<u32>,
    colours: Vec<[Vec4; 3]>,
}

/// Triangles on their way into a [`Geometry`].
#[derive(Clone, Default)]
pub(crate) struct Soup {
    /// Three corners each.
    pub(crate) corners: Vec<[Vec3A; 3]>,
    /// One a triangle.
    pub(crate) attributes: Vec<Attributes>,
    /// Vertex colours that attributes refer to.
    pub(crate) colours: Vec<[Vec4; 3]>,
}

impl Geometry {
    /// Builds the hierarchy.
    pub(crate) fn new(soup: Soup) -> Self {
        let boxed: Vec<_> = soup
            .corners
            .iter()
            .map(|&[v0, v1, v2]| triangle::Triangle { v0, v1, v2 })
            .collect();
        let bvh = if boxed.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2_from_tris(
                &boxed,
                BvhBuildParams::medium_build(),
                &mut Duration::default(),
            )
        };
        let source = bvh.primitive_indices.clone();
        let order = || source.iter().map(|&i| i as usize);
        let tris = order().map(|i| Tri::new(soup.corners[i])).collect();
        let attributes = order().map(|i| soup.attributes[i]).collect();
        Self {
            bvh,
            tris,
            attributes,
            source,
            colours: soup.colours,
        }
    }

    /// Bounds of all triangles; `None` when there are none.
    pub(crate) fn bounds(&self) -> Option<Aabb> {
        self.bvh.nodes.first().map(|root| *root.aabb())
    }

    /// Number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.tris.len()
    }

    /// Moves the triangles (given in input order) and fits the boxes to them.
    pub(crate) fn refit(&mut self, corners: &[[Vec3A; 3]], normals: &[[Vec3; 3]]) {
        for (i, &from) in self.source.iter().enumerate() {
            self.tris[i] = Tri::new(corners[from as usize]);
            self.attributes[i].normals = normals[from as usize];
        }
        for node in &mut self.bvh.nodes {
            if node.is_leaf() {
                let first = node.first_index as usize;
                let mut bounds = Aabb::empty();
                for tri in &self.tris[first..first + node.prim_count as usize] {
                    bounds = bounds.union(&Aabb::from_points(&tri.vertices()));
                }
                node.set_aabb(bounds);
            }
        }
        self.bvh.refit_all();
    }

    /// Nearest triangle along the ray for which `stops` holds; it is asked only about porous ones.
    #[inline]
    pub(crate) fn closest(
        &self,
        ray: Ray,
        mut stops: impl FnMut(&Attributes, Vec2) -> bool,
    ) -> Option<Met> {
        let mut met = None;
        self.bvh.ray_traverse(ray, &mut RayHit::none(), |ray, i| {
            let t = self.tris[i].intersect(ray);
            if t < ray.tmax && self.stopped(ray, i, &mut stops) {
                met = Some(Met { t, index: i as u32 });
                return t;
            }
            f32::INFINITY
        });
        met
    }

    /// Whether any triangle for which `stops` holds lies within the ray's limits.
    #[inline]
    pub(crate) fn blocked(
        &self,
        ray: Ray,
        mut stops: impl FnMut(&Attributes, Vec2) -> bool,
    ) -> bool {
        !self.bvh.ray_traverse_miss(ray, |ray, i| {
            let t = self.tris[i].intersect(ray);
            if t < ray.tmax && self.stopped(ray, i, &mut stops) {
                t
            } else {
                f32::INFINITY
            }
        })
    }

    #[inline(always)]
    fn stopped(
        &self,
        ray: &Ray,
        i: usize,
        stops: &mut impl FnMut(&Attributes, Vec2) -> bool,
    ) -> bool {
        let a = &self.attributes[i];
        !a.porous || stops(a, interpolate(self.tris[i].weights(ray), a.uvs))
    }

    /// The surface under a triangle that the ray met.
    pub(crate) fn surface(&self, ray: &Ray, met: Met) -> Spot {
        let i = met.index as usize;
        let (tri, attributes) = (&self.tris[i], &self.attributes[i]);
        let w = tri.weights(ray);
        let flat = Vec3::from(-tri.ng);
        let smooth = interpolate(w, attributes.normals);
        let place = tri.v0 - tri.e1 * w.x + tri.e2 * w.y;
        Spot {
            place: place.into(),
            flat,
            smooth: if smooth.length_squared() > 0.0 {
                smooth
            } else {
                flat
            },
            uv: interpolate(w, attributes.uvs),
            gradients: if attributes.textured {
                tri.gradients(attributes.uvs)
            } else {
                [Vec3::ZERO; 2]
            },
            curvature: if attributes.polished {
                tri.curvature(attributes.normals)
            } else {
                0.0
            },
            colour: self
                .colours
                .get(attributes.colours as usize)
                .map_or(Vec4::ONE, |&c| interpolate(w, c)),
            material: attributes.material,
            object: attributes.object,
        }
    }

    /// Each triangle's corners and attributes, in leaf order.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = ([Vec3A; 3], &Attributes)> {
        self.tris
            .iter()
            .zip(&self.attributes)
            .map(|(t, a)| (t.vertices(), a))
    }
}

/// A place on a surface, in the coordinates of its geometry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    /// Computed from the triangle, so more precise than origin + t·direction.
    pub(crate) place: Vec3,
    /// Normal of the triangle, unnormalised.
    pub(crate) flat: Vec3,
    /// Interpolated normal, unnormalised.
    pub(crate) smooth: Vec3,
    /// Texture coordinates.
    pub(crate) uv: Vec2,
    /// Gradients of u and v in the triangle's plane, 1/m; zero where nothing asks for them.
    pub(crate) gradients: [Vec3; 2],
    /// Mean curvature that the vertex normals pretend, 1/m, positive where the front bulges;
    /// zero where nothing asks for it.
    pub(crate) curvature: f32,
    /// Vertex colour.
    pub(crate) colour: Vec4,
    /// Index into the materials.
    pub(crate) material: u32,
    /// Object id on the wire.
    pub(crate) object: u8,
}

fn interpolate<T>(w: Vec2, v: [T; 3]) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    v[0] * (1.0 - w.x - w.y) + v[1] * w.x + v[2] * w.y
}

/// A box among others, for the top level.
#[derive(Clone, Copy)]
pub(crate) struct Boxed(pub(crate) Aabb);

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        self.0
    }
}
