//! Methods: which sampler, which stream, which reconstruction.

use clap::ValueEnum;
use glam::UVec2;
use unframed_host::sampler::Sampler;
use unframed_host::sampler::adaptive::{self, Adaptive};
use unframed_host::sampler::paper::{self, Paper};
use unframed_host::sampler::uniform::{Place, Traditional, Uniform};
use unframed_recon::Config;
use unframed_recon::config::Lifetime;
use unframed_wire::{Layout, TileFields};

/// What of a method's sampler can be set where it is chosen by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampling {
    /// Crosshairs that the sampler of [`Method::Paper`] keeps at each pixel, at least 1.
    pub depth: u16,
    /// Side, pixels, of the squares in which the sampler of [`Method::Adaptive`] takes the points
    /// of effects from one sequence; with 0 they are random.
    pub pattern: u16,
}

impl Default for Sampling {
    /// As the samplers have it.
    fn default() -> Self {
        Self {
            depth: paper::Config::default().depth,
            pattern: adaptive::Config::default().pattern,
        }
    }
}

/// A method of sampling and reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum)]
pub enum Method {
    /// Samples steered to where the picture is wrong, all reconstructed at the refresh.
    Adaptive,
    /// Traditional frameless rendering: random pixels, the newest sample shows.
    Frameless,
    /// Uniform samples, reprojected, one constant filter.
    Uniform,
    /// Uniform samples through the reconstructor of `adaptive`.
    UniformSameDisplay,
    /// Adaptive frameless rendering as published (Dayal et al. 2005).
    Paper,
}

impl Method {
    /// The name as typed and as in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Adaptive => "adaptive",
            Self::Frameless => "frameless",
            Self::Uniform => "uniform",
            Self::UniformSameDisplay => "uniform-same-display",
            Self::Paper => "paper",
        }
    }

    /// Its sampler for an image of `size` pixels.
    #[must_use]
    pub fn sampler(self, size: UVec2, seed: u64) -> Box<dyn Sampler> {
        self.sampler_with(size, seed, Sampling::default())
    }

    /// The same, set otherwise.
    #[must_use]
    pub fn sampler_with(self, size: UVec2, seed: u64, sampling: Sampling) -> Box<dyn Sampler> {
        match self {
            Self::Adaptive => Box::new(Adaptive::new(
                size,
                adaptive::Config {
                    seed,
                    pattern: sampling.pattern,
                    ..Default::default()
                },
            )),
            Self::Frameless => Box::new(Traditional::new(size, Place::Centre, seed)),
            Self::Uniform | Self::UniformSameDisplay => Box::new(Uniform::new(size, seed)),
            Self::Paper => Box::new(Paper::new(
                size,
                paper::Config {
                    seed,
                    depth: sampling.depth,
                    ..Default::default()
                },
            )),
        }
    }

    /// What its display does.
    #[must_use]
    pub fn display(self) -> Config {
        match self {
            Self::Adaptive => Config::ADAPTIVE,
            Self::Frameless => Config::NEWEST,
            Self::Uniform => Config::UNIFORM,
            Self::UniformSameDisplay => Config {
                lifetime: Lifetime::Constant(-256),
                ..Config::ADAPTIVE
            },
            Self::Paper => Config::PAPER,
        }
    }

    /// How its stream codes places.
    #[must_use]
    pub fn layout(self) -> Layout {
        match self {
            Self::Frameless => Layout::Screen,
            _ => Layout::World,
        }
    }

    /// Whether its display draws shadows of what moves.
    #[must_use]
    pub fn lamps(self) -> bool {
        matches!(self, Self::Adaptive | Self::UniformSameDisplay)
    }

    /// What its tiles carry.
    #[must_use]
    pub fn tile_fields(self) -> TileFields {
        TileFields {
            gradients: self == Self::Paper,
            lifetime: self == Self::Adaptive,
            density: self == Self::Paper,
        }
    }
}
