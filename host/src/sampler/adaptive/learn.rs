//! What a shot teaches: residuals of new samples, gradients of second looks, cuts.

use super::cells::{Fresh, NONE};
use super::projection::{SKY_DEPTH, same_depth};
use super::tiles::Tile;
use super::{Adaptive, Eye, Intent, Shot, displayed, squared_difference};

impl Adaptive {
    /// Learns from what was seen.
    pub(super) fn learn(&mut self, eye: &dyn Eye) {
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
