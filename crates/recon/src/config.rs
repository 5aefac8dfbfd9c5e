//! What the display does with the samples: every part can be switched off, so that its worth can
//! be measured.

mod text;

/// How samples become a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Traditional frameless display (Bishop et al. 1994): each pixel shows the newest sample that
    /// fell into it.
    Newest,
    /// Space-time filtering of all stored samples (Dayal et al. 2005 §5).
    SpaceTime,
}

/// What shapes the filter in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extents {
    /// One width everywhere: log2 of σ in pixels, 8 fractional bits.
    Constant(i16),
    /// σ = 0.5/√density in 0.35..=1.17 px by eighths of an octave, the density being the weight of the live
    /// samples in the 3 × 3 pixels around.
    Density,
    /// Extents from the tiles' gradients and sampling density (Dayal et al. 2005 §5.1).
    Gradient,
    /// No filter: a sample counts for the pixel that it falls into, and for no other.
    Pixel,
}

/// What gives a sample's lifetime.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifetime {
    /// One lifetime everywhere: log2 of seconds, 8 fractional bits.
    Constant(i16),
    /// The lifetimes of the tiles, measured along reprojected hits.
    Tiles,
    /// The temporal extent e_t from the tiles' gradients (Dayal et al. 2005 §5.1).
    Gradient,
}

/// How weight declines with u = age/lifetime.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeKernel {
    /// 1/(1 + u² + u⁴).
    Rational,
    /// e^(−u²/2).
    Gaussian,
    /// e^(−u): the relative weight of two samples does not change as both age.
    Exponential,
}

/// What is fitted to the weighted samples around a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Their mean.
    Constant,
    /// A plane, its slopes held by a ridge: 11 more sums a pixel.
    Linear,
}

/// The quantity that is filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Linear light: an average is what a lens would give.
    Linear,
    /// The encoded value as displayed.
    Encoded,
}

/// The parts of the reconstructor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// How samples become a picture.
    pub mode: Mode,
    /// Whether samples are moved to the view and poses of the refresh instant; otherwise they
    /// stay where they fell.
    pub reproject: bool,
    /// Whether samples behind others are dropped.
    pub hidden: bool,
    /// What shapes the filter in space.
    pub extents: Extents,
    /// What gives a sample's lifetime.
    pub lifetime: Lifetime,
    /// How weight declines with age.
    pub kernel: TimeKernel,
    /// What is taken off every weight, 15 fractional bits, so that it ends: a sample whose decline
    /// is no more does not count at all. 0 keeps the tails of the kernels.
    pub cutoff: u16,
    /// What is fitted.
    pub fit: Fit,
    /// Whether pixels with little weight are filled from around (pull-push).
    pub fill: bool,
    /// The quantity that is filtered.
    pub light: Light,
    /// Whether pixels average what falls into them while all stands still ([`crate::rest`]).
    pub rest: bool,
}

impl Config {
    /// Whether planes are fitted.
    #[must_use]
    pub const fn planes(&self) -> bool {
        matches!(self.fit, Fit::Linear)
    }

    /// Whether means are kept for what rests: only of what is filtered where it lies now.
    #[must_use]
    pub const fn averages(&self) -> bool {
        self.rest && self.reproject && matches!(self.mode, Mode::SpaceTime)
    }

    /// The default: everything that earns its cost.
    pub const ADAPTIVE: Self = Self {
        mode: Mode::SpaceTime,
        reproject: true,
        hidden: true,
        extents: Extents::Density,
        lifetime: Lifetime::Tiles,
        kernel: TimeKernel::Rational,
        cutoff: 1 << 7,
        fit: Fit::Linear,
        fill: true,
        light: Light::Linear,
        rest: true,
    };

    /// What a small core has time for: a sample counts for its own pixel, none is tested for being
    /// hidden.
    pub const PIXELS: Self = Self {
        hidden: false,
        extents: Extents::Pixel,
        fit: Fit::Constant,
        ..Self::ADAPTIVE
    };

    /// Traditional frameless display.
    pub const NEWEST: Self = Self {
        mode: Mode::Newest,
        rest: false,
        ..Self::ADAPTIVE
    };

    /// Reprojection and one constant filter: σ 0.6 px, e^(−u²/2) with 0.25 s.
    pub const UNIFORM: Self = Self {
        hidden: false,
        extents: Extents::Constant(-189),
        lifetime: Lifetime::Constant(-512),
        kernel: TimeKernel::Gaussian,
        cutoff: 0,
        fit: Fit::Constant,
        rest: false,
        ..Self::ADAPTIVE
    };

    /// The reconstructor of Dayal et al. 2005, with holes filled.
    pub const PAPER: Self = Self {
        hidden: false,
        extents: Extents::Gradient,
        lifetime: Lifetime::Gradient,
        kernel: TimeKernel::Gaussian,
        cutoff: 0,
        fit: Fit::Constant,
        rest: false,
        ..Self::ADAPTIVE
    };
}

/// Configurations by name: what a job for the firmware starts from, see [`Config::parse`].
pub const NAMED: [(&str, Config); 6] = [
    ("adaptive", Config::ADAPTIVE),
    (
        "adaptive-constant",
        Config {
            fit: Fit::Constant,
            ..Config::ADAPTIVE
        },
    ),
    ("uniform", Config::UNIFORM),
    ("paper", Config::PAPER),
    ("frameless", Config::NEWEST),
    ("pixels", Config::PIXELS),
];

impl Default for Config {
    fn default() -> Self {
        Self::ADAPTIVE
    }
}
