//! The display's memory: static, of one size for every panel that fits.

use crate::Failure;
use unframed_recon::Arith;
use unframed_recon::memory::{Memory, Needs, Storage};

/// Samples remembered at most.
pub const SAMPLES: usize = 65_536;
/// Pixels at most, of any shape: 64 × 64, 1 × 4080.
pub const PIXELS: usize = 4096;
/// The sky's pose and those of all objects.
pub const SLOTS: usize = 256;

/// The square needs most tiles for its pixels, the line the largest pyramid.
const SQUARE: Needs = Needs::of(64, 64);
const LINE: Needs = Needs::of(1, 4080);

const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// Entries of the coarser minima.
pub const MINIMA: usize = larger(SQUARE.minima, LINE.minima);
/// Coarser texels.
pub const PYRAMID: usize = larger(SQUARE.pyramid, LINE.pyramid);
/// Tile cells.
pub const CELLS: usize = larger(SQUARE.cells, LINE.cells);

/// Storage for every panel and configuration of this image.
pub type Room<A> = Storage<
    A,
    SAMPLES,
    PIXELS,
    PYRAMID,
    CELLS,
    SLOTS,
    SAMPLES,
    MINIMA,
    PIXELS,
    PIXELS,
    PIXELS,
    PIXELS,
>;

/// The memory of a display that remembers `samples` samples.
///
/// # Errors
/// [`Failure::TooLarge`].
pub fn memory<
    A: Arith,
    const N: usize,
    const P: usize,
    const Y: usize,
    const C: usize,
    const O: usize,
    const J: usize,
    const M: usize,
    const H: usize,
    const D: usize,
    const L: usize,
    const R: usize,
>(
    room: &'static mut Storage<A, N, P, Y, C, O, J, M, H, D, L, R>,
    samples: usize,
) -> Result<Memory<'static, A>, Failure> {
    let mut memory = room.memory();
    memory.samples = memory.samples.get_mut(..samples).ok_or(Failure::TooLarge)?;
    Ok(memory)
}
