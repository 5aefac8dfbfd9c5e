//! Spatial scatter: the noise that comes from neighbouring pixels showing different instants.
//!
//! Scher Zagier, *Defining and Refining Frameless Rendering*, UNC TR97-008, 1997, §6. She
//! characterises scatter by its velocity (scale and direction), density, area and gradient. Of
//! these a snapshot with the age and the image motion of each pixel gives:
//! - the **scale**, px: how far a point has travelled since its pixel was computed, and over the
//!   picture the maximum of it (eq. 4). Her formula takes 1 Rp second, the time to compute as many
//!   samples as there are pixels, for the age, because every pixel then has that age at most;
//!   here each pixel has its own;
//! - the **density**: the number of instants that the snapshot shows. 1 is a double-buffered
//!   frame, which has no scatter;
//! - the **asynchrony** of neighbours, which she does not number: the standard deviation of ages
//!   within 3 × 3 pixels. An old but synchronous region lags; it does not scatter;
//! - against the ideal image, the blur that would remove it ([`blur_to_remove`], eq. 3) and the
//!   gradient that it adds ([`gradient_ratio`], eq. 11).
//!
//! The area (the contour around an object's projections over the interval) needs object outlines
//! and is not measured.

use crate::{Image, MetricError};

/// Scatter of one snapshot, from its pixels' ages and motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Scatter {
    /// Greatest travel of a point since its pixel was computed, px (her scale of the scatter).
    pub scale: f64,
    /// The travel that 95 % of pixels do not exceed, px: the maximum is one pixel's luck.
    pub scale_p95: f64,
    /// Mean travel, px.
    pub scale_mean: f64,
    /// Distinct instants shown; 1 for a double-buffered frame, 0 for an empty snapshot.
    pub density: usize,
    /// Mean over pixels of the standard deviation of ages in their 3 × 3 neighbourhood, ms.
    pub asynchrony_ms: f64,
}

impl Scatter {
    /// Measures a snapshot of `width` × `height`, rows from the top.
    ///
    /// `ages` is the age of each pixel's newest sample, µs (`None`: it shows none, and is left
    /// out); `motion` the velocity of the image there, px/s right and down (not finite: taken as
    /// unknown, and left out of the scale).
    ///
    /// # Errors
    ///
    /// [`MetricError::Empty`] for a side of 0; [`MetricError::MapLength`] if a map has not one
    /// entry a pixel.
    pub fn measure(
        width: usize,
        height: usize,
        ages: &[Option<u32>],
        motion: &[[f32; 2]],
    ) -> Result<Self, MetricError> {
        let pixels = width.saturating_mul(height);
        if pixels == 0 {
            return Err(MetricError::Empty { width, height });
        }
        for (what, entries) in [("age", ages.len()), ("motion", motion.len())] {
            if entries != pixels {
                return Err(MetricError::MapLength {
                    what,
                    entries,
                    pixels,
                });
            }
        }
        let mut travel: Vec<f64> = ages
            .iter()
            .zip(motion)
            .filter_map(|(age, v)| {
                let speed = f64::from(v[0]).hypot(f64::from(v[1]));
                let seconds = f64::from((*age)?) * 1e-6;
                speed.is_finite().then_some(speed * seconds)
            })
            .collect();
        travel.sort_unstable_by(f64::total_cmp);
        let mut instants: Vec<u32> = ages.iter().copied().flatten().collect();
        instants.sort_unstable();
        instants.dedup();
        Ok(Self {
            scale: travel.last().copied().unwrap_or(0.0),
            scale_p95: crate::sequence::nearest_rank(&travel, 0.95).unwrap_or(0.0),
            scale_mean: mean(&travel),
            density: instants.len(),
            asynchrony_ms: asynchrony(width, height, ages) * 1e-3,
        })
    }
}

fn mean(values: &[f64]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        values.iter().sum::<f64>() / values.len() as f64
    }
}

/// Mean over pixels of the standard deviation of ages in 3 × 3, in the unit of the ages.
fn asynchrony(width: usize, height: usize, ages: &[Option<u32>]) -> f64 {
    let (mut sum_of_deviations, mut pixels) = (0.0, 0u32);
    for y in 0..height {
        for x in 0..width {
            let Some(here) = ages[y * width + x] else {
                continue;
            };
            // Relative to this pixel's own age, so that squares of old ages do not cancel.
            let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
            for v in y.saturating_sub(1)..(y + 2).min(height) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    if let Some(age) = ages[v * width + u] {
                        let d = f64::from(age) - f64::from(here);
                        sum += d;
                        squares += d * d;
                        count += 1.0;
                    }
                }
            }
            let variance: f64 = squares / count - (sum / count) * (sum / count);
            sum_of_deviations += variance.max(0.0).sqrt();
            pixels += 1;
        }
    }
    sum_of_deviations / f64::from(pixels.max(1))
}

/// Widths that [`blur_to_remove`] tries: half-octave steps.
const BLURS: [f32; 12] = [
    0.5, 0.71, 1.0, 1.41, 2.0, 2.83, 4.0, 5.66, 8.0, 11.3, 16.0, 22.6,
];

