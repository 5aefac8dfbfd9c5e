//! What a shot teaches: residuals of new samples, gradients of second looks, cuts.

use glam::{Vec2, Vec3};

use super::cells::{Fresh, NONE};
use super::guidance::Points;
use super::projection::{SKY_DEPTH, same_depth};
use super::tiles::Tile;
use super::{Adaptive, Eye, Intent, Shot, displayed, squared_difference};

/// A change beyond rounding: squared displayed levels.
const EVIDENT: f32 = 4.0;
/// By how much rounding may be off, levels: half a level and what two traces of a point differ.
const ROUNDING: f32 = 0.51;

/// The least change, squared displayed levels, between a colour that was stored rounded and one
/// that was not: what rests must not seem to change.
fn least_change(stored: Vec3, seen: Vec3) -> f32 {
    let beyond = ((seen - stored).abs() - ROUNDING).max(Vec3::ZERO);
    squared_difference(beyond, Vec3::ZERO)
}

/// A shot and where it falls in the memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Find {
    fresh: Fresh,
    /// Place (pixels) and depth (metres) in the map's view; `None` if it cannot be projected.
    seen: Option<(Vec2, f32)>,
    /// Its pixel, or [`NONE`], and the tile of that.
    pixel: u32,
    tile: u32,
    /// The cell in front there before the batch, or [`NONE`].
    front: u32,
    /// What was remembered there before the batch, if anything.
    shown: Option<Vec3>,
}

impl Adaptive {
    /// Learns from what was seen.
    ///
    /// Memory is looked up for the whole batch before any of it changes, one kind after the other: the
    /// look-ups hit cold cache lines, and only those that do not wait for each other overlap.
    pub(super) fn learn(&mut self, eye: &dyn Eye) {
        let mut finds = std::mem::take(&mut self.scratch.finds);
        finds.clear();
        for (seen, plan) in self.scratch.seen.iter().zip(&self.scratch.plans) {
            let Shot { as_of, hit, .. } = seen.shot;
            if !self.projection.knows(hit.object) {
                self.objects.push(hit.object);
                self.projection.prepare(hit.object, eye);
            }
            let seen = self.projection.project(hit.object, hit.local);
            let pixel = seen.map_or(NONE, |(at, _)| self.cells.pixel(at));
            finds.push(Find {
                fresh: Fresh {
                    local: hit.local,
                    object: hit.object,
                    colour: displayed(hit.colour),
                    born: (as_of - self.projection.time()) as f32,
                    points: Points::new(plan.seed, plan.care),
                },
                seen,
                pixel,
                tile: NONE,
                front: NONE,
                shown: None,
            });
        }
        for find in &mut finds {
            if let Some(spot) = self.cells.plane.get(find.pixel as usize) {
                find.front = spot.front;
                find.tile = self.grid.of(find.pixel) as u32;
            }
        }
        for find in &mut finds {
            find.shown = self.shown(find);
        }
        let cuts = self.stats.cuts;
        let seen = std::mem::take(&mut self.scratch.seen);
        let intents = std::mem::take(&mut self.scratch.intents);
        for ((find, seen), intent) in finds.iter_mut().zip(&seen).zip(&intents) {
            // What is left of a batch after a cut was aimed at cells that are gone.
            let cut = self.stats.cuts > cuts;
            if cut {
                find.shown = None;
            }
            if self.config.guidance {
                self.guidance.learn(intent.tile, &seen.told);
            }
            self.rates[intent.tile as usize] += 1.0;
            match seen.expected {
                Some(expected) if intent.cell != NONE && !cut => {
                    self.verified(&seen.shot, find, expected, intent);
                }
                _ => self.sampled(find),
            }
        }
        self.stats.shots += finds.len() as u64;
        self.scratch.finds = finds;
        self.scratch.seen = seen;
        self.scratch.intents = intents;
    }

    /// What the memory shows at a find's pixel: its front cell, drawn towards the mean of the
    /// tile where it stands for little.
    fn shown(&self, find: &Find) -> Option<Vec3> {
        let mean = self.tiles.get(find.tile as usize)?.mean();
        match self.cells.pool.get(find.front as usize) {
            None => mean,
            Some(cell) => {
                let share = (cell.weight / 0.7).min(1.0);
                Some(mean.map_or(cell.mean, |mean| mean.lerp(cell.mean, share)))
            }
        }
    }

    /// A new sample: its residual is its difference from what the memory showed there.
    fn sampled(&mut self, find: &Find) {
        let (fresh, Some((at, depth))) = (&find.fresh, find.seen) else {
            return;
        };
        if find.pixel == NONE {
            self.cells.deposit(fresh, at, depth, 0.0);
            return;
        }
        let index = find.tile as usize;
        self.learned.push(find.tile);
        let tile = &mut self.tiles[index];
        // What changes within a lifetime is to be known, not what changes between two samples: light
        // does not change evenly, and of jumps the slope over a short time is far too steep.
        let hold = self.lifetimes.tau[self.lifetime_tiles[find.pixel as usize] as usize];
        let index = self.cells.deposit(fresh, at, depth, hold);
        tile.samples += 1.0;
        tile.colour += fresh.colour;
        if let Some(shown) = find.shown {
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
    fn verified(&mut self, shot: &Shot, find: &Find, expected: f32, intent: &Intent) {
        let (fresh, time, depth) = (&find.fresh, shot.time, shot.hit.depth);
        self.stats.verifications += 1;
        let cell = self.cells.pool[intent.cell as usize];
        let found = if expected == f32::INFINITY {
            depth == f32::INFINITY
        } else {
            fresh.object == cell.object && same_depth(depth, expected)
        };
        let dc2 = least_change(intent.colour, fresh.colour);
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
            self.sampled(find);
            return;
        }
        if !found {
            self.cells.kill(intent.cell);
            self.sampled(find);
            return;
        }
        let lifetimes = self.lifetime_tiles[cell.pixel as usize] as usize;
        if self.still && dc2 > EVIDENT && !self.lifetimes.corroborated(lifetimes, cell.pixel, time)
        {
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
        // Until the next warp sums the cells up.
        self.lifetimes.add(lifetimes, [dc2, dt * dt]);
        cell.residuals[0] += 1.0;
        cell.residuals[1] += r2;
        self.learned.push(intent.tile);
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
        self.learn_anew();
    }
}
