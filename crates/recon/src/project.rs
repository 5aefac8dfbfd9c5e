//! First step of a refresh: every stored sample moved to the instant and weighed by its age.

use crate::arith::{Arith, Panel, Projected};
use crate::bins::{self, Grid};
use crate::config::{Config, Extents, Lifetime};
use crate::deep::{Placing, Stored, age, slot};
use crate::memory::Slot;
use crate::motion::Reach;
use crate::tiles::TileMap;
use unframed_wire::Tick;

/// What a refresh knows of its instant.
#[derive(Debug)]
pub struct Instant<'a, A: Arith> {
    /// What is to be done.
    pub config: &'a Config,
    /// The panel.
    pub panel: &'a Panel,
    /// Lifetimes and gradients.
    pub tiles: &'a TileMap<'a>,
    /// The transforms of all objects.
    pub slots: &'a [Slot<A>],
    /// How far occlusion can reach.
    pub reach: &'a Reach<A>,
    /// The time.
    pub now: Tick,
}

/// What follows from a sample's time.
#[derive(Clone, Copy)]
pub(crate) struct Age<A: Arith> {
    log: A::Log,
    /// [`Reach::of`] resting and moving samples.
    reach: [A::Depth; 2],
}

/// Where a sample is seen now: place and depth; `None` where it is out of sight.
#[inline]
pub fn locate<A: Arith>(
    panel: &Panel,
    slots: &[Slot<A>],
    sample: &Stored,
) -> Option<(A::Coord, A::Coord, A::Depth)> {
    match sample.placing {
        Placing::Empty => None,
        Placing::Screen => {
            let [x, y, _] = sample.place.map(|v| A::from_sixteenths(panel, v as u16));
            Some((x, y, A::Depth::default()))
        }
        Placing::Lattice => {
            let slot = slots.get(usize::from(sample.slot))?;
            A::project(slot.transform.as_ref()?, panel, sample.place)
        }
    }
}

impl<A: Arith> Instant<'_, A> {
    /// Moves samples to the instant; those in sight go to the front of `projected`, in their
    /// order, and are counted by tile: `starts` becomes where each tile's begin (see
    /// [`bins::sum`]). Returns their number. Samples too old to be told from young ones are
    /// emptied.
    pub fn project(
        &self,
        grid: &Grid,
        samples: &mut [Stored],
        projected: &mut [Projected<A>],
        starts: &mut [u32],
    ) -> usize {
        starts.fill(0);
        let mut len = 0;
        // Samples of a packet share their time.
        let (mut time, mut known) = (None, None);
        for sample in samples {
            if time != Some(sample.time) {
                time = Some(sample.time);
                known = self.age(sample.time);
            }
            let Some(age) = &known else {
                sample.placing = Placing::Empty;
                continue;
            };
            if let Some(seen) = self.see(sample, age)
                && A::counts(seen.weight)
                && let Some(place) = projected.get_mut(len)
            {
                if let Some(count) = starts.get_mut(grid.tile(self.panel, &seen) + 1) {
                    *count += 1;
                }
                *place = seen;
                len += 1;
            }
        }
        bins::sum(starts);
        len
    }

    /// `None` where it is too old to be told from a young one.
    pub(crate) fn age(&self, time: u32) -> Option<Age<A>> {
        let age = age(time, self.now)?;
        Some(Age {
            log: A::log_of_age(age),
            reach: [self.reach.of(age, false), self.reach.of(age, true)],
        })
    }

    /// One sample of an age as it is seen now; `None` where it is out of sight.
    #[inline]
    pub(crate) fn see(&self, sample: &Stored, age: &Age<A>) -> Option<Projected<A>> {
        let (config, panel) = (self.config, self.panel);
        let (x, y, depth) = locate(panel, self.slots, sample)?;
        let (mut lifetime, mut widths) = (A::Log::default(), [A::Width::default(); 2]);
        if config.extents == Extents::Gradient || config.lifetime == Lifetime::Gradient {
            let (et, wx, wy) = A::extents(self.tiles, panel, x, y);
            (lifetime, widths) = (et, [wx, wy]);
        }
        match config.lifetime {
            Lifetime::Constant(log) => lifetime = A::log(log),
            Lifetime::Tiles => lifetime = A::lifetime(self.tiles, panel, x, y),
            Lifetime::Gradient => {}
        }
        if let Extents::Constant(log) = config.extents {
            widths = [A::width(log.into()); 2];
        }
        // A sample of a moving object may itself have moved behind something.
        let moves = sample.slot > slot(0);
        Some(Projected {
            x,
            y,
            depth,
            weight: A::decline(config.kernel, age.log, lifetime),
            widths,
            reach: [age.reach[usize::from(moves)], age.reach[1]],
            rgb: sample.rgb,
            moves,
        })
    }
}
