//! What the sampler remembers: a pool of cells, at most about one for each pixel of the map and
//! surface. Pixels here are those of the map.
//!
//! A cell stands for the samples that fell on one pixel's worth of a surface. It keeps the place
//! of the newest of them *in its object's coordinates*, so that it moves as the surface moves.
//! Once an epoch the pool is walked in memory order: each cell ages, is projected to the view of
//! the epoch and takes its pixel in the planes (`front`, `back`: indices of cells), which are
//! small enough to stay in cache. Cells that meet in a pixel at one depth merge; otherwise the
//! nearer is in front and the other waits behind it. Cells outside the image wait unseen.

use glam::{UVec2, Vec2, Vec3};

use super::SIDE;
use super::config::Config;
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
    /// Place of the newest sample in its object's coordinates, metres.
    pub(super) local: Vec3,
    /// Instant of the newest sample, seconds after the instant of the map (before: negative).
    pub(super) born: f32,
    /// Mean displayed colour, 0..=255.
    pub(super) mean: Vec3,
    /// Samples that it stands for, the old ones discounted; 0 is a dead cell.
    pub(super) weight: f32,
    /// Displayed colour of the newest sample, rounded.
    pub(super) newest: [u8; 3],
    /// Object id.
    pub(super) object: u8,
    /// The points that the newest sample took of lamps and media: a second look sees the same.
    pub(super) points: Points,
    /// Where it was last seen; [`NONE`] outside the image.
    pub(super) pixel: u32,
    /// Depth along the axis, metres.
    pub(super) depth: f32,
    /// Residuals: Σ b and Σ b·r², r in displayed levels.
    pub(super) residuals: [f32; 2],
    /// Gradients: Σ Δc² (displayed levels²) and Σ Δt² (s²) of verified samples.
    pub(super) gradients: [f32; 2],
}

const _: () = assert!(size_of::<Cell>() == 64);

impl Cell {
    /// Displayed colour of the newest sample.
    pub(super) fn newest(&self) -> Vec3 {
        Vec3::from(self.newest.map(f32::from))
    }

    /// Adds what another cell of the same surface knows; the newer place stays.
    fn merge(&mut self, other: &Cell) {
        let weight = self.weight + other.weight;
        self.mean += (other.mean - self.mean) * (other.weight / weight.max(1e-6));
        self.weight = weight;
        for k in 0..2 {
            self.residuals[k] += other.residuals[k];
            self.gradients[k] += other.gradients[k];
        }
        if other.born > self.born {
            (self.local, self.born, self.newest) = (other.local, other.born, other.newest);
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
    /// Factor of the weight of cells outside the image.
    pub(super) unseen: f32,
    /// Factor of the residuals.
    pub(super) residuals: f32,
    /// Factor of the gradients.
    pub(super) gradients: f32,
}

/// A pixel of the planes: one look-up for all that is asked of it.
///
/// Invariant: `front` and `back` are [`NONE`] or indices of living cells whose `pixel` is this.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// The nearest cell.
    pub(super) front: u32,
    /// The cell that waits behind it.
    back: u32,
    /// Depth of the front cell, metres; infinite without one.
    depth: f32,
    /// Weight of the front cell; 0 without one.
    pub(super) cover: f32,
}

impl Spot {
    const EMPTY: Self = Self {
        front: NONE,
        back: NONE,
        depth: f32::INFINITY,
        cover: 0.0,
    };
}

/// The pool and its planes.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub(super) size: UVec2,
    pub(super) pool: Vec<Cell>,
    pub(super) plane: Vec<Spot>,
    hidden: Vec<u32>,
    second_layer: bool,
    hidden_test: bool,
    guard: f32,
}

impl Cells {
    pub(super) fn new(size: UVec2, config: &Config) -> Self {
        let pixels = (size.x * size.y) as usize;
        Self {
            size,
            pool: Vec::with_capacity(2 * pixels),
            plane: vec![Spot::EMPTY; pixels],
            hidden: Vec::new(),
            second_layer: config.second_layer,
            hidden_test: config.hidden_test,
            guard: config.guard / SIDE as f32,
        }
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.pool.clear();
        self.clear_planes();
    }

