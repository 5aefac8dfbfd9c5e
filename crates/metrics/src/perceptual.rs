//! ꟻLIP: the difference that a viewer sees when two pictures alternate in place.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, *ꟻLIP: A Difference
//! Evaluator for Alternating Images*, HPG 2020. The computation is `flip-rs`'s port of NVIDIA's
//! reference; this module fixes the viewing conditions and the pooling (the mean over pixels, as
//! the paper recommends for one number).

use crate::{Image, MetricError};

/// How the panel is looked at; shared by ꟻLIP and ColorVideoVDP so that they judge the same thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewing {
    /// Panel pixels in one degree of the viewer's field, finite and above 0.
    ///
    /// More of them hide more: at 67 a pixel is about the limit of vision, at 20 (a small
    /// panel close to the eye) each one shows.
    pub pixels_per_degree: f32,
}

impl Default for Viewing {
    /// 67 pixels a degree, the ꟻLIP paper's default: a monitor 0.7 m wide with 3840 columns, seen
    /// from 0.7 m.
    fn default() -> Self {
        Self {
            pixels_per_degree: flip_rs::DEFAULT_PPD,
        }
    }
}

/// The ꟻLIP error at each pixel, 0 (alike) to 1, rows from the top.
///
/// # Errors
///
/// [`MetricError::SizeMismatch`] if the sizes differ; [`MetricError::Flip`] if the viewing
/// conditions are not finite and positive, or memory is short.
pub fn flip_map(
    ideal: Image<'_>,
    shown: Image<'_>,
    viewing: Viewing,
) -> Result<Vec<f32>, MetricError> {
    ideal.check_same_size(&shown)?;
    let own = |image: Image<'_>| {
        let bytes = image.pixels().as_flattened().to_vec();
        flip_rs::RgbImage::new(image.width(), image.height(), bytes)
    };
    let map = flip_rs::ldr_flip(&own(ideal)?, &own(shown)?, viewing.pixels_per_degree)?;
    Ok(map.into_pixels())
}

/// Mean ꟻLIP error over the picture, 0 to 1.
///
/// # Errors
///
/// As [`flip_map`].
pub fn flip(ideal: Image<'_>, shown: Image<'_>, viewing: Viewing) -> Result<f64, MetricError> {
    let map = flip_map(ideal, shown, viewing)?;
    // A view has at least one pixel, and so has its map.
    Ok(map.iter().map(|&e| f64::from(e)).sum::<f64>() / map.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::{blocks, blurred, view};

    fn score(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
        flip(view(a, 64), view(b, 64), Viewing::default()).unwrap()
    }

    #[test]
    fn equal_pictures_score_zero_and_one_pixel_is_seen_where_it_is() {
        let a = blocks(64, 64, 0);
        assert_eq!(score(&a, &a), 0.0);
        let mut b = a.clone();
        b[20 * 64 + 40] = b[20 * 64 + 40].map(|c| c ^ 0x80);
        assert!(score(&a, &b) > 1e-4);
        let map = flip_map(view(&a, 64), view(&b, 64), Viewing::default()).unwrap();
        let worst = map.iter().enumerate().max_by(|x, y| x.1.total_cmp(y.1));
        let worst = worst.unwrap().0;
        assert!((worst / 64).abs_diff(20) <= 1 && (worst % 64).abs_diff(40) <= 1);
        assert_eq!(map[0], 0.0, "and nothing is seen far from it");
    }

    #[test]
    fn more_blur_scores_worse() {
        let a = blocks(64, 64, 0);
        let scores: Vec<f64> = [0, 1, 2, 4]
            .iter()
            .map(|&r| score(&a, &blurred(&a, 64, r)))
            .collect();
        assert!(scores.is_sorted_by(|x, y| x < y), "{scores:?}");
    }

    #[test]
    fn black_against_white_is_nearly_the_worst() {
        let (black, white) = (vec![[0u8; 3]; 4096], vec![[255u8; 3]; 4096]);
        assert!(score(&black, &white) > 0.95);
    }

    #[test]
    fn more_pixels_a_degree_hide_fine_errors() {
        let a = blocks(64, 64, 0);
        let b = blurred(&a, 64, 1);
        let at = |ppd| {
            let viewing = Viewing {
                pixels_per_degree: ppd,
            };
            flip(view(&a, 64), view(&b, 64), viewing).unwrap()
        };
        assert!(at(20.0) > at(67.0));
    }

    #[test]
    fn an_impossible_distance_is_an_error() {
        let a = blocks(64, 64, 0);
        for ppd in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let viewing = Viewing {
                pixels_per_degree: ppd,
            };
            assert!(matches!(
                flip(view(&a, 64), view(&a, 64), viewing),
                Err(MetricError::Flip(_))
            ));
        }
    }
}
