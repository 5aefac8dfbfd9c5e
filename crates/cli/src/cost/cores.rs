//! Instructions of a display on small cores, counted on an emulator.
//!
//! A preset sets everything by the pixel: samples a second, samples remembered. So what a refresh
//! costs grows with the pixels and with nothing else, and one count on a small panel tells all
//! others. What was not counted is not guessed.

use anyhow::Result;
use serde::Serialize;

/// A core whose instructions can be counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Core {
    /// Arm Cortex-M4F.
    CortexM4,
    /// Arm Cortex-M7.
    CortexM7,
    /// A 32-bit RISC-V without an FPU.
    RiscV,
}

const CORES: [(&str, Core); 3] = [
    ("cortex-m4", Core::CortexM4),
    ("cortex-m7", Core::CortexM7),
    ("rv32imac", Core::RiscV),
];

impl Core {
    /// By name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let found = CORES.iter().find(|core| core.0 == name);
        found.map(|core| core.1)
    }

    /// All names.
    #[must_use]
    pub fn names() -> String {
        CORES.map(|core| core.0).join(", ") + ", or `this` machine"
    }
}

/// Instructions of one preset on one core, for a pixel of the panel and a refresh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Effort {
    /// Receiving what comes between two refreshes.
    pub receive: f64,
    /// Making the picture.
    pub picture: f64,
}

impl Effort {
    /// Instructions of a refresh of a panel of this many pixels.
    #[must_use]
    pub fn refresh(&self, pixels: f64) -> f64 {
        (self.receive + self.picture) * pixels
    }
}

/// What is to be counted.
#[derive(Clone, Copy, Debug)]
pub struct Play<'a> {
    /// The core.
    pub core: Core,
    /// The stream, with its panel's size in it.
    pub stream: &'a [u8],
    /// What the display does.
    pub config: unframed_recon::Config,
    /// Samples remembered.
    pub samples: u32,
    /// Pixels of the panel.
    pub pixels: u32,
    /// Refreshes before the count begins.
    pub warm_up: usize,
}

/// Something that can count.
pub trait Counter {
    /// Plays a stream on a core; none where this display is not among those that the firmware
    /// knows by name.
    ///
    /// # Errors
    /// The emulator or the firmware cannot be had, or fails.
    fn count(&self, play: &Play<'_>) -> Result<Option<Effort>>;
}
