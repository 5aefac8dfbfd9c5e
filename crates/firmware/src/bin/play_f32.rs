//! The display in `f32`, for comparison: what it costs where there is an FPU, and where there is none.
#![no_std]
#![no_main]

use static_cell::ConstStaticCell;
use unframed_firmware::play::{Job, play};
use unframed_firmware::storage::{Room, memory};
use unframed_firmware::{Failure, end};

static ROOM: ConstStaticCell<Room<f32>> = ConstStaticCell::new(Room::<f32>::new());

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
