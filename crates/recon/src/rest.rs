//! At rest: averaging in place of filtering.
//!
//! A filter has a width, and a moving picture needs one: each pixel has met few samples that are
//! still true. Once view and poses stand still the same pixel is met again and again, and nothing
//! beats the plain mean of what fell into it: it is the ideal picture's own box filter, and its
//! error falls with every sample for as long as the rest lasts.
//!
//! - [`Mean`]: what fell into a pixel since all stands still. The picture shows the filter's
//!   estimate for as much as [`PRIOR`] samples would count, and the mean for the rest.
//! - A pixel in whose tile light changes (any lifetime but infinity) forgets its mean:
//!   there the filter alone speaks.
//! - When everything has rested for [`SETTLED`], what a filter would find is known: from then on a
//!   refresh projects the samples that are new, corrects the pixels that they fell into, and does
//!   no more. Its cost no longer grows with what is stored. Once in [`RENEW`] everything is
//!   filtered again, so that stored samples do not outlive the clock's wrap.
//!
//! Sums are integers in every arithmetic, so the order of samples cannot matter.

use crate::arith::{Arith, Panel};
use crate::deep::{Stored, age};
use crate::memory::Slot;
use crate::project::locate;
use crate::tiles::TileMap;
use unframed_wire::{Tick, View};

/// How many samples of a pixel the filter's estimate is worth.
pub const PRIOR: u32 = 4;
/// How long all must have rested before only new samples are looked at, microseconds.
pub const SETTLED: i32 = 1 << 20;
/// How often all is filtered nonetheless, microseconds.
pub const RENEW: i32 = 1 << 26;
/// Samples that a mean may hold before a refresh; it is halved from there on.
pub const FULL: u32 = 1 << 15;
/// New samples that a refresh takes into account, the newest: with [`FULL`] and [`PRIOR`] this
/// keeps a sum of 16-bit lights below 2^32.
pub const MOST: usize = (1 << 15) - 8;
const _: () = assert!(FULL as u64 - 1 + MOST as u64 + PRIOR as u64 <= 1 << 16);

/// What fell into a pixel while all stood still.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Mean {
    /// Σ light, each 0..=65535.
    pub sum: [u32; 3],
    /// Samples.
    pub count: u32,
}

impl Mean {
    /// Nothing fell into it.
    pub const EMPTY: Self = Self {
        sum: [0; 3],
        count: 0,
    };

    /// Adds a light.
    #[inline]
    pub fn add(&mut self, light: [u16; 3]) {
        self.count = self.count.wrapping_add(1);
        for (sum, light) in self.sum.iter_mut().zip(light) {
            *sum = sum.wrapping_add(u32::from(light));
        }
    }

    /// Makes room before a refresh: a full mean counts half from now on.
    #[inline]
    pub fn make_room(&mut self) {
        if self.count >= FULL {
            self.count /= 2;
            self.sum = self.sum.map(|sum| sum / 2);
        }
    }
}

/// The light to be shown where `count` samples of light `sum` fell since the rest began and the
/// filter's estimate is `prior` (`None` where it knows nothing); rounded down. Without samples it
/// is the prior itself.
#[inline]
#[must_use]
pub fn blend(prior: Option<u16>, sum: u32, count: u32) -> u16 {
    let Some(prior) = prior else {
        return (sum / count.max(1)) as u16;
    };
    if count == 0 {
        return prior;
    }
    // At most 2^16 lights in all (see MOST), whose mean is a light.
    let lights = count.saturating_add(PRIOR);
    (sum.wrapping_add(PRIOR * u32::from(prior)) / lights) as u16
}

/// What a refresh has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Something moves: filter.
    Filter,
    /// All stands still but has not settled: filter, and average.
    Both,
    /// All has rested: average what is new.
    Average,
}

/// Whether and since when all rests.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest {
    /// The view of the last refresh.
    shown: Option<View>,
    /// Since when nothing changes; `None` while something moves.
    since: Option<Tick>,
    /// When all was last filtered.
    filtered: Tick,
}

impl Rest {
    /// Nothing was shown yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            shown: None,
            since: None,
            filtered: Tick(0),
        }
    }

    /// Decides on a refresh of `view` at `now`; `quiet` says whether light changes in no tile. To
    /// be called before [`crate::motion::Motion`] takes the poses over as shown.
    pub fn step<A: Arith>(
        &mut self,
        now: Tick,
        view: &View,
        slots: &[Slot<A>],
        quiet: bool,
    ) -> Step {
        let still = self.shown.is_some_and(|shown| same(&shown, view))
            && slots.iter().all(|slot| slot.shown == slot.pose);
        self.shown = Some(*view);
        if !still {
            self.since = None;
            return Step::Filter;
        }
        // A clock that goes back, or passes half its range, starts anew.
        let since = match self.since {
            Some(since) if quiet && now.since(since) >= 0 => since,
            _ => now,
        };
        self.since = Some(since);
        let settled = now.since(since) >= SETTLED;
        let known = (0..RENEW).contains(&now.since(self.filtered));
        if settled && known {
            return Step::Average;
        }
        self.filtered = now;
        Step::Both
    }
}

/// Whether two views are the same but for their time.
fn same(a: &View, b: &View) -> bool {
    (a.eye, a.rows, a.frac_bits) == (b.eye, b.rows, b.frac_bits)
}

/// Forgets what changed and makes room, for a refresh of [`Step::Both`] or [`Step::Average`].
pub fn prepare(panel: &Panel, tiles: &TileMap<'_>, quiet: bool, means: &mut [Mean]) {
    let width = usize::from(panel.width).max(1);
    for (y, line) in (0..).zip(means.chunks_mut(width)) {
        for (x, mean) in (0..).zip(line) {
            if mean.count == 0 {
                continue;
            }
            if quiet || tiles.rests_at(x, y) {
                mean.make_room();
            } else {
                *mean = Mean::EMPTY;
            }
        }
    }
}

/// The pixel that a new sample falls into at `now`; it may lie in the guard band.
#[inline]
pub fn place<A: Arith>(
    panel: &Panel,
    slots: &[Slot<A>],
    sample: &Stored,
    now: Tick,
) -> Option<(i32, i32)> {
    age(sample.time, now)?;
    let (x, y, _) = locate(panel, slots, sample)?;
    Some((A::pixel(panel, x), A::pixel(panel, y)))
}
