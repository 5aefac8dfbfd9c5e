//! The k-d cut: a region's tree in preorder, each leaf's codes inline.
//!
//! Each split is at `floor(length/2)` along its axis, so a node costs one or two bits. A leaf's
//! codes are coded against those of the leaf before it (modulo 256, folded, Rice with one
//! parameter a field and packet): neighbours in preorder are mostly neighbours on the screen.

use crate::bits::{BitReader, BitWriter, fold, rice_len, unfold};
use crate::bytes::{Buffer, Cursor};
use crate::fixed::{self, MAX_EDGE};
use crate::ledger::TileBits;
use crate::repr::*;

/// The axis along which a node is halved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Left and right halves.
    X,
    /// Top and bottom halves.
    Y,
}

/// One node of a k-d tree in preorder: a split is followed by its first half (left or top), then
/// by its second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileNode {
    /// Halved at `floor(length/2)`; the length along the axis is at least 2.
    Split(Axis),
    /// A leaf of the cut. Its `rect` must be the one that the splits lead to.
    Leaf(Tile),
}

/// The neutral code of fields that are absent, and the start of the differences.
const NEUTRAL: [u8; 5] = [128; 5];

/// A tree of at most 4096×4096 pixels is at most 24 splits deep; each leaves one half waiting.
const MAX_DEPTH: usize = 24;

/// Largest Rice parameter of a field, in 3 bits.
const MAX_K: u32 = 7;

/// Halves of a rectangle, or `None` if it has only one pixel along the axis.
#[must_use]
pub fn split(rect: Rect, axis: Axis) -> Option<(Rect, Rect)> {
    let half = match axis {
        Axis::X => rect.w / 2,
        Axis::Y => rect.h / 2,
    };
    if half == 0 {
        return None;
    }
    Some(match axis {
        Axis::X => (
            Rect { w: half, ..rect },
            Rect {
                x: rect.x + half,
                w: rect.w - half,
                ..rect
            },
        ),
        Axis::Y => (
            Rect { h: half, ..rect },
            Rect {
                y: rect.y + half,
                h: rect.h - half,
                ..rect
            },
        ),
    })
}

/// Rectangles that wait for their turn in a preorder walk.
#[derive(Clone, Debug)]
struct Pending {
    rects: [Rect; MAX_DEPTH + 1],
    len: usize,
}

impl Pending {
    fn new(root: Rect) -> Self {
        let mut pending = Pending {
            rects: [Rect::default(); MAX_DEPTH + 1],
            len: 0,
        };
        let _ = pending.push(root);
        pending
    }

    fn push(&mut self, rect: Rect) -> Option<()> {
        *self.rects.get_mut(self.len)? = rect;
        self.len += 1;
        Some(())
    }

    fn pop(&mut self) -> Option<Rect> {
        self.len = self.len.checked_sub(1)?;
        self.rects.get(self.len).copied()
    }

    /// Replaces `rect` by its halves, the first on top.
    fn split(&mut self, rect: Rect, axis: Axis) -> Option<()> {
        let (first, second) = split(rect, axis)?;
        self.push(second)?;
        self.push(first)
    }
}

fn mask(fields: TileFields) -> [bool; 5] {
    let TileFields {
        gradients: g,
        lifetime,
        density,
    } = fields;
    [g, g, g, lifetime, density]
}

fn codes(tile: &Tile) -> [u8; 5] {
    [tile.gx, tile.gy, tile.gt, tile.lifetime, tile.density].map(|c| c.0)
}

/// A part of the k-d cut: the leaves of one region, in preorder.
#[derive(Clone, Debug)]
pub struct Tiles<'a> {
    time: Tick,
    region: Rect,
    fields: TileFields,
    bits: BitReader<'a>,
    k: [u8; 5],
    last: [u8; 5],
    pending: Pending,
    malformed: bool,
}

impl<'a> Tiles<'a> {
    /// `None` if the region is empty or outside a panel of `width`×`height` pixels, or a field is
    /// out of range.
    pub(crate) fn parse(payload: &'a [u8], width: u16, height: u16) -> Option<Self> {
        let mut c = Cursor(payload);
        let time = Tick(c.u32()?);
        let region = Rect {
            x: c.u16()?,
            y: c.u16()?,
            w: c.u16()?,
            h: c.u16()?,
        };
        let fields = fixed::get_fields(c.u8()?)?;
        let inside = |at: u16, len: u16, edge: u16| {
            len >= 1 && u32::from(at) + u32::from(len) <= u32::from(edge.min(MAX_EDGE))
        };
        if !inside(region.x, region.w, width) || !inside(region.y, region.h, height) {
            return None;
        }
        let mut bits = BitReader::new(c.0);
        let mut k = [0; 5];
        for (k, present) in k.iter_mut().zip(mask(fields)) {
            if present {
                *k = bits.bits(3)? as u8;
            }
        }
        let pending = Pending::new(region);
        Some(Tiles {
            time,
            region,
            fields,
            bits,
            k,
            last: NEUTRAL,
            pending,
            malformed: false,
        })
    }

    /// The instant for which the cut was made.
    #[must_use]
    pub fn time(&self) -> Tick {
        self.time
    }

