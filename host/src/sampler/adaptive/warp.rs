//! Moving what is remembered to the view of an epoch, where anything moved.

use glam::UVec2;

use super::cells::{Cell, NONE};
use super::projection::Projection;
use super::tiles::Tile;
use super::{Adaptive, Eye, SIDE};

/// After how many epochs what is remembered is warped even where nothing moves, so that it fades:
/// with the fourth (the half keeps rounding out of it).
const RESTED: f64 = 3.5;
/// The memory is warped when more than one in so many cells would move too far.
const MOVED: usize = 8;
/// Cells that are asked whether they would move.
const PROBES: usize = 256;

impl Adaptive {
    /// Whether the memory has to move to the view of an instant: whether too many of
    /// some cells in sight would move by more than [`Config::slack`] pixels, or nothing has faded
    /// for long.
    pub(super) fn is_due(&self, time: f64, eye: &dyn Eye) -> bool {
        let rested = time - self.projection.time();
        // Not a number before the first time.
        let known = rested < RESTED * self.config.span;
        if !known || self.config.slack <= 0.0 {
            return true;
        }
        let mut next = Projection::scaled(time, 1.0 / SIDE as f32);
        for &object in &self.objects {
            next.prepare(object, eye);
        }
        let place = |projection: &Projection, cell: &Cell| {
            let seen = projection.project(cell.object, cell.local);
            seen.map(|(at, _)| at)
        };
        let slack = self.config.slack / SIDE as f32;
        let stride = (self.cells.pool.len() / PROBES).max(1);
        let (mut all, mut moved) = (0, 0);
        for cell in self.cells.pool.iter().step_by(stride) {
            if cell.pixel == NONE {
                continue;
            }
            let steady = match (place(&self.projection, cell), place(&next, cell)) {
                (Some(from), Some(to)) => from.distance_squared(to) <= slack * slack,
                (None, None) => true,
                _ => false,
            };
            all += 1;
            moved += usize::from(!steady);
        }
        MOVED * moved > all
    }

    /// Whether neither view nor objects moved since the last warp.
    pub(super) fn stands_still(&self, time: f64, eye: &dyn Eye) -> bool {
        let mut now = Projection::scaled(time, 1.0 / SIDE as f32);
        for &object in &self.objects {
            now.prepare(object, eye);
        }
        self.projection.agrees(&now)
    }

    /// Moves the memory to the view of an instant and sums it up.
    pub(super) fn warp(&mut self, time: f64, eye: &dyn Eye) {
        self.stats.warps += 1;
        let step = (time - self.projection.time()) as f32;
        self.projection = Projection::scaled(time, 1.0 / SIDE as f32);
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
        self.fading.residuals = (-step / c.residual_memory).exp();
        self.fading.gradients = (-step / c.gradient_memory).exp();
        self.cells
            .warp(&self.projection, &self.fading, &self.lifetime_tiles);
        self.sum();
    }

    /// Time passes over the gradients of a map that stays where it is.
    pub(super) fn fade_gradients(&mut self, time: f64) {
        let step = (time - self.solved) as f32;
        self.lifetimes
            .fade((-step / self.config.gradient_memory).exp());
    }

    /// Finds the lifetimes of an instant.
    pub(super) fn solve(&mut self, time: f64) {
        let step = (time - self.solved) as f32;
        self.solved = time;
        self.noise.clear();
        if self.config.balanced {
            let grid = self.lifetimes.grid;
            for at in (0..grid.y).flat_map(|y| (0..grid.x).map(move |x| UVec2::new(x, y))) {
                self.noise.push(self.noise(at));
            }
        }
        self.lifetimes.solve(&self.noise, step);
    }

    /// No tile's error holds any longer.
    pub(super) fn learn_anew(&mut self) {
        self.learned.clear();
        self.learned.extend(0..self.tiles.len() as u32);
    }

    /// Sums the front cells up in their tiles.
    fn sum(&mut self) {
        self.tiles.fill(Tile::default());
        self.learn_anew();
        self.lifetimes.clear();
        let mut covered = 0;
        for cell in &self.cells.pool {
            if cell.weight <= 0.0 {
                continue;
            }
            let tile = &mut self.tiles[self.grid.of(cell.pixel)];
            tile.samples += cell.weight;
            tile.colour += cell.mean * cell.weight;
            tile.residuals[0] += cell.residuals[0];
            tile.residuals[1] += cell.residuals[1];
            let tile = self.lifetime_tiles[cell.pixel as usize] as usize;
            self.lifetimes.add(tile, cell.gradients);
            covered += 1;
        }
        self.stats.cells = self.cells.pool.len();
        self.stats.coverage = covered as f32 / self.cells.plane.len() as f32;
    }
}
