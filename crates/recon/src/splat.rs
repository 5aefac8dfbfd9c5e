//! Scatter: every sample adds its share to the pixels of its footprint (Dayal et al. 2005 §5.2).
//!
//! Sums commute, so the picture does not depend on the order of samples. All functions work on a
//! band of pixel rows, which one thread writes, from samples that may lie beyond it.

use crate::arith::{ANCHOR_BITS, Arith, Moments, Panel, Projected, REACH, Sums};
use core::ops::Range;

/// Sums over 5 pixels along rows, in place.
pub fn sum_along<A: Arith>(panel: &Panel, mass: &mut [A::Mass]) {
    for line in mass.chunks_mut(usize::from(panel.width).max(1)) {
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
}

/// The filter width of each pixel of the rows `lines`, from the mass in the 5 × 5 pixels around;
/// `sums` holds all of what [`sum_along`] made.
pub fn widths<A: Arith>(
    panel: &Panel,
    lines: Range<usize>,
    sums: &[A::Mass],
    widths: &mut [A::Width],
) {
    let (width, height) = (usize::from(panel.width).max(1), usize::from(panel.height));
    for (y, widths) in lines.zip(widths.chunks_mut(width)) {
        let rows = y.saturating_sub(2)..(y + 3).min(height);
        let mut rows = rows.map(|row| sums.get(row * width..).unwrap_or_default());
        let rows: [&[A::Mass]; 5] = core::array::from_fn(|_| rows.next().unwrap_or_default());
        for (x, out) in widths.iter_mut().enumerate() {
            let around = rows.map(|row| row.get(x).copied().unwrap_or_default());
            *out = A::width_of(around.into_iter().fold(A::Mass::default(), A::add_mass));
        }
    }
}

/// Where a sample's filter widths come from.
#[derive(Clone, Copy, Debug)]
pub enum Widths<'a, A: Arith> {
    /// The map of all pixels.
    Map(&'a [A::Width]),
    /// The sample itself.
    Own,
}

/// What samples are scattered with.
#[derive(Clone, Copy, Debug)]
pub struct Filter<'a, A: Arith> {
    /// The panel.
    pub panel: &'a Panel,
    /// Widths.
    pub widths: Widths<'a, A>,
    /// Light of each code of a colour.
    pub light: &'a [u16; 256],
}

/// A band of pixel rows and its sums.
#[derive(Debug)]
pub struct Target<'a, A: Arith> {
    /// The band's rows.
    pub lines: Range<usize>,
    /// Sums for means, one a pixel.
    pub sums: &'a mut [Sums<A>],
    /// Moments for planes, one a pixel, or empty.
    pub moments: &'a mut [Moments<A>],
}

impl<A: Arith> Filter<'_, A> {
    /// Adds the samples' shares to a band.
    pub fn scatter<'s>(
        &self,
        samples: impl Iterator<Item = &'s [Projected<A>]>,
        target: &mut Target<'_, A>,
    ) {
        target.sums.fill(Sums::<A>::default());
        target.moments.fill(Moments::<A>::default());
        for samples in samples {
            if target.moments.is_empty() {
                for sample in samples {
                    self.splat::<false>(sample, target);
                }
            } else {
                for sample in samples {
                    self.splat::<true>(sample, target);
                }
            }
        }
    }

    /// Adds one sample's share to the pixels of its footprint.
    #[inline]
    fn splat<const PLANES: bool>(&self, at: &Projected<A>, target: &mut Target<'_, A>) {
        if !A::counts(at.weight) {
            return;
        }
        let panel = self.panel;
        let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
        let band = target.lines.start as i32..target.lines.end as i32;
        if y + REACH < band.start || y - REACH >= band.end {
            return;
        }
        let [wide, high] = match self.widths {
            Widths::Map(map) => [map.get(panel.nearest(x, y)).copied().unwrap_or_default(); 2],
            Widths::Own => at.widths,
        };
        let down = A::taps(panel, high, at.y);
        let across = A::taps(panel, wide, at.x);
        let rows = (y + down.first).max(band.start)..(y + down.last + 1).min(band.end);
        let columns = (x + across.first).max(0)..(x + across.last + 1).min(i32::from(panel.width));
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let light = |c: usize| A::light(self.light[usize::from(at.rgb[c])]);
        let light = [light(0), light(1), light(2)];
        // A footprint seldom lies in more than one square.
        for square_y in rows.start >> ANCHOR_BITS..=(rows.end - 1) >> ANCHOR_BITS {
            for square_x in columns.start >> ANCHOR_BITS..=(columns.end - 1) >> ANCHOR_BITS {
                let features = A::features(panel, light, (at.x, at.y), (square_x, square_y));
                let rows = within(&rows, square_y);
                let columns = within(&columns, square_x);
                let taps = down.weights.get((rows.start - y + REACH) as usize..);
                for (row, tap) in rows.zip(taps.unwrap_or(&[])) {
                    let weight = A::times(at.weight, *tap);
                    let line = (row - band.start) as usize * usize::from(panel.width);
                    let pixels = line + columns.start as usize..line + columns.end as usize;
                    let taps = across.weights.get((columns.start - x + REACH) as usize..);
                    let taps = taps.unwrap_or(&[]).iter().map(|tap| A::times(weight, *tap));
                    let sums = target.sums.get_mut(pixels.clone()).unwrap_or(&mut []);
                    if PLANES {
                        let moments = target.moments.get_mut(pixels).unwrap_or(&mut []);
                        for ((sums, moments), weight) in sums.iter_mut().zip(moments).zip(taps) {
                            A::add(sums, weight, &features);
                            A::add_moments(moments, weight, &features);
                        }
                    } else {
                        for (sums, weight) in sums.iter_mut().zip(taps) {
                            A::add(sums, weight, &features);
                        }
                    }
                }
            }
        }
    }
}

/// The part of a range of pixels in square `square`.
fn within(range: &Range<i32>, square: i32) -> Range<i32> {
    range.start.max(square << ANCHOR_BITS)..range.end.min((square + 1) << ANCHOR_BITS)
}
