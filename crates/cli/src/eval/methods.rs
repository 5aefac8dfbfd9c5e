//! What can be evaluated, by name.

use std::fmt;
use std::str::FromStr;

use glam::UVec2;
use unframed_host::framed::{Framed, Frames, Taau, Tuning, Upscale};
use unframed_host::sampler::Sampler;
use unframed_host::sampler::adaptive::{self, Adaptive};
use unframed_host::sampler::paper;
use unframed_host::trace::World;
use unframed_recon::Config;
use unframed_recon::config::Lifetime;
use unframed_wire::{Layout, TileFields};

use super::parts::Part;
use super::unmoved::Unmoved;
use crate::method::Method;

/// A method in the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EvalMethod {
    /// Whole frames at 60 Hz, of as few pixels as the rate asks for.
    Framed60LowRes,
    /// Whole frames of full resolution, as few as the rate asks for.
    FramedFull,
    /// Traditional frameless rendering.
    Frameless,
    /// Uniform samples, reprojected, one constant filter.
    Uniform,
    /// Uniform samples through the reconstructor of `adaptive`.
    UniformSameDisplay,
    /// Temporal antialiasing and upscaling.
    Taau,
    /// Adaptive frameless rendering as published (Dayal et al. 2005).
    Paper,
    /// The subject.
    Adaptive,
    /// Its sampler is told that nothing moves.
    AdaptiveNoSamplerReprojection,
    /// Its display leaves samples where they fell.
    AdaptiveNoDisplayReprojection,
    /// Full resolution at 60 Hz, one refresh late.
    Framed60Tenfold,
    /// Full resolution at 60 Hz in no time.
    Framed60TenfoldNoDelay,
    /// `adaptive` without guidance by effects, at equal rays: random points, as many for each
    /// effect in each sample as do best.
    AdaptiveUnguided,
    /// The same with the tiles' sequences of points.
    AdaptivePatternOnly,
    /// `adaptive` with a part left out.
    Without(Part),
}

/// Methods that are asked for by name alone: they differ where effects are called for.
const BY_NAME: [(EvalMethod, &str); 2] = [
    (EvalMethod::AdaptiveUnguided, "adaptive-unguided"),
    (EvalMethod::AdaptivePatternOnly, "adaptive-pattern-only"),
];

/// Names that are known, and their methods.
const NAMES: [(EvalMethod, &str); 12] = [
    (EvalMethod::Framed60LowRes, "framed60-lowres"),
    (EvalMethod::FramedFull, "framed-full"),
    (EvalMethod::Frameless, "frameless"),
    (EvalMethod::Uniform, "uniform"),
    (EvalMethod::UniformSameDisplay, "uniform-same-display"),
    (EvalMethod::Taau, "taau"),
    (EvalMethod::Paper, "paper"),
    (EvalMethod::Adaptive, "adaptive"),
    (
        EvalMethod::AdaptiveNoSamplerReprojection,
        "adaptive-no-sampler-reprojection",
    ),
    (
        EvalMethod::AdaptiveNoDisplayReprojection,
        "adaptive-no-display-reprojection",
    ),
    (EvalMethod::Framed60Tenfold, "framed60-10x"),
    (EvalMethod::Framed60TenfoldNoDelay, "framed60-10x-nodelay"),
];

/// There is no such method.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MethodError {
    /// Unknown.
    #[error("there is no method `{name}`; there are {all}")]
    Unknown {
        /// As typed.
        name: String,
        /// What there is.
        all: String,
    },
}

/// How a method is carried out.
pub enum Way {
    /// A host and a display, joined by bytes.
    Stream {
        /// Where to look.
        sampler: Box<dyn Sampler>,
        /// How places are coded.
        layout: Layout,
        /// Whether the display draws shadows of what moves.
        lamps: bool,
        /// What tiles carry.
        tile_fields: TileFields,
        /// What the display does.
        display: Config,
    },
    /// Whole pictures.
    Frames(Box<dyn Framed>),
}

