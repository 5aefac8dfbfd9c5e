//! The constants of Dayal et al. 2005 and a switch for each part, so that its worth can be
//! measured.

/// Knobs; [`Config::default`] is the paper's method with all its parts.
///
/// The paper gives r = 5, b = 4, the chunk of 25 and the decline of 3.47. It gives neither m, κ,
/// λ, i nor the number of tiles: those here were chosen on the built-in scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Whether a crosshair has its four cotemporal arms (§4.1). Without, a visit costs two samples
    /// instead of six, and spatial gradients come from the newest samples of the pixels around.
    pub arms: bool,
    /// Whether the tiling follows the error of the tiles; else it is a grid of equal tiles.
    pub adapt: bool,
    /// How fast a sample's weight in the statistics declines: e^(−`decline`·age), 1/s (§4);
    /// 0 forgets only what leaves the deep buffer.
    pub decline: f64,
    /// b: crosshairs that the deep buffer keeps at each pixel (§4), 1 or more. What the display
    /// remembers is another buffer, with a size of its own.
    pub depth: u16,
    /// Crosshairs between two adjustments of the tiling (§4.2), 1 or more.
    pub chunk: u32,
    /// The most splits and merges of one adjustment.
    pub moves: u32,
    /// How many times the least pair's error the largest tile's must be before a pair is merged to
    /// split that tile, 1 or more.
    pub hysteresis: f64,
    /// Whether gain control chooses the number of tiles (§4.1); else it is `tiles`.
    pub gain: bool,
    /// The number of tiles without gain control, and at the beginning.
    pub tiles: u32,
    /// The least number of tiles that gain control may choose.
    pub least_tiles: u32,
    /// The most.
    pub most_tiles: u32,
    /// i of gain control: how much more temporal change counts than spatial.
    pub importance: f64,
    /// Side of the smallest tile, pixels, 1 or more.
    pub finest: u16,
    /// r: pixels of a tile whose front crosshair is reprojected at each visit (§6.1); 0 is off.
    pub reprojections: u32,
    /// Whether a ray tests if a reprojected crosshair's centre is still seen (§6.1).
    pub occlusion: bool,
    /// What such a ray costs, samples. Measured: `cargo run --release -p unframed-host --example
    /// occlusion_ray`.
    pub occlusion_cost: f64,
    /// κ: the share of variance in a tile's error (§6.1), 0..=1.
    pub kappa: f64,
    /// λ: the share of undersampling; κ + λ ≤ 1, the rest is that of occlusion.
    pub lambda: f64,
    /// m: how many times the mean of the empty places a tile must have to count as undersampled.
    pub undersampled: f64,
    /// The shortest interval over which a temporal gradient is taken, seconds: a difference of
    /// neighbouring pixels' texture over microseconds says nothing of time.
    pub least_interval: f64,
    /// Seeds everything.
    pub seed: u64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            arms: true,
            adapt: true,
            decline: 3.47,
            depth: 4,
            chunk: 25,
            moves: 8,
            hysteresis: 1.1,
            gain: true,
            tiles: 1024,
            least_tiles: 256,
            most_tiles: 4096,
            importance: 5.0,
            finest: 4,
            reprojections: 5,
            occlusion: true,
            occlusion_cost: 0.3,
            kappa: 0.6,
            lambda: 0.2,
            undersampled: 1.5,
            least_interval: 0.1,
            seed: 1,
        }
    }
}
