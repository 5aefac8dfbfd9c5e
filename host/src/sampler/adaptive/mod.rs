//! The adaptive sampler.
//!
//! After Dayal, Woolley, Watson & Luebke 2005 in aim: sample where the image is wrong, in space
//! and time, without frames. Different in its means. An epoch (a sixtieth of a second, say):
//!
//! 1. **Warp** ([`cells`]): what is remembered moves to the view and the poses of mid-epoch.
//! 2. **Lifetimes** ([`lifetime`]): verified samples say how fast light changes where.
//! 3. In batches of a few milliseconds: **allocate** ([`allocate`]) shots to 4×4-pixel tiles by
//!    water-filling over residuals, **aim** at the least covered of three pixels, or, for a fifth
//!    of the shots, look again at a place seen before; **trace**; **learn**: the difference
//!    between what was seen and what was remembered is the residual.
//!
//! Work is O(pixels) an epoch, O(tiles) a batch and O(1) a shot.

mod alarm;
mod allocate;
mod cells;
mod config;
mod lifetime;
pub(super) mod projection;
mod tiles;

use glam::{UVec2, Vec2, Vec3};
use unframed_wire::tiles::TileNode;
use unframed_wire::{LogCode, Rect, TileFields};

use super::kdtree::{self, Map, log_code};
use super::noise::{R2, Random, golden_stride, hash};
use super::srgb::{displayed, squared_difference};
use super::uniform::within;
use super::{Aim, Effort, Eye, Plan, Sampler, Seen, Shot, Span, trace};
use alarm::Alarm;
use cells::{Cell, Cells, Fading, Fresh, NONE};
pub use config::Config;
use lifetime::Lifetimes;
use projection::{Projection, SKY_DEPTH, same_depth};
use tiles::{Grid, Tile};

/// Epochs after which what is remembered is warped even where nothing moves, so that it fades.
const RESTED: f64 = 4.0;
/// Cells that are asked whether they would move.
const PROBES: usize = 256;

