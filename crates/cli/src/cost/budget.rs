//! The budget solver: the best preset that fits a machine, a link and a memory.

use std::str::FromStr;

use serde::Serialize;

use super::cores::{Core, Effort};

/// What there is to spend: `cortex-m7@480MHz link=20Mbit/s ram=1MiB 128x128@60Hz`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// The display's core; this machine's where none is named.
    pub core: Option<Core>,
    /// Cycles a second; of this machine's core none.
    pub hertz: f64,
    /// Bits a second.
    pub link: f64,
    /// Bytes.
    pub ram: f64,
    /// Panel width, pixels.
    pub width: u16,
    /// Panel height, pixels.
    pub height: u16,
    /// Refreshes a second.
    pub refresh: f64,
}

/// Why a budget cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}; a budget is like \"cortex-m7@480MHz link=20Mbit/s ram=1MiB 128x128@60Hz\"")]
pub struct BudgetError(String);

impl FromStr for Budget {
    type Err = BudgetError;

    fn from_str(text: &str) -> Result<Self, BudgetError> {
        let mut budget = Self {
            core: None,
            hertz: f64::INFINITY,
            link: f64::INFINITY,
            ram: f64::INFINITY,
            width: 0,
            height: 0,
            refresh: 60.0,
        };
        for word in text.split_whitespace() {
            let bad = || BudgetError(format!("`{word}` is not understood"));
            if let Some(link) = word.strip_prefix("link=") {
                budget.link = quantity(link, &LINKS).ok_or_else(bad)?;
            } else if let Some(ram) = word.strip_prefix("ram=") {
                budget.ram = quantity(ram, &SIZES).ok_or_else(bad)?;
            } else if word == "this" {
                budget.core = None;
            } else if let Some((name, clock)) = word.split_once('@') {
                let size = name
                    .split_once('x')
                    .filter(|_| name.starts_with(|c: char| c.is_ascii_digit()));
                if let Some((width, height)) = size {
                    budget.width = width.parse().map_err(|_| bad())?;
                    budget.height = height.parse().map_err(|_| bad())?;
                    budget.refresh = quantity(clock, &CLOCKS).ok_or_else(bad)?;
                } else {
                    let core = Core::named(name).ok_or_else(|| {
                        let known = Core::names();
                        BudgetError(format!("there is no core `{name}` (there are {known})"))
                    })?;
                    budget.core = Some(core);
                    budget.hertz = quantity(clock, &CLOCKS).ok_or_else(bad)?;
                }
            } else {
                return Err(bad());
            }
        }
        if unframed_recon::Panel::new(budget.width, budget.height).is_none() {
            return Err(BudgetError(
                "the panel's size is missing or out of range".to_owned(),
            ));
        }
        Ok(budget)
    }
}

const LINKS: [(&str, f64); 6] = [
    ("Gbit/s", 1e9),
    ("Mbit/s", 1e6),
    ("kbit/s", 1e3),
    ("bit/s", 1.0),
    ("MB/s", 8e6),
    ("kB/s", 8e3),
];
const SIZES: [(&str, f64); 5] = [
    ("MiB", 1_048_576.0),
    ("KiB", 1024.0),
    ("MB", 1e6),
    ("kB", 1e3),
    ("B", 1.0),
];
const CLOCKS: [(&str, f64); 4] = [("GHz", 1e9), ("MHz", 1e6), ("kHz", 1e3), ("Hz", 1.0)];

/// A number above 0 with one of these units.
fn quantity(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, factor) = units
        .iter()
        .find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))?;
    let value = number.trim().parse::<f64>().ok()? * factor;
    (value > 0.0 && value.is_finite()).then_some(value)
}

/// A preset as the solver sees it: on the panel of the budget.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Its name.
    pub preset: &'static str,
    /// RMSE as measured on the panel of the report.
    pub rmse: f64,
    /// Samples a second.
    pub rate: u32,
    /// Samples remembered.
    pub samples: u32,
    /// Bytes a second.
    pub bytes_per_second: f64,
    /// RAM, bytes: exact.
    pub ram_bytes: u64,
    /// Core seconds a second on this machine.
    pub display_seconds: f64,
    /// Instructions, where the core was counted.
    pub effort: Option<Effort>,
}

/// How much of each budget is used: 1 is all of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Use {
    /// Instructions over cycles, or core seconds of this machine a second; none if not known.
    pub time: Option<f64>,
    /// Of the link.
    pub link: f64,
    /// Of the RAM.
    pub ram: f64,
}

impl Use {
    fn parts(&self) -> [(&'static str, Option<f64>); 3] {
        [
            ("time", self.time),
            ("link", Some(self.link)),
            ("RAM", Some(self.ram)),
        ]
    }

    /// Whether all of it fits.
    #[must_use]
    pub fn fits(&self) -> bool {
        self.parts()
            .iter()
            .all(|(_, used)| used.is_some_and(|used| used <= 1.0))
    }

    /// What is used most, and how much.
    #[must_use]
    pub fn tightest(&self) -> (&'static str, f64) {
        let known = self
            .parts()
            .into_iter()
            .filter_map(|(name, v)| Some((name, v?)));
        known.fold(("nothing", 0.0), |a, b| if b.1 > a.1 { b } else { a })
    }
}

impl Budget {
    /// What a candidate would use. One instruction a cycle: cores with caches and dual issue do
    /// better, flash with wait states worse.
    #[must_use]
    pub fn used(&self, candidate: &Candidate) -> Use {
        let pixels = f64::from(self.width) * f64::from(self.height);
        let time = match self.core {
            None => Some(candidate.display_seconds * self.refresh / 60.0),
            Some(_) => {
                let instructions = candidate.effort.map(|effort| effort.refresh(pixels));
                instructions.map(|count| count * self.refresh / self.hertz)
            }
        };
        Use {
            time,
            link: 8.0 * candidate.bytes_per_second / self.link,
            ram: candidate.ram_bytes as f64 / self.ram,
        }
    }
}

/// The solver's answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// The budget.
    pub budget: Budget,
    /// The best preset that fits.
    pub preset: Option<Candidate>,
    /// What of the budget it uses.
    pub used: Option<Use>,
    /// What binds: what the next better preset lacks, or, where nothing fits, the least one.
    pub binds: Vec<String>,
    /// Each preset and what it would use.
    pub all: Vec<(Candidate, Use)>,
}

