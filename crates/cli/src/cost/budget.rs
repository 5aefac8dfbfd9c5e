//! The budget solver: the best preset that fits a machine, a link and a memory.

use std::str::FromStr;

use serde::Serialize;

use unframed_recon::Fixed;

use super::cores::Core;
use super::effort::Effort;
use super::knobs::Knobs;
use super::ram;
use crate::measure::REFRESH_HZ;

/// What there is to spend: `cortex-m7@480MHz link=20Mbit/s ram=1MiB 128x128@60Hz`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// The display's core; this machine's where none is named.
    pub core: Option<Core>,
    /// Cycles a second; of this machine's core none.
    pub hertz: f64,
    /// Cycles an instruction takes on average: 1 unless said. The emulator counts instructions;
    /// flash with wait states makes it more, a core that issues two at once less.
    pub cpi: f64,
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
            cpi: 1.0,
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
            } else if let Some(cpi) = word.strip_prefix("cpi=") {
                budget.cpi = quantity(cpi, &[("", 1.0)]).ok_or_else(bad)?;
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
const SIZES: [(&str, f64); 6] = [
    ("MiB", 1_048_576.0),
    ("KiB", 1024.0),
    ("GB", 1e9),
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
    /// Instructions of a mean refresh at 60 Hz, where the core can be counted.
    pub mean: Option<Effort>,
    /// Those of the dearest refresh: it must be in time too.
    pub worst: Option<Effort>,
    /// What it sets.
    #[serde(skip)]
    pub knobs: Knobs,
    /// Objects, and one for the sky.
    #[serde(skip)]
    pub slots: usize,
    /// Pixels a row, and rows.
    #[serde(skip)]
    pub panel: (u16, u16),
}

impl Candidate {
    /// The same preset on another panel: RAM is exact, all else grows with the pixels.
    #[must_use]
    pub fn on(&self, panel: (u16, u16)) -> Self {
        let pixels = |panel: (u16, u16)| u32::from(panel.0) * u32::from(panel.1);
        let scale = f64::from(pixels(panel)) / f64::from(pixels(self.panel));
        let scaled = |effort: Effort| Effort {
            receive: scale * effort.receive,
            picture: scale * effort.picture,
        };
        let samples = self.knobs.samples(pixels(panel));
        let config = &self.knobs.display;
        Self {
            rate: self.knobs.rate(pixels(panel)),
            samples,
            bytes_per_second: scale * self.bytes_per_second,
            ram_bytes: ram::bytes::<Fixed>(panel.0, panel.1, samples as usize, config, self.slots),
            display_seconds: scale * self.display_seconds,
            mean: self.mean.map(scaled),
            worst: self.worst.map(scaled),
            panel,
            ..self.clone()
        }
    }
}

/// How much of each budget is used: 1 is all of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Use {
    /// The dearest refresh's cycles over those that a refresh has, or core seconds of this machine
    /// a second; none if not known.
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
    /// What a candidate would use.
    #[must_use]
    pub fn used(&self, candidate: &Candidate) -> Use {
        let fewer = self.refresh / f64::from(REFRESH_HZ);
        let time = match self.core {
            None => Some(candidate.display_seconds * fewer),
            Some(_) => candidate.worst.map(|worst| {
                // As much is received in a second, however often it is shown.
                let instructions = worst.picture + worst.receive / fewer;
                instructions / self.instructions()
            }),
        };
        Use {
            time,
            link: 8.0 * candidate.bytes_per_second / self.link,
            ram: candidate.ram_bytes as f64 / self.ram,
        }
    }

    /// Instructions that there is time for in a refresh.
    #[must_use]
    pub fn instructions(&self) -> f64 {
        self.hertz / self.cpi / self.refresh
    }

    fn panel(&self) -> (u16, u16) {
        (self.width, self.height)
    }

    /// The largest panel of the same shape on which a candidate fits.
    fn largest(&self, candidate: &Candidate) -> Option<(u16, u16)> {
        let (width, height) = (u32::from(self.width), u32::from(self.height));
        (1..=self.width).rev().find_map(|w| {
            let h = (u32::from(w) * height + width / 2) / width;
            let panel = (w, h.max(1) as u16);
            self.used(&candidate.on(panel)).fits().then_some(panel)
        })
    }

    /// How often a candidate could be shown where nothing but time is missing, whole Hz.
    fn slower(&self, candidate: &Candidate) -> Option<f64> {
        (1..self.refresh.ceil() as u32)
            .rev()
            .map(f64::from)
            .find(|refresh| {
                let slower = Self {
                    refresh: *refresh,
                    ..*self
                };
                slower.used(candidate).fits()
            })
    }
}

/// What the preset that comes next lacks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lack {
    /// Its name.
    pub preset: &'static str,
    /// What there is too little of, and how much of it is needed.
    pub of: Vec<String>,
    /// The largest panel of the same shape on which it fits.
    pub panel: Option<(u16, u16)>,
    /// The refresh rate at which it fits on this panel, Hz.
    pub refresh: Option<f64>,
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
    /// What binds: what the next better preset lacks, or, where nothing fits, the least demanding.
    /// None where the best of all fits.
    pub binds: Option<Lack>,
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
    Answer {
        budget,
        preset: best.map(|best| all[best].0.clone()),
        used: best.map(|best| all[best].1),
        binds: lacking.map(|(candidate, used)| lack(&budget, candidate, used)),
        all,
    }
}

