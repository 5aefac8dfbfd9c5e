//! Colours of surfaces: images sampled bilinearly in linear light, and computed patterns.

use glam::{Vec2, Vec3, Vec4};

use crate::scene::model::{Procedural, Texture, TextureRef};

/// The factor that a pattern puts on the base colour at texture coordinates `uv`, linear.
///
/// One is the material's own colour; `other` and `mortar` multiply it elsewhere. Periods:
/// checker 2·size both ways; brick size.x and 2·size.y (each second row is shifted by half a
/// brick); stripes `period` in u, the first half plain.
#[must_use]
pub fn pattern(procedural: &Procedural, uv: Vec2) -> Vec3 {
    match *procedural {
        Procedural::Checker { size, other } => {
            let cell = (uv / size).floor();
            if (cell.x + cell.y).rem_euclid(2.0) < 0.5 {
                Vec3::ONE
            } else {
                other
            }
        }
        Procedural::Brick {
            size,
            joint,
            mortar,
        } => {
            let row = (uv.y / size.y).floor();
            let shift = if row.rem_euclid(2.0) < 0.5 { 0.0 } else { 0.5 };
            let across = (uv.x / size.x + shift).rem_euclid(1.0) * size.x;
            let up = uv.y - row * size.y;
            if across < joint || up < joint {
                mortar
            } else {
                Vec3::ONE
            }
        }
        Procedural::Stripes { period, other } => {
            if (uv.x / period).rem_euclid(1.0) < 0.5 {
                Vec3::ONE
            } else {
                other
            }
        }
    }
}

/// Samples images. Texels lie at half coordinates, v runs down (glTF 2.0 §3.6.1).
#[derive(Clone)]
pub(crate) struct Sampler {
    linear: [f32; 256],
}

impl Sampler {
    pub(crate) fn new() -> Self {
        Self {
            linear: super::srgb::decode_table(),
        }
    }

    /// Linear colour and opacity; filtering happens in linear light.
    pub(crate) fn sample(&self, textures: &[Texture], used: &TextureRef, uv: Vec2) -> Vec4 {
        let Some(texture) = textures.get(used.texture) else {
            return Vec4::ONE;
        };
        let uv = uv * used.scale + used.offset;
        let size = Vec2::new(texture.width as f32, texture.height as f32);
        let at = Vec2::new(
            if texture.repeat_u {
                uv.x - uv.x.floor()
            } else {
                uv.x.clamp(0.0, 1.0)
            },
            if texture.repeat_v {
                uv.y - uv.y.floor()
            } else {
                uv.y.clamp(0.0, 1.0)
            },
        ) * size
            - 0.5;
        let corner = at.floor();
        let f = at - corner;
        let columns = neighbours(corner.x, texture.width, texture.repeat_u);
        let rows = neighbours(corner.y, texture.height, texture.repeat_v);
        let texel = |x: u32, y: u32| {
            let i = y as usize * texture.width as usize + x as usize;
            texture.rgba.get(i).map_or(Vec4::ONE, |&[r, g, b, a]| {
                let l = |c: u8| self.linear[usize::from(c)];
                Vec4::new(l(r), l(g), l(b), f32::from(a) / 255.0)
            })
        };
        let top = texel(columns[0], rows[0]).lerp(texel(columns[1], rows[0]), f.x);
        let bottom = texel(columns[0], rows[1]).lerp(texel(columns[1], rows[1]), f.x);
        top.lerp(bottom, f.y)
    }
}

/// The two texels around a coordinate; `corner` is −1..=size−1.
fn neighbours(corner: f32, size: u32, repeat: bool) -> [u32; 2] {
    let last = size.saturating_sub(1);
    let low = if corner < 0.0 {
        if repeat { last } else { 0 }
    } else {
        (corner as u32).min(last)
    };
    let high = if corner < 0.0 {
        0
    } else if low == last {
        if repeat { 0 } else { last }
    } else {
        low + 1
    };
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(repeat: bool) -> Texture {
        Texture {
            width: 2,
            height: 2,
            rgba: vec![[0, 0, 0, 255], [255; 4], [255, 0, 0, 0], [0, 255, 0, 255]],
            repeat_u: repeat,
            repeat_v: repeat,
            ..Texture::default()
        }
    }

    fn at(t: Texture, u: f32, v: f32) -> Vec4 {
        let used = TextureRef {
            texture: 0,
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
        };
        Sampler::new().sample(&[t], &used, Vec2::new(u, v))
    }

    #[test]
    fn texel_centres_are_exact_and_rows_run_down() {
        for repeat in [false, true] {
            assert_eq!(
                at(texture(repeat), 0.25, 0.25),
                Vec4::new(0.0, 0.0, 0.0, 1.0)
            );
            assert_eq!(at(texture(repeat), 0.75, 0.25), Vec4::ONE);
            assert_eq!(
                at(texture(repeat), 0.25, 0.75),
                Vec4::new(1.0, 0.0, 0.0, 0.0)
            );
        }
        assert_eq!(
            at(texture(true), 1.25, -0.25),
            Vec4::new(1.0, 0.0, 0.0, 0.0)
        );
    }

    #[test]
    fn edges_repeat_or_clamp() {
        assert_eq!(at(texture(false), 0.0, 0.25).x, 0.0);
        assert_eq!(at(texture(true), 0.0, 0.25).x, 0.5);
        assert_eq!(at(texture(false), 7.0, 0.25).x, 1.0);
        // Filtered in linear light, not in codes.
        assert_eq!(at(texture(false), 0.5, 0.25).x, 0.5);
    }

    #[test]
    fn patterns_have_their_periods() {
        let other = Vec3::new(0.1, 0.2, 0.3);
        let checker = Procedural::Checker { size: 0.5, other };
        assert_eq!(pattern(&checker, Vec2::new(0.25, 0.25)), Vec3::ONE);
        assert_eq!(pattern(&checker, Vec2::new(0.75, 0.25)), other);
        assert_eq!(pattern(&checker, Vec2::new(-0.25, 0.25)), other);
        let stripes = Procedural::Stripes { period: 1.0, other };
        assert_eq!(pattern(&stripes, Vec2::new(-0.25, 9.0)), other);
        let brick = Procedural::Brick {
            size: Vec2::new(0.4, 0.2),
            joint: 0.02,
            mortar: other,
        };
        assert_eq!(pattern(&brick, Vec2::new(0.01, 0.1)), other);
        assert_eq!(pattern(&brick, Vec2::new(0.2, 0.1)), Vec3::ONE);
        // The next row is shifted by half a brick.
        assert_eq!(pattern(&brick, Vec2::new(0.01, 0.3)), Vec3::ONE);
        assert_eq!(pattern(&brick, Vec2::new(0.21, 0.3)), other);
        assert_eq!(pattern(&brick, Vec2::new(0.2, 0.41)), other);
    }
}
