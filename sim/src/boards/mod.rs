//! The microcontrollers: images built from `crates/firmware`, run under QEMU, looked into.
//!
//! | module | concern |
//! |---|---|
//! | `build` | an image from source, by rustup's target or by Debian's source of core |
//! | `emulator` | an image on a board, a stream in, hashes and counts out |
//! | [`elf`] | what an image holds: sizes, panics, an allocator, float instructions |

mod build;
pub mod elf;
mod emulator;

pub use build::{Firmware, Fitted, Image};
pub use emulator::{Job, Report, Shown};

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Board {
    /// mps2-an386: an Arm Cortex-M4 with a single-precision FPU.
    CortexM4F,
    /// mps2-an500: an Arm Cortex-M7.
    CortexM7,
    /// QEMU's `virt` with an rv32imac: no FPU.
    RiscV,
}

impl Board {
    /// All boards.
    pub const ALL: [Self; 3] = [Self::CortexM4F, Self::CortexM7, Self::RiscV];

    /// The name as typed and as in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::CortexM4F => "cortex-m4f",
            Self::CortexM7 => "cortex-m7",
            Self::RiscV => "rv32imac",
        }
    }

    /// What its code is compiled for: both Cortex-M run the same image.
    #[must_use]
    pub fn target(self) -> Target {
        match self {
            Self::CortexM4F | Self::CortexM7 => Target::CortexM,
            Self::RiscV => Target::RiscV,
        }
    }
}

/// What code is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// thumbv7em-none-eabihf
    CortexM,
    /// riscv32imac-unknown-none-elf
    RiscV,
}

impl Target {
    /// Both.
    pub const ALL: [Self; 2] = [Self::CortexM, Self::RiscV];

    /// The compiler's name.
    #[must_use]
    pub fn triple(self) -> &'static str {
        match self {
            Self::CortexM => "thumbv7em-none-eabihf",
            Self::RiscV => "riscv32imac-unknown-none-elf",
        }
    }
}

/// Why a board shows nothing.
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// A tool is not installed. Tests leave out what needs it, but never in CI.
    #[error("{what} is missing: {remedy}")]
    Missing {
        /// The tool.
        what: String,
        /// What to type.
        remedy: String,
    },
    /// The image does not build.
    #[error("the image {image} does not build for {target}:\n{output}")]
    Build {
        /// Which image.
        image: &'static str,
        /// For which target.
        target: &'static str,
        /// The end of the compiler's output.
        output: String,
    },
    /// The image did not do its job.
    #[error("{board}: {reason}")]
    Run {
        /// Where.
        board: &'static str,
        /// Why.
        reason: String,
    },
    /// A file cannot be read or written, or does not hold what it should.
    #[error("{file}: {reason}")]
    File {
        /// Which.
        file: String,
        /// Why.
        reason: String,
    },
}
