//! Scatter: every sample adds its share to the pixels of its footprint (Dayal et al. 2005 §5.2).
//!
//! Sums commute, so the picture does not depend on the order of samples. All functions work on a
//! band of pixel rows, which one thread writes, from samples that may lie beyond it.

use crate::arith::{ANCHOR_BITS, Arith, Moments, Panel, Projected, REACH, Sums};
use crate::config::Extents;
use crate::lanes::{LANES, UNROLLS};
use crate::taps::Taps;
use crate::tiles::TileMap;
use core::ops::Range;

/// Sums over 3 pixels along rows, in place.
pub fn sum_along<A: Arith>(panel: &Panel, mass: &mut [A::Mass]) {
    for line in mass.chunks_mut(usize::from(panel.width).max(1)) {
        // The value before x is overwritten by the time it is needed: keep it.
        let mut before = A::Mass::default();
        for x in 0..line.len() {
            let at = |x: usize| line.get(x).copied().unwrap_or_default();
            let own = at(x);
            let sum = A::add_mass(A::add_mass(before, own), at(x + 1));
            before = own;
            if let Some(mass) = line.get_mut(x) {
                *mass = sum;
            }
        }
    }
}

/// The filter width of each pixel of the rows `lines`, from the mass in the 3 × 3 pixels around;
/// `sums` holds all of what [`sum_along`] made.
pub fn widths<A: Arith>(
    panel: &Panel,
    lines: Range<usize>,
    sums: &[A::Mass],
    widths: &mut [A::Log],
) {
    let (width, height) = (usize::from(panel.width).max(1), usize::from(panel.height));
    for (y, widths) in lines.zip(widths.chunks_mut(width)) {
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let mut rows = rows.map(|row| sums.get(row * width..).unwrap_or_default());
        let rows: [&[A::Mass]; 3] = core::array::from_fn(|_| rows.next().unwrap_or_default());
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
    Map(&'a [A::Log]),
    /// The same for all.
    Constant(A::Log),
    /// The gradients of the tiles.
    Tiles(&'a TileMap<'a>),
    /// None: each sample counts for its pixel.
    Pixel,
}

impl<'a, A: Arith> Widths<'a, A> {
    /// What `extents` asks for, from the map that [`widths`] makes or the tiles.
    pub fn new(extents: Extents, map: &'a [A::Log], tiles: &'a TileMap<'a>) -> Self {
        match extents {
            Extents::Density => Self::Map(map),
            Extents::Constant(log) => Self::Constant(A::width(log.into())),
            Extents::Gradient => Self::Tiles(tiles),
            Extents::Pixel => Self::Pixel,
        }
    }

    /// The widths of a sample, in x and y; `None` where it counts for its pixel alone.
    #[inline]
    pub fn of(&self, panel: &Panel, at: &Projected<A>) -> Option<[A::Log; 2]> {
        Some(match self {
            Widths::Map(map) => {
                let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
                // Not `A::nearest`, which takes fewer instructions but longer: the width says how
                // many pixels follow, which no processor foresees.
                let nearest = panel.nearest(x, y);
                [map.get(nearest).copied().unwrap_or_default(); 2]
            }
            Widths::Constant(width) => [*width; 2],
            Widths::Tiles(map) => gradient_widths(map, panel, at),
            Widths::Pixel => return None,
        })
    }
}

/// The widths that the gradients at a sample's place ask for.
#[inline(never)]
fn gradient_widths<A: Arith>(map: &TileMap<'_>, panel: &Panel, at: &Projected<A>) -> [A::Log; 2] {
    let (_, wide, high) = A::extents(map, panel, at.x, at.y);
    [wide, high]
}

/// What samples are scattered with.
#[derive(Clone, Copy, Debug)]
pub struct Filter<'a, A: Arith> {
    /// The panel; its own, which no sum that is written can change.
    pub panel: Panel,
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

    /// A sample's light.
    #[inline]
    fn light_of(&self, rgb: [u8; 3]) -> [A::Light; 3] {
        rgb.map(|code| A::light(self.light[usize::from(code)]))
    }

    /// Adds one sample to its own pixel, if that is one of the band.
    #[inline]
    fn own(&self, at: &Projected<A>, target: &mut Target<'_, A>) {
        let panel = &self.panel;
        let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
        let first = target.lines.start * usize::from(panel.width);
        let Some(own) = panel.inside(x, y).and_then(|own| own.checked_sub(first)) else {
            return;
        };
        let anchor = (x >> ANCHOR_BITS, y >> ANCHOR_BITS);
        let features = A::features(panel, self.light_of(at.rgb), (at.x, at.y), anchor);
        let weight = A::factor(at.weight);
        if let Some(sums) = target.sums.get_mut(own) {
            A::add(sums, weight, &features);
        }
        if let Some(moments) = target.moments.get_mut(own) {
            A::add_moments(moments, weight, &features);
        }
    }

    /// Adds one sample's share to the pixels of its footprint.
    #[inline]
    fn splat<const PLANES: bool>(&self, at: &Projected<A>, target: &mut Target<'_, A>) {
        if !A::counts(at.weight) {
            return;
        }
        let panel = &self.panel;
        let (x, y) = (A::pixel(panel, at.x), A::pixel(panel, at.y));
        let band = target.lines.start as i32..target.lines.end as i32;
        if y + REACH < band.start || y - REACH >= band.end {
            return;
        }
        let Some([wide, high]) = self.widths.of(panel, at) else {
            return self.own(at, target);
        };
        let down = A::taps(panel, high, at.y);
        let across = A::taps(panel, wide, at.x);
        let footprint = Footprint {
            at,
            pixel: (x, y),
            light: self.light_of(at.rgb),
            down: &down,
            across: &across,
        };
        let rows = y + footprint.down.first..y + footprint.down.last + 1;
        let columns = x + footprint.across.first..x + footprint.across.last + 1;
        // Places count from the anchor of a square.
        let bits = if PLANES { ANCHOR_BITS } else { WHOLE_BITS };
        let whole = rows.start >= band.start
            && rows.end <= band.end
            && columns.start >= 0
            && columns.end <= i32::from(panel.width)
            && is_part(&rows, bits)
            && is_part(&columns, bits);
        if whole {
            footprint.add::<PLANES>(panel, rows, columns, target);
        } else {
            footprint.add_parts::<PLANES>(panel, rows, columns, target);
        }
    }
}

/// The pixels that a sample adds to, and what.
struct Footprint<'a, A: Arith> {
    at: &'a Projected<A>,
    /// The sample's own.
    pixel: (i32, i32),
    light: [A::Light; 3],
    down: &'a Taps<A::Weight>,
    across: &'a Taps<A::Weight>,
}

