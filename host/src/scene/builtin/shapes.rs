//! Simple solids, appended to a primitive. Texture coordinates are metres along the surface, so
//! that patterns have their size whatever the shape.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec2, Vec3};

use crate::scene::model::Primitive;

/// A primitive under construction.
#[derive(Default)]
pub(super) struct Shape(Primitive);

impl Shape {
    /// An empty shape of a material.
    pub(super) fn of(material: usize) -> Self {
        Self(Primitive {
            material,
            ..Primitive::default()
        })
    }

    /// The finished primitive.
    pub(super) fn done(self) -> Primitive {
        self.0
    }

    fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.0.positions.push(position);
        self.0.normals.push(normal);
        self.0.uvs.push(uv);
        self.0.positions.len() as u32 - 1
    }

    /// A parallelogram from `corner` along `u` and `v`; its normal is u × v.
    pub(super) fn quad(mut self, corner: Vec3, u: Vec3, v: Vec3) -> Self {
        let normal = u.cross(v).normalize();
        let (lu, lv) = (u.length(), v.length());
        let i = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|(a, b)| self.vertex(corner + u * a + v * b, normal, Vec2::new(lu * a, lv * b)));
        self.0
            .indices
            .extend([[i[0], i[1], i[2]], [i[0], i[2], i[3]]]);
        self
    }

    /// A box around `centre` with edges of `size` metres.
    pub(super) fn cuboid(self, centre: Vec3, size: Vec3) -> Self {
        let h = size * 0.5;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        let at = |sx: f32, sy: f32, sz: f32| centre + h * Vec3::new(sx, sy, sz);
        self.quad(at(-1.0, -1.0, 1.0), x, y)
            .quad(at(1.0, -1.0, -1.0), -x, y)
            .quad(at(1.0, -1.0, 1.0), -z, y)
            .quad(at(-1.0, -1.0, -1.0), z, y)
            .quad(at(-1.0, 1.0, 1.0), x, -z)
            .quad(at(-1.0, -1.0, -1.0), x, z)
    }

    /// A round bar from `a` to `b`, open at its ends; u runs around, v along, both in metres.
    pub(super) fn bar(self, a: Vec3, b: Vec3, radius: f32, sides: u32) -> Self {
        self.cone(a, b, radius, radius, sides)
    }

    /// A truncated cone from `a` to `b`, open at its ends.
    pub(super) fn cone(mut self, a: Vec3, b: Vec3, ra: f32, rb: f32, sides: u32) -> Self {
        let length = a.distance(b);
        let axis = (b - a) / length;
        let (p, q) = axis.any_orthonormal_pair();
        let first = self.0.positions.len() as u32;
        for i in 0..=sides {
            let angle = TAU * i as f32 / sides as f32;
            let out = p * angle.cos() + q * angle.sin();
            let normal = (out + axis * ((ra - rb) / length)).normalize();
            let u = angle * ra.max(rb);
            self.vertex(a + out * ra, normal, Vec2::new(u, 0.0));
            self.vertex(b + out * rb, normal, Vec2::new(u, length));
        }
        for i in 0..sides {
            let k = first + 2 * i;
            self.0
                .indices
                .extend([[k, k + 2, k + 3], [k, k + 3, k + 1]]);
        }
        self
    }

    /// A disc around `centre`, facing `normal`; texture coordinates in its plane.
    pub(super) fn disc(mut self, centre: Vec3, normal: Vec3, radius: f32, sides: u32) -> Self {
        let (p, q) = normal.any_orthonormal_pair();
        let hub = self.vertex(centre, normal, Vec2::ZERO);
        for i in 0..=sides {
            let angle = TAU * i as f32 / sides as f32;
            let at = Vec2::from_angle(angle) * radius;
            let k = self.vertex(centre + p * at.x + q * at.y, normal, at);
            if i > 0 {
                self.0.indices.push([hub, k - 1, k]);
            }
        }
        self
    }

    /// A sphere of `rings` × 2·`rings` facets; u runs around, v from pole to pole.
    pub(super) fn sphere(mut self, centre: Vec3, radius: f32, rings: u32) -> Self {
        let first = self.0.positions.len() as u32;
        let around = 2 * rings;
        for r in 0..=rings {
            let polar = PI * r as f32 / rings as f32;
            for s in 0..=around {
                let azimuth = TAU * s as f32 / around as f32;
                let normal = Vec3::new(
                    polar.sin() * azimuth.cos(),
                    polar.cos(),
                    -polar.sin() * azimuth.sin(),
                );
                let uv = Vec2::new(azimuth, polar) * radius;
                self.vertex(centre + normal * radius, normal, uv);
            }
        }
        for r in 0..rings {
            for s in 0..around {
                let k = first + r * (around + 1) + s;
                let below = k + around + 1;
                if r > 0 {
                    self.0.indices.push([k, below, k + 1]);
                }
                if r + 1 < rings {
                    self.0.indices.push([k + 1, below, below + 1]);
                }
            }
        }
        self
    }

    /// A ring (torus) around `centre` in the plane across `axis`.
    pub(super) fn ring(
        mut self,
        centre: Vec3,
        axis: Vec3,
        radius: f32,
        tube: f32,
        facets: u32,
    ) -> Self {
        let (p, q) = axis.any_orthonormal_pair();
        let sides = 8;
        let first = self.0.positions.len() as u32;
        for i in 0..=facets {
            let at = TAU * i as f32 / facets as f32;
            let out = p * at.cos() + q * at.sin();
            for k in 0..=sides {
                let around = TAU * k as f32 / sides as f32;
                let normal = out * around.cos() + axis * around.sin();
                let uv = Vec2::new(at * radius, around * tube);
                self.vertex(centre + out * radius + normal * tube, normal, uv);
            }
        }
        for i in 0..facets {
            for k in 0..sides {
                let a = first + i * (sides + 1) + k;
                let b = a + sides + 1;
                self.0.indices.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        self
    }

    /// A half ring with a square section in the plane of x and y, standing on both ends:
    /// an arch with its middle at `centre`. u runs along it.
    pub(super) fn arch(mut self, centre: Vec3, radius: f32, half: f32, facets: u32) -> Self {
        let section = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
        for side in 0..4 {
            let [(r0, z0), (r1, z1)] = [section[side], section[(side + 1) % 4]];
            let first = self.0.positions.len() as u32;
            for i in 0..=facets {
                let angle = PI * i as f32 / facets as f32;
                let out = Vec3::new(angle.cos(), angle.sin(), 0.0);
                let normal = out * (r0 + r1) * 0.5 + Vec3::Z * (z0 + z1) * 0.5;
                for (v, r, z) in [(0.0, r0, z0), (2.0 * half, r1, z1)] {
                    let at = centre + out * (radius + half * r) + Vec3::Z * (half * z);
                    self.vertex(at, normal, Vec2::new(angle * radius, v));
                }
            }
            for k in (0..facets).map(|i| first + 2 * i) {
                self.0
                    .indices
                    .extend([[k, k + 3, k + 1], [k, k + 2, k + 3]]);
            }
        }
        self
    }

    /// Takes in another shape; its material is forgotten.
    pub(super) fn with(mut self, other: Shape) -> Self {
        let first = self.0.positions.len() as u32;
        self.0.positions.extend(other.0.positions);
        self.0.normals.extend(other.0.normals);
        self.0.uvs.extend(other.0.uvs);
        self.0
            .indices
            .extend(other.0.indices.iter().map(|t| t.map(|i| i + first)));
        self
    }

    /// Turns what is there so far.
    pub(super) fn turned(mut self, rotation: Quat) -> Self {
        self.0.positions.iter_mut().for_each(|p| *p = rotation * *p);
        self.0.normals.iter_mut().for_each(|n| *n = rotation * *n);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners run counter-clockwise seen from where the normals point.
    #[test]
    fn facets_and_normals_agree() {
        let shapes = [
            Shape::of(0).cuboid(Vec3::ONE, Vec3::new(1.0, 2.0, 3.0)),
            Shape::of(0).sphere(Vec3::X, 2.0, 9),
            Shape::of(0).bar(Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), 0.1, 7),
            Shape::of(0).cone(Vec3::ZERO, Vec3::Y, 0.5, 0.0, 7),
            Shape::of(0).disc(Vec3::Y, Vec3::NEG_X, 0.5, 7),
            Shape::of(0).ring(Vec3::Y, Vec3::Z, 1.0, 0.1, 12),
            Shape::of(0).arch(Vec3::Y, 1.0, 0.2, 12),
            Shape::of(0)
                .quad(Vec3::Y, Vec3::Z, Vec3::X)
                .turned(Quat::from_rotation_x(0.3)),
        ];
        for shape in shapes {
            let p = shape.done();
            assert_eq!(p.uvs.len(), p.positions.len());
            for t in &p.indices {
                let [a, b, c] = t.map(|i| p.positions[i as usize]);
                let face = (b - a).cross(c - a);
                for i in t {
                    // The apex of a cone has facets without area.
                    assert!(face.length() < 1e-6 || face.dot(p.normals[*i as usize]) > 0.0);
                }
            }
        }
    }

    #[test]
    fn a_sphere_has_its_area() {
        let p = Shape::of(0).sphere(Vec3::ONE, 2.0, 40).done();
        let area: f32 = p
            .indices
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| p.positions[i as usize]);
                (b - a).cross(c - a).length() * 0.5
            })
            .sum();
        let exact = 4.0 * PI * 4.0;
        assert!((area / exact - 1.0).abs() < 0.01, "{area} {exact}");
    }
}
