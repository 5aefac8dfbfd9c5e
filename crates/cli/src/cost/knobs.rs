//! The knobs that trade error for cost, and the points at which they are measured.

use serde::Serialize;
use unframed_host::stream::Detail;
use unframed_recon::Config;
use unframed_recon::config::{Extents, Fit, Lifetime, Light, TimeKernel};

use super::effects;
use super::formats::{FORMATS, Narrow};
use crate::method::{Method, Sampling};

/// In which numbers a display computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Integers: what is deployed.
    Fixed,
    /// 32-bit floats.
    F32,
    /// 64-bit floats: the oracle.
    F64,
    /// Integers with fewer bits, emulated: what they would show, not how long they would take.
    Narrow(Narrow),
}

impl Format {
    /// For people and for tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::F32 => "f32",
            Self::F64 => "f64",
            Self::Narrow(narrow) => narrow.label(),
        }
    }

    /// Whether its time and memory are those of a display that could be built.
    #[must_use]
    pub fn is_real(self) -> bool {
        !matches!(self, Self::Narrow(_))
    }
}

impl Serialize for Format {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// In one phrase, what a stream leaves out; nothing where it leaves out nothing.
fn left_out(detail: Detail) -> String {
    let all = Detail::default();
    let mut said = Vec::new();
    if detail.lamps {
        said.push("lamps".to_owned());
    }
    if detail.place_bits != all.place_bits {
        said.push(format!("places of {} bits", detail.place_bits));
    }
    if detail.colour_bits != all.colour_bits {
        said.push(format!("colours of {} bits", detail.colour_bits));
    }
    if detail.tiles_every != all.tiles_every {
        said.push(format!("tiles every {} refreshes", detail.tiles_every));
    }
    said.join(" and ")
}

/// In one phrase, how a sampler is set otherwise than it comes; nothing where it is not.
fn set_otherwise(sampling: Sampling) -> String {
    let usual = Sampling::default();
    let mut said = Vec::new();
    if sampling.depth != usual.depth {
        said.push(format!("{} deep", sampling.depth));
    }
    if sampling.pattern != usual.pattern {
        said.push(effects::side(sampling.pattern));
    }
    said.join(" and ")
}

/// One setting of everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knobs {
    /// Which sampler, stream and display.
    pub method: Method,
    /// Samples a pixel and second: the rate of the stream over the pixels of the panel.
    pub density: f64,
    /// How many seconds of the stream the display remembers: N over the rate.
    pub memory: f64,
    /// In which numbers the display computes.
    pub format: Format,
    /// How the sampler is set.
    pub sampling: Sampling,
    /// How finely the stream tells things.
    pub detail: Detail,
    /// What the display does.
    pub display: Config,
}

impl Knobs {
    /// A method as it comes, at `density` samples a pixel and second.
    #[must_use]
    pub fn new(method: Method, density: f64) -> Self {
        Self {
            method,
            density,
            memory: 1.0,
            format: Format::Fixed,
            sampling: Sampling::default(),
            detail: Detail {
                lamps: false,
                ..Detail::default()
            },
            display: method.display(),
        }
    }

    /// Samples a second for a panel of this many pixels.
    #[must_use]
    pub fn rate(&self, pixels: u32) -> u32 {
        (self.density * f64::from(pixels)).round().max(1.0) as u32
    }

    /// Samples remembered by a panel of this many pixels.
    #[must_use]
    pub fn samples(&self, pixels: u32) -> u32 {
        (self.memory * self.density * f64::from(pixels))
            .round()
            .max(1.0) as u32
    }

