//! The adaptive sampler.
//!
//! After Dayal, Woolley, Watson & Luebke 2005 in aim: sample where the image is wrong, in space
//! and time, without frames. Different in its means. An epoch (a sixtieth of a second, say):
//!
//! 1. **Warp** ([`cells`]): what is remembered, on a map of half the image's resolution, moves to
//!    the view and the poses of the epoch's end, as they are foreseen.
//! 2. **Lifetimes** ([`lifetime`]): verified samples say how fast light changes where, in every
//!    epoch, warped or not: what became untrue at once is forgotten at once.
//! 3. In batches of a few milliseconds: **allocate** ([`allocate`]) shots to 4×4-pixel tiles by
//!    water-filling over residuals, **aim** at the next point of the tile, or, for a twentieth
//!    of the shots (a fortieth while nothing moves), look again at a place seen before; **trace**; **learn**: the difference
//!    between what was seen and what was remembered is the residual.
//!
//! Work is O(pixels) an epoch, O(tiles) a batch and O(1) a shot.

mod alarm;
mod allocate;
mod cells;
mod config;
mod guidance;
mod learn;
mod lifetime;
mod pattern;
mod plan;
pub(super) mod projection;
mod tiles;
mod warp;

use glam::{UVec2, Vec3};
use unframed_wire::tiles::TileNode;
use unframed_wire::{LogCode, Rect, TileFields};

use super::kdtree::{self, Map, log_code};
use super::noise::{R2, Random, golden_stride};
use super::srgb::{displayed, squared_difference};
use super::uniform::within;
use super::{Aim, Effort, Eye, Plan, Sampler, Seen, Shot, Span, trace};
use alarm::Alarm;
use cells::{Cells, Fading};
pub use config::Config;
use guidance::Guidance;
use learn::Find;
use lifetime::Lifetimes;
use pattern::Pattern;
use projection::Projection;
use tiles::{Grid, Tile};

/// Side of a pixel of the map, pixels of the image. The memory of a quarter as many cells costs a
/// fifth to warp, stays in the cache, and steers as well.
const SIDE: u32 = 2;

/// Of the second looks, those that are taken while nothing is seen to move: they teach a mean
/// nothing, and of those that graze an edge some end a rest.
const RESTING_LOOKS: f32 = 0.5;

/// By how much there are more second looks while a cut is suspected.
const SUSPICIOUS: f32 = 4.0;

/// The adaptive sampler of an image of fixed size.
#[derive(Clone, Debug)]
pub struct Adaptive {
    config: Config,
    /// Size of the image, pixels.
    image: UVec2,
    /// Tiles of the map.
    grid: Grid,
    cells: Cells,
    lifetimes: Lifetimes,
    /// The instant for which they were solved, seconds.
    solved: f64,
    projection: Projection,
    /// Whether nothing moved since that projection.
    still: bool,
    /// Share of a batch's shots that look again at a place seen before.
    look_share: f32,
    /// Objects seen so far, in the order of their first samples.
    objects: Vec<u8>,
    tiles: Vec<Tile>,
    /// Of each tile: the merit of a sample times its area, and the samples that it has; and the
    /// tiles that have learned since.
    errors: Vec<f32>,
    filled: Vec<f32>,
    learned: Vec<u32>,
    /// Of the last batch, see [`allocate`].
    level: f32,
    fading: Fading,
    guidance: Guidance,
    pattern: Pattern,
    alarm: Alarm,
    cut: Option<f64>,
    order: Vec<u32>,
    random: Random,
    /// A low-discrepancy sequence, the same in all tiles: where neighbours have as many points, one
    /// lattice goes on over their border. And how many each tile took, going round.
    points: R2,
    taken: Vec<u32>,
    /// The lifetime tile of each pixel of the map.
    lifetime_tiles: Vec<u32>,
    /// s²/r of each lifetime tile: squared levels × pixels × seconds a sample.
    noise: Vec<f32>,
    /// Smoothed shots of each tile in a second.
    rates: Vec<f32>,
    scratch: Scratch,
    stats: Stats,
}

