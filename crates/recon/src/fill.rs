//! Hole filling by a pull-push pyramid: where few samples reached a pixel, coarser levels speak.
//!
//! Pulling makes each coarser texel the confidence-weighted mean of four finer ones; pushing
//! gives each finer texel what it lacks in confidence from the filled coarser level.

use crate::arith::{Arith, Texel};

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

/// Fills `texels` (row by row, `width` × `height`) by way of `pyramid`. Says whether anything was
/// known at all; if not, all texels keep a confidence of zero.
pub fn fill<A: Arith>(
    width: usize,
    height: usize,
    texels: &mut [Texel<A>],
    pyramid: &mut [Texel<A>],
) -> bool {
    pull_level(texels, (width, height), pyramid);
    let top = push_levels(texels, (width, height), pyramid);
    top.is_some()
}

/// Pulls one level into the start of `pyramid`, then the rest from there.
fn pull_level<A: Arith>(fine: &[Texel<A>], size: Size, pyramid: &mut [Texel<A>]) {
    let mut size = size;
    let (mut rest, mut first) = (pyramid, true);
    let mut source: &[Texel<A>] = fine;
    while size.0 > 1 || size.1 > 1 {
        let below = coarser(size);
        let Some((level, tail)) = rest.split_at_mut_checked(below.0 * below.1) else {
            return;
        };
        let finer = if first { fine } else { source };
        for (y, line) in level.chunks_mut(below.0.max(1)).enumerate() {
            for (x, texel) in line.iter_mut().enumerate() {
                let at = |dx: usize, dy: usize| {
                    let (x, y) = (2 * x + dx, 2 * y + dy);
                    let inside = x < size.0 && y < size.1;
                    let texel = finer.get(y * size.0 + x).filter(|_| inside);
                    texel.copied().unwrap_or_default()
                };
                *texel = A::pull([at(0, 0), at(1, 0), at(0, 1), at(1, 1)]);
            }
        }
        first = false;
        source = level;
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
    push_level(texels, size, level, below);
    Some(())
}

fn known<A: Arith>(texel: &Texel<A>) -> Option<()> {
    (texel.confidence != A::Confidence::default()).then_some(())
}

/// Pushes one level: each fine texel sees the coarse one that holds it and the three beside it on
/// its side, weights 9, 3, 3, 1.
fn push_level<A: Arith>(fine: &mut [Texel<A>], size: Size, coarse: &[Texel<A>], below: Size) {
    for (y, line) in fine.chunks_mut(size.0.max(1)).enumerate().take(size.1) {
        let near_y = y / 2;
        let far_y = beside(y, below.1);
        for (x, texel) in line.iter_mut().enumerate() {
            let (near_x, far_x) = (x / 2, beside(x, below.0));
            let at = |x: usize, y: usize| coarse.get(y * below.0 + x).copied().unwrap_or_default();
            let around = [
                at(near_x, near_y),
                at(far_x, near_y),
                at(near_x, far_y),
                at(far_x, far_y),
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