/// One of the settings between which a method may choose: the one with the least error counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// There is nothing to choose.
    Only,
    /// Of temporal antialiasing.
    Taau(&'static str, Tuning),
    /// Rays of each effect in each sample, at the rate at which all rays are as many as those of
    /// `adaptive`.
    Rays(&'static str, u8),
}

impl Setting {
    /// Its name in reports; empty where there is nothing to choose.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Only => "",
            Self::Taau(name, _) | Self::Rays(name, _) => name,
        }
    }
}

/// The lifetime of uniform samples in the display of `adaptive`, log2 of seconds in 1/256: the
/// best on average over the built-in scenes (of 0.25, 0.5, 0.7 and 1 s the middle two are
/// within 0.3 %), so that what adaptivity is credited with is not a
/// badly chosen constant.
const UNIFORM_LIFETIME: i16 = -192;

impl EvalMethod {
    /// All whole methods, in the order of the tables.
    pub fn all() -> impl Iterator<Item = Self> {
        NAMES.iter().map(|entry| entry.0)
    }

    /// `adaptive` without this and without that.
    pub fn ablations() -> impl Iterator<Item = Self> {
        let reprojections = [
            Self::AdaptiveNoSamplerReprojection,
            Self::AdaptiveNoDisplayReprojection,
        ];
        reprojections
            .into_iter()
            .chain(Part::all().map(Self::Without))
    }

    /// Everything that has a name.
    pub fn known() -> impl Iterator<Item = Self> {
        let by_name = BY_NAME.iter().map(|entry| entry.0);
        Self::all()
            .chain(by_name)
            .chain(Part::all().map(Self::Without))
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        if let Self::Without(part) = self {
            return part.name();
        }
        NAMES
            .iter()
            .chain(&BY_NAME)
            .find(|entry| entry.0 == self)
            .map_or("", |entry| entry.1)
    }