    fn clear_planes(&mut self) {
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

    fn guarded(&self, at: Option<Vec2>) -> bool {
        if self.guard == f32::INFINITY {
            return true;
        }
        at.is_some_and(|at| {
            let beyond = (-at).max(at - self.size.as_vec2()).max_element();
            beyond < self.guard
        })
    }

    /// Moves every cell to a new view. `tile_of` gives a pixel's lifetime tile.
    pub(super) fn warp(
        &mut self,
        projection: &Projection,
        fading: &Fading,
        tile_of: impl Fn(u32) -> usize,
    ) {
        self.clear_planes();
        // A pool that overflows (many cells outside the image) sheds the faintest first.
        let crowded = self.pool.len() > 3 * self.plane.len();
        let least = if crowded { 0.3 } else { FORGOTTEN };
        let mut kept = 0;
        for i in 0..self.pool.len() {
            let mut cell = self.pool[i];
            if cell.weight <= 0.0 {
                continue;
            }
            cell.born -= fading.step;
            cell.weight *= if cell.pixel == NONE {
                fading.unseen
            } else {
                fading.weights[tile_of(cell.pixel)]
            };
            cell.residuals = cell.residuals.map(|r| r * fading.residuals);
            cell.gradients = cell.gradients.map(|g| g * fading.gradients);
            if cell.weight < least {
                continue;
            }
            let seen = projection.project(cell.object, cell.local);
            cell.pixel = seen.map_or(NONE, |(at, _)| self.pixel(at));
            cell.depth = seen.map_or(f32::INFINITY, |(_, depth)| depth);
            if cell.pixel == NONE && !self.guarded(seen.map(|(at, _)| at)) {
                continue;
            }
            let at = seen.map_or(Vec2::ZERO, |(at, _)| at);
            self.pool[kept] = cell;
            if cell.pixel == NONE || self.insert(kept as u32, at) {
                kept += 1;
            }
        }
        self.pool.truncate(kept);
        if self.hidden_test {
            self.hide();
        }
    }

    /// Gives a cell its place in the planes. False if it is not needed any more: merged into
    /// another, or hidden and not to be remembered.
    fn insert(&mut self, index: u32, at: Vec2) -> bool {
        let cell = self.pool[index as usize];
        let pixel = cell.pixel as usize;
        let front = self.plane[pixel].front;
        if front == NONE {
            self.bring_forward(pixel, index, &cell);
            return true;
        }
        if same_depth(cell.depth, self.plane[pixel].depth) {
            if let Some(free) = self.free_beside(at) {
                self.pool[index as usize].pixel = free as u32;
                self.bring_forward(free, index, &cell);
                return true;
            }
            let other = &mut self.pool[front as usize];
            other.merge(&cell);
            self.plane[pixel].depth = other.depth;
            self.plane[pixel].cover = other.weight;
            return false;
        }
        if cell.depth < self.plane[pixel].depth {
            self.bring_forward(pixel, index, &cell);
            self.hide_front(front);
            return true;
        }
        self.hide_behind(index)
    }

    /// Puts a cell that is no longer in front behind the front cell of its pixel, or forgets it.
    fn hide_front(&mut self, index: u32) {
        if !self.hide_behind(index) {
            self.pool[index as usize].weight = 0.0;
        }
    }

    /// Makes a cell the front one of a pixel.
    fn bring_forward(&mut self, pixel: usize, index: u32, cell: &Cell) {
        self.plane[pixel].front = index;
        self.plane[pixel].depth = cell.depth;
        self.plane[pixel].cover = cell.weight;
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

    /// Puts a cell behind the front cell of its pixel. False if it is not needed any more.
    fn hide_behind(&mut self, index: u32) -> bool {
        if !self.second_layer {
            return false;
        }
        let cell = self.pool[index as usize];
        let back = self.plane[cell.pixel as usize].back;
        if back == NONE {
            self.plane[cell.pixel as usize].back = index;
            return true;
        }
        let other = self.pool[back as usize];
        if same_depth(cell.depth, other.depth) {
            self.pool[back as usize].merge(&cell);
            return false;
        }
        // A third surface in one pixel: the two nearest are remembered.
        if cell.depth < other.depth {
            self.plane[cell.pixel as usize].back = index;
            self.pool[back as usize].weight = 0.0;
            return true;
        }
        false
    }

    /// Takes cells out of the front plane that shine through the gaps of a nearer surface: at
    /// least seven of their 3×3 pixels are nearer.
    fn hide(&mut self) {
        let (w, h) = (self.size.x as usize, self.size.y as usize);
        if w < 3 || h < 3 {
            return;
        }
        self.hidden.clear();
        let mut nearer = vec![0u8; w - 2];
        let plane = &self.plane;
        let line = |y: usize| plane[y * w..(y + 1) * w].iter().map(|spot| spot.depth);
        let mut rows: [Vec<f32>; 3] = core::array::from_fn(|y| line(y).collect());
        for y in 1..h - 1 {
            let [above, here, below] = &rows;
            nearer.fill(0);
            let limit = |z: f32| (z - 0.003) * (1.0 / 1.05);
            // One neighbour at a time for the whole row: loops that the compiler vectorises.
            for (row, shift) in [above, here, below]
                .into_iter()
                .flat_map(|r| (0..3).map(move |s| (r, s)))
            {
                let others = &row[shift..shift + w - 2];
                for ((count, z), other) in nearer.iter_mut().zip(&here[1..w - 1]).zip(others) {
                    *count += u8::from(*other < limit(*z));
                }
            }
            for (x, count) in nearer.iter().enumerate() {
                if *count >= 7 && here[x + 1] < f32::INFINITY {
                    self.hidden.push((y * w + x + 1) as u32);
                }
            }
            rows.rotate_left(1);
            if y + 2 < h {
                rows[2].clear();
                rows[2].extend(line(y + 2));
            }
        }
        for i in 0..self.hidden.len() {
            let pixel = self.hidden[i] as usize;
            let front = self.plane[pixel].front;
            self.plane[pixel].front = NONE;
            self.plane[pixel].depth = f32::INFINITY;
            self.plane[pixel].cover = 0.0;
            self.hide_front(front);
        }
    }

    /// Takes a new sample in, seen at `at` (pixel coordinates in the map's view) and `depth`
    /// metres. Returns its cell. What was just seen stands in front: a nearer cell in its pixel
    /// is either of an edge and returns with the next warp, or outdated and fades.
    pub(super) fn deposit(&mut self, fresh: &Fresh, at: Vec2, depth: f32) -> u32 {
        let pixel = self.pixel(at);
        let front = if pixel == NONE {
            NONE
        } else {
            self.plane[pixel as usize].front
        };
        if front != NONE && same_depth(depth, self.plane[pixel as usize].depth) {
            let cell = &mut self.pool[front as usize];
            cell.weight += 1.0;
            cell.mean += (fresh.colour - cell.mean) / cell.weight;
            cell.refresh(fresh, depth);
            self.plane[pixel as usize].depth = depth;
            self.plane[pixel as usize].cover = cell.weight;
            return front;
        }
        let index = self.pool.len() as u32;
        let mut cell = Cell {
            local: fresh.local,
            born: fresh.born,
            mean: fresh.colour,
            weight: 1.0,
            newest: [0; 3],
            object: fresh.object,
            points: fresh.points,
            pixel,
            depth,
            residuals: [0.0; 2],
            gradients: [0.0; 2],
        };
        cell.refresh(fresh, depth);
        self.pool.push(cell);
        if pixel != NONE {
            if front != NONE {
                if self.pool[front as usize].depth < depth {
                    self.pool[front as usize].weight *= 0.5;
                }
                self.hide_front(front);
            }
            self.plane[pixel as usize].front = index;
            self.plane[pixel as usize].depth = depth;
            self.plane[pixel as usize].cover = 1.0;
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
        cell.refresh(fresh, depth);
        if cell.pixel != NONE && self.plane[cell.pixel as usize].front == index {
            self.plane[cell.pixel as usize].cover = cell.weight;
        }
    }

    /// Forgets a cell.
    pub(super) fn kill(&mut self, index: u32) {
        let cell = &mut self.pool[index as usize];
        cell.weight = 0.0;
        let pixel = cell.pixel as usize;
        if cell.pixel != NONE {
            if self.plane[pixel].front == index {
                self.plane[pixel].front = NONE;
                self.plane[pixel].depth = f32::INFINITY;
                self.plane[pixel].cover = 0.0;
            }
            if self.plane[pixel].back == index {
                self.plane[pixel].back = NONE;
            }
        }
    }
}

impl Cell {
    /// Makes a sample the newest of its cell.
    fn refresh(&mut self, fresh: &Fresh, depth: f32) {
        (self.local, self.born, self.object) = (fresh.local, fresh.born, fresh.object);
        (self.depth, self.points) = (depth, fresh.points);
        self.newest = fresh.colour.to_array().map(|c| (c + 0.5) as u8);
    }

    /// How far a colour is from this cell's mean, squared levels.
    pub(super) fn residual(&self, colour: Vec3) -> f32 {
        squared_difference(self.mean, colour)
    }
}
