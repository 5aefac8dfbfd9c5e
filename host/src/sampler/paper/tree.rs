//! The whole k-d tree over the image, each node with the sums of its block of the deep buffer.
//!
//! The leaves are single pixels; a pixel's sums are those of its queue and a node's those of its
//! halves, so a crosshair that comes or goes costs O(log pixels). The sums of every tile that a cut
//! could have are always at hand, and moving the cut costs nothing but moving the cut: no sample is
//! touched by a split or a merge. Nothing is ever subtracted: where a new sample has left a block
//! of old ones, whose weights are smaller by many orders, rounding would have eaten them.
//!
//! **Weights.** A sample counts with e^(−3.47·age) (§4). Only ratios of sums are ever used, and
//! ratios do not change when all weights change by one factor; so a weight is e^(3.47·time), set
//! once, and time alone changes nothing. What would overflow is *rebased*: all sums are multiplied
//! by a power of two, which is exact.

use glam::UVec2;
use unframed_wire::Rect;
use unframed_wire::tiles::{Axis, split};

/// No node.
pub(super) const NONE: u32 = u32::MAX;

/// Doublings of a weight at which sums are rebased: 102 s of the paper's decline.
const REBASE: i32 = 512;

/// What the statistics keep of a crosshair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Entry {
    /// When it was taken, seconds.
    pub(super) time: f64,
    /// Luminance of the centre as displayed, 0..=1.
    pub(super) luminance: f32,
    /// |dL/dx|, |dL/dy| (1/pixel) and |dL/dt| (1/s).
    pub(super) gradients: [f32; 3],
    /// Whether it took the place of an occluded one.
    pub(super) occluded: bool,
}

/// Sums over the crosshairs of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sums {
    /// How many.
    pub(super) count: u32,
    /// Σw.
    pub(super) weight: f64,
    /// Σw·L and Σw·L².
    pub(super) light: [f64; 2],
    /// Σw·G.
    pub(super) gradients: [f64; 3],
    /// Σw of those that took the place of occluded ones.
    pub(super) occluded: f64,
    /// Σ of times, seconds, without weights.
    pub(super) times: f64,
}

impl Sums {
    /// Adds an entry of weight `w`.
    fn add(&mut self, entry: &Entry, w: f64) {
        let l = f64::from(entry.luminance);
        self.count += 1;
        self.weight += w;
        self.light[0] += w * l;
        self.light[1] += w * l * l;
        for (sum, g) in self.gradients.iter_mut().zip(entry.gradients) {
            *sum += w * f64::from(g);
        }
        if entry.occluded {
            self.occluded += w;
        }
        self.times += entry.time;
    }

    /// The sums of two blocks.
    fn join(a: &Self, b: &Self) -> Self {
        let add = |k: usize| a.gradients[k] + b.gradients[k];
        Self {
            count: a.count + b.count,
            weight: a.weight + b.weight,
            light: [a.light[0] + b.light[0], a.light[1] + b.light[1]],
            gradients: [add(0), add(1), add(2)],
            occluded: a.occluded + b.occluded,
            times: a.times + b.times,
        }
    }

    fn scale(&mut self, factor: f64) {
        let Self {
            weight,
            light,
            gradients,
            occluded,
            ..
        } = self;
        for sum in [weight, occluded].into_iter().chain(light).chain(gradients) {
            *sum *= factor;
        }
    }

    /// Weighted variance of luminance: the paper's v_tile (§4).
    pub(super) fn variance(&self) -> f64 {
        let mean = self.light[0] / self.weight;
        // Rounding may leave a little less than nothing.
        (self.light[1] / self.weight - mean * mean).max(0.0)
    }

    /// Mean gradients.
    pub(super) fn mean_gradients(&self) -> [f64; 3] {
        self.gradients.map(|g| (g / self.weight).max(0.0))
    }

    /// The weight's share of what took the place of occluded ones, 0..=1.
    pub(super) fn occluded_share(&self) -> f64 {
        (self.occluded / self.weight).clamp(0.0, 1.0)
    }
}

