//! RAM of a display, as a firmware that is made for one panel and one preset places it
//! (`crates/firmware/src/bin/fitted.rs`): to the byte, before anything is built.

use std::mem::size_of;

use unframed_recon::Arith;
use unframed_recon::arith::{Moments, Projected, Sums, Texel};
use unframed_recon::config::Fit;
use unframed_recon::deep::Stored;
use unframed_recon::memory::{Needs, Slot};
use unframed_recon::rest::Mean;
use unframed_recon::tiles::Cell;

/// The stack of the images, bytes (`crates/firmware/memory`): receiver and display lie on it.
pub const STACK: u64 = 16 * 1024;

/// Bytes of a display that remembers `samples` and knows `slots` objects (the sky is one): its
/// static storage and the stack.
#[must_use]
pub fn bytes<A: Arith>(width: u16, height: u16, samples: usize, fit: Fit, slots: usize) -> u64 {
    // The flag of the cell that hands the storage out once takes as much as its alignment.
    let (storage, alignment) = (storage::<A>(width, height, samples, fit, slots), 8);
    (storage.next_multiple_of(alignment) + alignment) as u64 + STACK
}

/// The parts of `unframed_recon::memory::Storage`.
fn storage<A: Arith>(width: u16, height: u16, samples: usize, fit: Fit, slots: usize) -> usize {
    let needs = Needs::of(width, height);
    let moments = match fit {
        Fit::Constant => 0,
        Fit::Linear => size_of::<Moments<A>>(),
    };
    let pixel = size_of::<A::Depth>() // limits
        + size_of::<u8>() // movers
        + size_of::<A::Mass>()
        + size_of::<A::Log>()
        + size_of::<Sums<A>>()
        + moments
        + size_of::<Texel<A>>()
        + size_of::<Mean>()
        + size_of::<[u8; 3]>();
    samples * (size_of::<Stored>() + size_of::<Projected<A>>())
        + size_of::<[u32; 2]>() // starts
        + needs.pixels * pixel
        + needs.minima * size_of::<A::Depth>()
        + needs.pyramid * size_of::<Texel<A>>()
        + needs.cells * size_of::<Cell>()
        + slots * size_of::<Slot<A>>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use unframed_recon::Fixed;
    use unframed_recon::memory::Storage;

    /// The sum of the parts is the size of the whole; on a board `tests/tests/budget.rs` looks.
    fn same<const L: usize>(fit: Fit) {
        const NEEDS: Needs = Needs::of(61, 47);
        type Whole<const L: usize> = Storage<
            Fixed,
            1001,
            { NEEDS.pixels },
            { NEEDS.minima },
            { NEEDS.pyramid },
            { NEEDS.cells },
            9,
            L,
        >;
        let sum = storage::<Fixed>(61, 47, 1001, fit, 9);
        assert_eq!(size_of::<Whole<L>>(), sum.next_multiple_of(8));
        assert_eq!(align_of::<Whole<L>>(), 8);
    }

    #[test]
    fn the_sum_is_that_of_the_storage() {
        same::<{ 61 * 47 }>(Fit::Linear);
        same::<0>(Fit::Constant);
        let small = bytes::<Fixed>(64, 64, 1000, Fit::Linear, 9);
        assert!(
            bytes::<f64>(64, 64, 1000, Fit::Linear, 9) > small,
            "doubles are larger"
        );
    }
}
