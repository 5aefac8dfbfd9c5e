//! Triangles as they are seen from a point: uniform over the solid angle (Arvo 1995, "Stratified
//! sampling of spherical triangles").
//!
//! Points uniform over the area stand for L·A·cos/d² each, which has no bound near by. Uniform over
//! the solid angle Ω each stands for L·Ω, at most 2π·L.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

/// Solid angles below this, sr, are left to points of the area: their angles drown in rounding.
const LEAST: f64 = 1e-4;

/// The unit direction at `at` (two numbers in 0..1, equal solid angles to equal areas) to a triangle
/// whose corners lie at `corners` from the eye, and its solid angle, sr. `None` for one that is seen
/// too small or from its edge.
pub(crate) fn towards(corners: [Vec3; 3], at: [f32; 2]) -> Option<(Vec3, f32)> {
    let [a, b, c] = corners.map(|v| v.as_dvec3().normalize_or_zero());
    let across = |u: DVec3, v: DVec3| u.cross(v).try_normalize();
    let [ab, bc, ca] = [across(a, b)?, across(b, c)?, across(c, a)?];
    let alpha = angle(ab, -ca);
    let solid = alpha + angle(bc, -ab) + angle(ca, -bc) - PI;
    if solid < LEAST {
        return None;
    }
    let [part, along] = at.map(f64::from);
    // The point on the side from a to c at which the triangle a, b, point has this part of all:
    // by its angle at b, from the sum of its angles (Arvo §2, equations 3 to 6).
    let (sin, cos) = (part * solid - alpha).sin_cos();
    let (sin_alpha, cos_alpha) = alpha.sin_cos();
    let u = cos - cos_alpha;
    let v = sin + sin_alpha * a.dot(b);
    let over = (v * cos - u * sin) * cos_alpha - v;
    let under = (v * sin + u * cos) * sin_alpha;
    let q = if under.abs() > 1e-14 {
        over / under
    } else {
        1.0
    };
    let side = rotated(a, c, q.clamp(-1.0, 1.0));
    // And from b towards it, equal areas again.
    let direction = rotated(b, side, 1.0 - along * (1.0 - side.dot(b)));
    Some((direction.as_vec3().normalize_or_zero(), solid as f32))
}

/// The unit vector at the angle with this cosine from `from`, in the direction of `to`.
fn rotated(from: DVec3, to: DVec3, cos: f64) -> DVec3 {
    let aside = (to - from * from.dot(to)).normalize_or_zero();
    from * cos + aside * (1.0 - cos * cos).max(0.0).sqrt()
}

/// The angle between unit vectors, exact for small and for flat ones.
fn angle(a: DVec3, b: DVec3) -> f64 {
    if a.dot(b) < 0.0 {
        PI - 2.0 * (0.5 * (a + b).length()).min(1.0).asin()
    } else {
        2.0 * (0.5 * (a - b).length()).min(1.0).asin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::moment::unit_square;

    /// The solid angle by the tetrahedron formula (van Oosterom and Strackee 1983).
    fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let under = la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la;
        2.0 * a.dot(b.cross(c)).abs().atan2(under)
    }

    #[test]
    fn solid_angles_are_those_of_the_tetrahedron_formula() {
        let corner = |seed: u32| {
            let ([x, y], [z, _]) = (unit_square(seed), unit_square(seed + 7777));
            Vec3::new(x, y, z) * 4.0 - 2.0
        };
        let mut seen = 0;
        for i in 0..2000u32 {
            let corners = [3 * i, 3 * i + 1, 3 * i + 2].map(corner);
            let expected = solid_angle(corners.map(|v| v.as_dvec3()));
            match towards(corners, [0.5; 2]) {
                Some((_, solid)) => {
                    seen += 1;
                    let solid = f64::from(solid);
                    assert!((solid - expected).abs() < 1e-5, "{solid} {expected}");
                }
                None => assert!(expected < 2.0 * LEAST, "{expected}"),
            }
        }
        assert!(seen > 1900, "{seen}");
    }

    #[test]
    fn directions_are_uniform_over_the_solid_angle() {
        // The share of directions within a part of the triangle is that part's solid angle. A
        // quarter of the sphere, a usual one, and one seen at a low angle.
        let triangles = [
            [Vec3::X, Vec3::Y, Vec3::Z],
            [
                Vec3::new(-0.3, -0.2, 1.0),
                Vec3::new(1.4, 0.1, 1.1),
                Vec3::new(0.2, 1.0, 0.7),
            ],
            [
                Vec3::new(-1.0, 0.05, 0.1),
                Vec3::new(2.0, 0.05, 0.2),
                Vec3::new(0.3, 0.05, 3.0),
            ],
        ];
        for corners in triangles {
            let [a, b, c] = corners;
            let whole = solid_angle(corners.map(|v| v.as_dvec3()));
            let middle = (a + b + c) / 3.0;
            let parts = [[a, b, middle], [b, c, middle], [c, a, middle]];
            let n = 128;
            let mut counts = [0u32; 3];
            for i in 0..n * n {
                let at = [i % n, i / n].map(|k| (k as f32 + 0.5) / n as f32);
                let (direction, _) = towards(corners, at).expect("large enough");
                // Inside a part when on the inner side of all three planes.
                let inside = |[p, q, r]: [Vec3; 3]| {
                    let out = p.cross(q).dot(r).signum();
                    [(p, q), (q, r), (r, p)]
                        .iter()
                        .all(|(u, v)| u.cross(*v).dot(direction) * out >= -1e-6)
                };
                let part = parts.iter().position(|&part| inside(part));
                counts[part.expect("within the triangle")] += 1;
            }
            for (count, part) in counts.into_iter().zip(parts) {
                let share = f64::from(count) / f64::from(n * n);
                let expected = solid_angle(part.map(|v| v.as_dvec3())) / whole;
                assert!((share - expected).abs() < 0.01, "{share} {expected}");
            }
        }
    }
}
