//! The image `play` with storage for one panel and one preset, and not a byte more: what a product
//! would hold. `unframed cost` says how much that is before anything is built; whoever builds says
//! it in the environment, see `unframed_sim::boards::Fitted`.
#![no_std]
#![no_main]

use static_cell::ConstStaticCell;
use unframed_firmware::play::{Job, play};
use unframed_firmware::storage::memory;
use unframed_firmware::{Failure, end};
use unframed_recon::config::{Extents, Fit};
use unframed_recon::memory::{Calls, Needs, Storage};
use unframed_recon::{Config, Fixed};

/// Decimal digits; what is none of them does not compile.
const fn number(text: &str) -> usize {
    let (digits, mut value, mut i) = (text.as_bytes(), 0, 0);
    while i < digits.len() {
        assert!(digits[i].is_ascii_digit(), "a number");
        value = 10 * value + (digits[i] - b'0') as usize;
        i += 1;
    }
    value
}

const SAMPLES: usize = number(env!("UNFRAMED_SAMPLES"));
const SLOTS: usize = number(env!("UNFRAMED_SLOTS"));
const NEEDS: Needs = Needs::of(
    number(env!("UNFRAMED_WIDTH")) as u16,
    number(env!("UNFRAMED_HEIGHT")) as u16,
);
const CALLS: Calls = Calls::of(&CONFIG, &NEEDS, SAMPLES);
/// What of a configuration calls for storage.
const CONFIG: Config = Config {
    fit: if called_for(env!("UNFRAMED_PLANES")) {
        Fit::Linear
    } else {
        Fit::Constant
    },
    extents: if called_for(env!("UNFRAMED_PIXELS")) {
        Extents::Pixel
    } else {
        Extents::Density
    },
    hidden: called_for(env!("UNFRAMED_HIDDEN")),
    rest: called_for(env!("UNFRAMED_REST")),
    ..Config::ADAPTIVE
};

const fn called_for(text: &str) -> bool {
    number(text) != 0
}

type Room = Storage<
    Fixed,
    SAMPLES,
    { NEEDS.pixels },
    { NEEDS.pyramid },
    { NEEDS.cells },
    SLOTS,
    { CALLS.projected },
    { CALLS.minima },
    { CALLS.hidden },
    { CALLS.mass },
    { CALLS.moments },
    { CALLS.means },
>;

static ROOM: ConstStaticCell<Room> = ConstStaticCell::new(Room::new());

fn run() -> Result<(), Failure> {
    let job = Job::read()?;
    let room = ROOM.try_take().ok_or(Failure::TooLarge)?;
    play(&job, memory(room, job.samples)?, |_| Ok(()))
}

#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    end(run())
}
