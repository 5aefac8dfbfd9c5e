//! The host at work: simulated time, a sampler looking, a sender sending.

use std::time::Instant;

use unframed_wire::{End, Hello, Status, TileNode, ledger::Ledger};

use crate::gaze::Gaze;
use crate::sampler::{Sampler, Shot, Span};
use crate::stream::Detail;
use crate::stream::sender::Promise;
use crate::stream::{Sender, StreamError};
use crate::trace::{Rays, World};

/// Adds up what passes.
struct Clock(Instant);

impl Clock {
    fn new() -> Self {
        Self(Instant::now())
    }

    /// Adds the time since the last lap.
    fn lap(&mut self, sum: &mut f64) {
        let now = Instant::now();
        *sum += (now - self.0).as_secs_f64();
        self.0 = now;
    }
}

/// What happened up to a refresh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// The refresh, counted from 0.
    pub index: u32,
    /// Its instant, seconds.
    pub time: f64,
    /// Samples sent since the last.
    pub samples: usize,
    /// Rays traced since the last.
    pub rays: Rays,
    /// Whether the sampler announced a cut.
    pub cut: bool,
}

/// Where a host's wall-clock time went since its beginning, seconds. Decides nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Posing the scene and fitting its bounding volumes to each span.
    pub scene: f64,
    /// Rays and shading.
    pub tracing: f64,
    /// Moving the sampler's memory to a new view.
    pub reprojection: f64,
    /// Deciding where to look, learning from it, and tiles.
    pub control: f64,
    /// Quantising and packing.
    pub stream: f64,
}

impl Spent {
    /// All of it, seconds.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.scene + self.tracing + self.reprojection + self.control + self.stream
    }
}

/// A host: a world, a sampler, a stream.
///
/// Refresh `k` is that of the instant `(k + 1)·1000/refresh_millihertz` seconds; every sample
/// costs 1/rate seconds.
pub struct Host {
    world: World,
    sampler: Box<dyn Sampler>,
    sender: Sender,
    shots: Vec<Shot>,
    tiles: Vec<TileNode>,
    now: f64,
    taken: u64,
    index: u32,
    /// Without what the sampler counts itself.
    spent: Spent,
}

impl std::fmt::Debug for Host {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Host")
            .field("now", &self.now)
            .field("taken", &self.taken)
            .finish()
    }
}

impl Host {
    /// A host at time 0.
    #[must_use]
    pub fn new(world: World, sampler: Box<dyn Sampler>, promise: Promise) -> Self {
        Self::with_detail(world, sampler, promise, Detail::default())
    }

    /// The same with a stream in less detail.
    #[must_use]
    pub fn with_detail(
        world: World,
        sampler: Box<dyn Sampler>,
        promise: Promise,
        detail: Detail,
    ) -> Self {
        let sender = Sender::with_detail(&world, promise, detail);
        Self {
            world,
            sampler,
            sender,
            shots: Vec::new(),
            tiles: Vec::new(),
            now: 0.0,
            taken: 0,
            index: 0,
            spent: Spent::default(),
        }
    }

    /// The world that is looked at.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// What the stream announces.
    #[must_use]
    pub fn hello(&self) -> &Hello {
        self.sender.hello()
    }

    /// Where the bytes went so far.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        self.sender.ledger()
    }

    /// The tiles of the last refresh, in preorder.
    #[must_use]
    pub fn tiles(&self) -> &[TileNode] {
        &self.tiles
    }

    /// The samples since the refresh before, in the order of time.
    #[must_use]
    pub fn shots(&self) -> &[Shot] {
        &self.shots
    }

    /// Where the time went so far.
    #[must_use]
    pub fn spent(&self) -> Spent {
        let mut spent = self.spent;
        if let Some(effort) = self.sampler.effort() {
            let rest = spent.tracing - effort.tracing - effort.reprojection;
            spent.control += rest.max(0.0);
            spent.tracing = effort.tracing;
            spent.reprojection = effort.reprojection;
        }
        spent
    }

    /// The instant of a refresh, seconds.
    #[must_use]
    pub fn instant(&self, index: u32) -> f64 {
        (f64::from(index) + 1.0) * 1000.0 / f64::from(self.hello().refresh_millihertz)
    }

    /// Tells the sampler what the display reports.
    pub fn status(&mut self, status: &Status) {
        self.sampler.status(status);
    }

    /// Goes on to the next refresh and appends the bytes up to it to `out`.
    ///
    /// # Errors
    /// When the stream cannot carry what the sampler gives.
    pub fn advance(&mut self, out: &mut Vec<u8>) -> Result<Progress, StreamError> {
        let (start, end) = (self.now, self.instant(self.index));
        let pieces = ((end - start) / self.sampler.preferred_span())
            .round()
            .max(1.0) as u32;
        let mut progress = Progress {
            index: self.index,
            time: end,
            ..Progress::default()
        };
        self.shots.clear();
        for piece in 0..pieces {
            let at = |piece| start + (end - start) * f64::from(piece) / f64::from(pieces);
            let (t0, t1) = (at(piece), at(piece + 1));
            let due = (t1 * f64::from(self.hello().rate)).round() as u64;
            let shots = due.saturating_sub(self.taken) as usize;
            self.taken = due;
            let before = self.shots.len();
            let mut clock = Clock::new();
            let ahead = self.sampler.looks_ahead().then_some(t1);
            match ahead {
                Some(_) => self.world.foresee(t0, t1),
                None => self.world.prepare(t0, t1),
            }
            progress.rays += self.world.preparation();
            clock.lap(&mut self.spent.scene);
            let span = Span { t0, t1, shots };
            let gaze = Gaze {
                world: &self.world,
                open: self.sender.hello().lamps > 0,
                ahead,
            };
            self.sampler.epoch(span, &gaze, &mut self.shots);
            clock.lap(&mut self.spent.tracing);
            if let Some(time) = self.sampler.take_cut() {
                progress.cut = true;
                self.sender.cut(time, out)?;
                // What was seen before the cut is not worth sending any more.
                let stale = self.shots[before..].partition_point(|shot| shot.time < time);
                self.sender.samples(&self.shots[before + stale..], out)?;
            } else {
                self.sender.samples(&self.shots[before..], out)?;
            }
            clock.lap(&mut self.spent.stream);
        }
        let mut clock = Clock::new();
        if self.sender.wants_tiles() {
            self.sampler
                .tiles(self.sender.hello().tile_fields, &mut self.tiles);
        } else {
            self.tiles.clear();
        }
        clock.lap(&mut self.spent.control);
        self.sender.refresh(&self.world, end, &self.tiles, out)?;
        clock.lap(&mut self.spent.stream);
        let untold = self.sampler.take_rays();
        for rays in self.shots.iter().map(|shot| shot.hit.rays).chain([untold]) {
            progress.rays += rays;
        }
        progress.samples = self.shots.len();
        self.now = end;
        self.index = self.index.wrapping_add(1);
        Ok(progress)
    }

    /// Ends the stream.
    ///
    /// # Errors
    /// None with a sound encoder.
    pub fn end(&mut self, out: &mut Vec<u8>) -> Result<End, StreamError> {
        self.sender.end(self.now, out)
    }
}
