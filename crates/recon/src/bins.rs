//! Samples in runs sorted by tile: what lies close on the screen lies close in memory, and rows of
//! tiles are work that threads can share.

use crate::arith::{Arith, Panel, Projected};
use crate::lanes::Pixel;
use crate::workers::{MAX_PARTS, take};
use core::ops::Range;

/// log2 of the side of a tile, pixels.
pub const TILE_BITS: u32 = 5;

/// The tiles of a panel; samples in the guard band belong to the nearest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    bits: u32,
    columns: usize,
    /// Rows of tiles.
    pub rows: usize,
}

impl Grid {
    /// Tiles of 2^[`TILE_BITS`] pixels.
    #[must_use]
    pub const fn new(width: u16, height: u16) -> Self {
        Self::of(width, height, TILE_BITS)
    }

    /// All in one tile: nothing to sort.
    #[must_use]
    pub const fn whole(width: u16, height: u16) -> Self {
        Self::of(width, height, 16)
    }

    const fn of(width: u16, height: u16, bits: u32) -> Self {
        Self {
            bits,
            columns: (width as usize).div_ceil(1 << bits),
            rows: (height as usize).div_ceil(1 << bits),
        }
    }

    /// Number of tiles.
    #[must_use]
    pub const fn tiles(&self) -> usize {
        self.columns * self.rows
    }

    /// The tile of a pixel.
    #[inline]
    #[must_use]
    pub fn tile(&self, pixel: Pixel) -> usize {
        pixel.coarser(self.bits).index(self.columns as u16)
    }

    /// The pixel rows of rows of tiles.
    #[must_use]
    pub fn lines(&self, rows: &Range<usize>, panel: &Panel) -> Range<usize> {
        let line = |row: usize| (row << self.bits).min(usize::from(panel.height));
        line(rows.start)..line(rows.end)
    }
}

/// Turns numbers of samples a tile, each one entry after its tile's, into where tiles start.
pub fn sum(starts: &mut [u32]) {
    let mut sum = 0;
    for start in starts {
        sum += *start;
        *start = sum;
    }
}

/// Sorts samples by tile, stably, into `sorted`; `starts` is that of [`sum`] before and after.
pub fn place<A: Arith>(
    grid: &Grid,
    panel: &Panel,
    samples: &[Projected<A>],
    starts: &mut [u32],
    sorted: &mut [Projected<A>],
) {
    for sample in samples {
        if let Some(next) = starts.get_mut(grid.tile(A::nearest(panel, sample.x, sample.y))) {
            if let Some(place) = sorted.get_mut(*next as usize) {
                *place = *sample;
            }
            *next += 1;
        }
    }
    // Each start has moved to the next one's place: move them back.
    let mut before = 0;
    for start in starts {
        before = core::mem::replace(start, before);
    }
}

/// Projected samples in runs, each run sorted by tile.
#[derive(Debug)]
pub struct Runs<'a, A: Arith> {
    /// The tiles.
    pub grid: Grid,
    /// Entries that each run may take; the runs lie behind each other.
    pub stride: usize,
    /// The samples; a run that is shorter than `stride` leaves a gap.
    pub samples: &'a mut [Projected<A>],
    /// The starts of each run's tiles, run behind run, one entry more than tiles each.
    pub starts: &'a [u32],
}

impl<'a, A: Arith> Runs<'a, A> {
    fn runs(&self) -> usize {
        self.starts.len() / (self.grid.tiles() + 1)
    }

    /// Where run `run` keeps the samples of tiles.
    fn range(&self, run: usize, tiles: &Range<usize>) -> Range<usize> {
        let first = run * (self.grid.tiles() + 1);
        let start = |tile: usize| self.starts.get(first + tile).map_or(0, |s| *s as usize);
        run * self.stride + start(tiles.start)..run * self.stride + start(tiles.end)
    }

    /// The tiles of rows of tiles, those beyond the grid left out.
    fn tiles(&self, rows: &Range<usize>) -> Range<usize> {
        let first = |row: usize| row.min(self.grid.rows) * self.grid.columns;
        first(rows.start)..first(rows.end)
    }

    /// The samples of rows of tiles, tile by tile.
    pub fn rows(&self, rows: Range<usize>) -> impl Iterator<Item = &[Projected<A>]> {
        self.tiles(&rows)
            .flat_map(move |tile| (0..self.runs()).map(move |run| (run, tile)))
            .map(move |(run, tile)| {
                let range = self.range(run, &(tile..tile + 1));
                self.samples.get(range).unwrap_or(&[])
            })
    }

    /// Rows of tiles in about `parts` pieces of equal numbers of samples, none empty.
    #[must_use]
    pub fn pieces(&self, parts: usize) -> [Option<Range<usize>>; MAX_PARTS] {
        let count = |rows: Range<usize>| -> usize {
            let tiles = self.tiles(&rows);
            (0..self.runs())
                .map(|run| self.range(run, &tiles).len())
                .sum()
        };
        let rows = self.grid.rows;
        let all = count(0..rows).max(1);
        let mut end = 0;
        core::array::from_fn(|part| {
            let first = end;
            if part >= parts || first == rows {
                return None;
            }
            // As many rows as come closest to this part's share of all.
            let share = |end: usize| (count(0..end) * parts).abs_diff(all * (part + 1));
            end = if part + 1 == parts {
                rows
            } else {
                (first + 1..=rows)
                    .min_by_key(|end| share(*end))
                    .unwrap_or(rows)
            };
            Some(first..end)
        })
    }

    /// The samples of each piece, to be changed: for each piece its part of each run.
    pub fn split(
        &mut self,
        pieces: &[Option<Range<usize>>; MAX_PARTS],
    ) -> [[&mut [Projected<A>]; MAX_PARTS]; MAX_PARTS] {
        let (runs, tiles, starts) = (self.runs(), self.grid.tiles() + 1, self.starts);
        let columns = self.grid.columns;
        let mut split: [[&mut [Projected<A>]; MAX_PARTS]; MAX_PARTS] = Default::default();
        let mut rest: &mut [Projected<A>] = self.samples;
        for run in 0..runs.min(MAX_PARTS) {
            let mut samples = take(&mut rest, self.stride);
            let mut at = 0;
            for (parts, rows) in split.iter_mut().zip(pieces.iter().flatten()) {
                let end = starts.get(run * tiles + rows.end * columns);
                let end = end.map_or(at, |end| *end as usize);
                if let Some(part) = parts.get_mut(run) {
                    *part = take(&mut samples, end.saturating_sub(at));
                }
                at = end;
            }
        }
        split
    }
}
