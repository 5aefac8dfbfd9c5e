//! Pictures of a run: sRGB bytes to PNG, and what is drawn from or over them.

use std::path::Path;

use super::{ReportError, write_file};

/// A picture: sRGB bytes, rows from the top.
///
/// Invariant: `pixels.len() == width * height`, and both sides are at least 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// A rectangle of pixels; its right and lower ends are excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column.
    pub x: usize,
    /// Topmost row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Picture {
    /// A picture from its pixels.
    ///
    /// # Errors
    ///
    /// [`ReportError::PictureSize`] if they do not fill `width` × `height`, or a side is 0.
    pub fn new(width: usize, height: usize, pixels: Vec<[u8; 3]>) -> Result<Self, ReportError> {
        if width == 0 || height == 0 || width.checked_mul(height) != Some(pixels.len()) {
            return Err(ReportError::PictureSize {
                width,
                height,
                pixels: pixels.len(),
            });
        }
        Ok(Self {
            width,
            height,
            pixels,
        })
    }

    /// Width, pixels, at least 1.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels, at least 1.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels, rows from the top.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    ///
    /// [`ReportError::Png`] if a side is beyond what PNG holds.
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        png_bytes(self.width, self.height, &self.pixels)
    }

    /// Writes the picture as a PNG file.
    ///
    /// # Errors
    ///
    /// [`ReportError::Write`] with the path, [`ReportError::Png`].
    pub fn write_png(&self, path: &Path) -> Result<(), ReportError> {
        write_file(path, &self.png()?)
    }

    /// Where and how much two pictures differ: the greatest of the three channels' differences,
    /// from black (0) through purple and orange to pale yellow (`full` of 255 and more).
    ///
    /// `full` is at least 1; 0 is taken as 1.
    ///
    /// # Errors
    ///
    /// [`ReportError::SizeMismatch`].
    pub fn heat_map(ideal: &Self, shown: &Self, full: u8) -> Result<Self, ReportError> {
        ideal.check_same_size(shown)?;
        let heat = |(a, b): (&[u8; 3], &[u8; 3])| {
            let worst = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
            inferno(f32::from(worst) / f32::from(full.max(1)))
        };
        let pixels = ideal.pixels.iter().zip(&shown.pixels).map(heat).collect();
        Self::new(ideal.width, ideal.height, pixels)
    }

    /// A map of values (errors, ages, densities; rows from the top) in the colours of
    /// [`Picture::heat_map`]: `full` and more is the palest. What is not a number is grey.
    ///
    /// # Errors
    ///
    /// [`ReportError::PictureSize`].
    pub fn value_map(
        width: usize,
        height: usize,
        values: &[f32],
        full: f32,
    ) -> Result<Self, ReportError> {
        let colour = |v: &f32| match v / full {
            t if t.is_nan() => [128; 3],
            t => inferno(t),
        };
        Self::new(width, height, values.iter().map(colour).collect())
    }

    /// Each pixel as a block of `factor` × `factor`; 0 is taken as 1.
    ///
    /// # Errors
    ///
    /// [`ReportError::PictureSize`] if the result is too large to address.
    pub fn enlarged(&self, factor: usize) -> Result<Self, ReportError> {
        let factor = factor.max(1);
        let too_large = || ReportError::PictureSize {
            width: self.width.saturating_mul(factor),
            height: self.height.saturating_mul(factor),
            pixels: self.pixels.len(),
        };
        let width = self.width.checked_mul(factor).ok_or_else(too_large)?;
        let height = self.height.checked_mul(factor).ok_or_else(too_large)?;
        let size = width.checked_mul(height).ok_or_else(too_large)?;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(size).map_err(|_| too_large())?;
        for row in self.pixels.chunks_exact(self.width) {
            for _ in 0..factor {
                pixels.extend(row.iter().flat_map(|p| std::iter::repeat_n(*p, factor)));
            }
        }
        Self::new(width, height, pixels)
    }

    /// Draws the upper and left sides of rectangles, one pixel wide, and of the whole the right
    /// and lower sides too: a tiling, whose tiles share their borders, becomes a net.
    ///
    /// `opacity` is 0 (nothing) to 1 (`colour` alone). What lies outside is cut off. Enlarge a
    /// small picture first, so that the lines do not hide its pixels.
    pub fn draw_net(&mut self, rects: &[Rect], colour: [u8; 3], opacity: f32) {
        let opacity = if opacity.is_nan() {
            1.0
        } else {
            opacity.clamp(0.0, 1.0)
        };
        // A line that two tiles share is blended once.
        let mut net = vec![false; self.pixels.len()];
        let edge = Rect {
            x: 0,
            y: 0,
            width: self.width,
            height: self.height,
        };
        for (rect, outer) in rects.iter().map(|r| (r, false)).chain([(&edge, true)]) {
            let right = rect.x.saturating_add(rect.width).min(self.width);
            let bottom = rect.y.saturating_add(rect.height).min(self.height);
            if rect.x >= right || rect.y >= bottom || rects.is_empty() {
                continue;
            }
            let (last_x, last_y) = if outer {
                (right - 1, bottom - 1)
            } else {
                (rect.x, rect.y)
            };
            for x in rect.x..right {
                net[rect.y * self.width + x] = true;
                net[last_y * self.width + x] = true;
            }
            for y in rect.y..bottom {
                net[y * self.width + rect.x] = true;
                net[y * self.width + last_x] = true;
            }
        }
        for (pixel, drawn) in self.pixels.iter_mut().zip(net) {
            if drawn {
                *pixel = blend(*pixel, colour, opacity);
            }
        }
    }

    /// Pictures of one height from left to right, `gap` grey pixels between them.
    ///
    /// # Errors
    ///
    /// [`ReportError::SizeMismatch`] if heights differ, [`ReportError::PictureSize`] for none.
    pub fn strip(pictures: &[&Self], gap: usize) -> Result<Self, ReportError> {
        let Some(first) = pictures.first() else {
            return Self::new(0, 0, Vec::new());
        };
        let mut pixels = Vec::new();
        for y in 0..first.height {
            for (i, picture) in pictures.iter().enumerate() {
                if picture.height != first.height {
                    return Err(first.mismatch(picture));
                }
                if i > 0 {
                    pixels.extend(std::iter::repeat_n([128; 3], gap));
                }
                let row = y * picture.width;
                pixels.extend_from_slice(&picture.pixels[row..row + picture.width]);
            }
        }
        Self::new(pixels.len() / first.height, first.height, pixels)
    }

    fn check_same_size(&self, other: &Self) -> Result<(), ReportError> {
        if (self.width, self.height) == (other.width, other.height) {
            Ok(())
        } else {
            Err(self.mismatch(other))
        }
    }

    fn mismatch(&self, other: &Self) -> ReportError {
        ReportError::SizeMismatch {
            first: format!("{}x{}", self.width, self.height),
            second: format!("{}x{}", other.width, other.height),
        }
    }
}