    /// For people and for JSON.
    #[must_use]
    pub fn described(&self, pixels: u32) -> Described {
        let display = &self.display;
        let seconds = |log: i16| format!("{:.2} s", (f64::from(log) / 256.0).exp2());
        Described {
            method: self.method.name(),
            rate: self.rate(pixels),
            samples: self.samples(pixels),
            format: self.format,
            sampling: set_otherwise(self.sampling),
            detail: left_out(self.detail),
            fit: match display.fit {
                Fit::Constant => "mean",
                Fit::Linear => "plane",
            },
            hidden: display.hidden,
            extents: match display.extents {
                Extents::Constant(log) => format!("{:.2} px", (f64::from(log) / 256.0).exp2()),
                Extents::Density => "density".to_owned(),
                Extents::Gradient => "gradient".to_owned(),
                Extents::Pixel => "pixel".to_owned(),
            },
            lifetime: match display.lifetime {
                Lifetime::Constant(log) => seconds(log),
                Lifetime::Tiles => "tiles".to_owned(),
                Lifetime::Gradient => "gradient".to_owned(),
            },
            kernel: match display.kernel {
                TimeKernel::Rational => "rational",
                TimeKernel::Gaussian => "gaussian",
                TimeKernel::Exponential => "exponential",
            },
            cutoff: match display.cutoff {
                0 => "none".to_owned(),
                cutoff => format!("1/{:.0}", 32_768.0 / f64::from(cutoff)),
            },
            fill: display.fill,
            light: match display.light {
                Light::Linear => "linear",
                Light::Encoded => "encoded",
            },
        }
    }
}

/// Knobs with names, as reports have them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Described {
    /// The method's name.
    pub method: &'static str,
    /// Samples a second.
    pub rate: u32,
    /// Samples remembered (N).
    pub samples: u32,
    /// Numbers.
    pub format: Format,
    /// How the sampler is set otherwise than it comes; empty where it is not.
    pub sampling: String,
    /// What the stream leaves out; empty where nothing.
    pub detail: String,
    /// What is fitted.
    pub fit: &'static str,
    /// Whether the hidden-point test is on.
    pub hidden: bool,
    /// What shapes the filter in space.
    pub extents: String,
    /// What gives a sample's lifetime.
    pub lifetime: String,
    /// How weight declines with age.
    pub kernel: &'static str,
    /// The weight at which samples no longer count.
    pub cutoff: String,
    /// Whether holes are filled.
    pub fill: bool,
    /// What is filtered.
    pub light: &'static str,
}

impl Described {
    /// In one line: what differs from the default of the method.
    #[must_use]
    pub fn line(&self) -> String {
        let hidden = if self.hidden { "" } else { ", no hidden test" };
        let fill = if self.fill { "" } else { ", no fill" };
        let and = |said: &str| match said {
            "" => String::new(),
            said => format!(", {said}"),
        };
        let cutoff = match self.cutoff.as_str() {
            "none" => String::new(),
            weight => format!(" down to {weight}"),
        };
        format!(
            "{} {}/s{}{}, N {}, {}, {}{hidden}, σ {}, τ {}, {}{cutoff}{fill}, {} light",
            self.method,
            super::short(self.rate),
            and(&self.sampling),
            and(&self.detail),
            super::short(self.samples),
            self.format.name(),
            self.fit,
            self.extents,
            self.lifetime,
            self.kernel,
            self.light
        )
    }
}

/// A setting worth a name. Measured, none of them is beaten by another point in everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Samples a pixel and second.
    density: f64,
    /// Seconds of the stream that are remembered.
    memory: f64,
    fit: Fit,
    hidden: bool,
    extents: Extents,
    rest: bool,
}

/// From the cheapest to the best, chosen at 128 × 128 pixels on three scenes. The Gaussian decline
/// comes to zero where the rational one has a tail: the same error for fewer samples that count.
/// Only the least does without the hidden-point test: the older a sample may be, the more the test
/// is worth.
pub const PRESETS: [Preset; 7] = [
    Preset {
        hidden: false,
        memory: 0.25,
        extents: Extents::Pixel,
        rest: false,
        ..preset("tiny", 1.5, Fit::Constant)
    },
    Preset {
        hidden: false,
        memory: 0.25,
        ..preset("least", 1.5, Fit::Constant)
    },
    preset("small", 1.5, Fit::Constant),
    preset("low", 3.0, Fit::Constant),
    preset("medium", 6.0, Fit::Constant),
    preset("full", 12.0, Fit::Constant),
    preset("best", 24.0, Fit::Linear),
];

