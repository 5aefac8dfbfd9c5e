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
        match self {
            Self::Adaptive => Box::new(Adaptive::new(
                size,
                adaptive::Config {
                    seed,
                    ..Default::default()
                },
            )),
            Self::Frameless => Box::new(Traditional::new(size, Place::Centre, seed)),
            Self::Uniform | Self::UniformSameDisplay => Box::new(Uniform::new(size, seed)),
            Self::Paper => Box::new(Paper::new(
                size,
                paper::Config {
                    seed,
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