    /// What of `adaptive` is different, of its ablations.
    #[must_use]
    pub fn instead(self) -> Option<&'static str> {
        match self {
            Self::Without(part) => Some(part.instead()),
            Self::AdaptiveNoSamplerReprojection => Some("the sampler is told that nothing moves"),
            Self::AdaptiveNoDisplayReprojection => Some("samples stay where they fell"),
            _ => None,
        }
    }

    /// Whether it takes a sample for each pixel and refresh, whatever rate is asked for.
    #[must_use]
    pub fn is_tenfold(self) -> bool {
        matches!(self, Self::Framed60Tenfold | Self::Framed60TenfoldNoDelay)
    }

    /// Whether a seed changes anything.
    #[must_use]
    pub fn is_random(self) -> bool {
        !self.is_tenfold() && !matches!(self, Self::Framed60LowRes | Self::FramedFull)
    }

    /// The settings it may choose between.
    #[must_use]
    pub fn settings(self) -> Vec<Setting> {
        match self {
            Self::Taau => {
                vec![
                    Setting::Taau("quick", Tuning::QUICK),
                    Setting::Taau("sharp", Tuning::SHARP),
                ]
            }
            Self::AdaptiveUnguided | Self::AdaptivePatternOnly => {
                [("1 ray", 1), ("4 rays", 4), ("9 rays", 9), ("15 rays", 15)]
                    .map(|(name, rays)| Setting::Rays(name, rays))
                    .to_vec()
            }
            _ => vec![Setting::Only],
        }
    }

    /// Everything that decides its result but scene, size, rate and seed, as text.
    #[must_use]
    pub fn fingerprint(self) -> String {
        let stream = match self.method() {
            Some(Method::Paper) => format!(
                "{:?} {:?}",
                self.display(Method::Paper),
                paper::Config::default()
            ),
            Some(method) => format!("{:?} {:?}", self.display(method), self.knobs(0)),
            None => String::new(),
        };
        format!("{} {:?} {stream}", self.name(), self.settings())
    }

    /// Sets it up.
    #[must_use]
    pub fn way(self, world: &World, rate: u32, seed: u64, setting: Setting) -> Way {
        let size = UVec2::from(world.size());
        if let Some(method) = self.method() {
            let sampler = match self {
                Self::Without(_) => Box::new(Adaptive::new(size, self.knobs(seed))),
                Self::AdaptiveUnguided | Self::AdaptivePatternOnly => {
                    let rays = match setting {
                        Setting::Rays(_, rays) => rays,
                        _ => 1,
                    };
                    let knobs = self.knobs(seed);
                    Box::new(Adaptive::new(size, adaptive::Config { rays, ..knobs }))
                }
                _ => method.sampler(size, seed),
            };
            let unmoved = self == Self::AdaptiveNoSamplerReprojection;
            return Way::Stream {
                sampler: if unmoved {
                    Box::new(Unmoved::new(sampler, size))
                } else {
                    sampler
                },
                layout: match self {
                    // A place on the screen is all that such a display could make use of.
                    Self::AdaptiveNoDisplayReprojection => Layout::Screen,
                    _ => method.layout(),
                },
                lamps: method.lamps() && !matches!(self, Self::Without(part) if part.is_lamps()),
                tile_fields: method.tile_fields(),
                display: self.display(method),
            };
        }
        let world = world.clone();
        Way::Frames(match (self, setting) {
            (Self::Framed60LowRes, _) => {
                Box::new(Frames::low_resolution(world, rate, Upscale::Linear))
            }
            (Self::Taau, Setting::Taau(_, tuning)) => {
                Box::new(Taau::new(world, rate, tuning, seed))
            }
            (Self::Taau, _) => Box::new(Taau::new(world, rate, Tuning::SHARP, seed)),
            (Self::FramedFull, _) => Box::new(Frames::full_resolution(world, rate)),
            (_, _) => Box::new(Frames::every_refresh(world, self == Self::Framed60Tenfold)),
        })
    }

    /// The sampler's method, of those with a stream.
    fn method(self) -> Option<Method> {
        match self {
            Self::Frameless => Some(Method::Frameless),
            Self::Uniform => Some(Method::Uniform),
            Self::UniformSameDisplay => Some(Method::UniformSameDisplay),
            Self::Paper => Some(Method::Paper),
            Self::Adaptive
            | Self::AdaptiveNoSamplerReprojection
            | Self::AdaptiveNoDisplayReprojection
            | Self::AdaptiveUnguided
            | Self::AdaptivePatternOnly
            | Self::Without(_) => Some(Method::Adaptive),
            Self::Framed60LowRes
            | Self::FramedFull
            | Self::Taau
            | Self::Framed60Tenfold
            | Self::Framed60TenfoldNoDelay => None,
        }
    }

    /// The knobs of the adaptive sampler.
    fn knobs(self, seed: u64) -> adaptive::Config {
        let knobs = adaptive::Config {
            seed,
            ..Default::default()
        };
        match self {
            Self::Without(part) => part.sampler(knobs),
            Self::AdaptivePatternOnly => adaptive::Config {
                guidance: false,
                ..knobs
            },
            Self::AdaptiveUnguided => adaptive::Config {
                pattern: 0,
                guidance: false,
                ..knobs
            },
            _ => knobs,
        }
    }

    fn display(self, method: Method) -> Config {
        let display = method.display();
        match self {
            Self::UniformSameDisplay => Config {
                lifetime: Lifetime::Constant(UNIFORM_LIFETIME),
                ..display
            },
            Self::AdaptiveNoDisplayReprojection => Config {
                reproject: false,
                ..display
            },
            Self::Without(part) => part.display(display),
            _ => display,
        }
    }
}

impl fmt::Display for EvalMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for EvalMethod {
    type Err = MethodError;

    fn from_str(name: &str) -> Result<Self, MethodError> {
        Self::known()
            .find(|method| method.name() == name)
            .ok_or_else(|| {
                let all: Vec<&str> = Self::known().map(Self::name).collect();
                MethodError::Unknown {
                    name: name.to_owned(),
                    all: all.join(", "),
                }
            })
    }
}