const fn preset(name: &'static str, density: f64, fit: Fit) -> Preset {
    Preset {
        name,
        density,
        memory: 0.5,
        fit,
        hidden: true,
        extents: Extents::Density,
        rest: true,
    }
}

impl Preset {
    /// What it sets.
    #[must_use]
    pub fn knobs(&self) -> Knobs {
        let knobs = Knobs::new(Method::Adaptive, self.density);
        Knobs {
            memory: self.memory,
            display: Config {
                kernel: TimeKernel::Gaussian,
                fit: self.fit,
                hidden: self.hidden,
                extents: self.extents,
                rest: self.rest,
                ..knobs.display
            },
            ..knobs
        }
    }

    /// The preset that sets just this.
    #[must_use]
    pub fn of(knobs: &Knobs) -> Option<&'static str> {
        let same = PRESETS.iter().find(|preset| preset.knobs() == *knobs);
        same.map(|preset| preset.name)
    }
}

/// Densities of the sweeps, samples a pixel and second: 6.1 are 400k a second on 256 × 256.
pub const DENSITIES: [f64; 5] = [1.5, 3.0, 6.0, 12.0, 24.0];
/// The density at which single knobs are turned.
pub const MIDDLE: f64 = 6.0;
/// Seconds of the stream that a display remembers.
const MEMORIES: [f64; 3] = [0.25, 0.5, 1.0];

/// The sweep of [`Sampling::depth`], around `paper` instead of `adaptive`.
pub const DEPTHS: &str = "depth of the sampler";

/// A point and the sweep that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned {
    /// The knob that is turned.
    pub sweep: &'static str,
    /// The setting.
    pub knobs: Knobs,
}

