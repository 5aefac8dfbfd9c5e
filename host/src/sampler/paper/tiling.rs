//! The tiling: a cut of the k-d tree that follows the error of its tiles (§4).
//!
//! "The tile with the most color variation is split and the two tiles with the least summed
//! variation are merged, until all tiles have roughly equal variation." Both are on top of a heap:
//! that of the tiles that can be halved, by error, and that of the nodes whose halves are both
//! tiles, by the least sum. A split or merge is O(log tiles).
//!
//! **Eras.** An error is a share in sums over all tiles, so that each change would change every
//! key of the heaps. The sums are therefore those of the beginning of an *era*, which lasts as
//! many changes of tiles as there are tiles; then all is summed up and keyed anew. That is
//! O(tiles) in an era: O(1) a change.

use unframed_wire::tiles::TileNode;
use unframed_wire::{LogCode, Tile, TileFields};

use super::buffer::DeepBuffer;
use super::config::Config;
use super::crosshair::{Crosshair, Initial};
use super::error::{self, Norms, Terms};
use super::heap::Heap;
use super::tree::{NONE, Tree};
use crate::sampler::kdtree::log_code;

/// What is kept of a tile of the cut.
#[derive(Clone, Copy, Debug, Default)]
struct Leaf {
    terms: Terms,
    /// E.
    error: f64,
    /// Area times spatial gradient, area times temporal gradient, mean time of the samples,
    /// whether there are samples: what the image's averages are made of.
    shares: [f64; 4],
    dirty: bool,
    initial: Option<Initial>,
}

/// The cut and its heaps.
///
/// Invariants: every pixel has exactly one node of the cut among its leaf and the nodes above it;
/// `splits` holds the nodes of the cut that may be halved, keyed by error; `merges`
/// holds the nodes whose halves are both in the cut, keyed by minus the sum of their errors.
#[derive(Clone, Debug)]
pub(super) struct Tiling {
    pub(super) tree: Tree,
    /// Nodes of the cut, in no order, for a uniform choice.
    cut: Vec<u32>,
    /// Where each node stands in `cut`; [`NONE`] for others.
    place: Vec<u32>,
    /// Side of the smallest tile, pixels.
    finest: u16,
    /// b: places of the deep buffer at each pixel.
    depth: u16,
    leaves: Vec<Leaf>,
    splits: Heap,
    merges: Heap,
    dirty: Vec<u32>,
    norms: Norms,
    /// Changes of tiles left of the era.
    era: u32,
    /// Sums of the leaves' shares.
    shares: [f64; 4],
    /// Splits and merges so far.
    pub(super) moves: [u64; 2],
}

impl Tiling {
    /// One tile, halved evenly until there are `config.tiles` or none can be halved.
    pub(super) fn new(tree: Tree, config: &Config) -> Self {
        let nodes = tree.nodes.len();
        let mut tiling = Self {
            cut: vec![0],
            place: vec![NONE; nodes],
            finest: config.finest,
            depth: config.depth.max(1),
            leaves: vec![Leaf::default(); nodes],
            splits: Heap::new(nodes),
            merges: Heap::new(nodes),
            dirty: Vec::new(),
            norms: Norms::default(),
            era: 0,
            shares: [0.0; 4],
            moves: [0; 2],
            tree,
        };
        tiling.place[0] = 0;
        if tiling.splittable(0) {
            tiling.splits.set(0, f64::from(tiling.tree.nodes[0].area()));
        }
        // Nothing is known: the largest tile first.
        while tiling.cut.len() < config.tiles as usize {
            let Some((node, _)) = tiling.splits.top() else {
                break;
            };
            tiling.split(node, config);
            for half in tiling.tree.nodes[node as usize].halves {
                if tiling.splittable(half) {
                    let area = f64::from(tiling.tree.nodes[half as usize].area());
                    tiling.splits.set(half, area);
                }
            }
        }
        tiling.new_era(config);
        tiling
    }

    /// Tiles of the cut.
    pub(super) fn len(&self) -> usize {
        self.cut.len()
    }

