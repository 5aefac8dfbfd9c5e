//! The k-d cut of the image.

use unframed_wire::Tile;

/// A node of a cut in preorder: a split stands before its two halves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// Divided into a left and a right half.
    SplitX,
    /// Divided into an upper and a lower half.
    SplitY,
    /// A tile.
    Leaf(Tile),
}

pub(super) fn clear(out: &mut Vec<Node>) {
    out.clear();
}
