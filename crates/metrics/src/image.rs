//! A checked view of a picture.

use crate::MetricError;

/// A borrowed picture: sRGB-encoded bytes, row by row from the top, each row from the left.
///
/// Invariant: `pixels.len() == width * height`, and both sides are at least 1.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    pixels: &'a [[u8; 3]],
    width: usize,
    height: usize,
}

impl<'a> Image<'a> {
    /// A view of `pixels` as `width` × `height`.
    ///
    /// # Errors
    ///
    /// [`MetricError::Empty`] if a side is 0, [`MetricError::Length`] if the slice does not fit.
    pub fn new(pixels: &'a [[u8; 3]], width: usize, height: usize) -> Result<Self, MetricError> {
        if width == 0 || height == 0 {
            return Err(MetricError::Empty { width, height });
        }
        if width.checked_mul(height) != Some(pixels.len()) {
            return Err(MetricError::Length {
                width,
                height,
                pixels: pixels.len(),
            });
        }
        Ok(Self {
            pixels,
            width,
            height,
        })
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> &'a [[u8; 3]] {
        self.pixels
    }

    /// Width, pixels, at least 1.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels, at least 1.
    pub fn height(&self) -> usize {
        self.height
    }

    /// `Ok` if `other` has the same size.
    pub(crate) fn check_same_size(&self, other: &Image<'_>) -> Result<(), MetricError> {
        if (self.width, self.height) == (other.width, other.height) {
            Ok(())
        } else {
            Err(MetricError::SizeMismatch {
                left_width: self.width,
                left_height: self.height,
                right_width: other.width,
                right_height: other.height,
            })
        }
    }

    /// `Ok` if a per-pixel map called `what` has one entry a pixel.
    pub(crate) fn check_map(&self, what: &'static str, entries: usize) -> Result<(), MetricError> {
        if entries == self.pixels.len() {
            Ok(())
        } else {
            Err(MetricError::MapLength {
                what,
                entries,
                pixels: self.pixels.len(),
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_must_fit_its_pixels() {
        let pixels = [[0u8; 3]; 6];
        assert!(Image::new(&pixels, 3, 2).is_ok());
        assert!(matches!(
            Image::new(&pixels, 4, 2),
            Err(MetricError::Length { pixels: 6, .. })
        ));
        assert!(matches!(
            Image::new(&pixels, usize::MAX, 2),
            Err(MetricError::Length { .. })
        ));
        assert!(matches!(
            Image::new(&[], 0, 5),
            Err(MetricError::Empty { .. })
        ));
    }
}
