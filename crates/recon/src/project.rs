//! First step of a refresh: every stored sample moved to the instant and weighed by its age.

use crate::arith::{Arith, Panel, Projected};
use crate::bins::{self, Grid};
use crate::config::{Config, Lifetime};
use crate::deep::{Placing, Stored, age, slot};
use crate::extents;
use crate::lanes::{Pixel, UNROLLS};
use crate::light::Lights;
use crate::memory::Slot;
use crate::motion::Past;
use crate::tiles::TileMap;
use crate::workers::take;
use unframed_wire::Tick;

/// What a refresh knows of its instant.
#[derive(Debug)]
pub struct Instant<'a, A: Arith> {
    /// What is to be done.
    pub config: Config,
    /// The panel; its own, which nothing that is written can change.
    pub panel: Panel,
    /// Lifetimes and gradients.
    pub tiles: &'a TileMap<'a>,
    /// The transforms of all objects.
    pub slots: &'a [Slot<A>],
    /// Those in the middles of all pixels, where tiles give them; empty to have them found one by
    /// one.
    pub lifetimes: &'a [A::Log],
    /// Lamps.
    pub lights: &'a Lights<'a>,
    /// The time.
    pub now: Tick,
}

/// What follows from a sample's time.
#[derive(Clone, Copy)]
pub(crate) struct Age<A: Arith> {
    pub(crate) log: A::Log,
    past: Past,
}

/// Samples whose places are found before any is weighed: loops that do one thing each, over what
/// the processor keeps close.
const BLOCK: usize = 16;

/// Where a sample is seen now: place and depth; `None` where it is out of sight.
#[inline(always)]
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

