//! Computed patterns, averaged exactly over an upright box of texture coordinates.

use glam::{Vec2, Vec3};

use crate::scene::model::Procedural;

/// The factor that a pattern puts on the base colour, linear: its mean over the box around `uv`
/// with sides `extent` (texture coordinates, not negative; zero for the point itself).
///
/// One is the material's own colour; `other` and `mortar` multiply it elsewhere. Periods:
/// checker 2·size both ways; brick size.x and 2·size.y (each second row is shifted by half a
/// brick); stripes `period` in u, the first half plain.
#[must_use]
pub fn pattern(procedural: &Procedural, uv: Vec2, extent: Vec2) -> Vec3 {
    let (plain, other) = match *procedural {
        Procedural::Checker { size, other } => {
            // A product of two square waves ±1.
            let wave = |x, width| 2.0 * share(x, width, 2.0 * size, size) - 1.0;
            let product = wave(uv.x, extent.x) * wave(uv.y, extent.y);
            (0.5 + 0.5 * product, other)
        }
        Procedural::Brick {
            size,
            joint,
            mortar,
        } => {
            let brick = (size - joint).max(Vec2::ZERO);
            let across = |shift| share(uv.x - joint + shift, extent.x, size.x, brick.x);
            let up = |row| share(uv.y - joint - row, extent.y, 2.0 * size.y, brick.y);
            let plain = up(0.0) * across(0.0) + up(size.y) * across(0.5 * size.x);
            (plain, mortar)
        }
        Procedural::Stripes { period, other } => {
            (share(uv.x, extent.x, period, 0.5 * period), other)
        }
    };
    other.lerp(Vec3::ONE, plain)
}

/// How much of the stretch of `width` around `x` lies in `0..on`, repeated each `period`.
fn share(x: f32, width: f32, period: f32, on: f32) -> f32 {
    if width <= 1e-4 * period {
        return if x.rem_euclid(period) < on { 1.0 } else { 0.0 };
    }
    // From the period's start, so that nothing cancels far from the origin.
    let start = (x - 0.5 * width).rem_euclid(period);
    let covered = |x: f32| {
        let whole = (x / period).floor();
        whole * on + (x - whole * period).min(on)
    };
    ((covered(start + width) - covered(start)) / width).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OTHER: Vec3 = Vec3::new(0.1, 0.2, 0.3);

    fn all() -> [Procedural; 3] {
        [
            Procedural::Checker {
                size: 0.5,
                other: OTHER,
            },
            Procedural::Brick {
                size: Vec2::new(0.4, 0.2),
                joint: 0.02,
                mortar: OTHER,
            },
            Procedural::Stripes {
                period: 1.0,
                other: OTHER,
            },
        ]
    }

    #[test]
    fn patterns_have_their_periods() {
        let at = |p: &Procedural, u, v| pattern(p, Vec2::new(u, v), Vec2::ZERO);
        let [checker, brick, stripes] = all();
        assert_eq!(at(&checker, 0.25, 0.25), Vec3::ONE);
        assert_eq!(at(&checker, 0.75, 0.25), OTHER);
        assert_eq!(at(&checker, -0.25, 0.25), OTHER);
        assert_eq!(at(&stripes, -0.25, 9.0), OTHER);
        assert_eq!(at(&brick, 0.01, 0.1), OTHER);
        assert_eq!(at(&brick, 0.2, 0.1), Vec3::ONE);
        // The next row is shifted by half a brick.
        assert_eq!(at(&brick, 0.01, 0.3), Vec3::ONE);
        assert_eq!(at(&brick, 0.21, 0.3), OTHER);
        assert_eq!(at(&brick, 0.2, 0.41), OTHER);
    }

    #[test]
    fn a_filtered_pattern_is_the_mean_of_its_points() {
        for p in all() {
            for (uv, extent) in [
                (Vec2::new(0.31, 0.17), Vec2::new(0.2, 0.3)),
                (Vec2::new(-7.6, 3.21), Vec2::new(1.7, 0.05)),
                (Vec2::new(0.02, 0.4), Vec2::new(0.03, 0.01)),
            ] {
                let n = 400;
                let mut sum = Vec3::ZERO;
                for i in 0..n * n {
                    let f = (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32 - 0.5;
                    sum += pattern(&p, uv + extent * f, Vec2::ZERO);
                }
                let (mean, exact) = (sum / (n * n) as f32, pattern(&p, uv, extent));
                assert!(mean.distance(exact) < 0.01, "{p:?} {uv}: {mean} {exact}");
            }
        }
    }

    #[test]
    fn far_patterns_are_grey_and_near_ones_are_sharp() {
        let mut inside_cells = 0;
        for p in all() {
            let far = pattern(&p, Vec2::new(0.3, 0.7), Vec2::splat(500.0));
            let inside = match p {
                Procedural::Brick { .. } => 0.95 * 0.9,
                _ => 0.5,
            };
            assert!(far.distance(OTHER.lerp(Vec3::ONE, inside)) < 2e-3, "{far}");
            for i in 0..100 {
                let uv = Vec2::new(0.0371 * i as f32 + 0.005, 0.0517 * i as f32 + 0.005);
                let sharp = |shift: Vec2| pattern(&p, uv + shift, Vec2::ZERO);
                let corners = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| Vec2::new(x, y) * 6e-4));
                if corners
                    .as_flattened()
                    .iter()
                    .any(|&c| sharp(c) != sharp(Vec2::ZERO))
                {
                    continue;
                }
                let near = pattern(&p, uv, Vec2::splat(1e-3));
                assert!(near.distance(sharp(Vec2::ZERO)) < 1e-3, "{p:?} {uv}");
                inside_cells += 1;
            }
        }
        assert!(inside_cells > 250);
    }
}
