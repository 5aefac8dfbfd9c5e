//! The parts of `adaptive`, each of which can be left out to measure what it is worth.

use unframed_host::sampler::adaptive;
use unframed_recon::Config;
use unframed_recon::config::{Extents, Fit, Lifetime, Light, TimeKernel};

/// log2 of 0.5 px in 1/256: the width that one live sample a pixel gets.
const PLAIN_WIDTH: i16 = -256;
/// log2 of 0.6 s in 1/256: the best lifetime of uniform samples.
const PLAIN_LIFETIME: i16 = -192;

/// A part of `adaptive`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// Sampler: residuals steer the shots.
    Residuals,
    /// Sampler: what a tile already has counts.
    WaterFilling,
    /// Sampler: places seen before are looked at again; without, no lifetimes either.
    Verification,
    /// Sampler and display: a lifetime a tile instead of one for all.
    Lifetimes,
    /// Sampler: lifetimes balance staleness against noise, instead of a tolerance.
    Balance,
    /// Sampler: cuts are noticed.
    Cuts,
    /// Sampler: samples see the scene of the refresh, foreseen.
    Ahead,
    /// Stream and display: the display draws shadows of what moves.
    Lamps,
    /// Display: samples behind others are dropped.
    DisplayHidden,
    /// Display: filter width from density.
    Density,
    /// Display: a plane instead of a mean.
    Plane,
    /// Display: holes are filled from around.
    Fill,
    /// Display: the rational tail in time (instead: Gaussian).
    RationalTail,
    /// Display: linear light is filtered (instead: encoded values).
    LinearLight,
}

/// What is known of a part.
struct Entry {
    part: Part,
    /// The method without it.
    name: &'static str,
    /// What is different then, for readers.
    instead: &'static str,
    sampler: fn(&mut adaptive::Config),
    display: fn(&mut Config),
}

const PARTS: [Entry; 14] = [
    Entry {
        part: Part::Residuals,
        name: "adaptive-no-residuals",
        instead: "every tile is as interesting as any other",
        sampler: |c| c.residuals = false,
        display: |_| {},
    },
    Entry {
        part: Part::WaterFilling,
        name: "adaptive-no-water-filling",
        instead: "a tile's residual alone decides, not what it has",
        sampler: |c| c.water_filling = false,
        display: |_| {},
    },
    Entry {
        part: Part::Verification,
        name: "adaptive-no-verification",
        instead: "no second looks, one lifetime of 0.6 s",
        sampler: |c| {
            c.verify_share = 0.0;
            c.lifetimes = false;
        },
        display: |c| c.lifetime = Lifetime::Constant(PLAIN_LIFETIME),
    },
    Entry {
        part: Part::Lifetimes,
        name: "adaptive-no-lifetimes",
        instead: "second looks, but one lifetime of 0.6 s",
        sampler: |c| c.lifetimes = false,
        display: |c| c.lifetime = Lifetime::Constant(PLAIN_LIFETIME),
    },
    Entry {
        part: Part::Balance,
        name: "adaptive-no-balance",
        instead: "samples live until they are a tolerance off",
        sampler: |c| c.balanced = false,
        display: |_| {},
    },
    Entry {
        part: Part::Cuts,
        name: "adaptive-no-cuts",
        instead: "a scene that changes wholly goes unnoticed",
        sampler: |c| c.cuts = false,
        display: |_| {},
    },
    Entry {
        part: Part::Ahead,
        name: "adaptive-no-prediction",
        instead: "samples see each instant as it is, not the refresh as it will be",
        sampler: |c| c.ahead = false,
        display: |_| {},
    },
    Entry {
        part: Part::Lamps,
        name: "adaptive-no-lamps",
        instead: "shadows of what moves are in the samples",
        sampler: |_| {},
        display: |_| {},
    },
    Entry {
        part: Part::DisplayHidden,
        name: "adaptive-no-display-hidden-test",
        instead: "samples behind others shine through",
        sampler: |_| {},
        display: |c| c.hidden = false,
    },
    Entry {
        part: Part::Density,
        name: "adaptive-no-density-width",
        instead: "one filter width, 0.5 px",
        sampler: |_| {},
        display: |c| c.extents = Extents::Constant(PLAIN_WIDTH),
    },
    Entry {
        part: Part::Plane,
        name: "adaptive-no-plane",
        instead: "a weighted mean",
        sampler: |_| {},
        display: |c| c.fit = Fit::Constant,
    },
    Entry {
        part: Part::Fill,
        name: "adaptive-no-fill",
        instead: "pixels without samples keep what they show",
        sampler: |_| {},
        display: |c| c.fill = false,
    },
    Entry {
        part: Part::RationalTail,
        name: "adaptive-gaussian-tail",
        instead: "weight declines as a Gaussian of age",
        sampler: |_| {},
        display: |c| c.kernel = TimeKernel::Gaussian,
    },
    Entry {
        part: Part::LinearLight,
        name: "adaptive-encoded-light",
        instead: "encoded values are filtered",
        sampler: |_| {},
        display: |c| c.light = Light::Encoded,
    },
];

impl Part {
    /// All, sampler first.
    pub fn all() -> impl Iterator<Item = Self> {
        PARTS.iter().map(|entry| entry.part)
    }

    /// The name of the method without it.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// What is different without it.
    #[must_use]
    pub fn instead(self) -> &'static str {
        self.entry().instead
    }

    /// Whether it is the shadows that the display draws.
    #[must_use]
    pub fn is_lamps(self) -> bool {
        self == Self::Lamps
    }

    /// The sampler's knobs without it.
    #[must_use]
    pub fn sampler(self, mut config: adaptive::Config) -> adaptive::Config {
        (self.entry().sampler)(&mut config);
        config
    }

    /// The display's switches without it.
    #[must_use]
    pub fn display(self, mut config: Config) -> Config {
        (self.entry().display)(&mut config);
        config
    }

    /// The table stands in the order of the enumeration; a test holds it to that.
    fn entry(self) -> &'static Entry {
        &PARTS[self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_makes_a_difference_and_stands_in_its_place() {
        let (sampler, display) = (adaptive::Config::default(), Config::ADAPTIVE);
        for (i, part) in Part::all().enumerate() {
            assert_eq!(part as usize, i, "{}", part.name());
            let (sampled, shown) = (part.sampler(sampler.clone()), part.display(display));
            let without = (sampled, shown, !part.is_lamps());
            let whole = (sampler.clone(), display, true);
            assert!(without != whole, "{} leaves nothing out", part.name());
        }
    }
}
