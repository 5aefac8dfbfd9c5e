//! Scatter: every sample adds its share to the pixels of its footprint (Dayal et al. 2005 §5.2).
//!
//! Sums commute, so the picture does not depend on the order of samples.

use crate::arith::{Arith, Moments, Panel, Projected, REACH, Sums};
use crate::deep::Stored;

/// Samples' weights summed a pixel.
pub fn masses<A: Arith>(panel: &Panel, projected: &[Projected<A>], mass: &mut [A::Mass]) {
    mass.fill(A::Mass::default());
    for sample in projected.iter().filter(|s| A::counts(s.weight)) {
        let pixel = panel.nearest(A::pixel(panel, sample.x), A::pixel(panel, sample.y));
        if let Some(mass) = mass.get_mut(pixel) {
            A::gather(mass, sample.weight);
        }
    }
}

/// The filter width of each pixel, from the mass in the 5 × 5 pixels around. `mass` is used up:
/// it ends as sums over 5 pixels along rows.
pub fn widths<A: Arith>(panel: &Panel, mass: &mut [A::Mass], widths: &mut [A::Width]) {
    let width = usize::from(panel.width);
    for line in mass.chunks_mut(width.max(1)) {
        // The two values before x are overwritten by the time they are needed: keep them.
        let mut before = [A::Mass::default(); 2];
        for x in 0..line.len() {
            let at = |x: usize| line.get(x).copied().unwrap_or_default();
            let own = at(x);
            let sum = [before[0], before[1], at(x + 1), at(x + 2)]
                .into_iter()
                .fold(own, A::add_mass);
            before = [before[1], own];
            if let Some(mass) = line.get_mut(x) {
                *mass = sum;
            }
        }
    }
    let height = usize::from(panel.height);
    for (y, line) in widths.chunks_mut(width.max(1)).enumerate() {
        let rows = y.saturating_sub(2)..(y + 3).min(height);
        for (x, out) in line.iter_mut().enumerate() {
            let sum = rows
                .clone()
                .map(|row| mass.get(row * width + x).copied().unwrap_or_default())
                .fold(A::Mass::default(), A::add_mass);
            *out = A::width_of(sum);
        }
    }
}

/// Where the sums go.
#[derive(Debug)]
pub struct Target<'a, A: Arith> {
    /// Sums for means, one a pixel.
    pub sums: &'a mut [Sums<A>],
    /// Moments for planes, one a pixel, or empty.
    pub moments: &'a mut [Moments<A>],
}

/// Adds all samples' shares.
pub fn scatter<A: Arith>(
    panel: &Panel,
    samples: &[Stored],
    projected: &[Projected<A>],
    light: &[u16; 256],
    target: &mut Target<'_, A>,
) {
    target.sums.fill(Sums::<A>::default());
    target.moments.fill(Moments::<A>::default());
    for (sample, at) in samples.iter().zip(projected) {
        if A::counts(at.weight) {
            let light = sample.rgb.map(|c| A::light(light[usize::from(c)]));
            splat(panel, at, light, target);
        }
    }
}

/// Adds one sample's share to the pixels of its footprint.
#[inline]
fn splat<A: Arith>(
    panel: &Panel,
    at: &Projected<A>,
    light: [A::Light; 3],
    target: &mut Target<'_, A>,
) {
    let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
    let (reach_x, reach_y) = (A::reach(at.widths[0]), A::reach(at.widths[1]));
    let left = (x - reach_x).max(0);
    let right = (x + reach_x).min(i32::from(panel.width) - 1);
    if left > right {
        return;
    }
    let top = (y - reach_y).max(0);
    let bottom = (y + reach_y).min(i32::from(panel.height) - 1);
    let mut across = [A::Weight::default(); 2 * REACH as usize + 1];
    let mut down = across;
    A::taps(panel, at.widths[0], at.x, left, &mut across);
    A::taps(panel, at.widths[1], at.y, top, &mut down);
    for (tap, row) in down.iter().zip(top..=bottom) {
        let down = A::times(at.weight, *tap);
        if !A::counts(down) {
            continue;
        }
        let line = row as usize * usize::from(panel.width);
        for (tap, column) in across.iter().zip(left..=right) {
            let weight = A::times(down, *tap);
            if !A::counts(weight) {
                continue;
            }
            let pixel = line + column as usize;
            if let Some(sums) = target.sums.get_mut(pixel) {
                A::add(sums, weight, light);
            }
            if let Some(moments) = target.moments.get_mut(pixel) {
                A::add_moments(moments, panel, weight, light, (at.x, at.y), (column, row));
            }
        }
    }
}