/// Buffers that are reused.
#[derive(Clone, Debug, Default)]
struct Scratch {
    errors: Vec<f32>,
    shares: Vec<f32>,
    dues: Vec<i32>,
    visits: Vec<u32>,
    plans: Vec<Plan>,
    intents: Vec<Intent>,
    seen: Vec<Seen>,
    finds: Vec<Find>,
}

/// What a shot is for.
#[derive(Clone, Copy, Debug)]
struct Intent {
    /// The tile that paid for it.
    tile: u32,
    /// Over how many times likelier than by a uniform choice it got the shot: 1 divided by that.
    weight: f32,
    /// The cell to be verified; [`NONE`] for a new sample.
    cell: u32,
    /// Displayed colour and birth of the sample to be verified.
    colour: Vec3,
    born: f32,
}

/// Counts since the beginning, for the ledger and for tests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Shots taken.
    pub shots: u64,
    /// Shots that looked again at a place seen before.
    pub verifications: u64,
    /// Verifications that found something else there.
    pub failed: u64,
    /// Epochs at which the memory was warped.
    pub warps: u64,
    /// Cuts noticed.
    pub cuts: u64,
    /// Cells remembered after the last warp.
    pub cells: usize,
    /// Share of the pixels that held a cell after the last warp.
    pub coverage: f32,
    /// Wall-clock seconds spent warping and summing, planning, tracing, learning.
    pub seconds: [f64; 4],
}

impl Adaptive {
    /// For an image of `size` pixels (each side at least 1).
    #[must_use]
    pub fn new(size: UVec2, config: Config) -> Self {
        let image = size;
        let size = UVec2::new(image.x.div_ceil(SIDE), image.y.div_ceil(SIDE));
        let grid = Grid::new(size);
        let lifetimes = Lifetimes::new(size, &config);
        let lifetime_tiles = (0..size.y)
            .flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y) / lifetime::TILE))
            .map(|at| at.y * lifetimes.grid.x + at.x)
            .collect();
        Self {
            cells: Cells::new(size),
            lifetimes,
            solved: f64::NAN,
            projection: Projection::new(f64::NAN),
            still: false,
            look_share: config.verify_share,
            objects: Vec::new(),
            tiles: vec![Tile::default(); grid.len()],
            errors: vec![0.0; grid.len()],
            filled: vec![0.0; grid.len()],
            level: f32::INFINITY,
            learned: (0..grid.len() as u32).collect(),
            fading: Fading::default(),
            guidance: Guidance::new(grid.columns, grid.rows),
            pattern: Pattern::new(image, config.pattern),
            alarm: Alarm::default(),
            cut: None,
            order: allocate::z_order(grid.columns, grid.rows),
            random: Random::new(config.seed),
            points: R2::new(config.seed as u32),
            taken: vec![0; grid.len()],
            rates: vec![0.0; grid.len()],
            lifetime_tiles,
            noise: Vec::new(),
            scratch: Scratch::default(),
            stats: Stats::default(),
            grid,
            image,
            config,
        }
    }

    /// Counts since the beginning.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// The grid of lifetime tiles (8×8 pixels each, row by row) and their lifetimes in seconds.
    #[must_use]
    pub fn lifetimes(&self) -> (UVec2, &[f32]) {
        (self.lifetimes.grid, &self.lifetimes.tau)
    }

    /// The tiles in a lifetime tile.
    fn inside(&self, at: UVec2) -> impl Iterator<Item = usize> + use<> {
        let ratio = lifetime::TILE / tiles::TILE;
        let columns = self.grid.columns;
        let xs = at.x * ratio..((at.x + 1) * ratio).min(columns);
        let ys = at.y * ratio..((at.y + 1) * ratio).min(self.grid.rows);
        ys.flat_map(move |y| xs.clone().map(move |x| (y * columns + x) as usize))
    }

    /// Recent shots a pixel of the image and second in a lifetime tile.
    fn density(&self, at: UVec2) -> f32 {
        let (mut shots, mut area) = (0.0, 0.0);
        for tile in self.inside(at) {
            shots += self.rates[tile];
            area += self.grid.areas[tile];
        }
        let pixels = (area * (SIDE * SIDE) as f32).max(1.0);
        shots / (self.config.residual_memory * pixels)
    }

    /// s²/r of a lifetime tile.
    fn noise(&self, at: UVec2) -> f32 {
        let (mut squares, mut count) = (0.0, 0.0);
        for tile in self.inside(at) {
            squares += self.tiles[tile].squared_error(&self.config);
            count += 1.0;
        }
        squares / (count * self.density(at).max(0.1))
    }
}

