//! A map on a grid as a k-d cut of the image: what is alike in a neighbourhood is one tile.
//!
//! The display gets a sampler's side data (lifetimes, densities) as the leaves of a k-d tree in
//! preorder, in the logarithmic codes of the wire. Where nothing happens one tile says it all.

use unframed_wire::tiles::{Axis, TileNode, split};
use unframed_wire::{LogCode, Rect, Tile};

/// Codes of the fields on a regular grid of square cells over the image, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a> {
    /// Side of a cell, pixels; 1 or more.
    pub cell: u16,
    /// Cells in a row: the image's width over `cell`, rounded up.
    pub columns: usize,
    /// Lifetime and density of each cell.
    pub codes: &'a [[LogCode; 2]],
}

impl Map<'_> {
    /// Columns and rows of the cells that a rectangle touches.
    fn cells(&self, rect: Rect) -> [std::ops::Range<usize>; 2] {
        let range = |at: u16, len: u16| {
            let first = at / self.cell;
            let last = (u32::from(at) + u32::from(len) - 1) / u32::from(self.cell);
            usize::from(first)..last as usize + 1
        };
        [range(rect.x, rect.w), range(rect.y, rect.h)]
    }

    /// Lowest, highest and mean code of the fields in a rectangle.
    fn spread(&self, rect: Rect) -> [[u32; 3]; 2] {
        let [columns, rows] = self.cells(rect);
        let mut out = [[255, 0, 0]; 2];
        let count = (columns.len() * rows.len()) as u32;
        for y in rows {
            for cell in &self.codes[y * self.columns..][columns.clone()] {
                for (out, code) in out.iter_mut().zip(cell) {
                    let code = u32::from(code.0);
                    *out = [out[0].min(code), out[1].max(code), out[2] + code];
                }
            }
        }
        out.map(|[low, high, sum]| [low, high, (sum + count / 2) / count.max(1)])
    }
}

/// Appends the cut of `rect` to `out`: tiles are halved along their longer side until their codes
/// differ by at most `tolerance` from each other, or only one cell of the map is left. `fields`
/// says which of lifetime and density count; the other is left neutral.
pub fn cut(map: &Map<'_>, rect: Rect, fields: [bool; 2], tolerance: u32, out: &mut Vec<TileNode>) {
    let spread = map.spread(rect);
    let alike = spread
        .iter()
        .zip(fields)
        .all(|([low, high, _], on)| !on || high - low <= tolerance);
    let axis = if rect.w >= rect.h { Axis::X } else { Axis::Y };
    let [columns, rows] = map.cells(rect);
    let one = columns.len() == 1 && rows.len() == 1;
    match split(rect, axis) {
        Some((first, second)) if !alike && !one => {
            out.push(TileNode::Split(axis));
            cut(map, first, fields, tolerance, out);
            cut(map, second, fields, tolerance, out);
        }
        _ => {
            let code = |k: usize| LogCode(if fields[k] { spread[k][2] as u8 } else { 128 });
            let neutral = LogCode(128);
            out.push(TileNode::Leaf(Tile {
                rect,
                gx: neutral,
                gy: neutral,
                gt: neutral,
                lifetime: code(0),
                density: code(1),
            }));
        }
    }
}

/// The code nearest to a quantity: `2^((c − 128)/8)`, see [`LogCode`].
#[must_use]
pub fn log_code(quantity: f32) -> LogCode {
    // The cast saturates; zero gives −∞ and code 0.
    LogCode((128.0 + 8.0 * quantity.log2()).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::noise::Random;

    fn leaves(nodes: &[TileNode]) -> Vec<Tile> {
        let leaf = |n: &TileNode| match n {
            TileNode::Leaf(tile) => Some(*tile),
            TileNode::Split(_) => None,
        };
        nodes.iter().filter_map(leaf).collect()
    }

    #[test]
    fn leaves_partition_the_image_and_hold_what_they_cover() {
        let mut random = Random::new(3);
        for (w, h) in [(256u16, 256u16), (100, 75), (9, 300), (1, 1), (8, 8)] {
            let (columns, rows) = (usize::from(w.div_ceil(8)), usize::from(h.div_ceil(8)));
            let codes: Vec<_> = (0..columns * rows)
                .map(|_| {
                    [
                        LogCode(100 + random.below(3) as u8),
                        LogCode(random.below(9) as u8),
                    ]
                })
                .collect();
            let map = Map {
                cell: 8,
                columns,
                codes: &codes,
            };
            let rect = Rect { x: 0, y: 0, w, h };
            for tolerance in [0, 2, 4] {
                let mut nodes = Vec::new();
                cut(&map, rect, [true, true], tolerance, &mut nodes);
                let mut owner = vec![0u32; usize::from(w) * usize::from(h)];
                for tile in leaves(&nodes) {
                    for y in tile.rect.y..tile.rect.y + tile.rect.h {
                        for x in tile.rect.x..tile.rect.x + tile.rect.w {
                            owner[usize::from(y) * usize::from(w) + usize::from(x)] += 1;
                            let code = codes[usize::from(y / 8) * columns + usize::from(x / 8)];
                            let off = tile.lifetime.0.abs_diff(code[0].0);
                            assert!(u32::from(off) <= tolerance);
                        }
                    }
                }
                assert!(owner.iter().all(|&n| n == 1), "{w}×{h}");
            }
        }
    }

    #[test]
    fn quiet_costs_one_tile_and_a_spot_a_path() {
        let mut codes = vec![[LogCode(128), LogCode(7)]; 1024];
        fn map(codes: &[[LogCode; 2]]) -> Map<'_> {
            Map {
                cell: 8,
                columns: 32,
                codes,
            }
        }
        let rect = Rect {
            x: 0,
            y: 0,
            w: 256,
            h: 256,
        };
        let mut nodes = Vec::new();
        cut(&map(&codes), rect, [true, true], 0, &mut nodes);
        assert_eq!(leaves(&nodes).len(), 1);
        codes[5 * 32 + 9][0] = LogCode(90);
        nodes.clear();
        cut(&map(&codes), rect, [true, true], 0, &mut nodes);
        assert_eq!(leaves(&nodes).len(), 11, "ten halvings down to 8×8 pixels");
        nodes.clear();
        cut(&map(&codes), rect, [false, true], 0, &mut nodes);
        assert_eq!(
            leaves(&nodes).len(),
            1,
            "a field that is not sent does not split"
        );
    }

    #[test]
    fn codes_are_logarithms() {
        for (quantity, code) in [
            (1.0, 128),
            (2.0, 136),
            (0.5, 120),
            (0.0, 0),
            (-1.0, 0),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(log_code(quantity).0, code, "{quantity}");
        }
    }
}
