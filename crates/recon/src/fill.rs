//! Hole filling by a pull-push pyramid: where few samples reached a pixel, coarser levels speak.
//!
//! Pulling makes each coarser texel the confidence-weighted mean of four finer ones; pushing
//! gives each finer texel what it lacks in confidence from the filled coarser level.

use crate::arith::{Arith, Texel};
use crate::workers::{Parts, Workers};

/// Texels of all coarser levels of a picture of this size.
#[must_use]
pub const fn pyramid_len(width: u16, height: u16) -> usize {
    let (mut w, mut h) = (width as usize, height as usize);
    let mut sum = 0;
    while w > 1 || h > 1 {
        w = w.div_ceil(2);
        h = h.div_ceil(2);
        sum += w * h;
    }
    sum
}

/// A level's size.
type Size = (usize, usize);

fn coarser((w, h): Size) -> Size {
    (w.div_ceil(2), h.div_ceil(2))
}

/// Texels from which on a level is shared among the workers.
const WORTH_SHARING: usize = 1 << 12;

/// Fills `texels` (row by row, `width` × `height`) by way of `pyramid`. Says whether anything was
/// known at all; if not, all texels keep a confidence of zero.
pub fn fill<A: Arith>(
    width: usize,
    height: usize,
    texels: &mut [Texel<A>],
    pyramid: &mut [Texel<A>],
    workers: &impl Workers,
) -> bool {
    fill_level(texels, (width, height), pyramid, workers).is_some()
}

/// Fills a level by way of the coarser ones. `None` when nothing was known.
fn fill_level<A: Arith>(
    texels: &mut [Texel<A>],
    size: Size,
    pyramid: &mut [Texel<A>],
    workers: &impl Workers,
) -> Option<()> {
    let parts = workers.parts();
    if parts == 1 || texels.len() < WORTH_SHARING {
        pull_levels(texels, size, pyramid);
        return push_levels(texels, size, pyramid);
    }
    let below = coarser(size);
    let (level, rest) = pyramid.split_at_mut_checked(below.0 * below.1)?;
    let share = below.1.div_ceil(parts.max(1)).max(1);
    let fine = &*texels;
    let work = level.chunks_mut((share * below.0).max(1)).enumerate();
    Parts::new(work).each(workers, |(part, level)| {
        pull_level(fine, size, *part * share, level, below);
    });
    fill_level(level, below, rest, workers)?;
    let level = &*level;
    let work = texels.chunks_mut((2 * share * size.0).max(1)).enumerate();
    Parts::new(work).each(workers, |(part, fine)| {
        push_level(fine, 2 * *part * share, size, level, below);
    });
    Some(())
}

/// Pulls rows of a coarse level, those from row `first` on, from a fine one.
fn pull_level<A: Arith>(
    fine: &[Texel<A>],
    size: Size,
    first: usize,
    coarse: &mut [Texel<A>],
    below: Size,
) {
    for (y, line) in (first..).zip(coarse.chunks_mut(below.0.max(1))) {
        let row = |y: usize| {
            let row = fine.get(y * size.0..).filter(|_| y < size.1);
            row.and_then(|row| row.get(..size.0)).unwrap_or_default()
        };
        let (above, under) = (row(2 * y), row(2 * y + 1));
        for (x, texel) in line.iter_mut().enumerate() {
            let at = |row: &[Texel<A>], x: usize| row.get(x).copied().unwrap_or_default();
            *texel = A::pull([
                at(above, 2 * x),
                at(above, 2 * x + 1),
                at(under, 2 * x),
                at(under, 2 * x + 1),
            ]);
        }
    }
}

/// Pulls one level into the start of `pyramid`, then the rest from there.
fn pull_levels<'a, A: Arith>(
    mut fine: &'a [Texel<A>],
    mut size: Size,
    pyramid: &'a mut [Texel<A>],
) {
    let mut rest = pyramid;
    while size.0 > 1 || size.1 > 1 {
        let below = coarser(size);
        let Some((level, tail)) = rest.split_at_mut_checked(below.0 * below.1) else {
            return;
        };
        pull_level(fine, size, 0, level, below);
        fine = level;
        rest = tail;
        size = below;
    }
}

/// Pushes from the coarsest level down. `None` when the coarsest knows nothing.
fn push_levels<A: Arith>(
    texels: &mut [Texel<A>],
    size: Size,
    pyramid: &mut [Texel<A>],
) -> Option<()> {
    if size.0 <= 1 && size.1 <= 1 {
        return known(texels.first()?);
    }
    let below = coarser(size);
    let (level, rest) = pyramid.split_at_mut_checked(below.0 * below.1)?;
    push_levels(level, below, rest)?;
    push_level(texels, 0, size, level, below);
    Some(())
}

fn known<A: Arith>(texel: &Texel<A>) -> Option<()> {
    (texel.confidence != A::Confidence::default()).then_some(())
}

/// Pushes rows of a level, those from row `first` on: each fine texel sees the coarse one that
/// holds it and the three beside it on its side, weights 9, 3, 3, 1.
fn push_level<A: Arith>(
    fine: &mut [Texel<A>],
    first: usize,
    size: Size,
    coarse: &[Texel<A>],
    below: Size,
) {
    for (y, line) in (first..size.1).zip(fine.chunks_mut(size.0.max(1))) {
        let row = |y: usize| coarse.get(y * below.0..).unwrap_or_default();
        let (near, far) = (row(y / 2), row(beside(y, below.1)));
        for (x, texel) in line.iter_mut().enumerate() {
            if !A::lacks(texel.confidence) {
                continue;
            }
            let (near_x, far_x) = (x / 2, beside(x, below.0));
            let at = |row: &[Texel<A>], x: usize| row.get(x).copied().unwrap_or_default();
            let around = [
                at(near, near_x),
                at(near, far_x),
                at(far, near_x),
                at(far, far_x),
            ];
            *texel = A::push(*texel, around);
        }
    }
}

/// The coarse neighbour on the side of fine index `i`, clamped.
fn beside(i: usize, len: usize) -> usize {
    let near = i / 2;
    if i.is_multiple_of(2) {
        near.saturating_sub(1)
    } else {
        (near + 1).min(len - 1)
    }
}
