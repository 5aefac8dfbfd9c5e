//! The tile map: what the stream's tiles say, rasterised into square cells.
//!
//! A cell takes the values of the tile that holds its centre, so a tile costs work in proportion
//! to its cells and one smaller than a cell may fall between centres. The centre of a cell at the
//! border that lies beyond the panel counts as the last pixel before it.

use unframed_wire::{LogCode, Tile};

/// log2 of the side of a cell, pixels.
pub const CELL_BITS: u32 = 2;
/// Side of a cell, pixels.
pub const CELL: usize = 1 << CELL_BITS;

/// The lifetime of a tile in which nothing changes: infinity.
pub const RESTS: LogCode = LogCode(255);

/// The longest lifetime that samples are weighed by: a second. Infinity would reach into
/// neighbouring tiles whose samples live for milliseconds.
pub const LONGEST: LogCode = LogCode(128);

/// What is known of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// |dL/dx|, 1/pixel.
    pub gx: LogCode,
    /// |dL/dy|, 1/pixel.
    pub gy: LogCode,
    /// |dL/dt|, 1/s.
    pub gt: LogCode,
    /// Lifetime, seconds.
    pub lifetime: LogCode,
    /// Samples a pixel and second.
    pub density: LogCode,
}

impl Cell {
    /// The lifetime that samples are weighed by.
    #[inline]
    #[must_use]
    pub fn weighed(&self) -> LogCode {
        self.lifetime.min(LONGEST)
    }

    /// All codes zero: storage that no map has cleared yet.
    pub const ZERO: Self = Self {
        gx: LogCode(0),
        gy: LogCode(0),
        gt: LogCode(0),
        lifetime: LogCode(0),
        density: LogCode(0),
    };
}

impl Default for Cell {
    /// Before the first tile: lifetime 1 s, slopes of 2^−4, 4 samples a pixel and second.
    fn default() -> Self {
        Self {
            gx: LogCode(96),
            gy: LogCode(96),
            gt: LogCode(96),
            lifetime: LogCode(128),
            density: LogCode(144),
        }
    }
}

/// Cells needed along `pixels`.
#[must_use]
pub const fn cells_along(pixels: u16) -> usize {
    (pixels as usize).div_ceil(CELL)
}

/// The map over the caller's cells.
#[derive(Debug)]
pub struct TileMap<'a> {
    cells: &'a mut [Cell],
    columns: usize,
    rows: usize,
    /// Width and height of the panel.
    size: [u16; 2],
}

impl<'a> TileMap<'a> {
    /// A map of a panel of this size; `None` when there are not enough cells.
    pub fn new(cells: &'a mut [Cell], width: u16, height: u16) -> Option<Self> {
        let mut map = Self::resume(cells, width, height)?;
        map.clear();
        Some(map)
    }

    /// The map that these cells hold, as one of the same size left them.
    pub fn resume(cells: &'a mut [Cell], width: u16, height: u16) -> Option<Self> {
        let (columns, rows) = (cells_along(width), cells_along(height));
        let cells = cells.get_mut(..columns * rows)?;
        Some(Self {
            cells,
            columns,
            rows,
            size: [width, height],
        })
    }

    /// Forgets all tiles.
    pub fn clear(&mut self) {
        self.cells.fill(Cell::default());
    }

    /// Takes a tile over. Parts outside the panel are ignored.
    pub fn set(&mut self, tile: &Tile) {
        let cell = Cell {
            gx: tile.gx,
            gy: tile.gy,
            gt: tile.gt,
            lifetime: tile.lifetime,
            density: tile.density,
        };
        let [width, height] = self.size;
        let columns = centres(tile.rect.x, tile.rect.w, width);
        for row in centres(tile.rect.y, tile.rect.h, height) {
            if let Some(cells) = self
                .cells
                .get_mut(row * self.columns..)
                .and_then(|r| r.get_mut(columns.clone()))
            {
                cells.fill(cell);
            }
        }
    }

    /// The longest lifetime that samples are weighed by anywhere.
    #[must_use]
    pub fn longest(&self) -> LogCode {
        let lifetimes = self.cells.iter().map(Cell::weighed);
        lifetimes.max().unwrap_or_default()
    }