    /// The tile at a place of the list, `0..len`.
    pub(super) fn at(&self, index: u32) -> u32 {
        self.cut[index as usize]
    }

    /// The tile of a pixel.
    pub(super) fn of(&self, pixel: u32) -> u32 {
        let mut node = self.tree.home(pixel);
        while self.place[node as usize] == NONE {
            node = self.tree.nodes[node as usize].parent;
        }
        node
    }

    /// The sample that waits in a tile for its crosshair.
    pub(super) fn take_initial(&mut self, tile: u32) -> Option<Initial> {
        self.leaves[tile as usize].initial.take()
    }

    /// Leaves a sample to wait in the tile of a pixel.
    pub(super) fn set_initial(&mut self, pixel: u32, initial: Initial) {
        let tile = self.of(pixel);
        self.leaves[tile as usize].initial = Some(initial);
    }

    /// Takes over what a pixel's queue now holds.
    pub(super) fn update(&mut self, pixel: u32, buffer: &DeepBuffer) {
        self.tree
            .set(pixel, buffer.queue(pixel).map(Crosshair::entry));
        let tile = self.of(pixel);
        let leaf = &mut self.leaves[tile as usize];
        if !leaf.dirty {
            leaf.dirty = true;
            self.dirty.push(tile);
        }
    }

    /// Places of the deep buffer in a tile.
    fn places(&self, tile: u32) -> f64 {
        f64::from(self.tree.nodes[tile as usize].area()) * f64::from(self.depth)
    }

    /// Those of them that are empty.
    fn empty(&self, tile: u32) -> f64 {
        self.places(tile) - f64::from(self.tree.sums(tile).count)
    }

    fn terms(&self, tile: u32, config: &Config) -> Terms {
        let Some(known) = self.tree.known(tile) else {
            return [0.0; 3];
        };
        let count = f64::from(self.tree.sums(tile).count);
        [
            known.variance(),
            error::undersampling(self.empty(tile), self.norms.empty, config.undersampled),
            error::occlusion(known.occluded_share(), count, self.places(tile)),
        ]
    }

    /// Works a tile's statistics out anew.
    fn refresh(&mut self, tile: u32, config: &Config) {
        let area = f64::from(self.tree.nodes[tile as usize].area());
        let terms = self.terms(tile, config);
        let sums = self.tree.sums(tile);
        let timed = if sums.count > 0 { 1.0 } else { 0.0 };
        let time = sums.times / f64::from(sums.count.max(1));
        let [gx, gy, gt] = self
            .tree
            .known(tile)
            .map_or([0.0; 3], |s| s.mean_gradients());
        let leaf = &mut self.leaves[tile as usize];
        leaf.terms = terms;
        leaf.error = if config.adapt {
            error::error(terms, area, &self.norms, config)
        } else {
            area
        };
        let shares = [area * 0.5 * (gx + gy), area * gt, time, timed];
        for ((sum, new), old) in self.shares.iter_mut().zip(shares).zip(leaf.shares) {
            *sum += new - old;
        }
        leaf.shares = shares;
    }

    /// Puts a tile's error into the heaps.
    fn key(&mut self, tile: u32) {
        if self.splittable(tile) {
            self.splits.set(tile, self.leaves[tile as usize].error);
        }
        let parent = self.tree.nodes[tile as usize].parent;
        if parent != NONE && self.pair(parent) {
            self.merges.set(parent, -self.pair_error(parent));
        }
    }

    /// Whether a tile is larger than the smallest may be.
    fn splittable(&self, tile: u32) -> bool {
        let node = &self.tree.nodes[tile as usize];
        node.halves[0] != NONE && node.rect.w.max(node.rect.h) > self.finest
    }

    /// Whether both halves of a node are tiles.
    fn pair(&self, node: u32) -> bool {
        let halves = self.tree.nodes[node as usize].halves;
        halves[0] != NONE && halves.iter().all(|&h| self.place[h as usize] != NONE)
    }

    fn pair_error(&self, node: u32) -> f64 {
        let halves = self.tree.nodes[node as usize].halves;
        halves.iter().map(|&h| self.leaves[h as usize].error).sum()
    }