impl<A: Arith> Footprint<'_, A> {
    /// Adds the sample's share to pixels of the band that lie in one square, at most [`LANES`] each
    /// way.
    #[inline(always)]
    fn add<const PLANES: bool>(
        &self,
        panel: &Panel,
        rows: Range<i32>,
        columns: Range<i32>,
        target: &mut Target<'_, A>,
    ) {
        let width = usize::from(panel.width);
        let (x, y) = self.pixel;
        let anchor = (columns.start >> ANCHOR_BITS, rows.start >> ANCHOR_BITS);
        let (Some(down), Some(across)) = (
            self.down.from(rows.start - y),
            self.across.from(columns.start - x),
        ) else {
            return;
        };
        let share = Share {
            weight: self.at.weight,
            across,
            features: A::features(panel, self.light, (self.at.x, self.at.y), anchor),
        };
        let line = (rows.start - target.lines.start as i32) as usize * width;
        let first = line + columns.start as usize;
        let rows = rows.len();
        // Loops over so few end in a branch that no processor foresees: where code is cheap, there
        // is one without a loop for each number of columns.
        match columns.len() {
            columns if !UNROLLS => {
                let down = down.get(..rows).unwrap_or_default();
                share.add_some::<PLANES>(down, first, width, columns, target);
            }
            1 => share.add::<1, PLANES>((down, rows), first, width, target),
            2 => share.add::<2, PLANES>((down, rows), first, width, target),
            3 => share.add::<3, PLANES>((down, rows), first, width, target),
            4 => share.add::<4, PLANES>((down, rows), first, width, target),
            5 => share.add::<5, PLANES>((down, rows), first, width, target),
            6 => share.add::<6, PLANES>((down, rows), first, width, target),
            7 => share.add::<7, PLANES>((down, rows), first, width, target),
            _ => share.add::<LANES, PLANES>((down, rows), first, width, target),
        }
    }

    /// The same for any pixels: those of the band, square by square. Seldom called.
    #[inline(never)]
    fn add_parts<const PLANES: bool>(
        &self,
        panel: &Panel,
        rows: Range<i32>,
        columns: Range<i32>,
        target: &mut Target<'_, A>,
    ) {
        let bits = if PLANES { ANCHOR_BITS } else { WHOLE_BITS };
        let (start, end) = (target.lines.start as i32, target.lines.end as i32);
        let rows = rows.start.max(start)..rows.end.min(end);
        let columns = columns.start.max(0)..columns.end.min(i32::from(panel.width));
        let mut top = rows.start;
        while top < rows.end {
            let bottom = part_end(top, rows.end, bits);
            let mut left = columns.start;
            while left < columns.end {
                let right = part_end(left, columns.end, bits);
                self.add::<PLANES>(panel, top..bottom, left..right, target);
                left = right;
            }
            top = bottom;
        }
    }
}

