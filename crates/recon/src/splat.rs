//! Scatter: every sample adds its share to the pixels of its footprint (Dayal et al. 2005 §5.2).
//!
//! Sums commute, so the picture does not depend on the order of samples. All functions work on a
//! band of pixel rows, which one thread writes, from samples that may lie beyond it.

use crate::arith::{ANCHOR_BITS, Arith, Moments, Panel, Projected, REACH, Sums};
use crate::config::Extents;
use crate::lanes::LANES;
use crate::tiles::TileMap;
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

/// log2 of a side that no panel reaches: all pixels lie in one square.
const WHOLE_BITS: u32 = 16;

/// Where a sample's filter widths come from.
#[derive(Clone, Copy, Debug)]
pub enum Widths<'a, A: Arith> {
    /// The map of all pixels.
    Map(&'a [A::Width]),
    /// The same for all.
    Constant(A::Width),
    /// The gradients of the tiles.
    Tiles(&'a TileMap<'a>),
}

impl<'a, A: Arith> Widths<'a, A> {
    /// What `extents` asks for, from the map that [`widths`] makes or the tiles.
    pub fn new(extents: Extents, map: &'a [A::Width], tiles: &'a TileMap<'a>) -> Self {
        match extents {
            Extents::Density => Self::Map(map),
            Extents::Constant(log) => Self::Constant(A::width(log.into())),
            Extents::Gradient => Self::Tiles(tiles),
        }
    }

    /// The widths of a sample, in x and y.
    #[inline]
    pub fn of(&self, panel: &Panel, at: &Projected<A>) -> [A::Width; 2] {
        match self {
            Widths::Map(map) => {
                let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
                [map.get(panel.nearest(x, y)).copied().unwrap_or_default(); 2]
            }
            Widths::Constant(width) => [*width; 2],
            Widths::Tiles(map) => {
                let (_, wide, high) = A::extents(map, panel, at.x, at.y);
                [wide, high]
            }
        }
    }
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
        let [wide, high] = self.widths.of(panel, at);
        let down = A::taps(panel, high, at.y);
        let across = A::taps(panel, wide, at.x);
        let rows = (y + down.first).max(band.start)..(y + down.last + 1).min(band.end);
        let columns = (x + across.first).max(0)..(x + across.last + 1).min(i32::from(panel.width));
        let light = |c: usize| A::light(self.light[usize::from(at.rgb[c])]);
        let light = [light(0), light(1), light(2)];
        // Places count from the anchor of a square; a footprint seldom lies in more than one.
        let bits = if PLANES { ANCHOR_BITS } else { WHOLE_BITS };
        let mut top = rows.start;
        while top < rows.end {
            let bottom = part_end(top, rows.end, bits);
            let mut left = columns.start;
            while left < columns.end {
                let right = part_end(left, columns.end, bits);
                let anchor = (left >> ANCHOR_BITS, top >> ANCHOR_BITS);
                let share = Share {
                    weight: at.weight,
                    down: down.from(top - y),
                    across: across.from(left - x),
                    features: A::features(panel, light, (at.x, at.y), anchor),
                };
                let line = (top - band.start) as usize * usize::from(panel.width);
                let place = Place {
                    first: line + left as usize,
                    rows: (bottom - top) as usize,
                    stride: usize::from(panel.width),
                };
                match right - left {
                    1 => share.add::<1, PLANES>(&place, target),
                    2 => share.add::<2, PLANES>(&place, target),
                    3 => share.add::<3, PLANES>(&place, target),
                    4 => share.add::<4, PLANES>(&place, target),
                    5 => share.add::<5, PLANES>(&place, target),
                    6 => share.add::<6, PLANES>(&place, target),
                    7 => share.add::<7, PLANES>(&place, target),
                    _ => share.add::<LANES, PLANES>(&place, target),
                }
                left = right;
            }
            top = bottom;
        }
    }
}

/// Pixels of a band: some rows, as many columns as a [`Share::add`] is made for.
struct Place {
    /// Index of the first.
    first: usize,
    rows: usize,
    /// Pixels between rows.
    stride: usize,
}

/// What a sample adds to pixels of one square.
struct Share<A: Arith> {
    weight: A::Weight,
    /// Taps from the first row on.
    down: [A::Weight; LANES],
    /// Taps from the first column on.
    across: [A::Weight; LANES],
    features: A::Features,
}

impl<A: Arith> Share<A> {
    /// Adds it to `COLUMNS` pixels of each row: a number that the compiler knows, since a loop
    /// over so few ends in a branch that no processor foresees.
    #[inline]
    fn add<const COLUMNS: usize, const PLANES: bool>(
        &self,
        place: &Place,
        target: &mut Target<'_, A>,
    ) {
        for (row, tap) in self.down.iter().enumerate().take(place.rows) {
            let weights = A::factors(A::times(self.weight, *tap), &self.across);
            let first = place.first + row * place.stride;
            if let Some(sums) = chunk::<_, COLUMNS>(target.sums, first) {
                for (sums, weight) in sums.iter_mut().zip(weights) {
                    A::add(sums, weight, &self.features);
                }
            }
            if PLANES && let Some(moments) = chunk::<_, COLUMNS>(target.moments, first) {
                for (moments, weight) in moments.iter_mut().zip(weights) {
                    A::add_moments(moments, weight, &self.features);
                }
            }
        }
    }
}

/// `N` entries from `first` on.
#[inline]
fn chunk<T, const N: usize>(of: &mut [T], first: usize) -> Option<&mut [T; N]> {
    of.get_mut(first..)?.first_chunk_mut()
}

/// Where the part of `start..end` ends that lies in one square of 2^`bits` pixels and is no longer
/// than [`LANES`].
#[inline]
fn part_end(start: i32, end: i32, bits: u32) -> i32 {
    end.min(((start >> bits) + 1) << bits)
        .min(start + LANES as i32)
}
