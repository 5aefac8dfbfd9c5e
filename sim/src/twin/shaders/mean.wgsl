// What fell into a pixel while all stands still, twin of unframed_recon::rest::Mean: three sums
// of light and a count.

alias Mean = vec4<u32>;

// Samples that a mean may hold before a refresh.
const FULL: u32 = 32768u;
// How many samples of a pixel the filter's estimate is worth.
const PRIOR: u32 = 4u;
// The lifetime of a tile in which nothing changes.
const RESTS: u32 = 255u;
// log2 of the side of a cell of the tile map, pixels.
const MAP_BITS: u32 = 2u;

// The cell of a pixel of the panel.
fn cell_of(x: i32, y: i32) -> u32 {
    return u32((y >> MAP_BITS) * params.columns + (x >> MAP_BITS));
}

// Its lifetime is the highest byte of the first word, see params.rs.
fn rests(cell: vec2<u32>) -> bool { return (cell.x >> 24u) == RESTS; }
