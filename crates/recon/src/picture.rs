//! The stages of a refresh, each shared out among the workers.

use crate::arith::{Arith, Sums};
use crate::bins::{self, Grid, Runs};
use crate::config::{Extents, Lifetime};
use crate::display::Display;
use crate::hidden::Minima;
use crate::motion::Reach;
use crate::project::Instant;
use crate::splat::{Filter, Target, Widths};
use crate::workers::{MAX_PARTS, Parts, Workers, take};
use crate::{hidden, own, solve, splat};
use core::hint::select_unpredictable;
use core::ops::Range;
use unframed_wire::Tick;

/// Stretches of the ring a worker.
const STRETCHES: usize = 2;

/// A band of the picture: rows of tiles and their pixel rows.
#[derive(Clone, Debug)]
struct Band {
    rows: Range<usize>,
    lines: Range<usize>,
}

impl Band {
    /// The rows of tiles whose samples can reach the band.
    fn reached_from(&self) -> Range<usize> {
        self.rows.start.saturating_sub(1)..self.rows.end + 1
    }
}

impl<A: Arith, W: Workers> Display<'_, A, W> {
    /// From stored samples to a texel a pixel.
    pub(crate) fn filter(&mut self, now: Tick, reach: &Reach<A>) {
        let (panel, config, workers) = (self.panel, self.config, &self.workers);
        let width = usize::from(panel.width);
        let sorts = !self.sorted.is_empty();
        let grid = if sorts {
            Grid::new(panel.width, panel.height)
        } else {
            Grid::whole(panel.width, panel.height)
        };
        let entries = (grid.tiles() + 1).max(1);
        let parts = if sorts { workers.parts() } else { 1 };
        let parts = parts.clamp(1, MAX_PARTS);
        // Workers project and sort stretches of the ring, more than there are workers: fewer
        // samples count the older they are.
        let rooms = self.starts.len() / entries;
        let stretches = if parts > 1 { STRETCHES * parts } else { 1 };
        let stretches = stretches.min(rooms).clamp(1, MAX_PARTS);
        let lifetimes = if config.lifetime == Lifetime::Tiles {
            let lines = usize::from(panel.height).div_ceil(parts).max(1);
            let work = self.logs.chunks_mut((lines * width).max(1)).enumerate();
            Parts::new(work).each(workers, |(part, logs)| {
                for (row, logs) in (*part * lines..).zip(logs.chunks_mut(width.max(1))) {
                    A::lifetimes(&self.tiles, &panel, row, logs);
                }
            });
            &*self.logs
        } else {
            &[]
        };
        let instant = Instant {
            config,
            panel,
            tiles: &self.tiles,
            slots: self.slots,
            lifetimes,
            lights: &self.lights,
            now,
        };
        let stored = self.deep.samples_mut();
        if !sorts && own::applies(&config) {
            self.sums.fill(Sums::<A>::default());
            own::add(&instant, config.light.table(), stored, self.sums);
            solve::means::<A>(self.sums, self.texels);
            return;
        }
        let stride = stored.len().div_ceil(stretches).max(1);
        let starts = self.starts.get_mut(..stretches * entries);
        let starts = starts.unwrap_or(&mut []);
        starts.fill(0);
        let mut sorted = &mut *self.sorted;
        let work = stored
            .chunks_mut(stride)
            .zip(self.projected.chunks_mut(stride))
            .zip(starts.chunks_exact_mut(entries))
            .map(|((samples, projected), starts)| {
                (samples, projected, take(&mut sorted, stride), starts)
            });
        Parts::new(work).each(workers, |(samples, projected, sorted, starts)| {
            let len = instant.project(&grid, samples, projected, starts);
            let seen = projected.get(..len).unwrap_or(&[]);
            if !sorted.is_empty() {
                bins::place(&grid, &panel, seen, starts, sorted);
            }
        });
        let samples = if sorts {
            &mut *self.sorted
        } else {
            &mut *self.projected
        };
        let mut runs = Runs {
            grid,
            stride,
            samples,
            starts,
        };

        // From here on each works on a band of the picture.
        let pieces = runs.pieces(parts);
        let bands: [Option<Band>; MAX_PARTS] = core::array::from_fn(|i| {
            let rows = pieces.get(i)?.clone()?;
            let lines = grid.lines(&rows, &panel);
            Some(Band { rows, lines })
        });
        let bands = || bands.iter().flatten();
        let pixels = |band: &Band| band.lines.len() * width;

        if config.hidden {
            let mut minima = Minima::of(&panel, self.minima);
            let mut movers = &mut *self.movers;
            let work = bands().map(|band| {
                let minima = minima.take(&panel, band.lines.len());
                (band, minima, take(&mut movers, pixels(band)))
            });
            Parts::new(work).each(workers, |(band, minima, movers)| {
                let (samples, top) = (runs.rows(band.reached_from()), band.lines.start);
                hidden::survey(&panel, samples, top, minima.nearest, movers);
                hidden::coarsen::<A>(&panel, minima);
            });
            let minima = &*self.minima;
            let mut limits = &mut *self.limits;
            let work = bands().map(|band| (band.lines.start, take(&mut limits, pixels(band))));
            Parts::new(work).each(workers, |(top, limits)| {
                hidden::limits::<A>(&panel, minima, *top, limits);
            });
        }
        if config.hidden || config.extents == Extents::Density {
            let mut mass = &mut *self.mass;
            let (limits, movers) = (&*self.limits, &*self.movers);
            let work = bands()
                .zip(runs.split(&pieces))
                .map(|(band, samples)| (band.lines.start, samples, take(&mut mass, pixels(band))));
            Parts::new(work).each(workers, |(top, samples, mass)| {
                mass.fill(A::Mass::default());
                let first = *top * width;
                for sample in samples.iter_mut().flat_map(|samples| samples.iter_mut()) {
                    let pixel = A::nearest(&panel, sample.x, sample.y).index(panel.width);
                    let hidden =
                        config.hidden && hidden::hides(reach, limits, movers, pixel, sample);
                    // Stored either way: which samples are hidden no processor foresees.
                    sample.weight =
                        select_unpredictable(hidden, A::Weight::default(), sample.weight);
                    if let Some(mass) = pixel.checked_sub(first).and_then(|own| mass.get_mut(own)) {
                        A::gather(mass, sample.weight);
                    }
                }
                splat::sum_along::<A>(&panel, mass);
            });
        }
        if config.extents == Extents::Density {
            let mut widths = &mut *self.logs;
            let mass = &*self.mass;
            let work = bands().map(|band| (band.lines.clone(), take(&mut widths, pixels(band))));
            Parts::new(work).each(workers, |(lines, widths)| {
                splat::widths::<A>(&panel, lines.clone(), mass, widths);
            });
        }

        let filter = Filter {
            panel,
            widths: Widths::new(config.extents, self.logs, &self.tiles),
            light: config.light.table(),
        };
        let planes = config.planes();
        let (mut sums, mut moments) = (&mut *self.sums, &mut *self.moments);
        let mut texels = &mut *self.texels;
        let work = bands().map(|band| {
            let len = pixels(band);
            let target = Target {
                lines: band.lines.clone(),
                sums: take(&mut sums, len),
                moments: take(&mut moments, if planes { len } else { 0 }),
            };
            (band, target, take(&mut texels, len))
        });
        Parts::new(work).each(workers, |(band, target, texels)| {
            filter.scatter(runs.rows(band.reached_from()), target);
            if planes {
                let (sums, moments) = (&*target.sums, &*target.moments);
                solve::planes(width, band.lines.start, sums, moments, texels);
            } else {
                solve::means::<A>(target.sums, texels);
            }
        });
    }
}