    /// The pixels that the leaves cover, without gaps or overlap.
    #[must_use]
    pub fn region(&self) -> Rect {
        self.region
    }

    /// The fields that the leaves carry.
    #[must_use]
    pub fn fields(&self) -> TileFields {
        self.fields
    }

    /// Whether the tree ended before the region was covered: the sender is wrong, not the link.
    #[must_use]
    pub fn malformed(&self) -> bool {
        self.malformed
    }

    /// Walks down to the next leaf and reads its codes; `None` if the bits do not allow it.
    fn leaf(&mut self) -> Option<Tile> {
        loop {
            let rect = self.pending.pop()?;
            if self.bits.flag()? {
                let axis = if self.bits.flag()? { Axis::Y } else { Axis::X };
                self.pending.split(rect, axis)?;
                continue;
            }
            for ((last, k), present) in self.last.iter_mut().zip(self.k).zip(mask(self.fields)) {
                if present {
                    let u = self.bits.rice(u32::from(k), 8)?;
                    *last = last.wrapping_add(unfold(u) as u8);
                }
            }
            let [gx, gy, gt, lifetime, density] = self.last.map(LogCode);
            return Some(Tile {
                rect,
                gx,
                gy,
                gt,
                lifetime,
                density,
            });
        }
    }
}

impl Iterator for Tiles<'_> {
    type Item = Tile;

    fn next(&mut self) -> Option<Tile> {
        if self.pending.len == 0 {
            return None;
        }
        let tile = self.leaf();
        if tile.is_none() {
            self.malformed = true;
            self.pending.len = 0;
        }
        tile
    }
}

/// Why a tree cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TreeError {
    /// The nodes are not one whole preorder tree of the region.
    Shape,
    /// A leaf's rectangle is not the one that the splits lead to.
    Rect,
}

/// Number of nodes of the subtree that starts `nodes`, and checks that it is a whole tree of
/// `region` whose leaves are where they say.
pub(crate) fn check(region: Rect, nodes: &[TileNode]) -> Result<usize, TreeError> {
    let mut pending = Pending::new(region);
    for (i, node) in nodes.iter().enumerate() {
        let Some(rect) = pending.pop() else {
            return Ok(i);
        };
        match node {
            TileNode::Split(axis) => pending.split(rect, *axis).ok_or(TreeError::Shape)?,
            TileNode::Leaf(tile) if tile.rect != rect => return Err(TreeError::Rect),
            TileNode::Leaf(_) => {}
        }
    }
    if pending.len == 0 {
        Ok(nodes.len())
    } else {
        Err(TreeError::Shape)
    }
}

/// Folded differences of each leaf's fields to the leaf before.
fn residuals(nodes: &[TileNode]) -> impl Iterator<Item = [u32; 5]> {
    let mut last = NEUTRAL;
    nodes.iter().filter_map(move |node| match node {
        TileNode::Split(_) => None,
        TileNode::Leaf(tile) => {
            let now = codes(tile);
            let mut out = [0; 5];
            for ((out, now), last) in out.iter_mut().zip(now).zip(last) {
                *out = fold(i32::from(now.wrapping_sub(last) as i8));
            }
            last = now;
            Some(out)
        }
    })
}

/// The cheapest Rice parameter of each field.
fn parameters(nodes: &[TileNode]) -> [u32; 5] {
    let mut cost = [[0u32; MAX_K as usize + 1]; 5];
    for residual in residuals(nodes) {
        for (cost, u) in cost.iter_mut().zip(residual) {
            for (k, cost) in (0..).zip(cost.iter_mut()) {
                *cost += rice_len(u, k, 8);
            }
        }
    }
    cost.map(|cost| {
        (0..)
            .zip(cost)
            .min_by_key(|&(_, bits)| bits)
            .map_or(0, |(k, _)| k)
    })
}

/// Writes one whole subtree of `region`; the buffer says whether it fitted.
pub(crate) fn put(
    b: &mut Buffer,
    time: Tick,
    region: Rect,
    fields: TileFields,
    nodes: &[TileNode],
) -> TileBits {
    b.u32(time.0);
    [region.x, region.y, region.w, region.h]
        .into_iter()
        .for_each(|v| b.u16(v));
    b.u8(fixed::put_fields(fields));
    let mask = mask(fields);
    let k = parameters(nodes);
    let mut w = BitWriter::new(b);
    for (k, present) in k.into_iter().zip(mask) {
        if present {
            w.bits(k, 3);
        }
    }
    let mut residuals = residuals(nodes);
    let mut spent = TileBits::default();
    for node in nodes {
        let before = w.total();
        match node {
            TileNode::Split(axis) => w.bits(if *axis == Axis::X { 0b10 } else { 0b11 }, 2),
            TileNode::Leaf(_) => w.bits(0, 1),
        }
        spent.tree += u64::from(w.total() - before);
        if let TileNode::Leaf(_) = node {
            spent.leaves += 1;
            let before = w.total();
            let residual = residuals.next().unwrap_or_default();
            for ((u, k), present) in residual.into_iter().zip(k).zip(mask) {
                if present {
                    w.rice(u, k, 8);
                }
            }
            spent.codes += u64::from(w.total() - before);
        }
    }
    w.finish();
    spent
}