    /// Whether nothing changes in any tile.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.cells.iter().all(|cell| cell.lifetime == RESTS)
    }

    /// Whether nothing changes in the tile of a pixel.
    #[inline]
    #[must_use]
    pub fn rests_at(&self, x: i32, y: i32) -> bool {
        self.at(x >> CELL_BITS, y >> CELL_BITS).lifetime == RESTS
    }

    /// The cell at a column and row, clamped to the map.
    #[inline]
    #[must_use]
    pub fn at(&self, column: i32, row: i32) -> Cell {
        // `clamp` would be a panic path for a map without cells.
        let column = column.min(self.columns as i32 - 1).max(0) as usize;
        let row = row.min(self.rows as i32 - 1).max(0) as usize;
        self.cells
            .get(row * self.columns + column)
            .copied()
            .unwrap_or_default()
    }

    /// Columns and rows of cells.
    #[inline]
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// A cell of the map, the next in its row, and the two below these; where there is no next,
    /// the same again.
    #[inline]
    #[must_use]
    pub fn corner(&self, column: usize, row: usize) -> [Cell; 4] {
        let here = row * self.columns + column;
        let right = usize::from(column + 1 < self.columns);
        let below = usize::from(row + 1 < self.rows) * self.columns;
        let cell = |at: usize| self.cells.get(at).copied().unwrap_or_default();
        [
            cell(here),
            cell(here + right),
            cell(here + below),
            cell(here + below + right),
        ]
    }

    /// The four cells around, for bilinear interpolation.
    #[inline]
    #[must_use]
    pub fn around(&self, column: i32, row: i32) -> [Cell; 4] {
        // `clamp` would be a panic path for a map without cells.
        let clamped = |v: i32, len: usize| v.min(len as i32 - 1).max(0) as usize;
        let (left, right) = (
            clamped(column, self.columns),
            clamped(column + 1, self.columns),
        );
        let (above, below) = (clamped(row, self.rows), clamped(row + 1, self.rows));
        let (above, below) = (above * self.columns, below * self.columns);
        let cell = |at: usize| self.cells.get(at).copied().unwrap_or_default();
        [
            cell(above + left),
            cell(above + right),
            cell(below + left),
            cell(below + right),
        ]
    }
}

/// The cells whose centres lie in `start..start + length` of `size` pixels.
fn centres(start: u16, length: u16, size: u16) -> core::ops::Range<usize> {
    let half = CELL / 2;
    let (start, size) = (usize::from(start), usize::from(size));
    let limit = size.div_ceil(CELL);
    // The first cell whose centre does not lie before a place.
    let from = |place: usize| {
        if place < size {
            (place + half - 1) >> CELL_BITS
        } else {
            limit
        }
    };
    from(start)..from(start + usize::from(length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use unframed_wire::Rect;

    fn tile(x: u16, y: u16, w: u16, h: u16, code: u8) -> Tile {
        Tile {
            rect: Rect { x, y, w, h },
            lifetime: LogCode(code),
            ..Tile::default()
        }
    }

    #[test]
    fn a_cell_takes_the_tile_with_its_centre() {
        for size in 1..=16u16 {
            for (start, length) in (0..20).flat_map(|s| (0..20).map(move |l| (s, l))) {
                let got = centres(start, length, size);
                for cell in 0..6 {
                    let centre = ((cell * CELL + CELL / 2) as u16).min(size - 1);
                    let inside = cell * CELL < usize::from(size)
                        && (start..start + length).contains(&centre);
                    let case = (size, start, length, cell);
                    assert_eq!(got.contains(&cell), inside, "{case:?}");
                }
            }
        }
    }

    #[test]
    fn a_tile_of_the_whole_panel_reaches_every_cell() {
        for size in 1..=33u16 {
            let mut cells = [Cell::default(); 81];
            let mut map = TileMap::new(&mut cells, size, size).expect("9 x 9 cells");
            map.set(&tile(0, 0, size, size, RESTS.0));
            assert!(map.rests(), "{size}");
        }
    }

    #[test]
    fn tiles_beyond_the_panel_are_cut() {
        let mut cells = [Cell::default(); 6];
        let mut map = TileMap::new(&mut cells, 9, 8).expect("3 x 2 cells");
        map.set(&tile(4, 0, 65535, 65535, 7));
        assert_eq!(map.at(0, 0).lifetime, LogCode(128));
        assert_eq!(map.at(1, 1).lifetime, LogCode(7));
        assert_eq!(map.at(99, 99).lifetime, LogCode(7));
        map.set(&tile(65535, 65535, 65535, 65535, 9));
        assert_eq!(map.at(2, 1).lifetime, LogCode(7));
    }
}
