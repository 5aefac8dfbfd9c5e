//! The display with its panel: each picture goes through embedded-graphics into the driver
//! `mipidsi`, which sends the windows that changed over an SPI bus that records.
#![no_std]
#![no_main]

use static_cell::ConstStaticCell;
use unframed_firmware::panel::{Bus, driver};
use unframed_firmware::play::{Job, play};
use unframed_firmware::storage::{PIXELS, Room, memory};
use unframed_firmware::{Failure, end};
use unframed_recon::{Fixed, scanout};

static ROOM: ConstStaticCell<Room<Fixed>> = ConstStaticCell::new(Room::<Fixed>::new());
static SHOWN: ConstStaticCell<[[u8; 3]; PIXELS]> = ConstStaticCell::new([[0; 3]; PIXELS]);

fn run() -> Result<(), Failure> {
    let job = Job::read()?;
    let room = ROOM.try_take().ok_or(Failure::TooLarge)?;
    let shown = SHOWN.try_take().ok_or(Failure::TooLarge)?;
    let bus = Bus::new()?;
    let mut buffer = [0; 512];
    let mut driver = driver(&bus, &mut buffer, (job.hello.width, job.hello.height))?;
    play(&job, memory(room, job.samples)?, |display| {
        let drawn = scanout::draw_changes(display, shown, &mut driver);
        drawn.map_err(|_| Failure::Driver)?;
        bus.end_refresh()
    })
}

#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    end(run())
}
