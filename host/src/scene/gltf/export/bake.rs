//! Procedural patterns as images.
//!
//! A pattern repeats in texture coordinates, so one period with repeat wrapping is the whole of
//! it; the texture transform maps the period to 0..1. Edges become a ramp of one texel
//! (bilinear filtering), 1/1024 of a period: the only difference from the computed pattern, and
//! the 8-bit rounding of its colours.

use crate::scene::Procedural;
use crate::trace::{pattern::pattern, srgb};
use glam::{Vec2, Vec3};

/// Texels along one period of a pattern.
const PERIOD_TEXELS: u32 = 1024;

/// One period of a pattern.
pub(super) struct Baked {
    /// Width and height, texels.
    pub(super) size: (u32, u32),
    /// Row by row from the top, sRGB.
    pub(super) rgba: Vec<[u8; 4]>,
    /// From the surface's texture coordinates to those of the image.
    pub(super) scale: Vec2,
}

/// Computes one period of `pattern` times `colour` (linear), a mean of 2×2 points a texel.
pub(super) fn bake(procedural: &Procedural, colour: Vec3) -> Baked {
    let period = match *procedural {
        Procedural::Checker { size, .. } => Vec2::splat(2.0 * size),
        Procedural::Brick { size, .. } => size * Vec2::new(1.0, 2.0),
        // Constant in v: one row is enough.
        Procedural::Stripes { period, .. } => Vec2::new(period, 1.0),
    };
    let size = match procedural {
        Procedural::Stripes { .. } => (PERIOD_TEXELS, 1),
        _ => (PERIOD_TEXELS, PERIOD_TEXELS),
    };
    let step = period / Vec2::new(size.0 as f32, size.1 as f32);
    let points = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(Vec2::from);
    let texel = |x: u32, y: u32| {
        let corner = Vec2::new(x as f32, y as f32);
        let sum: Vec3 = points
            .iter()
            .map(|&p| pattern(procedural, (corner + p) * step, Vec2::ZERO))
            .sum();
        let [r, g, b] = srgb::encode8(sum * 0.25 * colour);
        [r, g, b, 255]
    };
    let rgba = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    let rgba = rgba.map(|(x, y)| texel(x, y)).collect();
    Baked {
        size,
        rgba,
        scale: period.recip(),
    }
}

/// Encodes RGBA texels as PNG.
pub(super) fn png((width, height): (u32, u32), rgba: &[[u8; 4]]) -> Result<Vec<u8>, String> {
    if rgba.is_empty() || u64::from(width) * u64::from(height) != rgba.len() as u64 {
        return Err(format!("{width}×{height} pixels and {} texels", rgba.len()));
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer
        .write_image_data(rgba.as_flattened())
        .map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())?;
    Ok(bytes)
}
