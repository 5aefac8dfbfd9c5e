//! QEMU's `virt` with an rv32imac: counting by `minstret`, faults.

use crate::FAULT;
use semihosting::process::ExitCode;

/// Counts executed instructions by `minstret` (exact under `-icount`).
#[derive(Debug)]
pub struct Counter {
    first: u64,
}

impl Counter {
    /// Starts counting.
    #[must_use]
    pub fn start() -> Self {
        Self {
            first: riscv::register::minstret::read64(),
        }
    }

    /// Instructions executed since the start.
    pub fn read(&mut self) -> u64 {
        riscv::register::minstret::read64() - self.first
    }
}

#[expect(unsafe_code, reason = "the name by which riscv-rt knows the handler")]
#[unsafe(export_name = "ExceptionHandler")]
fn exception(_: &riscv_rt::TrapFrame) -> ! {
    ExitCode::from(FAULT).exit_process()
}