/// The standard deviation, px, of the narrowest Gaussian that blurs the error of `shown` down to
/// the share `left` of its RMS (eq. 3: "would blur away the scatter"), to half an octave.
///
/// 0 for equal pictures. `None` if 23 px do not do it: then the error is broad (a lag, a wrong
/// colour), not scatter. Noise that is independent from pixel to pixel falls as 0.28/σ.
///
/// # Errors
///
/// [`MetricError::SizeMismatch`]; [`MetricError::Parameter`] if `left` is not in (0, 1).
pub fn blur_to_remove(
    ideal: Image<'_>,
    shown: Image<'_>,
    left: f64,
) -> Result<Option<f64>, MetricError> {
    ideal.check_same_size(&shown)?;
    if !(left > 0.0 && left < 1.0) {
        return Err(MetricError::Parameter {
            what: "the share left",
            value: left,
            range: "above 0 and below 1",
        });
    }
    // Blurring is linear: the blurred pictures differ by the blurred difference.
    let planes: [Vec<f32>; 3] = [0, 1, 2].map(|c| {
        let pairs = shown.pixels().iter().zip(ideal.pixels());
        pairs
            .map(|(s, i)| f32::from(s[c]) - f32::from(i[c]))
            .collect()
    });
    let energy = |planes: &[Vec<f32>; 3]| -> f64 {
        let values = planes.iter().flatten();
        values.map(|&d| f64::from(d) * f64::from(d)).sum()
    };
    let whole = energy(&planes);
    if whole == 0.0 {
        return Ok(Some(0.0));
    }
    let enough = BLURS.into_iter().find(|&sigma| {
        let blurred = [0, 1, 2].map(|c: usize| blur(&planes[c], ideal.width(), sigma));
        energy(&blurred) <= left * left * whole
    });
    Ok(enough.map(f64::from))
}

/// Mean gradient magnitude of the luma of `shown` over that of `ideal`, both blurred by `sigma` px
/// first (a scale-space gradient, eq. 11).
///
/// Above 1: edges that are not there (scatter, noise). Below 1: edges are lost (blur). `None`
/// where the ideal image has no gradient at all.
///
/// # Errors
///
/// [`MetricError::SizeMismatch`]; [`MetricError::Parameter`] if `sigma` is not in 0..=64.
pub fn gradient_ratio(
    ideal: Image<'_>,
    shown: Image<'_>,
    sigma: f32,
) -> Result<Option<f64>, MetricError> {
    ideal.check_same_size(&shown)?;
    if !(0.0..=64.0).contains(&sigma) {
        return Err(MetricError::Parameter {
            what: "the blur",
            value: f64::from(sigma),
            range: "in 0..=64 px",
        });
    }
    let of = |image: Image<'_>| {
        let luma: Vec<f32> = image
            .pixels()
            .iter()
            .map(|&[r, g, b]| 0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b))
            .collect();
        mean_gradient(&blur(&luma, image.width(), sigma), image.width())
    };
    let base = of(ideal);
    Ok((base > 0.0).then(|| of(shown) / base))
}

