//! The hidden-point test: samples behind what is seen are dropped.
//!
//! A cell's nearest depth says that something stands there, but one cell's minimum may belong to
//! the gap beside a thin thing or to a stray sample. So a sample is hidden when it lies behind
//! *most* of the 3 × 3 cells around it: 1.05 times behind the 7th smallest minimum at cells of 1 pixel,
//! 1.1 times behind the 8th at 2 pixels, or 2.6 times behind the largest at 4 pixels, which is for few
//! samples: a near wall of which one pixel in nine met a sample yet. Wider cells take for hidden what
//! shows between occluders. Minima commute, so the order of samples does not matter.
//!
//! Beside a moving object a sample of what stands still is hidden by something 3 % nearer to it: the
//! tolerance is for surfaces that recede, and would let a wall show through what passes close before it.
//!
//! And a sample is spared where nothing can have moved before it since it was taken, see
//! [`crate::motion`].

use crate::arith::{Arith, Panel, Projected};
use crate::lanes::UNROLLS;
use crate::motion::Reach;
use crate::workers::take;

/// Sides of the cells, pixels.
pub const CELLS: [usize; 3] = [1, 2, 4];

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

#[inline]
fn max<D: PartialOrd>(a: D, b: D) -> D {
    if a < b { b } else { a }
}

#[inline]
fn min<D: PartialOrd>(a: D, b: D) -> D {
    if a < b { a } else { b }
}

/// The three smallest-first largest of nine: a running top three.
#[inline]
fn top_three<D: PartialOrd + Copy>(values: [D; 9]) -> [D; 3] {
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

/// A sample of a moving object lies in the pixel; the other bit of a mark is its verdict.
const OWN: u8 = 2;

/// What the samples say of the pixels of the rows from `top` on: the nearest depth in each, and
/// which lie within one pixel of a sample of a moving object: their mark is 1.
pub fn survey<'a, A: Arith>(
    panel: &Panel,
    samples: impl Iterator<Item = &'a [Projected<A>]>,
    top: usize,
    nearest: &mut [A::Depth],
    movers: &mut [u8],
) {
    nearest.fill(A::FAR);
    movers.fill(0);
    let width = usize::from(panel.width);
    let first = top * width;
    for at in samples.flatten() {
        let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
        let own = panel
            .inside(x, y)
            .and_then(|pixel| pixel.checked_sub(first));
        if let Some(own) = own
            && let (Some(cell), Some(mark)) = (nearest.get_mut(own), movers.get_mut(own))
        {
            // Stored whether it changes or not: there is no telling which samples are nearest.
            *cell = min(at.depth, *cell);
            *mark |= if at.past.moves() { OWN } else { 0 };
        } else if at.past.moves() {
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
    reach: &Reach<A>,
    limits: &[A::Depth],
    movers: &[u8],
    pixel: usize,
    sample: &Projected<A>,
) -> bool {
    let (Some(limit), Some(mover)) = (limits.get(pixel), movers.get(pixel)) else {
        return false;
    };
    let beside = *mover != 0;
    let bound = if beside && !sample.past.moves() {
        A::nearer(*limit)
    } else {
        *limit
    };
    (bound < sample.depth) & (*limit <= reach.of(sample.past, beside))
}

/// The three levels of minima of a band of rows of pixels.
#[derive(Debug)]
pub struct Minima<'a, D> {
    /// Of pixels.
    pub nearest: &'a mut [D],
    halves: &'a mut [D],
    blocks: &'a mut [D],
}

impl<'a, D> Minima<'a, D> {
    /// Of a whole panel, over [`minima_len`] entries.
    pub fn of(panel: &Panel, mut minima: &'a mut [D]) -> Self {
        let [nearest, halves, blocks] = CELLS.map(|side| {
            let cells = cells_along(panel.width, side) * cells_along(panel.height, side);
            take(&mut minima, cells)
        });
        Self {
            nearest,
            halves,
            blocks,
        }
    }

    /// Splits off the first `lines` rows: a multiple of 4, or all.
    pub fn take(&mut self, panel: &Panel, lines: usize) -> Self {
        let [nearest, halves, blocks] =
            CELLS.map(|side| cells_along(panel.width, side) * lines.div_ceil(side.max(1)));
        Self {
            nearest: take(&mut self.nearest, nearest),
            halves: take(&mut self.halves, halves),
            blocks: take(&mut self.blocks, blocks),
        }
    }
}

/// The coarser minima from the first level.
pub fn coarsen<A: Arith>(panel: &Panel, minima: &mut Minima<'_, A::Depth>) {
    let width = usize::from(panel.width).max(1);
    let [_, half, block] = CELLS;
    let levels = [(&mut *minima.halves, half), (&mut *minima.blocks, block)];
    for (cells, side) in levels {
        cells.fill(A::FAR);
        let rows = cells.chunks_mut(width.div_ceil(side).max(1));
        for (cells, rows) in rows.zip(minima.nearest.chunks((side * width).max(1))) {
            for pixels in rows.chunks(width) {
                for (cell, pixels) in cells.iter_mut().zip(pixels.chunks(side)) {
                    for depth in pixels {
                        *cell = min(*depth, *cell);
                    }
                }
            }
        }
    }
}

/// The depth beyond which each pixel is hidden, of the rows from `top` (a multiple of 4) on.
pub fn limits<A: Arith>(panel: &Panel, minima: &[A::Depth], top: usize, limits: &mut [A::Depth]) {
    limits.fill(A::FAR);
    let [fine, halves, blocks] = levels(panel, minima);
    lower::<A, { CELLS[0] }>(panel, fine, top, limits, |[third, ..]| third);
    lower::<A, { CELLS[1] }>(panel, halves, top, limits, |[_, second, _]| second);
    lower::<A, { CELLS[2] }>(panel, blocks, top, limits, |[.., first]| first);
}

/// The levels of minima: of pixels, of 2 and of 4 pixels.
fn levels<'a, D>(panel: &Panel, minima: &'a [D]) -> [&'a [D]; 3] {
    let mut rest = minima;
    CELLS.map(|side| {
        let cells = cells_along(panel.width, side) * cells_along(panel.height, side);
        let (level, others) = rest.split_at_checked(cells).unwrap_or_default();
        rest = others;
        level
    })
}