impl Sampler for Adaptive {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        let clock = std::time::Instant::now;
        let begin = clock();
        // What is foreseen at the beginning is of the end; else the middle stands for all of it.
        let now = if self.config.ahead {
            span.t0
        } else {
            0.5 * (span.t0 + span.t1)
        };
        self.still = self.stands_still(now, eye);
        let rests = self.still && !self.objects.is_empty();
        let look_share = self.config.verify_share * if rests { RESTING_LOOKS } else { 1.0 };
        let looks = span.shots as f64 * f64::from(look_share);
        self.alarm.set_rate(looks / span.length());
        if self.is_due(now, eye) {
            self.warp(now, eye);
        } else {
            self.fade_gradients(now);
        }
        self.solve(now);
        self.stats.seconds[0] += begin.elapsed().as_secs_f64();
        let fade = (-span.length() as f32 / self.config.residual_memory).exp();
        self.rates.iter_mut().for_each(|rate| *rate *= fade);
        self.guidance.fade(fade);
        let batches = (span.length() / self.config.batch).round().max(1.0) as usize;
        let batch = span.shots.div_ceil(batches).max(1);
        let mut first = 0;
        while first < span.shots {
            let count = batch.min(span.shots - first);
            let t0 = clock();
            self.look_share = if self.alarm.suspects() {
                (SUSPICIOUS * look_share).min(1.0)
            } else {
                look_share
            };
            self.allocate(count);
            self.plan(span, first);
            let t1 = clock();
            trace(&self.scratch.plans, self.image, eye, &mut self.scratch.seen);
            let t2 = clock();
            self.learn(eye);
            out.extend(self.scratch.seen.iter().map(|seen| seen.shot));
            let t3 = clock();
            for (sum, (from, to)) in
                self.stats.seconds[1..]
                    .iter_mut()
                    .zip([(t0, t1), (t1, t2), (t2, t3)])
            {
                *sum += (to - from).as_secs_f64();
            }
            first += count;
        }
    }

    fn preferred_span(&self) -> f64 {
        self.config.span
    }

    fn tiles(&mut self, fields: TileFields, out: &mut Vec<TileNode>) {
        let grid = self.lifetimes.grid;
        let codes: Vec<[LogCode; 2]> = (0..grid.y)
            .flat_map(|y| (0..grid.x).map(move |x| UVec2::new(x, y)))
            .map(|at| {
                let lifetime = fields.lifetime.then(|| {
                    let tile = (at.y * grid.x + at.x) as usize;
                    log_code(self.lifetimes.told(tile))
                });
                let density = fields.density.then(|| log_code(self.density(at)));
                [lifetime, density].map(|code| code.unwrap_or(LogCode(128)))
            })
            .collect();
        let map = Map {
            cell: (lifetime::TILE * SIDE) as u16,
            columns: grid.x as usize,
            codes: &codes,
        };
        let size = self.image;
        let rect = Rect {
            x: 0,
            y: 0,
            w: size.x as u16,
            h: size.y as u16,
        };
        out.clear();
        let fields = [fields.lifetime, fields.density];
        kdtree::cut(&map, rect, fields, self.config.code_tolerance, out);
    }

    fn take_cut(&mut self) -> Option<f64> {
        self.cut.take()
    }

    fn looks_ahead(&self) -> bool {
        self.config.ahead
    }

    fn effort(&self) -> Option<Effort> {
        let [reprojection, _, tracing, _] = self.stats.seconds;
        Some(Effort {
            tracing,
            reprojection,
        })
    }
}

#[cfg(test)]
mod tests;
