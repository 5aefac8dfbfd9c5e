//! What the sampler remembers: a pool of cells, about one for each pixel of the map. Pixels here
//! are those of the map.
//!
//! A cell stands for the samples that fell on one pixel's worth of a surface. It keeps the place
//! of one of them *in its object's coordinates*, so that it moves as the surface moves: the one that
//! a second look would compare with, which stays until it is a lifetime old.
//! Once an epoch the pool is walked in memory order: each cell ages, is projected to the view of
//! the epoch and takes its pixel in the plane (of indices of cells), which is small enough to stay
//! in cache. Cells that meet in a pixel at one depth merge; otherwise the nearer stays. What is
//! hidden or outside the image is forgotten: to remember it (a second layer, a guard band of 32
//! pixels), and to take out what shines through a nearer surface's gaps, was worth less than 1 %.

use glam::{UVec2, Vec2, Vec3};

use super::guidance::Points;
use super::projection::{Projection, same_depth};
use crate::sampler::srgb::squared_difference;

/// No cell.
pub(super) const NONE: u32 = u32::MAX;
/// Cells whose weight falls below this are forgotten.
const FORGOTTEN: f32 = 0.02;

/// The memory of a pixel's worth of surface.
///
/// One cache line: most cells are met in no order that a cache could foresee.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Cell {
    /// Place of the sample kept for a second look, in its object's coordinates, metres.
    pub(super) local: Vec3,
    /// Its instant, seconds after the instant of the map (before: negative).
    pub(super) born: f32,
    /// Mean displayed colour, 0..=255.
    pub(super) mean: Vec3,
    /// Samples that it stands for, the old ones discounted; 0 is a dead cell.
    pub(super) weight: f32,
    /// Its displayed colour, rounded.
    pub(super) kept: [u8; 3],
    /// Its object's id.
    pub(super) object: u8,
    /// The points that it took of lamps and media: a second look sees the same.
    pub(super) points: Points,
    /// Where it was last seen; [`NONE`] outside the image.
    pub(super) pixel: u32,
    /// Depth of what was last seen there along the axis, metres.
    pub(super) depth: f32,
    /// Residuals: Σ b and Σ b·r², r in displayed levels.
    pub(super) residuals: [f32; 2],
    /// Gradients: Σ Δc² (displayed levels²) and Σ Δt² (s²) of verified samples.
    pub(super) gradients: [f32; 2],
}

const _: () = assert!(size_of::<Cell>() == 64);

impl Cell {
    /// Displayed colour of the sample kept for a second look.
    pub(super) fn kept(&self) -> Vec3 {
        Vec3::from(self.kept.map(f32::from))
    }

    /// Adds what another cell of the same surface knows; the newer of the kept samples stays.
    fn merge(&mut self, other: &Cell) {
        let weight = self.weight + other.weight;
        self.mean += (other.mean - self.mean) * (other.weight / weight.max(1e-6));
        self.weight = weight;
        for k in 0..2 {
            self.residuals[k] += other.residuals[k];
            self.gradients[k] += other.gradients[k];
        }
        if other.born > self.born {
            (self.local, self.born, self.kept) = (other.local, other.born, other.kept);
            (self.object, self.depth) = (other.object, other.depth);
            self.points = other.points;
        }
    }
}

/// A new sample as the cells see it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fresh {
    pub(super) local: Vec3,
    pub(super) object: u8,
    /// Displayed colour, 0..=255.
    pub(super) colour: Vec3,
    /// Seconds after the instant of the map.
    pub(super) born: f32,
    /// The points that it took of lamps and media.
    pub(super) points: Points,
}

/// How things fade from one epoch to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Fading {
    /// Seconds between the two maps.
    pub(super) step: f32,
    /// Factor of the weights in each lifetime tile.
    pub(super) weights: Vec<f32>,
    /// Factor of the residuals.
    pub(super) residuals: f32,
    /// Factor of the gradients.
    pub(super) gradients: f32,
}

/// A pixel of the plane: one look-up for all that is asked of it.
///
/// Invariant: `front` is [`NONE`] or the index of a living cell whose `pixel` is this.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// The nearest cell.
    pub(super) front: u32,
    /// Its depth, metres.
    depth: f32,
}

impl Spot {
    const EMPTY: Self = Self {
        front: NONE,
        depth: f32::INFINITY,
    };
}

/// The pool and its plane.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub(super) size: UVec2,
    pub(super) pool: Vec<Cell>,
    pub(super) plane: Vec<Spot>,
}

impl Cells {
    pub(super) fn new(size: UVec2) -> Self {
        let pixels = (size.x * size.y) as usize;
        Self {
            size,
            pool: Vec::with_capacity(2 * pixels),
            plane: vec![Spot::EMPTY; pixels],
        }
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.pool.clear();
        self.plane.fill(Spot::EMPTY);
    }

    /// The pixel at pixel coordinates, [`NONE`] outside the image.
    pub(super) fn pixel(&self, at: Vec2) -> u32 {
        let inside = at.x >= 0.0 && at.y >= 0.0;
        // Casts saturate, so that the far side of a wide projection cannot wrap.
        let (x, y) = (at.x as u32, at.y as u32);
        if inside && x < self.size.x && y < self.size.y {
            y * self.size.x + x
        } else {
            NONE
        }
    }