/// Where a sample of a block is seen: x, y, depth; its index.
type Seen<A> = (
    <A as Arith>::Coord,
    <A as Arith>::Coord,
    <A as Arith>::Depth,
    usize,
);

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
        self.each(samples, |seen, pixel| {
            // Written whether it counts or not: half a chance is more than a branch that is not
            // foreseen costs.
            let counts = A::counts(seen.weight);
            if let Some(place) = projected.get_mut(len) {
                *place = seen;
                len += usize::from(counts);
            }
            if let Some(count) = starts.get_mut(grid.tile(pixel) + 1) {
                *count += u32::from(counts);
            }
        });
        bins::sum(starts);
        len
    }

    /// Moves samples to the instant and hands over those in sight, in their order, each with the
    /// pixel that is nearest. Samples too old to be told from young ones are emptied.
    #[inline]
    fn each(&self, samples: &mut [Stored], sink: impl FnMut(Projected<A>, Pixel)) {
        if UNROLLS {
            self.each_in_blocks(samples, sink);
        } else {
            self.each_alone(samples, sink);
        }
    }

    /// One after the other: for processors that do one thing at a time.
    #[inline]
    fn each_alone(&self, samples: &mut [Stored], mut sink: impl FnMut(Projected<A>, Pixel)) {
        let longest = self.longest();
        let age_of = |time: u32| {
            let age = self.age(time);
            let counts = |age: &Age<A>| A::counts(self.decline(age.log, longest));
            (age, age.as_ref().is_some_and(counts))
        };
        // Samples of a packet share their time.
        let mut time = self.now.0;
        let (mut age, mut counts) = age_of(time);
        for sample in samples {
            if sample.time != time {
                time = sample.time;
                (age, counts) = age_of(time);
            }
            let Some(age) = &age else {
                sample.placing = Placing::Empty;
                continue;
            };
            if counts && let Some(place) = locate(&self.panel, self.slots, sample) {
                let pixel = A::nearest(&self.panel, place.0, place.1);
                sink(self.weigh(sample, age, place, pixel), pixel);
            }
        }
    }

    /// Block by block: loops that do one thing each.
    #[inline]
    fn each_in_blocks(&self, samples: &mut [Stored], mut sink: impl FnMut(Projected<A>, Pixel)) {
        let longest = self.longest();
        let mut places = [(<_>::default(), <_>::default(), <_>::default(), 0); BLOCK];
        let mut rest = samples;
        while let Some(&Stored { time, placing, .. }) = rest.first() {
            // Samples of a packet share their time.
            let alike = |sample: &&Stored| (sample.time, sample.placing) == (time, placing);
            let run = rest.iter().take(BLOCK).take_while(alike).count();
            let block = take(&mut rest, run);
            let Some(age) = self.age(time) else {
                for sample in block {
                    sample.placing = Placing::Empty;
                }
                continue;
            };
            if !A::counts(self.decline(age.log, longest)) {
                continue;
            }
            let seen = self.places(placing, block, &mut places);
            for (x, y, depth, index) in places.iter().take(seen) {
                let Some(sample) = block.get(*index) else {
                    continue;
                };
                let pixel = A::nearest(&self.panel, *x, *y);
                sink(self.weigh(sample, &age, (*x, *y, *depth), pixel), pixel);
            }
        }
    }

    /// Where the samples in sight of a block, all placed in the same way, are seen, with their
    /// indices; returns their number.
    fn places(&self, placing: Placing, block: &[Stored], places: &mut [Seen<A>; BLOCK]) -> usize {
        let mut len = 0;
        if placing == Placing::Lattice {
            let mut sights = [(A::Sight::default(), 0); BLOCK];
            for (index, sample) in block.iter().enumerate() {
                let slot = self.slots.get(usize::from(sample.slot));
                if let Some(transform) = slot.and_then(|slot| slot.transform.as_ref())
                    && let Some(place) = sights.get_mut(len)
                {
                    let (sight, inside) = A::sight(transform, &self.panel, sample.place);
                    *place = (sight, index);
                    len += usize::from(inside);
                }
            }
            for ((sight, index), place) in sights.iter().take(len).zip(places) {
                let (x, y, depth) = A::seen(&self.panel, sight);
                *place = (x, y, depth, *index);
            }
        } else {
            let seen = block.iter().enumerate().filter_map(|(index, sample)| {
                let (x, y, depth) = locate(&self.panel, self.slots, sample)?;
                Some((x, y, depth, index))
            });
            for (place, seen) in places.iter_mut().zip(seen) {
                *place = seen;
                len += 1;
            }
        }
        len
    }

    /// No lifetime is longer: what is too old for this one counts nowhere, and nobody need ask
    /// where it is.
    pub(crate) fn longest(&self) -> A::Log {
        A::log(match self.config.lifetime {
            Lifetime::Constant(log) => log,
            Lifetime::Tiles => self.tiles.longest().log2_q8() as i16,
            Lifetime::Gradient => extents::LONGEST,
        })
    }

    /// The lifetime in the middle of a pixel of the panel.
    #[inline]
    fn lifetime(&self, pixel: Pixel) -> A::Log {
        let known = self.lifetimes.get(pixel.index(self.panel.width));
        known.copied().unwrap_or_else(|| {
            let [x, y] = pixel.place().map(|v| A::centre(&self.panel, v.into()));
            A::lifetime(self.tiles, &self.panel, x, y)
        })
    }

    /// View and pose of an object composed, if both are known.
    #[inline]
    pub(crate) fn transform(&self, slot: u8) -> Option<&A::Transform> {
        self.slots.get(usize::from(slot))?.transform.as_ref()
    }

    /// The weight at an age.
    #[inline]
    pub(crate) fn decline(&self, age: A::Log, lifetime: A::Log) -> A::Weight {
        A::decline(self.config.kernel, self.config.cutoff, age, lifetime)
    }

    /// `None` where it is too old to be told from a young one.
    pub(crate) fn age(&self, time: u32) -> Option<Age<A>> {
        let age = age(time, self.now)?;
        Some(Age {
            log: A::log_of_age(age),
            past: Past::new(age, false),
        })
    }

    /// A sample of an age that is seen at a place and depth, nearest to a pixel.
    #[inline]
    pub(crate) fn weigh(
        &self,
        sample: &Stored,
        age: &Age<A>,
        (x, y, depth): (A::Coord, A::Coord, A::Depth),
        pixel: Pixel,
    ) -> Projected<A> {
        let lifetime = match self.config.lifetime {
            Lifetime::Constant(log) => A::log(log),
            Lifetime::Tiles => self.lifetime(pixel),
            Lifetime::Gradient => A::extents(self.tiles, &self.panel, x, y).0,
        };
        let weight = self.decline(age.log, lifetime);
        Projected {
            x,
            y,
            depth,
            weight,
            rgb: if A::counts(weight) {
                self.lights.relight(sample)
            } else {
                sample.rgb
            },
            // A sample of a moving object may itself have moved behind something.
            past: age.past.moving(sample.slot > slot(0)),
        }
    }
}
