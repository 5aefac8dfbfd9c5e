//! The display in integers, from a stream of bytes to hashes of pictures. Deployed code: nothing in
//! this image can panic, allocates, or executes an instruction on floats.
#![no_std]
#![no_main]

use static_cell::ConstStaticCell;
use unframed_firmware::play::{Job, play};
use unframed_firmware::storage::{Room, memory};
use unframed_firmware::{Failure, end};
use unframed_recon::Fixed;

static ROOM: ConstStaticCell<Room<Fixed>> = ConstStaticCell::new(Room::<Fixed>::new());

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