/// One possible tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Its pixels.
    pub(super) rect: Rect,
    /// How it is halved.
    pub(super) axis: Axis,
    /// Its halves; [`NONE`] for a pixel.
    pub(super) halves: [u32; 2],
    /// The tile it is half of; [`NONE`] for the root.
    pub(super) parent: u32,
}

impl Node {
    /// Pixels.
    pub(super) fn area(&self) -> u32 {
        u32::from(self.rect.w) * u32::from(self.rect.h)
    }
}

/// The tree. Node 0 is the root; every node's rectangle is the one that the wire's splits give.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    sums: Vec<Sums>,
    /// The leaf of each pixel.
    home: Vec<u32>,
    width: u32,
    /// Doublings of weight a second: 3.47·log2 e.
    doublings: f64,
    /// Weights are 2^(`doublings`·time − `base`).
    base: i32,
}

impl Tree {
    /// Of an image; `decline` in 1/s.
    pub(super) fn new(size: UVec2, decline: f64) -> Self {
        let root = Rect {
            x: 0,
            y: 0,
            w: size.x as u16,
            h: size.y as u16,
        };
        let mut tree = Self {
            nodes: Vec::new(),
            sums: Vec::new(),
            home: vec![NONE; (size.x * size.y) as usize],
            width: size.x,
            doublings: decline * std::f64::consts::LOG2_E,
            base: 0,
        };
        tree.grow(root, NONE);
        tree.sums = vec![Sums::default(); tree.nodes.len()];
        tree
    }

    fn grow(&mut self, rect: Rect, parent: u32) -> u32 {
        let id = self.nodes.len() as u32;
        let axis = if rect.w >= rect.h { Axis::X } else { Axis::Y };
        self.nodes.push(Node {
            rect,
            axis,
            halves: [NONE; 2],
            parent,
        });
        match split(rect, axis) {
            Some((first, second)) => {
                let halves = [first, second].map(|half| self.grow(half, id));
                self.nodes[id as usize].halves = halves;
            }
            None => {
                let pixel = u32::from(rect.y) * self.width + u32::from(rect.x);
                self.home[pixel as usize] = id;
            }
        }
        id
    }

    pub(super) fn sums(&self, node: u32) -> &Sums {
        &self.sums[node as usize]
    }

    /// The leaf of a pixel.
    pub(super) fn home(&self, pixel: u32) -> u32 {
        self.home[pixel as usize]
    }

    /// The weight of a time: apart from the power of two the same whatever the base.
    fn weight(&self, time: f64) -> f64 {
        let doublings = self.doublings * time;
        let whole = doublings.floor();
        (doublings - whole).exp2() * 2.0f64.powi(whole as i32 - self.base)
    }

    /// Takes the queue of a pixel over as it now is.
    pub(super) fn set(&mut self, pixel: u32, queue: impl Iterator<Item = Entry>) {
        let mut sums = Sums::default();
        for entry in queue {
            while self.doublings * entry.time > f64::from(self.base + REBASE) {
                self.rebase();
                sums.scale(2.0f64.powi(-REBASE));
            }
            sums.add(&entry, self.weight(entry.time));
        }
        let leaf = self.home(pixel);
        self.sums[leaf as usize] = sums;
        let mut node = self.nodes[leaf as usize].parent;
        while node != NONE {
            let Node { halves, parent, .. } = self.nodes[node as usize];
            let [a, b] = halves.map(|half| &self.sums[half as usize]);
            self.sums[node as usize] = Sums::join(a, b);
            node = parent;
        }
    }

    fn rebase(&mut self) {
        self.base += REBASE;
        let factor = 2.0f64.powi(-REBASE);
        self.sums.iter_mut().for_each(|sums| sums.scale(factor));
    }

    /// The sums of a tile or, where it has under two crosshairs (or all so old that their weights
    /// have vanished), those of the smallest tile around it that has two; `None` when the whole
    /// image has not.
    pub(super) fn known(&self, mut node: u32) -> Option<&Sums> {
        while self.sums[node as usize].count < 2 || !self.sums[node as usize].weight.is_normal() {
            node = self.nodes[node as usize].parent;
            if node == NONE {
                return None;
            }
        }
        Some(self.sums(node))
    }
}