/// What a sample adds to pixels of one square.
struct Share<'a, A: Arith> {
    weight: A::Weight,
    /// Taps from the first column on.
    across: &'a [A::Weight; LANES],
    features: A::Features,
}

impl<A: Arith> Share<'_, A> {
    /// Adds it to `COLUMNS` pixels of each of so many rows, with the taps `down`, from pixel
    /// `first` on, rows being `width` apart.
    #[inline]
    fn add<const COLUMNS: usize, const PLANES: bool>(
        &self,
        (down, rows): (&[A::Weight; LANES], usize),
        mut first: usize,
        width: usize,
        target: &mut Target<'_, A>,
    ) {
        let along = A::along(self.across);
        let weights = A::rows(self.weight, down);
        for row in weights.get(..rows).unwrap_or_default() {
            let weights = A::factors(*row, &along);
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
            first += width;
        }
    }

    /// The same to any number of pixels, at most [`LANES`], of a row.
    #[inline]
    fn add_some<const PLANES: bool>(
        &self,
        down: &[A::Weight],
        mut first: usize,
        width: usize,
        columns: usize,
        target: &mut Target<'_, A>,
    ) {
        for tap in down {
            let weight = A::times(self.weight, *tap);
            let weights = self.across.iter().map(|tap| A::times(weight, *tap));
            let pixels = first..first + columns;
            let sums = target.sums.get_mut(pixels.clone()).unwrap_or_default();
            if PLANES {
                let moments = target.moments.get_mut(pixels).unwrap_or_default();
                for ((sums, moments), weight) in sums.iter_mut().zip(moments).zip(weights) {
                    A::add(sums, A::factor(weight), &self.features);
                    A::add_moments(moments, A::factor(weight), &self.features);
                }
            } else {
                for (sums, weight) in sums.iter_mut().zip(weights) {
                    A::add(sums, A::factor(weight), &self.features);
                }
            }
            first += width;
        }
    }
}

/// `N` entries from `first` on.
#[inline]
fn chunk<T, const N: usize>(of: &mut [T], first: usize) -> Option<&mut [T; N]> {
    of.get_mut(first..)?.first_chunk_mut()
}

/// Whether pixels lie in one square of 2^`bits` pixels and are no more than [`LANES`].
#[inline]
fn is_part(pixels: &Range<i32>, bits: u32) -> bool {
    pixels.end - pixels.start <= LANES as i32 && pixels.start >> bits == (pixels.end - 1) >> bits
}

/// Where the part of `start..end` ends that lies in one square of 2^`bits` pixels and is no longer
/// than [`LANES`].
#[inline]
fn part_end(start: i32, end: i32, bits: u32) -> i32 {
    end.min(((start >> bits) + 1) << bits)
        .min(start + LANES as i32)
}
