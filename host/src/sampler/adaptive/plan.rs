//! Sharing shots out among the tiles, and aiming them.

use glam::{Vec2, Vec3};

use super::cells::NONE;
use super::{Adaptive, Aim, Intent, Plan, SIDE, Span, allocate, golden_stride, within};

impl Adaptive {
    /// Shares `count` shots out among the tiles: fills `scratch.visits`.
    pub(super) fn allocate(&mut self, count: usize) {
        let c = &self.config;
        let s = &mut self.scratch;
        // A batch reaches a fifth of the tiles, and a square root for each costs.
        for tile in self.learned.drain(..) {
            let (i, tile) = (tile as usize, &self.tiles[tile as usize]);
            let merit = if c.residuals { tile.merit(c) } else { 1.0 };
            self.errors[i] = merit * self.grid.areas[i];
            self.filled[i] = if c.water_filling { tile.samples } else { 0.0 };
        }
        let mut errors = &self.errors;
        if self.guidance.guides() {
            s.errors.clear();
            let costs = (0..errors.len()).map(|i| errors[i] / self.guidance.cost(i));
            s.errors.extend(costs);
            errors = &s.errors;
        }
        let (level, _) = allocate::water_level(errors, &self.filled, count as f32, self.level);
        self.level = level;
        let everywhere = c.uniform_share * count as f32 / (self.grid.size.element_product() as f32);
        s.shares.clear();
        let tiles = errors.iter().zip(&self.filled).zip(&self.grid.areas);
        s.shares.extend(tiles.map(|((error, filled), area)| {
            let due = (level * error - filled).max(0.0) * (1.0 - c.uniform_share);
            due + everywhere * area
        }));
        allocate::visits(
            &self.order,
            &s.shares,
            count,
            self.random.unit(),
            &mut s.dues,
            &mut s.visits,
        );
    }

    /// Plans the visits as the shots `first..` of the span.
    pub(super) fn plan(&mut self, span: Span, first: usize) {
        self.scratch.plans.clear();
        self.scratch.intents.clear();
        let count = self.scratch.visits.len();
        let stride = golden_stride(count);
        let evenly = count as f32 / self.grid.size.element_product() as f32;
        let mut at = self.random.below(count.max(1) as u32) as usize;
        // Where no effect was met there is no sequence to go on with.
        let points = !self.config.guidance || self.guidance.guides();
        for i in 0..count {
            let tile = self.scratch.visits[at];
            at += stride;
            if at >= count {
                at -= count;
            }
            let again = self.random.unit() < self.look_share;
            let (place, front) = self.aim(tile, again);
            let place = within(place * SIDE as f32, self.image);
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
            let mut care = (self.guidance).care(tile, &self.tiles[tile as usize], &self.config);
            let mut seed = self.random.next();
            if front != NONE {
                let cell = &self.cells.pool[front as usize];
                intent.cell = front;
                (intent.colour, intent.born) = (cell.kept(), cell.born);
                if care.pattern {
                    (seed, care) = cell.points.get();
                }
                aim = Aim::Again {
                    object: cell.object,
                    local: cell.local,
                    instead: place,
                };
            } else if care.pattern && points {
                seed = self.pattern.seed(place, care);
            }
            self.scratch.plans.push(Plan {
                time,
                aim,
                seed,
                care,
            });
            self.scratch.intents.push(intent);
        }
    }

    /// A place in a tile, of the map: the next point of the tile's sequence; for a second look a
    /// random one and the cell there, or [`NONE`].
    fn aim(&mut self, tile: u32, again: bool) -> (Vec2, u32) {
        let (corner, size) = self.grid.rect(tile);
        let place = |point: Vec2| corner.as_vec2() + point * size.as_vec2();
        if again {
            let place = place(Vec2::new(self.random.unit(), self.random.unit()));
            let spot = self.cells.plane.get(self.cells.pixel(place) as usize);
            return (place, spot.map_or(NONE, |spot| spot.front));
        }
        let taken = &mut self.taken[tile as usize];
        let point = self.points.nth(*taken);
        *taken = taken.wrapping_add(1);
        (place(point), NONE)
    }
}
