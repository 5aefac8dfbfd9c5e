//! The display's images: what they share.
//!
//! | module | concern |
//! |---|---|
//! | [`board`] | instructions counted, stack measured, faults ended |
//! | [`files`] | the stream in and results out, by semihosting |
//! | [`storage`] | the display's memory, static |
//! | [`play`] | a stream through the reconstructor, everything measured |
//! | `panel` | a display driver on an SPI bus that records |
//!
//! QEMU gives the instructions executed, not cycles: neither flash wait states nor caches nor dual
//! issue are in these numbers.
#![no_std]

pub mod board;
pub mod files;
mod host;
#[cfg(feature = "panel")]
pub mod panel;
pub mod play;
pub mod storage;

use semihosting::process::ExitCode;

/// Why an image ended without doing its job, and its exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// A file cannot be read or written.
    File = 3,
    /// The job's first line is not `CONFIG SAMPLES`.
    Job = 4,
    /// The stream has no Hello.
    NoHello = 5,
    /// The panel or the deep buffer is beyond this image's storage.
    TooLarge = 6,
    /// The display driver failed.
    Driver = 7,
}

/// Ends the image with the status of its outcome.
pub fn end(outcome: Result<(), Failure>) -> ! {
    match outcome {
        Ok(()) => ExitCode::SUCCESS.exit_process(),
        Err(failure) => ExitCode::from(failure as u8).exit_process(),
    }
}

/// Status of an image that ended by a fault of the processor.
pub const FAULT: u8 = 101;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    #[cfg(feature = "panics")]
    ExitCode::from(102).exit_process();
    #[cfg(not(feature = "panics"))]
    {
        // The linker drops this function unless something can panic. If something can, it finds no
        // such symbol and the build fails.
        #[expect(unsafe_code, reason = "a name that must not be linked")]
        {
            unsafe extern "C" {
                fn this_image_can_panic() -> !;
            }
            // SAFETY: never linked, so never called.
            unsafe { this_image_can_panic() }
        }
    }
}