/// An 8-bit RGB PNG file, marked as sRGB, of `pixels` (rows from the top).
///
/// # Errors
///
/// [`ReportError::PictureSize`] if the slice does not fill the size; [`ReportError::Png`].
pub fn png_bytes(width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<Vec<u8>, ReportError> {
    let wrong = || ReportError::PictureSize {
        width,
        height,
        pixels: pixels.len(),
    };
    if width.checked_mul(height) != Some(pixels.len()) {
        return Err(wrong());
    }
    let (Ok(columns), Ok(rows)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err(wrong());
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

/// Nine knots of the colour map *inferno* (Smith and van der Walt for matplotlib, CC0): equal
/// steps of value look like equal steps, in grey print and to the colour-blind too.
const INFERNO: [[u8; 3]; 9] = [
    [0, 0, 4],
    [31, 12, 72],
    [85, 15, 109],
    [136, 34, 106],
    [186, 54, 85],
    [227, 89, 51],
    [249, 140, 10],
    [249, 201, 50],
    [252, 255, 164],
];

/// The colour of a value of 0..=1; beyond the ends the colour of the end, not a number as 0.
pub fn inferno(value: f32) -> [u8; 3] {
    let place = if value > 0.0 {
        value.min(1.0) * 8.0
    } else {
        0.0
    };
    let knot = (place as usize).min(7);
    blend(INFERNO[knot], INFERNO[knot + 1], place - knot as f32)
}

/// `t` of the way from `a` to `b`, on the encoded values.
fn blend(a: [u8; 3], b: [u8; 3], t: f32) -> [u8; 3] {
    [0, 1, 2].map(|c| {
        let (a, b) = (f32::from(a[c]), f32::from(b[c]));
        (a + (b - a) * t).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(width: usize, height: usize) -> Picture {
        let pixels = (0..width * height).map(|i| [i as u8, (i / width) as u8, 7]);
        Picture::new(width, height, pixels.collect()).unwrap()
    }

    #[test]
    fn png_gives_back_what_went_in() {
        let picture = gradient(13, 5);
        let bytes = picture.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut back = vec![0xA5; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut back).unwrap();
        assert_eq!((info.width, info.height), (13, 5));
        assert_eq!(info.color_type, png::ColorType::Rgb);
        assert_eq!(&back[..info.buffer_size()], picture.pixels().as_flattened());
    }

    #[test]
    fn sizes_are_checked() {
        assert!(Picture::new(2, 2, vec![[0; 3]; 3]).is_err());
        assert!(Picture::new(0, 0, vec![]).is_err());
        assert!(Picture::new(usize::MAX, 2, vec![[0; 3]; 2]).is_err());
        assert!(png_bytes(2, 2, &[[0; 3]; 5]).is_err());
        assert!(png_bytes(0, 0, &[]).is_err());
        assert!(gradient(2, 2).enlarged(usize::MAX / 3).is_err());
        assert!(Picture::heat_map(&gradient(2, 3), &gradient(3, 2), 9).is_err());
        assert!(Picture::strip(&[], 1).is_err());
        assert!(Picture::strip(&[&gradient(2, 3), &gradient(3, 2)], 1).is_err());
    }

    #[test]
    fn the_ramp_gets_lighter_all_the_way() {
        let luma = |v| {
            let [r, g, b] = inferno(v).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let steps: Vec<f32> = (0..=64).map(|i| luma(i as f32 / 64.0)).collect();
        assert!(steps.is_sorted_by(|a, b| a < b), "{steps:?}");
        assert_eq!(inferno(-1.0), INFERNO[0]);
        assert_eq!(inferno(f32::NAN), INFERNO[0]);
        assert_eq!(inferno(f32::INFINITY), INFERNO[8]);
    }

    #[test]
    fn heat_is_where_the_difference_is() {
        let ideal = gradient(4, 4);
        let mut shown = ideal.clone();
        shown.pixels[6][2] = 7 + 32;
        let heat = Picture::heat_map(&ideal, &shown, 64).unwrap();
        for (i, pixel) in heat.pixels().iter().enumerate() {
            assert_eq!(*pixel, if i == 6 { INFERNO[4] } else { INFERNO[0] });
        }
        let zero = Picture::heat_map(&ideal, &shown, 0).unwrap();
        assert_eq!(zero.pixels()[6], INFERNO[8]);
        let values = [0.0, f32::NAN, 5.0, 9e9];
        let map = Picture::value_map(2, 2, &values, 10.0).unwrap();
        assert_eq!(map.pixels(), [INFERNO[0], [128; 3], INFERNO[4], INFERNO[8]]);
    }

    #[test]
    fn enlarging_repeats_pixels() {
        let big = gradient(2, 2).enlarged(3).unwrap();
        assert_eq!((big.width(), big.height()), (6, 6));
        for y in 0..6 {
            for x in 0..6 {
                assert_eq!(
                    big.pixels()[y * 6 + x],
                    [(y / 3 * 2 + x / 3) as u8, (y / 3) as u8, 7]
                );
            }
        }
    }

    #[test]
    fn a_net_has_lines_of_one_pixel_and_a_border() {
        let mut picture = Picture::new(9, 5, vec![[100; 3]; 45]).unwrap();
        let rect = |x, y, width, height| Rect {
            x,
            y,
            width,
            height,
        };
        let tiles = [rect(0, 0, 4, 5), rect(4, 0, 5, 2), rect(4, 2, 5, 3)];
        picture.draw_net(&tiles, [200; 3], 0.5);
        let rows: Vec<String> = picture
            .pixels()
            .chunks(9)
            .map(|row| {
                row.iter()
                    .map(|p| if p[0] == 150 { '#' } else { '.' })
                    .collect()
            })
            .collect();
        let expected = [
            "#########",
            "#...#...#",
            "#...#####",
            "#...#...#",
            "#########",
        ];
        assert_eq!(rows, expected);
        // Out of bounds, empty, or no rectangles at all: nothing is drawn, nothing panics.
        let before = picture.clone();
        picture.draw_net(&[], [0; 3], 1.0);
        assert_eq!(picture, before);
        picture.draw_net(
            &[rect(50, 0, 4, 4), rect(usize::MAX, 1, 2, 0)],
            [200; 3],
            0.0,
        );
        assert_eq!(picture, before);
    }

    #[test]
    fn a_strip_is_as_wide_as_its_parts() {
        let (a, b) = (gradient(2, 3), gradient(5, 3));
        let strip = Picture::strip(&[&a, &b], 2).unwrap();
        assert_eq!((strip.width(), strip.height()), (9, 3));
        assert_eq!(strip.pixels()[9..11], a.pixels()[2..4]);
        assert_eq!(strip.pixels()[11..13], [[128; 3]; 2]);
        assert_eq!(strip.pixels()[13..18], b.pixels()[5..10]);
    }
}