/// Mean magnitude of forward differences, over pixels that have a right and a lower neighbour.
fn mean_gradient(plane: &[f32], width: usize) -> f64 {
    let height = plane.len() / width;
    let mut sum = 0.0;
    for y in 1..height {
        for x in 1..width {
            let here = plane[(y - 1) * width + x - 1];
            let dx = plane[(y - 1) * width + x] - here;
            let dy = plane[y * width + x - 1] - here;
            sum += f64::from(dx.hypot(dy));
        }
    }
    let count = width.saturating_sub(1) * height.saturating_sub(1);
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// Convolves with a Gaussian cut at 3σ, the border repeated; `sigma` 0 changes nothing.
fn blur(plane: &[f32], width: usize, sigma: f32) -> Vec<f32> {
    let height = plane.len() / width;
    let radius = (3.0 * sigma).ceil() as usize;
    let weight = |i: usize| {
        let d = i as f32 - radius as f32;
        if sigma > 0.0 {
            (-0.5 * (d / sigma).powi(2)).exp()
        } else {
            1.0
        }
    };
    let kernel: Vec<f32> = (0..=2 * radius).map(weight).collect();
    let total: f32 = kernel.iter().sum();
    let clamp = |p: usize, i: usize, side: usize| (p + i).saturating_sub(radius).min(side - 1);
    let mut rows = Vec::with_capacity(plane.len());
    for line in plane.chunks_exact(width) {
        for x in 0..width {
            let taps = kernel.iter().enumerate();
            let sum: f32 = taps.map(|(i, k)| k * line[clamp(x, i, width)]).sum();
            rows.push(sum / total);
        }
    }
    let mut out = vec![0.0; plane.len()];
    for (y, line) in out.chunks_exact_mut(width).enumerate() {
        for (i, k) in kernel.iter().enumerate() {
            let from = clamp(y, i, height) * width;
            for (o, v) in line.iter_mut().zip(&rows[from..from + width]) {
                *o += k / total * v;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::{blocks, blurred, next, view};

    #[test]
    fn her_example_two_and_an_eighth_pixels() {
        // §6.2, eqs. 6-8: 64 px/s at 30 full images a second; the oldest pixel is one such old.
        let mut state = 3;
        let oldest = 1_000_000 / 30;
        let mut ages: Vec<_> = (0..256).map(|_| Some(next(&mut state) % oldest)).collect();
        ages[17] = Some(oldest);
        let scatter = Scatter::measure(16, 16, &ages, &[[64.0, 0.0]; 256]).unwrap();
        assert!((scatter.scale - 2.13).abs() < 0.005, "{}", scatter.scale);
        assert!(scatter.scale_p95 < scatter.scale && scatter.scale_mean < scatter.scale_p95);
        assert!(scatter.density > 200);
    }

    #[test]
    fn a_double_buffered_frame_lags_but_does_not_scatter() {
        let ages = vec![Some(16_667); 64];
        let frame = Scatter::measure(8, 8, &ages, &[[60.0, 80.0]; 64]).unwrap();
        assert_eq!((frame.density, frame.asynchrony_ms), (1, 0.0));
        assert!((frame.scale - 1.6667).abs() < 1e-9);
        // Must fail: one pixel of another instant.
        let mut ages = ages;
        ages[27] = Some(0);
        let frame = Scatter::measure(8, 8, &ages, &[[60.0, 80.0]; 64]).unwrap();
        assert_eq!(frame.density, 2);
        // Its 9 neighbourhoods have one in nine apart: 16.667·√8/9 each, over 64 pixels.
        let expected = 16.667 * 8f64.sqrt() / 9.0 * 9.0 / 64.0;
        assert!((frame.asynchrony_ms - expected).abs() < 1e-6);
    }

    #[test]
    fn holes_and_unknown_motion_are_left_out() {
        let ages = [None, Some(1000), Some(3000), None];
        let motion = [[1e9, 0.0], [f32::NAN, 0.0], [1000.0, 0.0], [0.0; 2]];
        let scatter = Scatter::measure(2, 2, &ages, &motion).unwrap();
        assert_eq!(scatter.scale, 3.0);
        assert_eq!(scatter.asynchrony_ms, 1.0);
        let nothing = Scatter::measure(2, 2, &[None; 4], &motion).unwrap();
        assert_eq!(nothing, Scatter::default());
        assert!(Scatter::measure(2, 2, &ages[1..], &motion).is_err());
        assert!(Scatter::measure(0, 2, &[], &[]).is_err());
    }

    #[test]
    fn blur_removes_scatter_and_not_a_wrong_colour() {
        let ideal = vec![[128u8; 3]; 64 * 64];
        let mut state = 7;
        let scattered: Vec<_> = ideal
            .iter()
            .map(|_| [128 - 20 + (next(&mut state) % 41) as u8; 3])
            .collect();
        let wrong = vec![[148u8; 3]; 64 * 64];
        let removed_by =
            |shown: &[[u8; 3]]| blur_to_remove(view(&ideal, 64), view(shown, 64), 0.25).unwrap();
        // 0.282/σ = 0.25 at σ = 1.13: the next step of the ladder.
        assert_eq!(removed_by(&scattered), Some(f64::from(1.41f32)));
        assert_eq!(removed_by(&wrong), None);
        assert_eq!(removed_by(&ideal), Some(0.0));
        // Scatter in clumps of 2 × 2 takes twice the blur.
        let clumps: Vec<_> = (0..4096)
            .map(|i| scattered[(i / 64 / 2) * 64 + i % 64 / 2])
            .collect();
        assert_eq!(removed_by(&clumps), Some(f64::from(2.83f32)));
        assert!(blur_to_remove(view(&ideal, 64), view(&wrong, 64), f64::NAN).is_err());
    }

    #[test]
    fn the_gradient_tells_noise_from_blur() {
        let ideal = blocks(64, 64, 0);
        let mut state = 4;
        let noisy: Vec<_> = ideal
            .iter()
            .map(|p| p.map(|c| c.saturating_add((next(&mut state) % 40) as u8)))
            .collect();
        let ratio = |shown: &[[u8; 3]], sigma| {
            gradient_ratio(view(&ideal, 64), view(shown, 64), sigma).unwrap()
        };
        assert_eq!(ratio(&ideal, 0.0), Some(1.0));
        assert!(ratio(&noisy, 0.0).unwrap() > 1.2);
        assert!(ratio(&blurred(&ideal, 64, 3), 0.0).unwrap() < 0.9);
        // At a coarser scale the noise is gone.
        assert!(ratio(&noisy, 3.0).unwrap() < ratio(&noisy, 0.0).unwrap());
        let flat = vec![[9u8; 3]; 16];
        let none = gradient_ratio(view(&flat, 4), view(&flat, 4), 0.0);
        assert_eq!(none, Ok(None));
    }
}