/// The adaptive sampler of an image of fixed size.
#[derive(Clone, Debug)]
pub struct Adaptive {
    config: Config,
    grid: Grid,
    cells: Cells,
    lifetimes: Lifetimes,
    projection: Projection,
    /// Objects seen so far, in the order of their first samples.
    objects: Vec<u8>,
    tiles: Vec<Tile>,
    fading: Fading,
    alarm: Alarm,
    cut: Option<f64>,
    order: Vec<u32>,
    random: Random,
    /// A low-discrepancy sequence in each tile.
    points: Vec<R2>,
    /// The lifetime tile of each tile.
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
    filled: Vec<f32>,
    shares: Vec<f32>,
    visits: Vec<u32>,
    plans: Vec<Plan>,
    intents: Vec<Intent>,
    seen: Vec<Seen>,
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
        let grid = Grid::new(size);
        let lifetimes = Lifetimes::new(size, &config);
        let lifetime_tiles = (0..grid.len() as u32)
            .map(|tile| {
                let at = grid.rect(tile).0 / lifetime::TILE;
                at.y * lifetimes.grid.x + at.x
            })
            .collect();
        Self {
            cells: Cells::new(size, &config),
            lifetimes,
            projection: Projection::new(f64::NAN),
            objects: Vec::new(),
            tiles: vec![Tile::default(); grid.len()],
            fading: Fading::default(),
            alarm: Alarm::default(),
            cut: None,
            order: allocate::z_order(grid.columns, grid.rows),
            random: Random::new(config.seed),
            points: (0..grid.len() as u32)
                .map(|t| R2::new(hash(t) ^ config.seed as u32))
                .collect(),
            rates: vec![0.0; grid.len()],
            lifetime_tiles,
            noise: Vec::new(),
            scratch: Scratch::default(),
            stats: Stats::default(),
            grid,
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

    /// Recent shots a pixel and second in a lifetime tile.
    fn density(&self, at: UVec2) -> f32 {
        let (mut shots, mut area) = (0.0, 0);
        for tile in self.inside(at) {
            shots += self.rates[tile];
            area += self.grid.rect(tile as u32).1.element_product();
        }
        shots / (self.config.residual_memory * area.max(1) as f32)
    }

    /// s²/r of a lifetime tile.
    fn noise(&self, at: UVec2) -> f32 {
        let (mut squares, mut count) = (0.0, 0.0);
        for tile in self.inside(at) {
            squares += self.tiles[tile].error(0.0, &self.config).powi(2);
            count += 1.0;
        }
        squares / (count * self.density(at).max(0.1))
    }

    /// Whether the memory has to move to the view of an instant: whether more than one in twenty
    /// of some cells in sight would move by more than [`Config::slack`] pixels, or nothing has faded for long.
    fn is_due(&self, time: f64, eye: &dyn Eye) -> bool {
        let rested = time - self.projection.time();
        // Not a number before the first time.
        let known = rested < RESTED * self.config.span;
        if !known || self.config.slack <= 0.0 {
            return true;
        }
        let mut next = Projection::new(time);
        for &object in &self.objects {
            next.prepare(object, eye);
        }
        let place = |projection: &Projection, cell: &Cell| {
            let seen = projection.project(cell.object, cell.local);
            seen.map(|(at, _)| at)
        };
        let stride = (self.cells.pool.len() / PROBES).max(1);
        let (mut all, mut moved) = (0, 0);
        for cell in self.cells.pool.iter().step_by(stride) {
            if cell.pixel == NONE {
                continue;
            }
            let steady = match (place(&self.projection, cell), place(&next, cell)) {
                (Some(from), Some(to)) => {
                    from.distance_squared(to) <= self.config.slack * self.config.slack
                }
                (None, None) => true,
                _ => false,
            };
            all += 1;
            moved += usize::from(!steady);
        }
        20 * moved > all
    }

    /// Moves the memory to the view of an instant and sums it up.
    fn warp(&mut self, time: f64, eye: &dyn Eye) {
        let step = (time - self.projection.time()) as f32;
        self.projection = Projection::new(time);
        for &object in &self.objects {
            self.projection.prepare(object, eye);
        }
        let c = self.config.clone();
        // The reconstructor's tail 1/(1+u²+u⁴) as an exponential that can be updated.
        let fade = |tau: f32| (-step / (0.9 * tau)).exp();
        self.fading.step = step;
        self.fading.weights.clear();
        self.fading
            .weights
            .extend(self.lifetimes.tau.iter().map(|&tau| fade(tau)));
        self.fading.unseen = fade(c.lifetime_max);
        self.fading.residuals = (-step / c.residual_memory).exp();
        self.fading.gradients = (-step / c.gradient_memory).exp();
        let (grid, lifetimes) = (&self.grid, &self.lifetime_tiles);
        self.cells.warp(&self.projection, &self.fading, |pixel| {
            lifetimes[grid.of(pixel)] as usize
        });
        self.sum();
        if c.balanced {
            self.noise.clear();
            let grid = self.lifetimes.grid;
            for at in (0..grid.y).flat_map(|y| (0..grid.x).map(move |x| UVec2::new(x, y))) {
                self.noise.push(self.noise(at));
            }
        }
        self.lifetimes.solve(&self.noise);
    }

    /// Sums the front cells up in their tiles.
    fn sum(&mut self) {
        self.tiles.fill(Tile::default());
        self.lifetimes.clear();
        let mut covered = 0;
        for (i, cell) in self.cells.pool.iter().enumerate() {
            if cell.pixel == NONE || self.cells.plane[cell.pixel as usize].front != i as u32 {
                continue;
            }
            let index = self.grid.of(cell.pixel);
            let tile = &mut self.tiles[index];
            tile.samples += cell.weight;
            tile.covered += 1.0;
            tile.colour += cell.mean * cell.weight;
            tile.residuals[0] += cell.residuals[0];
            tile.residuals[1] += cell.residuals[1];
            self.lifetimes
                .add(self.lifetime_tiles[index] as usize, cell.gradients);
            covered += 1;
        }
        self.stats.cells = self.cells.pool.len();
        self.stats.coverage = covered as f32 / self.cells.plane.len() as f32;
    }

    /// Shares `count` shots out among the tiles: fills `scratch.visits`.
    fn allocate(&mut self, count: usize) {
        let c = &self.config;
        let s = &mut self.scratch;
        s.errors.clear();
        s.filled.clear();
        for (i, tile) in self.tiles.iter().enumerate() {
            let area = self.grid.areas[i];
            let error = if c.residuals {
                tile.error(area - tile.covered, c)
            } else {
                1.0
            };
            s.errors.push(error * area);
            s.filled
                .push(if c.water_filling { tile.samples } else { 0.0 });
        }
        let (level, _) = allocate::water_level(&s.errors, &s.filled, count as f32);
        let everywhere = c.uniform_share * count as f32 / (self.grid.size.element_product() as f32);
        s.shares.clear();
        for (i, (&error, &filled)) in s.errors.iter().zip(&s.filled).enumerate() {
            let due = (level * error - filled).max(0.0) * (1.0 - c.uniform_share);
            s.shares.push(due + everywhere * self.grid.areas[i]);
        }
        allocate::visits(
            &self.order,
            &s.shares,
            count,
            self.random.unit(),
            &mut s.visits,
        );
    }

    /// Plans the visits as the shots `first..` of the span.
    fn plan(&mut self, span: Span, first: usize) {
        self.scratch.plans.clear();
        self.scratch.intents.clear();
        let count = self.scratch.visits.len();
        let stride = golden_stride(count);
        let evenly = count as f32 / self.grid.size.element_product() as f32;
        let mut at = self.random.below(count.max(1) as u32) as usize;
        for i in 0..count {
            let tile = self.scratch.visits[at];
            at = (at + stride) % count;
            let again = self.random.unit() < self.config.verify_share;
            let (place, pixel) = self.aim(tile, again);
            let time = span.instant(first + i);
            let uniform = evenly * self.grid.areas[tile as usize];
            let mut intent = Intent {
                tile,
                weight: uniform / self.scratch.shares[tile as usize].max(1e-9),
                cell: NONE,
                colour: Vec3::ZERO,
                born: 0.0,
            };
            let mut aim = Aim::Pixel(place);
            let front = self.cells.plane[pixel as usize].front;
            if again && front != NONE {
                let cell = &self.cells.pool[front as usize];
                intent.cell = front;
                (intent.colour, intent.born) = (cell.newest(), cell.born);
                aim = Aim::Again {
                    object: cell.object,
                    local: cell.local,
                    instead: place,
                };
            } else {
                self.cells.plane[pixel as usize].cover += 1.0;
            }
            self.scratch.plans.push(Plan {
                time,
                aim,
                seed: self.random.next(),
            });
            self.scratch.intents.push(intent);
        }
    }

    /// A place in a tile and its pixel: for a second look the best covered of three random
    /// pixels; else the next point of the tile's sequence or, where pixels of the tile are empty,
    /// the least covered of its next three points.
    fn aim(&mut self, tile: u32, again: bool) -> (Vec2, u32) {
        let (corner, size) = self.grid.rect(tile);
        let full =
            self.tiles[tile as usize].covered >= self.config.full * size.element_product() as f32;
        let candidates = if full && !again { 1 } else { 3 };
        let mut best = (Vec2::ZERO, 0, f32::INFINITY);
        for _ in 0..candidates {
            let point = if again {
                Vec2::new(self.random.unit(), self.random.unit())
            } else {
                self.points[tile as usize].next()
            };
            let place = within(corner.as_vec2() + point * size.as_vec2(), self.grid.size);
            let pixel = place.y as u32 * self.grid.size.x + place.x as u32;
            let cover = self.cells.plane[pixel as usize].cover;
            let badness = if again { -cover } else { cover };
            if badness < best.2 {
                best = (place, pixel, badness);
            }
        }
        (best.0, best.1)
    }

    /// Learns from what was seen.
    fn learn(&mut self, eye: &dyn Eye) {
        for i in 0..self.scratch.seen.len() {
            let (seen, intent) = (self.scratch.seen[i], self.scratch.intents[i]);
            let Shot { time, hit, .. } = seen.shot;
            if !self.objects.contains(&hit.object) {
                self.objects.push(hit.object);
            }
            self.projection.prepare(hit.object, eye);
            let fresh = Fresh {
                local: hit.local,
                object: hit.object,
                colour: displayed(hit.colour),
                born: (time - self.projection.time()) as f32,
            };
            self.rates[intent.tile as usize] += 1.0;
            match seen.expected {
                Some(expected) if intent.cell != NONE => {
                    self.verified(time, &fresh, hit.depth, expected, &intent);
                }
                _ => self.sampled(&fresh),
            }
        }
        self.stats.shots += self.scratch.seen.len() as u64;
    }

    /// A new sample: its residual is its difference from what the memory showed there.
    fn sampled(&mut self, fresh: &Fresh) {
        let Some((at, depth)) = self.projection.project(fresh.object, fresh.local) else {
            return;
        };
        let pixel = self.cells.pixel(at);
        if pixel == NONE {
            self.cells.deposit(fresh, at, depth);
            return;
        }
        let tile = self.grid.of(pixel);
        let mean = self.tiles[tile].mean();
        let front = self.cells.plane[pixel as usize].front;
        let shown = if front == NONE {
            mean
        } else {
            let cell = &self.cells.pool[front as usize];
            let share = (cell.weight / 0.7).min(1.0);
            Some(mean.map_or(cell.mean, |mean| mean.lerp(cell.mean, share)))
        };
        let index = self.cells.deposit(fresh, at, depth);
        let tile = &mut self.tiles[tile];
        tile.samples += 1.0;
        tile.colour += fresh.colour;
        if front == NONE {
            tile.covered += 1.0;
        }
        if let Some(shown) = shown {
            let r2 = squared_difference(shown, fresh.colour);
            let cell = &mut self.cells.pool[index as usize];
            for sums in [&mut cell.residuals, &mut tile.residuals] {
                sums[0] += 1.0;
                sums[1] += r2;
            }
        }
    }

    /// A second look at a stored place: found again, its change of colour over its age is the
    /// temporal gradient; else the place is hidden or gone.
    fn verified(&mut self, time: f64, fresh: &Fresh, depth: f32, expected: f32, intent: &Intent) {
        self.stats.verifications += 1;
        let cell = self.cells.pool[intent.cell as usize];
        let found = if expected == f32::INFINITY {
            depth == f32::INFINITY
        } else {
            fresh.object == cell.object && same_depth(depth, expected)
        };
        let dc2 = squared_difference(intent.colour, fresh.colour);
        let wrong = !found || dc2 > 60.0 * 60.0;
        if !found {
            self.stats.failed += 1;
        }
        if self.config.cuts
            && let Some(since) = self.alarm.verified(time, intent.weight, wrong)
        {
            self.forget(since);
            return;
        }
        if cell.weight <= 0.0 {
            self.sampled(fresh);
            return;
        }
        if !found {
            self.cells.kill(intent.cell);
            self.sampled(fresh);
            return;
        }
        let r2 = cell.residual(fresh.colour);
        let dt = fresh.born - intent.born;
        let depth = depth.min(SKY_DEPTH);
        let outdated = dc2 > 9.0 * self.config.tolerance * self.config.tolerance;
        self.cells.confirm(intent.cell, fresh, depth, outdated);
        let cell = &mut self.cells.pool[intent.cell as usize];
        cell.gradients[0] += dc2;
        cell.gradients[1] += dt * dt;
        cell.residuals[0] += 1.0;
        cell.residuals[1] += r2;
        let tile = &mut self.tiles[intent.tile as usize];
        tile.samples += 1.0;
        tile.colour += fresh.colour;
        tile.residuals[0] += 1.0;
        tile.residuals[1] += r2;
    }

    /// The scene changed wholly: start anew.
    fn forget(&mut self, since: f64) {
        self.stats.cuts += 1;
        self.cut = Some(since);
        self.cells.clear();
        self.tiles.fill(Tile::default());
        // What is left of the batch was aimed at cells that are gone.
        self.scratch
            .intents
            .iter_mut()
            .for_each(|intent| intent.cell = NONE);
    }
}

impl Sampler for Adaptive {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        let clock = std::time::Instant::now;
        let begin = clock();
        let looks = span.shots as f64 * f64::from(self.config.verify_share);
        self.alarm.set_rate(looks / span.length());
        let middle = 0.5 * (span.t0 + span.t1);
        if self.is_due(middle, eye) {
            self.warp(middle, eye);
        }
        self.stats.seconds[0] += begin.elapsed().as_secs_f64();
        let fade = (-span.length() as f32 / self.config.residual_memory).exp();
        self.rates.iter_mut().for_each(|rate| *rate *= fade);
        let batches = (span.length() / self.config.batch).round().max(1.0) as usize;
        let batch = span.shots.div_ceil(batches).max(1);
        let mut first = 0;
        while first < span.shots {
            let count = batch.min(span.shots - first);
            let t0 = clock();
            self.allocate(count);
            self.plan(span, first);
            let t1 = clock();
            trace(
                &self.scratch.plans,
                self.grid.size,
                eye,
                &mut self.scratch.seen,
            );
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
                let lifetime = self.lifetimes.tau[(at.y * grid.x + at.x) as usize];
                [log_code(lifetime), log_code(self.density(at))]
            })
            .collect();
        let map = Map {
            cell: lifetime::TILE as u16,
            columns: grid.x as usize,
            codes: &codes,
        };
        let size = self.grid.size;
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