    /// Moves every cell to a new view; what leaves the image is forgotten. `tiles` are the lifetime
    /// tiles of pixels.
    pub(super) fn warp(&mut self, projection: &Projection, fading: &Fading, tiles: &[u32]) {
        self.plane.fill(Spot::EMPTY);
        let mut kept = 0;
        for i in 0..self.pool.len() {
            let mut cell = self.pool[i];
            if cell.pixel != NONE {
                cell.weight *= fading.weights[tiles[cell.pixel as usize] as usize];
            }
            if cell.weight < FORGOTTEN {
                continue;
            }
            let Some((at, depth)) = projection.project(cell.object, cell.local) else {
                continue;
            };
            cell.pixel = self.pixel(at);
            if cell.pixel == NONE {
                continue;
            }
            cell.depth = depth;
            cell.born -= fading.step;
            cell.residuals = cell.residuals.map(|r| r * fading.residuals);
            cell.gradients = cell.gradients.map(|g| g * fading.gradients);
            self.pool[kept] = cell;
            kept += usize::from(self.insert(kept as u32, at));
        }
        self.pool.truncate(kept);
    }

    /// Gives a cell its place in the plane. False if it is not needed any more: hidden, or merged
    /// into another.
    fn insert(&mut self, index: u32, at: Vec2) -> bool {
        let cell = self.pool[index as usize];
        let Spot { front, depth } = self.plane[cell.pixel as usize];
        if front == NONE {
            self.bring_forward(index);
        } else if same_depth(cell.depth, depth) {
            if let Some(free) = self.free_beside(at) {
                self.pool[index as usize].pixel = free as u32;
                self.bring_forward(index);
                return true;
            }
            let other = &mut self.pool[front as usize];
            other.merge(&cell);
            self.plane[cell.pixel as usize].depth = other.depth;
            return false;
        } else if cell.depth < depth {
            self.bring_forward(index);
        } else {
            return false;
        }
        true
    }

    /// Makes a cell the front one of its pixel; the one that was is forgotten.
    fn bring_forward(&mut self, index: u32) {
        let Cell { pixel, depth, .. } = self.pool[index as usize];
        let spot = &mut self.plane[pixel as usize];
        if spot.front != NONE {
            self.pool[spot.front as usize].weight = 0.0;
        }
        *spot = Spot {
            front: index,
            depth,
        };
    }

    /// The pixel next to the one of the place `at`, on its side, if it is free. Two cells of a
    /// surface fall into one pixel and none into the next wherever the pixel grid moves over it:
    /// if they merged each time, a moving view would eat its memory up within a few epochs.
    fn free_beside(&self, at: Vec2) -> Option<usize> {
        let (w, h) = (self.size.x as usize, self.size.y as usize);
        // `at` lies in the pixel: no division is needed to find its place.
        let (x, y) = (at.x as usize, at.y as usize);
        let off = at - Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let step = |at: usize, off: f32, size: usize| {
            let to = if off < 0.0 {
                at.checked_sub(1)?
            } else {
                at + 1
            };
            (to < size).then_some(to)
        };
        let beside = step(x, off.x, w).map(|x| y * w + x);
        let above = step(y, off.y, h).map(|y| y * w + x);
        let nearest = if off.x.abs() >= off.y.abs() {
            [beside, above]
        } else {
            [above, beside]
        };
        nearest
            .into_iter()
            .flatten()
            .find(|&p| self.plane[p].front == NONE)
    }

    /// Takes a new sample in, seen at `at` (pixel coordinates in the map's view) and `depth`
    /// metres. Returns its cell, which keeps the sample it has for `hold` seconds. What was just seen
    /// stands in front: a nearer cell in its pixel is either of an edge or outdated.
    pub(super) fn deposit(&mut self, fresh: &Fresh, at: Vec2, depth: f32, hold: f32) -> u32 {
        let pixel = self.pixel(at);
        let spot = self.plane.get_mut(pixel as usize);
        if let Some(spot) = spot
            && let Some(cell) = self.pool.get_mut(spot.front as usize)
            && same_depth(depth, spot.depth)
        {
            cell.weight += 1.0;
            cell.mean += (fresh.colour - cell.mean) / cell.weight;
            if cell.object != fresh.object || fresh.born - cell.born >= hold {
                cell.keep(fresh);
            }
            (cell.depth, spot.depth) = (depth, depth);
            return spot.front;
        }
        let index = self.pool.len() as u32;
        let mut cell = Cell {
            local: fresh.local,
            born: fresh.born,
            mean: fresh.colour,
            weight: 1.0,
            kept: [0; 3],
            object: fresh.object,
            points: fresh.points,
            pixel,
            depth,
            residuals: [0.0; 2],
            gradients: [0.0; 2],
        };
        cell.keep(fresh);
        self.pool.push(cell);
        if pixel != NONE {
            self.bring_forward(index);
        }
        index
    }

    /// Takes a second look at a cell in: its place, seen again at `depth`.
    pub(super) fn confirm(&mut self, index: u32, fresh: &Fresh, depth: f32, outdated: bool) {
        let cell = &mut self.pool[index as usize];
        if outdated {
            (cell.weight, cell.mean) = (1.0, fresh.colour);
        } else {
            cell.weight += 1.0;
            cell.mean += (fresh.colour - cell.mean) / cell.weight;
        }
        cell.keep(fresh);
        cell.depth = depth;
    }

    /// Forgets a cell.
    pub(super) fn kill(&mut self, index: u32) {
        let cell = &mut self.pool[index as usize];
        cell.weight = 0.0;
        if let Some(spot) = self.plane.get_mut(cell.pixel as usize)
            && spot.front == index
        {
            *spot = Spot::EMPTY;
        }
    }
}

impl Cell {
    /// Keeps a sample for a second look.
    fn keep(&mut self, fresh: &Fresh) {
        (self.local, self.born, self.object) = (fresh.local, fresh.born, fresh.object);
        self.points = fresh.points;
        self.kept = fresh.colour.to_array().map(|c| (c + 0.5) as u8);
    }

    /// How far a colour is from this cell's mean, squared levels.
    pub(super) fn residual(&self, colour: Vec3) -> f32 {
        squared_difference(self.mean, colour)
    }
}
