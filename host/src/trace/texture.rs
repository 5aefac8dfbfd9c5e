//! Images on surfaces: pyramids of box averages in linear light (Williams 1983), sampled
//! trilinearly, a few times along the longer side of a footprint.

use std::sync::Arc;

use glam::{Vec2, Vec4};
use rayon::prelude::*;

use super::cone::Footprint;
use crate::scene::model::{Texture, TextureRef};

/// Most probes along the longer side; beyond, the level rises instead.
const PROBES: f32 = 8.0;

/// Samples the images of a scene. Texels lie at half coordinates, v runs down (glTF 2.0
/// §3.6.1). Level 0 is the scene's own image.
#[derive(Clone)]
pub(crate) struct Sampler {
    linear: [f32; 256],
    /// Levels 1 and up of each texture.
    pyramids: Arc<[Vec<Level>]>,
}

/// A level of a pyramid.
struct Level {
    width: u32,
    height: u32,
    /// Linear colour and opacity, 0..=65535.
    texels: Vec<[u16; 4]>,
}

impl Sampler {
    pub(crate) fn new(textures: &[Texture]) -> Self {
        let linear = super::srgb::decode_table();
        let pyramids = textures.par_iter().map(|t| pyramid(t, &linear)).collect();
        Self { linear, pyramids }
    }

    /// Linear colour and opacity, averaged over the footprint.
    pub(crate) fn sample(&self, textures: &[Texture], used: &TextureRef, seen: &Footprint) -> Vec4 {
        let Some(texture) = textures.get(used.texture) else {
            return Vec4::ONE;
        };
        let uv = seen.uv * used.scale + used.offset;
        let scale = used.scale * Vec2::new(texture.width as f32, texture.height as f32);
        let (mut long, mut short) = ((seen.long * scale).length(), (seen.short * scale).length());
        let mut step = seen.long * used.scale;
        if long < short {
            (long, short) = (short, long);
            step = seen.short * used.scale;
        }
        if long <= 1.0 {
            return self.level(texture, used, 0, uv);
        }
        let probes = (long / short.max(1.0)).round().clamp(1.0, PROBES);
        let lod = short.max(long / PROBES).max(1.0).log2();
        let mut sum = Vec4::ZERO;
        for i in 0..probes as u32 {
            let along = (i as f32 + 0.5) / probes - 0.5;
            sum += self.trilinear(texture, used, lod, uv + step * along);
        }
        sum / probes
    }

    fn trilinear(&self, texture: &Texture, used: &TextureRef, lod: f32, uv: Vec2) -> Vec4 {
        let fine = lod.floor();
        let f = lod - fine;
        let near = self.level(texture, used, fine as usize, uv);
        if f == 0.0 {
            return near;
        }
        near.lerp(self.level(texture, used, fine as usize + 1, uv), f)
    }

    /// A bilinear sample of a level; beyond the last, of the last.
    fn level(&self, texture: &Texture, used: &TextureRef, level: usize, uv: Vec2) -> Vec4 {
        let levels = &self.pyramids[used.texture];
        let repeat = [texture.repeat_u, texture.repeat_v];
        match level.min(levels.len()).checked_sub(1).map(|l| &levels[l]) {
            None => bilinear(texture.width, texture.height, repeat, uv, |i| {
                let [r, g, b, a] = texture.rgba[i];
                let l = |c: u8| self.linear[usize::from(c)];
                Vec4::new(l(r), l(g), l(b), f32::from(a) / 255.0)
            }),
            Some(level) => bilinear(level.width, level.height, repeat, uv, |i| {
                Vec4::from(level.texels[i].map(f32::from)) / 65535.0
            }),
        }
    }
}

/// Levels 1 and up, each the area average of the one before, down to one texel. Opacity is
/// averaged like a colour: images need not be cut-outs to have some.
fn pyramid(texture: &Texture, linear: &[f32; 256]) -> Vec<Level> {
    let (mut width, mut height) = (texture.width, texture.height);
    let mut fine: Vec<Vec4> = texture
        .rgba
        .iter()
        .map(|&[r, g, b, a]| {
            let l = |c: u8| linear[usize::from(c)];
            Vec4::new(l(r), l(g), l(b), f32::from(a) / 255.0)
        })
        .collect();
    let mut levels = Vec::new();
    while width > 1 || height > 1 {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let (columns, rows) = (parts(width, w), parts(height, h));
        let mut coarse = Vec::with_capacity(w as usize * h as usize);
        for row in &rows {
            for column in &columns {
                let mut sum = Vec4::ZERO;
                for &(y, wy) in row {
                    for &(x, wx) in column {
                        sum += fine[y as usize * width as usize + x as usize] * (wx * wy);
                    }
                }
                coarse.push(sum);
            }
        }
        levels.push(Level {
            width: w,
            height: h,
            texels: coarse
                .iter()
                .map(|t| t.to_array().map(|c| (c * 65535.0).round() as u16))
                .collect(),
        });
        (fine, width, height) = (coarse, w, h);
    }
    levels
}

/// For each of `coarse` texels, the texels of `fine` under it and their shares of it.
fn parts(fine: u32, coarse: u32) -> Vec<Vec<(u32, f32)>> {
    let size = f64::from(fine) / f64::from(coarse);
    (0..coarse)
        .map(|i| {
            let (from, to) = (f64::from(i) * size, f64::from(i + 1) * size);
            (from as u32..(to.ceil() as u32).min(fine))
                .map(|k| {
                    let share = to.min(f64::from(k) + 1.0) - from.max(f64::from(k));
                    (k, (share / size) as f32)
                })
                .collect()
        })
        .collect()
}

