//! From the pixels of a frame to those of the panel.

use glam::{UVec2, Vec3};

/// What a pixel of the panel shows of a frame with fewer pixels. Of a frame with more, both are
/// averages over the pixel's area and a little more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Upscale {
    /// The frame's nearest pixel.
    Nearest,
    /// Linear interpolation between the nearest four.
    Linear,
}

/// Resamples `image` (linear light, rows from the top) from one size to another. Both sides of
/// both sizes are at least 1.
pub(super) fn resize(image: &[Vec3], from: UVec2, to: UVec2, upscale: Upscale) -> Vec<Vec3> {
    if from == to {
        return image.to_vec();
    }
    let columns = taps(from.x, to.x, upscale);
    let rows = taps(from.y, to.y, upscale);
    let mut narrow = Vec::with_capacity((to.x * from.y) as usize);
    for row in image.chunks_exact(from.x as usize) {
        narrow.extend(columns.iter().map(|taps| mix(taps, |i| row[i])));
    }
    let mut out = Vec::with_capacity((to.x * to.y) as usize);
    for taps in &rows {
        out.extend((0..to.x as usize).map(|x| mix(taps, |y| narrow[y * to.x as usize + x])));
    }
    out
}

fn mix(taps: &[(usize, f32)], value: impl Fn(usize) -> Vec3) -> Vec3 {
    taps.iter().map(|(i, weight)| value(*i) * *weight).sum()
}

/// For each pixel of a line of `to`, the pixels of a line of `from` and their weights, whose sum
/// is 1.
fn taps(from: u32, to: u32, upscale: Upscale) -> Vec<Vec<(usize, f32)>> {
    let ratio = f64::from(from) / f64::from(to);
    let radius = match upscale {
        Upscale::Nearest => 0.5 * ratio.max(1.0),
        Upscale::Linear => ratio.max(1.0),
    };
    (0..to)
        .map(|x| {
            let centre = (f64::from(x) + 0.5) * ratio - 0.5;
            let weight = |i: u32| match upscale {
                Upscale::Nearest if ratio <= 1.0 => {
                    f64::from(u8::from(f64::from(i) == (centre + 0.5).floor()))
                }
                Upscale::Nearest => f64::from(u8::from((f64::from(i) - centre).abs() <= radius)),
                Upscale::Linear => (1.0 - (f64::from(i) - centre).abs() / radius).max(0.0),
            };
            let first = (centre - radius).floor().max(0.0) as u32;
            let last = ((centre + radius).ceil() as u32).min(from - 1);
            let taps: Vec<_> = (first..=last)
                .map(|i| (i, weight(i)))
                .filter(|t| t.1 > 0.0)
                .collect();
            let sum: f64 = taps.iter().map(|t| t.1).sum();
            taps.into_iter()
                .map(|(i, w)| (i as usize, (w / sum) as f32))
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(size: UVec2) -> Vec<Vec3> {
        let place = |i: u32| UVec2::new(i % size.x, i / size.x).as_vec2() + 0.5;
        (0..size.x * size.y)
            .map(|i| (place(i) / size.as_vec2()).extend(0.25))
            .collect()
    }

    #[test]
    fn a_ramp_stays_a_ramp_and_a_constant_a_constant() {
        let to = UVec2::new(64, 40);
        for from in [UVec2::new(20, 13), UVec2::new(160, 97), UVec2::new(1, 1)] {
            for upscale in [Upscale::Linear, Upscale::Nearest] {
                let image = resize(&ramp(from), from, to, upscale);
                let exact = ramp(to);
                assert_eq!(image.len(), exact.len());
                for (i, (a, b)) in image.iter().zip(&exact).enumerate() {
                    assert!((a.z - 0.25).abs() < 1e-6, "{from} {upscale:?}");
                    let (x, y) = (i % 64, i / 64);
                    let inner = (8..56).contains(&x) && (8..32).contains(&y);
                    let off = (*a - *b).abs().max_element();
                    // Half a frame pixel at most for the nearest one.
                    let limit = match upscale {
                        Upscale::Linear => 1e-2,
                        Upscale::Nearest => 0.5 / 13.0 + 1e-3,
                    };
                    assert!(
                        !inner || from.x == 1 || off < limit,
                        "{from} {upscale:?} at {x},{y}: {off}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_nearest_pixel_is_shown_unchanged() {
        let from = UVec2::new(3, 2);
        let image: Vec<Vec3> = (0..6).map(|i| Vec3::splat(i as f32)).collect();
        let large = resize(&image, from, UVec2::new(9, 6), Upscale::Nearest);
        for y in 0..6 {
            for x in 0..9 {
                assert_eq!(large[y * 9 + x], image[y / 3 * 3 + x / 3]);
            }
        }
    }
}
