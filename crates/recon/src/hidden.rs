//! The hidden-point test: samples behind what is seen are dropped.
//!
//! A cell's nearest depth says that something stands there, but one cell's minimum may belong to
//! the gap beside a thin thing or to a stray sample. So a sample is hidden when it lies behind
//! *most* of the 3 × 3 cells around it: behind the 7th smallest minimum at cells of 1 pixel, the
//! 8th at 2 pixels, the largest at 32 pixels, each with a tolerance of 5 % of the depth times the
//! cell's side. Minima commute, so the order of samples does not matter.
//!
//! And a sample is spared where nothing can have moved before it since it was taken, see
//! [`crate::motion`].

use crate::arith::{Arith, Panel, Projected};

/// Sides of the cells, pixels.
pub const CELLS: [usize; 3] = [1, 2, 32];

/// Cells along `pixels` for cells of a side.
#[must_use]
pub const fn cells_along(pixels: u16, side: usize) -> usize {
    // Never 0; said so that no division can fail.
    (pixels as usize).div_ceil(if side == 0 { 1 } else { side })
}

/// Entries that the three levels of minima need together.
#[must_use]
pub const fn minima_len(width: u16, height: u16) -> usize {
    let mut sum = 0;
    let mut level = 0;
    while level < 3 {
        let side = CELLS[level];
        sum += cells_along(width, side) * cells_along(height, side);
        level += 1;
    }
    sum
}

/// The three smallest-first largest of nine: a running top three.
#[inline]
fn top_three<D: PartialOrd + Copy>(values: [D; 9]) -> [D; 3] {
    let max = |a: D, b: D| if a < b { b } else { a };
    let min = |a: D, b: D| if a < b { a } else { b };
    let [a, b, c, rest @ ..] = values;
    let (lo, hi) = (min(a, b), max(a, b));
    let mut third = min(lo, c);
    let rest_of = max(lo, c);
    let mut second = min(hi, rest_of);
    let mut first = max(hi, rest_of);
    for v in rest {
        let down = min(first, v);
        first = max(first, v);
        let down_again = min(second, down);
        second = max(second, down);
        third = max(third, down_again);
    }
    [third, second, first]
}

/// Nearest depth of each pixel of the rows from `top` on.
pub fn nearest<'a, A: Arith>(
    panel: &Panel,
    samples: impl Iterator<Item = &'a [Projected<A>]>,
    top: usize,
    level: &mut [A::Depth],
) {
    level.fill(A::FAR);
    let first = top * usize::from(panel.width);
    for samples in samples {
        for sample in samples {
            let (x, y) = (A::pixel(panel, sample.x), A::pixel(panel, sample.y));
            let own = panel
                .inside(x, y)
                .and_then(|pixel| pixel.checked_sub(first));
            if let Some(cell) = own.and_then(|own| level.get_mut(own))
                && sample.depth < *cell
            {
                *cell = sample.depth;
            }
        }
    }
}

/// A sample of a moving object lies in the pixel; the other bit of a mark is its verdict.
const OWN: u8 = 2;

/// Marks the pixels, of the rows from `top` on, within one pixel of a sample of a moving object.
/// A mark is 1.
pub fn mark_movers<'a, A: Arith>(
    panel: &Panel,
    samples: impl Iterator<Item = &'a [Projected<A>]>,
    top: usize,
    movers: &mut [u8],
) {
    movers.fill(0);
    let width = usize::from(panel.width);
    let first = top * width;
    for samples in samples {
        for at in samples.iter().filter(|s| s.moves) {
            let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
            let own = panel
                .inside(x, y)
                .and_then(|pixel| pixel.checked_sub(first));
            if let Some(mark) = own.and_then(|own| movers.get_mut(own)) {
                *mark |= OWN;
                continue;
            }
            // Beside the band: those of its pixels that are near.
            for dy in -1..=1 {
                for dx in -1..=1 {
                    let own = panel.nearest(x + dx, y + dy).checked_sub(first);
                    if let Some(mark) = own.and_then(|own| movers.get_mut(own)) {
                        *mark |= 1;
                    }
                }
            }
        }
    }
    spread(movers, width);
    for mark in movers {
        *mark &= 1;
    }
}

/// Own marks spread along rows into another bit, and from there across rows into bit 0.
fn spread(movers: &mut [u8], width: usize) {
    const ALONG: u8 = 2 * OWN;
    for line in movers.chunks_mut(width.max(1)) {
        let mut before = 0;
        for x in 0..line.len() {
            let after = line.get(x + 1).copied().unwrap_or_default();
            if let Some(mark) = line.get_mut(x) {
                let own = *mark;
                if (before | own | after) & OWN != 0 {
                    *mark |= ALONG;
                }
                before = own;
            }
        }
    }
    for i in 0..movers.len() {
        let at = |i: Option<usize>| i.and_then(|i| movers.get(i)).copied().unwrap_or_default();
        let near = at(i.checked_sub(width)) | at(Some(i)) | at(Some(i + width));
        if near & ALONG != 0
            && let Some(mark) = movers.get_mut(i)
        {
            *mark |= 1;
        }
    }
}