    /// Replaces a tile by its halves.
    fn split(&mut self, tile: u32, config: &Config) {
        self.moves[0] += 1;
        let node = self.tree.nodes[tile as usize];
        let initial = self.leaves[tile as usize].initial.take();
        self.leave(tile);
        if node.parent != NONE {
            self.merges.remove(node.parent);
        }
        for half in node.halves {
            self.enter(half, config);
            let rect = self.tree.nodes[half as usize].rect;
            let inside = |at: f32, from: u16, len: u16| {
                let at = at - f32::from(from);
                at >= 0.0 && at < f32::from(len)
            };
            self.leaves[half as usize].initial = initial
                .filter(|i| inside(i.place.x, rect.x, rect.w) && inside(i.place.y, rect.y, rect.h));
        }
        node.halves.into_iter().for_each(|half| self.key(half));
    }

    /// Replaces the two halves of a node by itself.
    fn merge(&mut self, node: u32, config: &Config) {
        self.moves[1] += 1;
        self.merges.remove(node);
        let halves = self.tree.nodes[node as usize].halves;
        let waiting = halves.map(|half| self.leaves[half as usize].initial.take());
        halves.into_iter().for_each(|half| self.leave(half));
        self.enter(node, config);
        // The later of two that wait stays.
        self.leaves[node as usize].initial = waiting
            .into_iter()
            .flatten()
            .max_by(|a, b| a.time.total_cmp(&b.time));
        self.key(node);
    }

    fn enter(&mut self, tile: u32, config: &Config) {
        self.place[tile as usize] = self.cut.len() as u32;
        self.cut.push(tile);
        self.refresh(tile, config);
    }

    fn leave(&mut self, tile: u32) {
        let place = std::mem::replace(&mut self.place[tile as usize], NONE);
        self.cut.swap_remove(place as usize);
        if let Some(&moved) = self.cut.get(place as usize) {
            self.place[moved as usize] = place;
        }
        self.splits.remove(tile);
        let leaf = std::mem::take(&mut self.leaves[tile as usize]);
        for (sum, share) in self.shares.iter_mut().zip(leaf.shares) {
            *sum -= share;
        }
    }

    /// Sums everything up and keys everything anew: O(tiles).
    fn new_era(&mut self, config: &Config) {
        self.era = self.cut.len() as u32;
        self.shares = [0.0; 4];
        let empty: f64 = self.empty(0);
        self.norms.empty = empty / self.cut.len() as f64;
        self.norms.sums = [0.0; 3];
        for i in 0..self.cut.len() {
            let tile = self.cut[i];
            self.leaves[tile as usize].terms = self.terms(tile, config);
            for (sum, term) in self
                .norms
                .sums
                .iter_mut()
                .zip(self.leaves[tile as usize].terms)
            {
                *sum += term;
            }
        }
        for i in 0..self.cut.len() {
            let tile = self.cut[i];
            self.leaves[tile as usize].shares = [0.0; 4];
            self.refresh(tile, config);
        }
        let leaves = &self.leaves;
        self.splits.rekey(|tile| leaves[tile as usize].error);
        let nodes = &self.tree.nodes;
        self.merges.rekey(|node| {
            let halves = nodes[node as usize].halves;
            -halves
                .iter()
                .map(|&h| leaves[h as usize].error)
                .sum::<f64>()
        });
    }

    /// Brings errors up to date and moves the cut towards `target` tiles of equal error, by at
    /// most `config.moves` splits and merges.
    pub(super) fn adjust(&mut self, target: u32, config: &Config) {
        let mut dirty = std::mem::take(&mut self.dirty);
        self.era = self.era.saturating_sub(dirty.len() as u32);
        let over = self.era == 0;
        for tile in dirty.drain(..) {
            // A tile that has left the cut since is not marked any more.
            if std::mem::take(&mut self.leaves[tile as usize].dirty) && !over {
                self.refresh(tile, config);
                self.key(tile);
            }
        }
        self.dirty = dirty;
        if over {
            self.new_era(config);
        }
        for _ in 0..config.moves {
            if !self.step(target as usize, config) {
                return;
            }
        }
    }