/// Finds the preset of least error that fits.
#[must_use]
pub fn solve(budget: Budget, candidates: Vec<Candidate>) -> Answer {
    let mut all: Vec<(Candidate, Use)> = candidates
        .into_iter()
        .map(|candidate| {
            let used = budget.used(&candidate);
            (candidate, used)
        })
        .collect();
    all.sort_by(|a, b| a.0.rmse.total_cmp(&b.0.rmse));
    let best = all.iter().position(|(_, used)| used.fits());
    // Those that are better do not fit; of them the cheapest is the next step.
    let lacking = match best {
        Some(0) => None,
        Some(best) => all.get(best - 1),
        None => all
            .iter()
            .min_by(|a, b| a.1.tightest().1.total_cmp(&b.1.tightest().1)),
    };
    let binds = lacking.map_or_else(Vec::new, |(candidate, used)| {
        let missing = |(name, used): (&'static str, Option<f64>)| match used {
            Some(used) if used > 1.0 => Some(format!(
                "{name}: `{}` needs {used:.2} times as much",
                candidate.preset
            )),
            Some(_) => None,
            None => Some(format!(
                "{name}: not known, this core's instructions were not counted"
            )),
        };
        used.parts().into_iter().filter_map(missing).collect()
    });
    Answer {
        budget,
        preset: best.map(|best| all[best].0.clone()),
        used: best.map(|best| all[best].1),
        binds,
        all,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(preset: &'static str, rmse: f64, scale: f64) -> Candidate {
        Candidate {
            preset,
            rmse,
            rate: (1000.0 * scale) as u32,
            samples: (1000.0 * scale) as u32,
            bytes_per_second: 8000.0 * scale,
            ram_bytes: (100_000.0 * scale) as u64,
            display_seconds: 0.01 * scale,
            effort: Some(Effort {
                receive: 1000.0 * scale,
                picture: 3000.0 * scale,
            }),
        }
    }

    #[test]
    fn budgets_are_read_with_their_units_and_refused_with_a_reason() {
        let text = "cortex-m7@480MHz link=20Mbit/s ram=1MiB 128x96@50Hz";
        let budget: Budget = text.parse().unwrap();
        assert_eq!(
            (budget.hertz, budget.link, budget.ram),
            (480e6, 20e6, 1_048_576.0)
        );
        assert_eq!(
            (budget.width, budget.height, budget.refresh),
            (128, 96, 50.0)
        );
        assert_eq!(budget.core, Core::named("cortex-m7"));
        for bad in [
            "",
            "ram=1MiB",
            "z80@4MHz 8x8@60Hz",
            "link=20 8x8@60Hz",
            "ram=-1MiB 8x8@60Hz",
            "0x8@60Hz",
            "8x8@60",
            "nonsense 8x8@60Hz",
        ] {
            assert!(bad.parse::<Budget>().is_err(), "{bad}");
        }
    }

    #[test]
    fn the_best_that_fits_is_chosen_and_what_binds_is_said() {
        let candidates = || {
            vec![
                candidate("small", 20.0, 1.0),
                candidate("medium", 15.0, 4.0),
                candidate("large", 10.0, 16.0),
            ]
        };
        let ask = |text: &str| solve(text.parse().unwrap(), candidates());
        let name = |answer: &Answer| answer.preset.as_ref().map(|p| p.preset);
        let answer = ask("cortex-m7@10GHz link=1Gbit/s ram=500kB 16x16@60Hz");
        assert_eq!(name(&answer), Some("medium"));
        assert!(answer.binds.len() == 1 && answer.binds[0].starts_with("RAM"));
        let answer = ask("cortex-m7@10GHz link=100kbit/s ram=1MiB 16x16@60Hz");
        assert_eq!(name(&answer), Some("small"));
        assert!(answer.binds[0].starts_with("link"), "{:?}", answer.binds);
        // 60 × 256 × 4000 instructions are 61.44 million.
        let answer = ask("cortex-m7@61.5MHz link=1Gbit/s ram=1000MB 16x16@60Hz");
        assert_eq!(name(&answer), Some("small"));
        assert!(answer.binds[0].starts_with("time"), "{:?}", answer.binds);
        let answer = ask("cortex-m7@61.4MHz link=1Gbit/s ram=1000MB 16x16@60Hz");
        assert_eq!(name(&answer), None);
        assert!(answer.binds[0].contains("small"), "{:?}", answer.binds);
        let answer = ask("this ram=1000MB 16x16@60Hz");
        assert_eq!(name(&answer), Some("large"));
        assert!(answer.binds.is_empty());
    }
}
