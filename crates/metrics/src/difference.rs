//! Squared error, RMSE and PSNR on displayed sRGB values (`docs/METHODS.md`).
//!
//! The sum of squares is kept in integers, so it does not depend on the order of additions, and
//! so totals over an animation are the exact pool of its refreshes.

use crate::{Image, MetricError};

/// A sum of squared differences of sRGB bytes and the number of values that it is over.
///
/// One picture of w × h adds 3·w·h values of at most 255² each: 2^48 values fit in the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SquaredError {
    /// Sum of squares, in units of 1/255² of the full range.
    pub sum: u64,
    /// Values summed: three for each pixel.
    pub count: u64,
}

impl SquaredError {
    /// Over all pixels and R, G, B of two pictures.
    ///
    /// # Errors
    ///
    /// [`MetricError::SizeMismatch`] if the sizes differ.
    pub fn between(ideal: Image<'_>, shown: Image<'_>) -> Result<Self, MetricError> {
        ideal.check_same_size(&shown)?;
        let sum = ideal
            .pixels()
            .iter()
            .zip(shown.pixels())
            .map(|(a, b)| u64::from(pixel_squared_error(*a, *b)))
            .sum();
        Ok(Self {
            sum,
            count: 3 * ideal.pixels().len() as u64,
        })
    }

    /// The pool of two sets of values.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            sum: self.sum.saturating_add(other.sum),
            count: self.count.saturating_add(other.count),
        }
    }

    /// Mean of squares, 0..=65025; 0 for no values.
    pub fn mean(self) -> f64 {
        if self.count == 0 {
            0.0
        } else {
            self.sum as f64 / self.count as f64
        }
    }

    /// Root of the mean of squares, 0..=255.
    pub fn rmse(self) -> f64 {
        self.mean().sqrt()
    }

    /// Peak signal-to-noise ratio, dB, peak 255; infinite where nothing differs.
    pub fn psnr(self) -> f64 {
        if self.sum == 0 {
            f64::INFINITY
        } else {
            10.0 * (255.0 * 255.0 / self.mean()).log10()
        }
    }
}

/// Σ over R, G, B of the squared difference, 0..=195075.
pub fn pixel_squared_error(a: [u8; 3], b: [u8; 3]) -> u32 {
    let square = |i: usize| {
        let d = u32::from(a[i].abs_diff(b[i]));
        d * d
    };
    square(0) + square(1) + square(2)
}

/// RMSE of two pictures: root mean square over pixels and R, G, B, 0..=255.
///
/// # Errors
///
/// [`MetricError::SizeMismatch`] if the sizes differ.
pub fn rmse(ideal: Image<'_>, shown: Image<'_>) -> Result<f64, MetricError> {
    Ok(SquaredError::between(ideal, shown)?.rmse())
}

/// PSNR of two pictures, dB; infinite for equal ones.
///
/// # Errors
///
/// [`MetricError::SizeMismatch`] if the sizes differ.
pub fn psnr(ideal: Image<'_>, shown: Image<'_>) -> Result<f64, MetricError> {
    Ok(SquaredError::between(ideal, shown)?.psnr())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::{noise, view};

    #[test]
    fn a_constant_offset_is_its_own_rmse() {
        let black = vec![[10u8, 20, 30]; 12];
        let shifted = vec![[17u8, 13, 37]; 12];
        let e = SquaredError::between(view(&black, 4), view(&shifted, 4)).unwrap();
        assert_eq!(e.sum, 12 * 3 * 49);
        assert_eq!(e.rmse(), 7.0);
        // 20·log10(255 / 7), from a table of logarithms.
        assert!((e.psnr() - 31.2288).abs() < 1e-4, "{}", e.psnr());
    }

    #[test]
    fn black_against_white_is_the_end_of_the_scale() {
        let (black, white) = (vec![[0u8; 3]; 9], vec![[255u8; 3]; 9]);
        let e = SquaredError::between(view(&black, 3), view(&white, 3)).unwrap();
        assert_eq!(e.rmse(), 255.0);
        assert_eq!(e.psnr(), 0.0);
    }

    #[test]
    fn equal_pictures_differ_by_nothing_and_one_value_is_seen() {
        let a = noise(16, 16, 1);
        assert_eq!(rmse(view(&a, 16), view(&a, 16)).unwrap(), 0.0);
        assert_eq!(psnr(view(&a, 16), view(&a, 16)).unwrap(), f64::INFINITY);
        // Must fail: the least change that there is, at the last pixel's last channel.
        let mut b = a.clone();
        let last = &mut b[255][2];
        *last = if *last == 255 { 254 } else { *last + 1 };
        let r = rmse(view(&a, 16), view(&b, 16)).unwrap();
        assert_eq!(r, (1.0f64 / 768.0).sqrt());
    }

    #[test]
    fn the_order_of_the_two_pictures_does_not_matter() {
        let (a, b) = (noise(8, 8, 2), noise(8, 8, 3));
        let ab = SquaredError::between(view(&a, 8), view(&b, 8)).unwrap();
        let ba = SquaredError::between(view(&b, 8), view(&a, 8)).unwrap();
        assert_eq!(ab, ba);
        assert!(ab.sum > 0);
    }

    #[test]
    fn sizes_must_match_even_where_the_counts_do() {
        let a = noise(8, 4, 2);
        assert!(matches!(
            rmse(view(&a, 8), view(&a, 4)),
            Err(MetricError::SizeMismatch { .. })
        ));
    }
}