/// Whether a sample of a pixel is hidden.
#[inline]
pub fn hides<A: Arith>(
    limits: &[A::Depth],
    movers: &[u8],
    pixel: usize,
    sample: &Projected<A>,
) -> bool {
    let (Some(limit), Some(mover)) = (limits.get(pixel), movers.get(pixel)) else {
        return false;
    };
    let [resting, moving] = sample.reach;
    let reach = if *mover == 0 { resting } else { moving };
    *limit < sample.depth && *limit <= reach
}

/// The coarser minima from the first level.
pub fn coarsen<A: Arith>(panel: &Panel, minima: &mut [A::Depth]) {
    let width = usize::from(panel.width).max(1);
    let Some((fine, halves, blocks)) = levels_mut(panel, minima) else {
        return;
    };
    for (cells, side) in [(halves, 2), (blocks, 32)] {
        cells.fill(A::FAR);
        let rows = cells.chunks_mut(width.div_ceil(side).max(1));
        for (cells, rows) in rows.zip(fine.chunks((side * width).max(1))) {
            for pixels in rows.chunks(width) {
                for (cell, pixels) in cells.iter_mut().zip(pixels.chunks(side)) {
                    for depth in pixels {
                        if *depth < *cell {
                            *cell = *depth;
                        }
                    }
                }
            }
        }
    }
}

/// The levels of minima: of pixels, of 2 and of 32 pixels.
fn levels_mut<'a, D>(
    panel: &Panel,
    minima: &'a mut [D],
) -> Option<(&'a mut [D], &'a mut [D], &'a mut [D])> {
    let halves = cells_along(panel.width, 2) * cells_along(panel.height, 2);
    let (fine, coarse) = minima.split_at_mut_checked(panel.pixels())?;
    let (halves, blocks) = coarse.split_at_mut_checked(halves)?;
    Some((fine, halves, blocks))
}

/// The depth beyond which each pixel is hidden, of the rows from `top` (a multiple of 32) on.
pub fn limits<A: Arith>(panel: &Panel, minima: &[A::Depth], top: usize, limits: &mut [A::Depth]) {
    limits.fill(A::FAR);
    let mut rest = minima;
    for (side, rank) in [(1, 0), (2, 1), (32, 2)] {
        let size = [panel.width, panel.height].map(|pixels| cells_along(pixels, side));
        let (cells, others) = rest.split_at_checked(size[0] * size[1]).unwrap_or_default();
        rest = others;
        let limit = |around| {
            let [third, second, first] = top_three(around);
            let depth = match rank {
                0 => third,
                1 => second,
                _ => first,
            };
            A::behind(depth, side as u32)
        };
        each(
            cells,
            size,
            side,
            top.checked_div(side).unwrap_or_default(),
            limits,
            usize::from(panel.width),
            limit,
        );
    }
}

/// Lowers the limits of the pixels of each cell to what `limit` makes of the 3 × 3 cells around
/// it, clamped at borders; `limits` begins with the row of cells `first`.
fn each<D: Copy + Default + PartialOrd>(
    cells: &[D],
    [columns, rows]: [usize; 2],
    side: usize,
    first: usize,
    limits: &mut [D],
    width: usize,
    limit: impl Fn([D; 9]) -> D,
) {
    let width = width.max(1);
    let last = rows.saturating_sub(1);
    for (row, band) in (first..rows).zip(limits.chunks_mut((side * width).max(1))) {
        let [above, here, below] = [row.saturating_sub(1), row, (row + 1).min(last)].map(|r| {
            let from = cells.get(r * columns..).unwrap_or_default();
            from.get(..columns).unwrap_or_default()
        });
        let last = columns.saturating_sub(1);
        for column in 0..columns {
            let near = [column.saturating_sub(1), column, (column + 1).min(last)];
            let [a, b, c] = [above, here, below]
                .map(|line| near.map(|x| line.get(x).copied().unwrap_or_default()));
            let limit = limit([a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]);
            let from = column * side;
            for line in band.chunks_mut(width) {
                let to = (from + side).min(line.len());
                for own in line.get_mut(from..to).unwrap_or_default() {
                    if limit < *own {
                        *own = limit;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn top_three_equals_sorting(values in prop::array::uniform9(any::<u16>())) {
            let mut sorted = values;
            sorted.sort_unstable();
            prop_assert_eq!(top_three(values), [sorted[6], sorted[7], sorted[8]]);
        }
    }
}