/// All points of all sweeps; a setting that belongs to several stands in each.
#[must_use]
pub fn sweeps() -> Vec<Planned> {
    let middle = Knobs::new(Method::Adaptive, MIDDLE);
    let with = |change: &dyn Fn(&mut Config)| {
        let mut knobs = middle;
        change(&mut knobs.display);
        knobs
    };
    let mut points = Vec::new();
    let mut add = |sweep, knobs: &[Knobs]| {
        points.extend(knobs.iter().map(|knobs| Planned {
            sweep,
            knobs: *knobs,
        }));
    };
    for method in [
        Method::Adaptive,
        Method::UniformSameDisplay,
        Method::Uniform,
        Method::Paper,
    ] {
        add(
            "method and rate",
            &DENSITIES.map(|density| Knobs::new(method, density)),
        );
    }
    let format = |format| Knobs { format, ..middle };
    add(
        "number format",
        &[Format::Fixed, Format::F32, Format::F64].map(format),
    );
    for (sweep, narrow) in FORMATS {
        add(sweep, &[middle]);
        for narrow in *narrow {
            add(sweep, &[format(Format::Narrow(*narrow))]);
        }
    }
    let detail = |change: &dyn Fn(&mut Detail)| {
        let mut knobs = middle;
        change(&mut knobs.detail);
        knobs
    };
    let places = [16, 12, 10].map(|bits| detail(&|d| d.place_bits = bits));
    add("wire: bits of places", &places);
    let colours = [8, 6, 4].map(|bits| detail(&|d| d.colour_bits = bits));
    add("wire: bits of colours", &colours);
    let tilings = [1, 2, 8].map(|every| detail(&|d| d.tiles_every = every));
    add("wire: refreshes a tiling", &tilings);
    let lamps = [false, true].map(|lamps| detail(&|d| d.lamps = lamps));
    add("wire: shares of lamps", &lamps);
    let paper = Knobs::new(Method::Paper, MIDDLE);
    let depth = |depth| Knobs {
        sampling: Sampling {
            depth,
            ..paper.sampling
        },
        ..paper
    };
    add(DEPTHS, &[1, 2, 4, 8].map(depth));
    let memory = |memory| Knobs { memory, ..middle };
    add(
        "samples remembered",
        &[0.0625, 0.125, 0.25, 0.5, 1.0, 2.0].map(memory),
    );
    let fit = |fit| with(&|c| c.fit = fit);
    add("fit", &[Fit::Constant, Fit::Linear].map(fit));
    add(
        "hidden-point test",
        &[false, true].map(|on| with(&|c| c.hidden = on)),
    );
    add("filling", &[false, true].map(|on| with(&|c| c.fill = on)));
    // 0.35, 0.45, 0.6, 0.85 px and as density has it.
    let widths = [-388, -295, -189, -60].map(|log| with(&|c| c.extents = Extents::Constant(log)));
    add("filter width", &widths);
    add("filter width", &[with(&|c| c.extents = Extents::Pixel)]);
    add("filter width", &[middle]);
    let kernels = [
        TimeKernel::Rational,
        TimeKernel::Gaussian,
        TimeKernel::Exponential,
    ];
    add(
        "decline with age",
        &kernels.map(|kernel| with(&|c| c.kernel = kernel)),
    );
    let cutoffs = [0, 32, 128, 256, 512, 1024].map(|cutoff| with(&|c| c.cutoff = cutoff));
    add("cut-off of weights", &cutoffs);
    // 0.1, 0.2, 0.4 and 0.8 s for all, and a lifetime a tile.
    let lives = [-850, -594, -338, -82].map(|log| with(&|c| c.lifetime = Lifetime::Constant(log)));
    add("lifetime", &lives);
    add("lifetime", &[middle]);
    add(
        "light",
        &[Light::Linear, Light::Encoded].map(|light| with(&|c| c.light = light)),
    );
    for density in DENSITIES {
        let mut together = |memory, kernel, fit, hidden| {
            let mut knobs = Knobs::new(Method::Adaptive, density);
            knobs.memory = memory;
            knobs.display = Config {
                kernel,
                fit,
                hidden,
                ..knobs.display
            };
            add("all together", &[knobs]);
        };
        for memory in MEMORIES {
            for fit in [Fit::Constant, Fit::Linear] {
                together(memory, TimeKernel::Rational, fit, true);
                together(memory, TimeKernel::Gaussian, fit, true);
            }
        }
        together(MEMORIES[0], TimeKernel::Gaussian, Fit::Constant, false);
        // Samples that count for their pixels alone: what a small core has time and room for.
        for (memory, hidden) in [
            (MEMORIES[0], false),
            (MEMORIES[1], false),
            (MEMORIES[1], true),
        ] {
            let mut knobs = Knobs::new(Method::Adaptive, density);
            knobs.memory = memory;
            knobs.display = Config {
                kernel: TimeKernel::Gaussian,
                fit: Fit::Constant,
                extents: Extents::Pixel,
                hidden,
                rest: hidden,
                ..knobs.display
            };
            add("all together", &[knobs]);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_measured_and_has_its_name() {
        let points = sweeps();
        for preset in PRESETS {
            assert!(
                points.iter().any(|p| p.knobs == preset.knobs()),
                "{}",
                preset.name
            );
            assert_eq!(Preset::of(&preset.knobs()), Some(preset.name));
        }
    }

    #[test]
    fn a_sweep_turns_one_knob() {
        for sweep in [
            "number format",
            "fit",
            "filling",
            "light",
            "filter width",
            "lifetime",
            "cut-off of weights",
            "bits of weights",
            "steps of ages",
            "wire: bits of places",
            "wire: bits of colours",
            "wire: refreshes a tiling",
            DEPTHS,
            effects::SWEEP,
        ] {
            let all = sweeps().into_iter().chain(effects::sweep());
            let points: Vec<_> = all.filter(|p| p.sweep == sweep).collect();
            assert!(points.len() >= 2, "{sweep}");
            let rest = |p: &Planned| (p.knobs.method, p.knobs.density, p.knobs.memory);
            assert!(
                points.windows(2).all(|w| rest(&w[0]) == rest(&w[1])),
                "{sweep}"
            );
            assert!(
                points.windows(2).all(|w| w[0].knobs != w[1].knobs),
                "{sweep}"
            );
        }
    }
}
