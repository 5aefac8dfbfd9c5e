//! Instructions of a display on small cores: counted on an emulator at two sizes, then linear.
//!
//! A refresh costs so much a stored sample and so much a pixel; between refreshes so much a new
//! sample and so much for what comes with each refresh. These four are found from four runs; what
//! is not counted is not guessed.

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
    /// A 32-bit RISC-V.
    RiscV,
}

const CORES: [(&str, Core); 3] = [
    ("cortex-m4", Core::CortexM4),
    ("cortex-m7", Core::CortexM7),
    ("riscv", Core::RiscV),
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

/// Instructions of one configuration of a display on one core.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Effort {
    /// For receiving a new sample.
    pub new: f64,
    /// For receiving what comes with a refresh besides samples.
    pub refresh: f64,
    /// For a stored sample at a refresh.
    pub stored: f64,
    /// For a pixel at a refresh.
    pub pixel: f64,
}

impl Effort {
    /// For making a picture of `pixels` from `stored` samples.
    #[must_use]
    pub fn picture(&self, stored: f64, pixels: f64) -> f64 {
        self.stored * stored + self.pixel * pixels
    }

    /// For receiving `new` samples and a refresh.
    #[must_use]
    pub fn receive(&self, new: f64) -> f64 {
        self.new * new + self.refresh
    }
}

/// One emulated run: means over its last refreshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Count {
    /// New samples a refresh.
    pub new: f64,
    /// Samples stored.
    pub stored: f64,
    /// Pixels.
    pub pixels: f64,
    /// Instructions from a refresh to the next one's packet.
    pub receive: f64,
    /// Instructions of a picture.
    pub picture: f64,
}

/// Something that can count.
pub trait Counter {
    /// Plays a stream on a core: `config` is a name of the firmware's configurations, `samples`
    /// what is remembered. None where there is no such core or no emulator.
    ///
    /// # Errors
    /// The emulator fails.
    fn count(&self, core: Core, stream: &[u8], config: &str, samples: u32)
    -> Result<Option<Count>>;
}

/// The effort that explains two runs on one panel that differ in new and stored samples.
#[must_use]
pub fn effort(few: &Count, many: &Count) -> Effort {
    let slope = |a: f64, b: f64, from: f64, to: f64| (b - a) / (to - from).max(1.0);
    let new = slope(few.receive, many.receive, few.new, many.new);
    let stored = slope(few.picture, many.picture, few.stored, many.stored);
    Effort {
        new,
        refresh: few.receive - new * few.new,
        stored,
        pixel: (few.picture - stored * few.stored) / few.pixels.max(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_runs_give_back_what_they_were_made_of() {
        let made = Effort {
            new: 1000.0,
            refresh: 70_000.0,
            stored: 2500.0,
            pixel: 3000.0,
        };
        let run = |new: f64, stored: f64| Count {
            new,
            stored,
            pixels: 4096.0,
            receive: made.receive(new),
            picture: made.picture(stored, 4096.0),
        };
        let found = effort(&run(100.0, 4000.0), &run(400.0, 16_000.0));
        for (a, b) in [
            (found.new, made.new),
            (found.refresh, made.refresh),
            (found.stored, made.stored),
            (found.pixel, made.pixel),
        ] {
            assert!((a - b).abs() < 1e-6 * b, "{a} {b}");
        }
    }
}
