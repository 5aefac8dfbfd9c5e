//! mps2-an386 and mps2-an500: counting by the CMSDK timer, faults.

use crate::FAULT;
use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::process::ExitCode;

/// CMSDK APB timer 0: CTRL, VALUE, RELOAD (ARM DDI 0479, 4.4).
const TIMER: *mut u32 = 0x4000_0000 as *mut u32;

/// Counts executed instructions. QEMU's cycle counter reads zero; with `-icount shift=6` an
/// instruction takes 64 ns and the timer ticks every 40 ns (25 MHz), so 8 ticks are 5 instructions.
/// Read it more often than every 2^32 ticks, 2.7·10^9 instructions.
#[derive(Debug)]
pub struct Counter {
    last: u32,
    ticks: u64,
}

impl Counter {
    /// Starts the timer.
    #[must_use]
    pub fn start() -> Self {
        // SAFETY: registers of a timer that nothing else uses.
        #[expect(unsafe_code, reason = "memory-mapped registers")]
        unsafe {
            TIMER.add(2).write_volatile(u32::MAX);
            TIMER.add(1).write_volatile(u32::MAX);
            TIMER.write_volatile(1);
        }
        Self {
            last: u32::MAX,
            ticks: 0,
        }
    }

    /// Instructions executed since the start.
    pub fn read(&mut self) -> u64 {
        // SAFETY: as above. The timer counts down.
        #[expect(unsafe_code, reason = "memory-mapped registers")]
        let now = unsafe { TIMER.add(1).read_volatile() };
        self.ticks += u64::from(self.last.wrapping_sub(now));
        self.last = now;
        self.ticks * 5 / 8
    }
}

#[expect(unsafe_code, reason = "the handler's signature")]
mod fault {
    use super::*;

    #[exception]
    unsafe fn HardFault(_: &ExceptionFrame) -> ! {
        ExitCode::from(FAULT).exit_process()
    }
}