/// A bilinear sample of a row-by-row image.
#[inline]
fn bilinear(
    width: u32,
    height: u32,
    [repeat_u, repeat_v]: [bool; 2],
    uv: Vec2,
    texel: impl Fn(usize) -> Vec4,
) -> Vec4 {
    let wrap = |x: f32, repeat: bool| {
        if repeat {
            x - x.floor()
        } else {
            x.clamp(0.0, 1.0)
        }
    };
    let size = Vec2::new(width as f32, height as f32);
    let at = Vec2::new(wrap(uv.x, repeat_u), wrap(uv.y, repeat_v)) * size - 0.5;
    let corner = at.floor();
    let f = at - corner;
    let columns = neighbours(corner.x, width, repeat_u);
    let rows = neighbours(corner.y, height, repeat_v);
    let texel = |x: u32, y: u32| texel(y as usize * width as usize + x as usize);
    let top = texel(columns[0], rows[0]).lerp(texel(columns[1], rows[0]), f.x);
    let bottom = texel(columns[0], rows[1]).lerp(texel(columns[1], rows[1]), f.x);
    top.lerp(bottom, f.y)
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

    const USED: TextureRef = TextureRef {
        texture: 0,
        scale: Vec2::ONE,
        offset: Vec2::ZERO,
    };

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

    /// An image of odd size without any regularity.
    fn noise(width: u32, height: u32) -> Texture {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        Texture {
            width,
            height,
            rgba: (0..width * height)
                .map(|_| [next(), next(), next(), next()])
                .collect(),
            repeat_u: true,
            repeat_v: true,
            ..Texture::default()
        }
    }

    fn at(t: Texture, u: f32, v: f32) -> Vec4 {
        let textures = [t];
        let seen = Footprint::point(Vec2::new(u, v));
        Sampler::new(&textures).sample(&textures, &USED, &seen)
    }

    fn mean(t: &Texture) -> Vec4 {
        let linear = crate::trace::srgb::decode_table();
        let texel = |&[r, g, b, a]: &[u8; 4]| {
            let l = |c: u8| linear[usize::from(c)];
            Vec4::new(l(r), l(g), l(b), f32::from(a) / 255.0)
        };
        t.rgba.iter().map(texel).sum::<Vec4>() / t.rgba.len() as f32
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
    fn each_level_is_the_box_average_of_the_image() {
        let t = noise(8, 4);
        let levels = pyramid(&t, &crate::trace::srgb::decode_table());
        let sizes: Vec<_> = levels.iter().map(|l| (l.width, l.height)).collect();
        assert_eq!(sizes, [(4, 2), (2, 1), (1, 1)]);
        for (k, level) in levels.iter().enumerate() {
            let (bw, bh) = (8 / level.width, 4 / level.height);
            for (i, texel) in level.texels.iter().enumerate() {
                let (x, y) = (i as u32 % level.width, i as u32 / level.width);
                let block = Texture {
                    rgba: (0..bw * bh)
                        .map(|j| t.rgba[((y * bh + j / bw) * 8 + x * bw + j % bw) as usize])
                        .collect(),
                    ..Texture::default()
                };
                let found = Vec4::from(texel.map(f32::from)) / 65535.0;
                assert!(found.distance(mean(&block)) < 1e-4, "level {}", k + 1);
            }
        }
        // Odd sizes keep the mean too.
        let t = noise(7, 5);
        let levels = pyramid(&t, &crate::trace::srgb::decode_table());
        for level in &levels {
            let sum: Vec4 = level
                .texels
                .iter()
                .map(|t| Vec4::from(t.map(f32::from)) / 65535.0)
                .sum();
            let found = sum / level.texels.len() as f32;
            assert!(found.distance(mean(&t)) < 1e-4, "{found}");
        }
    }

    #[test]
    fn near_is_level_zero_and_far_is_the_mean() {
        let textures = [noise(16, 16)];
        let sampler = Sampler::new(&textures);
        let look = |uv: Vec2, long: Vec2, short: Vec2| {
            sampler.sample(&textures, &USED, &Footprint { uv, long, short })
        };
        let uv = Vec2::new(0.37, 0.81);
        let point = look(uv, Vec2::ZERO, Vec2::ZERO);
        assert_eq!(look(uv, Vec2::X / 16.0, Vec2::Y / 17.0), point);
        let far = look(uv, Vec2::X * 40.0, Vec2::Y * 40.0);
        assert!(far.distance(mean(&textures[0])) < 1e-4);
        // Long and thin: a line of texels, not a blur in both directions.
        let row: Vec4 = (0..8)
            .map(|i| {
                let along = (i as f32 + 0.5) / 8.0 - 0.5;
                look(uv + Vec2::X * along * 0.5, Vec2::ZERO, Vec2::ZERO)
            })
            .sum::<Vec4>()
            / 8.0;
        assert!(look(uv, Vec2::X * 0.5, Vec2::Y / 16.0).distance(row) < 1e-5);
        // Whichever side is the longer.
        assert!(look(uv, Vec2::Y / 16.0, Vec2::X * 0.5).distance(row) < 1e-5);
    }
}