/// Cells whose limits are found at a time: few where no loop over them is made parallel, for a row
/// shorter than a run takes as long as the run.
const RUN: usize = if UNROLLS { 32 } else { 4 };

/// Lowers the limits of the pixels of cells of a side to what `choose` takes of the largest three
/// of the 3 × 3 cells around, clamped at borders, plus the tolerance.
fn lower<A: Arith, const SIDE: usize>(
    panel: &Panel,
    cells: &[A::Depth],
    top: usize,
    limits: &mut [A::Depth],
    choose: impl Fn([A::Depth; 3]) -> A::Depth,
) {
    let width = usize::from(panel.width).max(1);
    let columns = cells_along(panel.width, SIDE).max(1);
    let (first, last) = (
        top / SIDE,
        cells_along(panel.height, SIDE).saturating_sub(1),
    );
    for (row, band) in (first..=last).zip(limits.chunks_mut(SIDE * width)) {
        let rows = [row.saturating_sub(1), row, (row + 1).min(last)].map(|row| {
            let from = cells.get(row * columns..).unwrap_or_default();
            from.get(..columns).unwrap_or_default()
        });
        for column in (0..columns).step_by(RUN) {
            // Rows of known length, their neighbours beside them: compilers make this parallel.
            let [a, b, c] = rows.map(|cells| with_neighbours(cells, column));
            let run: [A::Depth; RUN] = core::array::from_fn(|i| {
                let around = [
                    a[i],
                    a[i + 1],
                    a[i + 2],
                    b[i],
                    b[i + 1],
                    b[i + 2],
                    c[i],
                    c[i + 1],
                    c[i + 2],
                ];
                A::behind(choose(top_three(around)), SIDE as u32)
            });
            for line in band.chunks_mut(width) {
                let line = line.get_mut(column * SIDE..).unwrap_or_default();
                for (pixels, limit) in line.chunks_mut(SIDE).zip(run) {
                    for own in pixels {
                        *own = min(limit, *own);
                    }
                }
            }
        }
    }
}

/// [`RUN`] cells from `first` on with one before and one after; those at the ends of the row
/// continue beyond it.
fn with_neighbours<D: Copy + Default>(cells: &[D], first: usize) -> [D; RUN + 2] {
    let at = |i: usize| cells.get(i).copied().unwrap_or_default();
    let last = cells.len().saturating_sub(1);
    let mut run = [at(last); RUN + 2];
    let from = cells.get(first..).unwrap_or_default();
    for (run, cell) in run[1..].iter_mut().zip(from) {
        *run = *cell;
    }
    run[0] = at(first.saturating_sub(1));
    run
}

#[cfg(test)]
mod tests {
    use std::vec;

    use super::*;
    use crate::fixed::Fixed;
    use proptest::prelude::*;

    const NEAR: u16 = 20_000;
    const FAR: u16 = 40_000;
    const SIZE: u16 = 96;

    /// Which pixels of [`SIZE`]² are hidden at [`FAR`] where the nearest sample of each is as given.
    fn hidden_far(nearest: impl Fn(usize, usize) -> u16) -> impl Fn(usize, usize) -> bool {
        let panel = Panel::new(SIZE, SIZE).expect("a size");
        let size = usize::from(SIZE);
        let mut minima = vec![0; minima_len(SIZE, SIZE)];
        for (i, cell) in minima[..size * size].iter_mut().enumerate() {
            *cell = nearest(i % size, i / size);
        }
        coarsen::<Fixed>(&panel, &mut Minima::of(&panel, &mut minima));
        let mut found = vec![0; size * size];
        limits::<Fixed>(&panel, &minima, 0, &mut found);
        move |x, y| found[y * size + x] < FAR
    }

    #[test]
    fn what_shows_beside_a_near_pillar_is_not_hidden() {
        // At the border too, where the pillar is all that lies on one side.
        let pillar = 25..80;
        let hidden = hidden_far(|x, _| if pillar.contains(&x) { NEAR } else { FAR });
        for y in 0..usize::from(SIZE) {
            for x in 0..usize::from(SIZE) {
                let inside = (pillar.start + 1..pillar.end - 1).contains(&x);
                let outside = !(pillar.start - 4..pillar.end + 4).contains(&x);
                assert!(!inside || hidden(x, y), "{x} {y} behind the pillar shows");
                assert!(!outside || !hidden(x, y), "{x} {y} beside it does not");
            }
        }
    }

    #[test]
    fn few_samples_of_a_near_wall_hide_what_is_far_behind() {
        let nothing = <Fixed as crate::arith::Arith>::FAR;
        let met = |x: usize, y: usize| x % 3 == 1 && y % 3 == 1;
        let hidden = hidden_far(|x, y| if met(x, y) { NEAR } else { nothing });
        let all = |y| (0..usize::from(SIZE)).all(|x| hidden(x, y));
        assert!((0..usize::from(SIZE)).all(all));
    }

    proptest! {
        #[test]
        fn top_three_equals_sorting(values in prop::array::uniform9(any::<u16>())) {
            let mut sorted = values;
            sorted.sort_unstable();
            prop_assert_eq!(top_three(values), [sorted[6], sorted[7], sorted[8]]);
        }
    }
}