fn lack(budget: &Budget, candidate: &Candidate, used: &Use) -> Lack {
    let amount = |name: &str| match name {
        "RAM" => format!("{} of {:.0} bytes", candidate.ram_bytes, budget.ram),
        "link" => format!(
            "{:.2} of {:.2} Mbit/s",
            8e-6 * candidate.bytes_per_second,
            1e-6 * budget.link
        ),
        _ => match candidate.worst {
            Some(_) if budget.core.is_some() => format!(
                "{:.2} of {:.2} million instructions for the dearest refresh",
                1e-6 * used.time.unwrap_or(0.0) * budget.instructions(),
                1e-6 * budget.instructions()
            ),
            _ => "core seconds a second here".to_owned(),
        },
    };
    let missing = |(name, used): (&'static str, Option<f64>)| match used {
        Some(used) if used > 1.0 => Some(format!("{name} × {used:.2} ({})", amount(name))),
        Some(_) => None,
        None => Some(format!(
            "{name} unknown (this core's instructions were not counted)"
        )),
    };
    Lack {
        preset: candidate.preset,
        of: used.parts().into_iter().filter_map(missing).collect(),
        panel: budget
            .largest(&candidate.on(budget.panel()))
            .filter(|panel| *panel != budget.panel()),
        refresh: budget.slower(candidate),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Method;

    /// On 16 × 16 pixels.
    fn candidate(preset: &'static str, rmse: f64, density: f64) -> Candidate {
        let knobs = Knobs::new(Method::Adaptive, density);
        let scaled = |picture| Effort {
            receive: 256e3 * density,
            picture: 256.0 * picture * density,
        };
        Candidate {
            preset,
            rmse,
            rate: knobs.rate(256),
            samples: knobs.samples(256),
            bytes_per_second: 8000.0 * density,
            ram_bytes: 0,
            display_seconds: 0.01 * density,
            mean: Some(scaled(2500.0)),
            worst: Some(scaled(3000.0)),
            knobs,
            slots: 9,
            panel: (16, 16),
        }
        .on((16, 16))
    }

    #[test]
    fn budgets_are_read_with_their_units_and_refused_with_a_reason() {
        let text = "cortex-m7@480MHz cpi=1.25 link=20Mbit/s ram=1MiB 128x96@50Hz";
        let budget: Budget = text.parse().unwrap();
        assert_eq!(
            (budget.hertz, budget.link, budget.ram),
            (480e6, 20e6, 1_048_576.0)
        );
        assert_eq!(budget.instructions(), 480e6 / 1.25 / 50.0);
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
            "cpi=0 8x8@60Hz",
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
        let lacks = |answer: &Answer, what: &str| {
            let lack = answer.binds.clone().unwrap();
            assert!(
                lack.of.len() == 1 && lack.of[0].starts_with(what),
                "{lack:?}"
            );
            lack
        };
        let [small, medium, large] = [0, 1, 2].map(|i| candidates()[i].ram_bytes);
        assert!(small < medium && medium < large);
        let room = |bytes: u64| format!("cortex-m7@10GHz link=1Gbit/s ram={bytes}B 16x16@60Hz");
        let answer = ask(&room(large - 1));
        assert_eq!(name(&answer), Some("medium"));
        let lack = lacks(&answer, "RAM × 1.00");
        // A row or two less and it fits; showing it less often does not help.
        assert_eq!(
            (lack.preset, lack.panel, lack.refresh),
            ("large", Some((15, 15)), None)
        );
        assert_eq!(name(&ask(&room(large))), Some("large"));
        let answer = ask("cortex-m7@10GHz link=100kbit/s ram=1MiB 16x16@60Hz");
        assert_eq!(name(&answer), Some("small"));
        lacks(&answer, "link × 2.56 (0.26 of 0.10 Mbit/s)");
        // 256 × 4000 instructions are 1.024 million a refresh, 61.44 million a second.
        let answer = ask("cortex-m7@61.5MHz link=1Gbit/s ram=1000MB 16x16@60Hz");
        assert_eq!(name(&answer), Some("small"));
        lacks(&answer, "time × 4.00");
        let answer = ask("cortex-m7@61.4MHz link=1Gbit/s ram=1000MB 16x16@60Hz");
        assert_eq!(name(&answer), None);
        let lack = lacks(&answer, "time × 1.00");
        assert_eq!(
            (lack.preset, lack.panel, lack.refresh),
            ("small", Some((15, 15)), Some(59.0))
        );
        assert_eq!(
            name(&ask("cortex-m7@61.5MHz cpi=1.01 ram=1GB 16x16@60Hz")),
            None
        );
        // Half the refreshes receive as much each second: 256 × (3000 + 2 · 1000) · 30.
        let answer = ask("cortex-m7@38.4MHz ram=1000MB 16x16@30Hz");
        assert_eq!(answer.used.unwrap().time, Some(1.0));
        let answer = ask("this ram=1000MB 16x16@60Hz");
        assert_eq!(name(&answer), Some("large"));
        assert_eq!(answer.binds, None);
        let mut unknown = candidates();
        unknown
            .iter_mut()
            .for_each(|candidate| candidate.worst = None);
        let answer = solve("cortex-m4@1GHz 16x16@60Hz".parse().unwrap(), unknown);
        assert_eq!(name(&answer), None);
        lacks(&answer, "time unknown");
    }
}