    /// One split, merge, or exchange of one for the other; false if there is nothing to do.
    fn step(&mut self, target: usize, config: &Config) -> bool {
        let largest = self.splits.top();
        let least = self.merges.top().map(|(node, key)| (node, -key));
        match (largest, least) {
            (Some((tile, _)), _) if self.cut.len() < target => self.split(tile, config),
            (_, Some((node, _))) if self.cut.len() > target => self.merge(node, config),
            (Some((_, most)), Some((node, sum))) if most > sum * config.hysteresis => {
                self.merge(node, config);
                // The merged tile itself may now be the largest: then all is as equal as it gets.
                let Some((tile, _)) = self.splits.top() else {
                    return false;
                };
                self.split(tile, config);
                return tile != node;
            }
            _ => return false,
        }
        true
    }

    /// Means over the image of spatial (1/pixel) and temporal (1/s) gradients, and the mean over
    /// the tiles of their samples' mean age at `now`, seconds.
    pub(super) fn averages(&self, now: f64) -> [f64; 3] {
        let pixels = f64::from(self.tree.nodes[0].area());
        let [spatial, temporal, time, timed] = self.shares;
        let age = if timed > 0.5 { now - time / timed } else { 0.0 };
        [spatial / pixels, temporal / pixels, age.max(0.0)]
    }

    /// The cut in preorder with the gradients of each tile and its sampling density: `rate`
    /// samples a second, shared alike among the tiles.
    pub(super) fn side_data(&self, fields: TileFields, rate: f64, out: &mut Vec<TileNode>) {
        out.clear();
        let each = rate / self.cut.len() as f64;
        let mut pending = vec![0];
        while let Some(id) = pending.pop() {
            let node = &self.tree.nodes[id as usize];
            if self.place[id as usize] == NONE {
                out.push(TileNode::Split(node.axis));
                pending.extend([node.halves[1], node.halves[0]]);
                continue;
            }
            let known = self.tree.known(id).filter(|_| fields.gradients);
            let [gx, gy, gt] = known.map_or([LogCode(128); 3], |sums| {
                sums.mean_gradients().map(|g| log_code(g as f32))
            });
            let density = each / f64::from(node.area());
            out.push(TileNode::Leaf(Tile {
                rect: node.rect,
                gx,
                gy,
                gt,
                lifetime: LogCode(128),
                density: if fields.density {
                    log_code(density as f32)
                } else {
                    LogCode(128)
                },
            }));
        }
    }

    /// Panics where an invariant does not hold.
    #[cfg(test)]
    pub(super) fn check(&self) {
        let nodes = &self.tree.nodes;
        let inside = |node: u32| self.place[node as usize] != NONE;
        for (k, &tile) in self.cut.iter().enumerate() {
            assert_eq!(self.place[tile as usize], k as u32);
        }
        assert_eq!(
            nodes
                .iter()
                .zip(&self.place)
                .filter(|&(_, &p)| p != NONE)
                .count(),
            self.cut.len()
        );
        self.splits.check();
        self.merges.check();
        let mut heaped = [0; 2];
        for node in 0..nodes.len() as u32 {
            let splittable = inside(node) && self.splittable(node);
            assert_eq!(self.splits.contains(node), splittable);
            if splittable {
                heaped[0] += 1;
                assert_eq!(self.splits.key(node), self.leaves[node as usize].error);
            }
            assert_eq!(self.merges.contains(node), self.pair(node));
            if self.pair(node) {
                heaped[1] += 1;
                assert_eq!(self.merges.key(node), -self.pair_error(node));
            }
        }
        assert_eq!(heaped, [self.splits.len(), self.merges.len()]);
        let mut shares = [0.0; 4];
        for &tile in &self.cut {
            let leaf = &self.leaves[tile as usize];
            shares
                .iter_mut()
                .zip(leaf.shares)
                .for_each(|(s, l)| *s += l);
        }
        for (sum, exact) in self.shares.iter().zip(shares) {
            assert!(
                (sum - exact).abs() < 1e-6 * exact.abs().max(1.0),
                "{sum} {exact}"
            );
        }
    }
}
