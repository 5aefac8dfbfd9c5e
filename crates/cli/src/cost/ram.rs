//! RAM of a display, as a firmware that is made for one panel and one preset places it
//! (`crates/firmware/src/bin/fitted.rs`): to the byte, before anything is built.

use std::mem::size_of;

use unframed_recon::arith::{Moments, Projected, Sums, Texel};
use unframed_recon::deep::Stored;
use unframed_recon::memory::{Calls, Needs, Slot};
use unframed_recon::rest::Mean;
use unframed_recon::tiles::Cell;
use unframed_recon::{Arith, Config};

/// The stack of the images, bytes (`crates/firmware/memory`): receiver and display lie on it.
pub const STACK: u64 = 16 * 1024;

/// Bytes of a display that remembers `samples` and knows `slots` objects (the sky is one): its
/// static storage and the stack.
#[must_use]
pub fn bytes<A: Arith>(
    width: u16,
    height: u16,
    samples: usize,
    config: &Config,
    slots: usize,
) -> u64 {
    // The flag of the cell that hands the storage out once takes as much as its alignment.
    let (storage, alignment) = (storage::<A>(width, height, samples, config, slots), 8);
    (storage.next_multiple_of(alignment) + alignment) as u64 + STACK
}

/// The parts of `unframed_recon::memory::Storage`.
fn storage<A: Arith>(
    width: u16,
    height: u16,
    samples: usize,
    config: &Config,
    slots: usize,
) -> usize {
    let needs = Needs::of(width, height);
    let calls = Calls::of(config, &needs, samples);
    let pixel =
        size_of::<A::Log>() + size_of::<Sums<A>>() + size_of::<Texel<A>>() + size_of::<[u8; 3]>();
    samples * size_of::<Stored>()
        + calls.projected * size_of::<Projected<A>>()
        + size_of::<[u32; 2]>() // starts
        + calls.minima * size_of::<A::Depth>()
        + calls.hidden * (size_of::<A::Depth>() + size_of::<u8>())
        + calls.mass * size_of::<A::Mass>()
        + calls.moments * size_of::<Moments<A>>()
        + calls.means * size_of::<Mean>()
        + needs.pixels * pixel
        + needs.pyramid * size_of::<Texel<A>>()
        + needs.cells * size_of::<Cell>()
        + slots * size_of::<Slot<A>>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use unframed_recon::Fixed;
    use unframed_recon::config::{Extents, Fit};
    use unframed_recon::memory::Storage;

    /// The sum of the parts is the size of the whole; on a board `tests/e2e/budget.rs` looks.
    macro_rules! same {
        ($config:expr) => {{
            const CONFIG: Config = $config;
            const NEEDS: Needs = Needs::of(61, 47);
            const CALLS: Calls = Calls::of(&CONFIG, &NEEDS, 1001);
            type Whole = Storage<
                Fixed,
                1001,
                { NEEDS.pixels },
                { NEEDS.pyramid },
                { NEEDS.cells },
                9,
                { CALLS.projected },
                { CALLS.minima },
                { CALLS.hidden },
                { CALLS.mass },
                { CALLS.moments },
                { CALLS.means },
            >;
            let sum = storage::<Fixed>(61, 47, 1001, &CONFIG, 9);
            // Here sums may be aligned to more than on a board, which fills up the end alone.
            let alignment = align_of::<Whole>();
            assert_eq!(size_of::<Whole>(), sum.next_multiple_of(alignment));
            sum
        }};
    }

    #[test]
    fn the_sum_is_that_of_the_storage() {
        const MEANS: Config = Config {
            fit: Fit::Constant,
            ..Config::ADAPTIVE
        };
        const NARROW: Config = Config {
            extents: Extents::Pixel,
            ..MEANS
        };
        let all = same!(Config::ADAPTIVE);
        let means = same!(MEANS);
        let narrow = same!(NARROW);
        let own = same!(Config {
            hidden: false,
            ..NARROW
        });
        let least = same!(Config {
            hidden: false,
            rest: false,
            ..NARROW
        });
        assert!(all > means && means == narrow && narrow > own && own > least);
        let small = bytes::<Fixed>(64, 64, 1000, &Config::ADAPTIVE, 9);
        assert!(
            bytes::<f64>(64, 64, 1000, &Config::ADAPTIVE, 9) > small,
            "doubles are larger"
        );
    }
}
