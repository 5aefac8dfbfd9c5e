//! The knobs of the adaptive sampler. Each part can be switched off, to measure what it is worth.

/// Knobs; [`Config::default`] is what was tuned on the built-in scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Length of an epoch, seconds: how often the cells are warped.
    pub span: f64,
    /// How far things may move on the screen before the cells are warped again, pixels; 0 warps
    /// them in each epoch.
    pub slack: f32,
    /// Length of a batch, seconds: how often what was seen changes what is looked at.
    pub batch: f64,
    /// Share of the shots that go everywhere alike, 0..=1.
    pub uniform_share: f32,
    /// Share of the shots that look again at a place seen before, 0..1.
    pub verify_share: f32,
    /// Whether residuals steer the shots (else every tile is as interesting as any other).
    pub residuals: bool,
    /// Whether what a tile already has counts (else its residual alone does).
    pub water_filling: bool,
    /// Whether lifetimes are measured (else they are `lifetime_max` everywhere).
    pub lifetimes: bool,
    /// Whether samples see everything, the eye included, as it will be at the end of a span.
    pub ahead: bool,
    /// Whether a scene that changes wholly is noticed.
    pub cuts: bool,
    /// Time constant in which residuals fade, seconds.
    pub residual_memory: f32,
    /// Time constant in which gradients fade, seconds.
    pub gradient_memory: f32,
    /// The residual of a place of which nothing is known, displayed levels (0..255).
    pub residual_prior: f32,
    /// How many samples that prior is worth.
    pub prior_weight: f32,
    /// The least residual, displayed levels: keeps quiet places from starving.
    pub residual_floor: f32,
    /// The longest lifetime, seconds.
    pub lifetime_max: f32,
    /// The shortest lifetime, seconds.
    pub lifetime_min: f32,
    /// By how much a lifetime may grow, seconds a second: what was taken before the light changed
    /// is not true again because it no longer changes. Infinity lets it grow at once.
    pub recovery: f32,
    /// Whether a lifetime balances staleness against noise: the error of a tile whose samples
    /// count for τ is about k·g²τ² + s²/(r·τ), least at τ³ = s²/(2k·g²·r). Else samples live until
    /// they are `tolerance` off.
    pub balanced: bool,
    /// The change of displayed level after which a sample has outlived itself.
    pub tolerance: f32,
    /// How much the logarithmic codes (eight to a factor of two) may differ within one tile that
    /// is sent.
    pub code_tolerance: u32,
    /// Side, pixels, of the squares whose samples take the points of lamps and media from one
    /// sequence, while second looks take those of before; with 0 all points are random.
    pub pattern: u16,
    /// Whether a tile's samples give more rays to the effects whose rays disagree there.
    pub guidance: bool,
    /// Rays of each effect in a sample, 1..=15, where there is no guidance.
    pub rays: u8,
    /// Seeds everything.
    pub seed: u64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            span: 1.0 / 60.0,
            slack: 4.0,
            batch: 0.002,
            uniform_share: 0.2,
            verify_share: 0.05,
            residuals: true,
            water_filling: true,
            lifetimes: true,
            ahead: true,
            cuts: true,
            residual_memory: 0.15,
            gradient_memory: 0.025,
            residual_prior: 40.0,
            prior_weight: 0.5,
            residual_floor: 4.0,
            lifetime_max: 1.0,
            lifetime_min: 0.012,
            recovery: 0.5,
            balanced: true,
            tolerance: 10.0,
            code_tolerance: 2,
            pattern: 4,
            guidance: true,
            rays: 1,
            seed: 1,
        }
    }
}
