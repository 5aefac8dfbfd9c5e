//! RAM of a display: the slices that `unframed_recon::memory` asks for, times their sizes.

use std::mem::size_of;

use unframed_recon::arith::{Moments, Projected, Sums, Texel};
use unframed_recon::config::Fit;
use unframed_recon::deep::Stored;
use unframed_recon::memory::{Needs, Slot};
use unframed_recon::rest::Mean;
use unframed_recon::tiles::Cell;
use unframed_recon::{Arith, Player};

/// Bytes of a display that remembers `samples` and knows `slots` objects (the sky is one), its
/// receiver included; without stack and code.
#[must_use]
pub fn bytes<A: Arith>(width: u16, height: u16, samples: usize, fit: Fit, slots: usize) -> u64 {
    let needs = Needs::of(width, height);
    let moments = match fit {
        Fit::Constant => 0,
        Fit::Linear => size_of::<Moments<A>>(),
    };
    let pixel = size_of::<A::Depth>() // limits
        + size_of::<u8>() // movers
        + size_of::<A::Mass>()
        + size_of::<A::Width>()
        + size_of::<Sums<A>>()
        + moments
        + size_of::<Texel<A>>()
        + size_of::<Mean>()
        + size_of::<[u8; 3]>();
    let sum = samples * (size_of::<Stored>() + size_of::<Projected<A>>())
        + needs.pixels * pixel
        + needs.minima * size_of::<A::Depth>()
        + needs.pyramid * size_of::<Texel<A>>()
        + needs.cells * size_of::<Cell>()
        + slots * size_of::<Slot<A>>()
        + size_of::<Player<'static, A>>();
    sum as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use unframed_recon::Fixed;
    use unframed_recon::memory::Storage;

    /// The sum of the parts is the size of the whole, as a firmware places it.
    fn same<const L: usize>(fit: Fit) {
        const NEEDS: Needs = Needs::of(64, 64);
        type Whole<const L: usize> = Storage<
            Fixed,
            16384,
            { NEEDS.pixels },
            { NEEDS.minima },
            { NEEDS.pyramid },
            { NEEDS.cells },
            9,
            L,
        >;
        let whole = size_of::<Whole<L>>() + size_of::<Player<'static, Fixed>>();
        let sum = bytes::<Fixed>(64, 64, 16384, fit, 9) as usize;
        // Padding between fields; and where nothing is sorted, two starts.
        assert!(sum.abs_diff(whole) <= 64, "{sum} and {whole}");
    }

    #[test]
    fn the_sum_is_that_of_the_storage() {
        same::<{ 64 * 64 }>(Fit::Linear);
        same::<0>(Fit::Constant);
        let small = bytes::<Fixed>(64, 64, 1000, Fit::Linear, 9);
        assert!(
            bytes::<f64>(64, 64, 1000, Fit::Linear, 9) > small,
            "doubles are larger"
        );
    }
}
