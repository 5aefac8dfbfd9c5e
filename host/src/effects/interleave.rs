//! Interleaving a component (Dubla et al. 2009, Listing 1): a sample a pixel, guidance by pattern,
//! more samples where it says so.

use glam::Vec3;
use rayon::prelude::*;

use super::components::{Component, Told};
use super::deferred::Deferred;
use super::framed::{Layer, MOST, Refinement};
use crate::trace::Rays;

/// The squared error that is left alone, displayed levels; the numbers for others are in
/// `docs/RESULTS.md`.
const TOLERATED: f32 = 1.5 * 1.5;

/// What a component is computed for.
#[derive(Clone, Copy)]
pub(crate) struct Canvas<'a> {
    pub(crate) seen: &'a [Deferred],
    /// Pixels in a row.
    pub(crate) width: u32,
    /// Side of the pattern, pixels.
    pub(crate) side: u32,
    /// Light that is known without the component, as it leaves towards the eye.
    pub(crate) known: &'a [Vec3],
}

/// All samples of a component, averaged by pixel, and how many there were. `which` is the
/// component's place in [`Refinement::Plain`].
pub(crate) fn interleave(
    component: &impl Component,
    name: &'static str,
    canvas: &Canvas<'_>,
    refinement: Refinement,
    which: usize,
    rays: &mut Rays,
) -> (Vec<Vec3>, Layer) {
    let Canvas {
        seen, width, side, ..
    } = *canvas;
    let place = |i: usize| [i as u32 % width, i as u32 / width];
    let member = |i: usize| {
        let [x, y] = place(i);
        y % side * side + x % side
    };
    let first: Vec<(Vec3, Told, Rays)> = (seen.par_iter().enumerate())
        .map(|(i, at)| {
            let mut rays = Rays::default();
            let (light, told) = component.sample(at, member(i), 0, &mut rays);
            (light, told, rays)
        })
        .collect();
    let patterns = Patterns::new(seen.len(), width, side);
    let sets: Vec<u32> = match refinement {
        Refinement::All => vec![MOST; patterns.len()],
        Refinement::Plain(n) => vec![n[which].clamp(1, MOST); patterns.len()],
        Refinement::Listings => patterns.map(|pixels| {
            let told: Vec<Told> = pixels.map(|i| first[i].1).collect();
            let refine = component.listing(&told);
            (1 + (refine * MOST as f32).ceil() as u32).min(MOST)
        }),
        Refinement::Adaptive => {
            let own = patterns.map(|pixels| noise(component, canvas, &first, pixels));
            let wanted = patterns.dilated(&own);
            let sets = |noise: f32| (noise / TOLERATED).ceil().clamp(1.0, MOST as f32);
            wanted.into_iter().map(|noise| sets(noise) as u32).collect()
        }
    };
    let refined: Vec<(Vec3, u8, Rays)> = (seen.par_iter().enumerate())
        .map(|(i, at)| {
            let (mut light, _, mut rays) = first[i];
            let sets = sets[patterns.of(place(i))];
            for set in 1..sets {
                light += component.sample(at, member(i), set, &mut rays).0;
            }
            (light / sets as f32, sets as u8, rays)
        })
        .collect();
    refined.iter().for_each(|pixel| *rays += pixel.2);
    let layer = Layer {
        name,
        samples: refined.iter().map(|pixel| pixel.1).collect(),
        width,
    };
    (refined.into_iter().map(|pixel| pixel.0).collect(), layer)
}

/// The squared error, in displayed levels, that the filter would leave of one sample a pixel: from
/// the differences between neighbours that are alike.
fn noise(
    component: &impl Component,
    canvas: &Canvas<'_>,
    first: &[(Vec3, Told, Rays)],
    pixels: impl Iterator<Item = usize>,
) -> f32 {
    let Canvas {
        seen,
        width,
        side,
        known,
    } = *canvas;
    let (mut squares, mut pairs) = (0.0f32, 0.0f32);
    let mut count = 0.0f32;
    for i in pixels {
        let weight = component.weight(&seen[i]);
        let slope = slope(known[i] + weight * first[i].0);
        count += 1.0;
        for k in neighbours(i, width, seen.len()) {
            if !seen[i].like(&seen[k]) {
                continue;
            }
            let apart = weight * (first[i].0 - first[k].0);
            squares += (luminance(apart) * slope).powi(2);
            pairs += 1.0;
        }
    }
    // A difference has twice the variance of a sample; the filter averages a whole pattern.
    let variance = squares / (2.0 * pairs.max(1.0));
    let left = component.left(pairs / (4.0 * count.max(1.0)));
    variance * left / (side * side) as f32
}

/// The four neighbours of a pixel within the image.
fn neighbours(i: usize, width: u32, pixels: usize) -> impl Iterator<Item = usize> {
    let width = width as usize;
    let x = i % width;
    [
        (x > 0).then(|| i - 1),
        (x + 1 < width).then(|| i + 1),
        i.checked_sub(width),
        (i + width < pixels).then_some(i + width),
    ]
    .into_iter()
    .flatten()
}

fn luminance(light: Vec3) -> f32 {
    light.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Displayed levels (0..=255) for a unit of linear light around a light: the slope of the sRGB
/// curve, about 255·x^(1/2.2); none above white.
fn slope(light: Vec3) -> f32 {
    let level = luminance(light);
    if level >= 1.0 {
        return 0.0;
    }
    255.0 / 2.2 * level.max(0.003).powf(1.0 / 2.2 - 1.0)
}

/// The patterns of an image, row by row.
struct Patterns {
    side: u32,
    width: u32,
    height: u32,
    columns: u32,
    rows: u32,
}

impl Patterns {
    fn new(pixels: usize, width: u32, side: u32) -> Self {
        let height = pixels as u32 / width;
        Self {
            side,
            width,
            height,
            columns: width.div_ceil(side),
            rows: height.div_ceil(side),
        }
    }

    fn len(&self) -> usize {
        (self.columns * self.rows) as usize
    }

    /// The pattern of a pixel.
    fn of(&self, [x, y]: [u32; 2]) -> usize {
        (y / self.side * self.columns + x / self.side) as usize
    }

    /// Something of each pattern from its pixels, row by row.
    fn map<T: Send>(
        &self,
        of: impl Fn(Box<dyn Iterator<Item = usize> + '_>) -> T + Sync,
    ) -> Vec<T> {
        (0..self.columns * self.rows)
            .into_par_iter()
            .map(|pattern| {
                let side = self.side;
                let (left, top) = (pattern % self.columns * side, pattern / self.columns * side);
                let right = (left + side).min(self.width);
                let bottom = (top + side).min(self.height);
                let row = move |y: u32| (left..right).map(move |x| (y * self.width + x) as usize);
                of(Box::new((top..bottom).flat_map(row)))
            })
            .collect()
    }

    /// Half of the most that the eight patterns around have, where a pattern has less: where
    /// neighbours disagree all nine samples may agree by chance.
    fn dilated(&self, own: &[f32]) -> Vec<f32> {
        let [columns, rows] = [self.columns as i32, self.rows as i32];
        let around = |i: usize| {
            let (x, y) = (i as i32 % columns, i as i32 / columns);
            let mut most = 0.0f32;
            for ny in (y - 1).max(0)..=(y + 1).min(rows - 1) {
                for nx in (x - 1).max(0)..=(x + 1).min(columns - 1) {
                    most = most.max(own[(ny * columns + nx) as usize]);
                }
            }
            own[i].max(0.5 * most)
        };
        (0..own.len()).map(around).collect()
    }
}
