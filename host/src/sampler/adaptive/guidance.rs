//! How many points of lamps and media samples look at: the guidance of adaptive interleaved sampling
//! (Dubla et al. 2009) without frames; which points these are, says the pattern ([`super::pattern`]).
//!
//! The guidance is the spread of what rays of a tile brought, effect by effect: none in the umbra,
//! little in the full light of a small lamp, much in a penumbra. A
//! sample that gives `k` rays to an effect costs `c + k` rays and errs by `v + w/k`, where `v` is the tile's
//! squared error without the effect's noise and `w` the squared spread of one of its rays; for a
//! given number of rays the error is least at k = √(w·c/v). A tile that has seen little listens to
//! its neighbours. The paper's guidance (Listings 2 to 4)
//! goes by the share of rays that are blocked, which is the spread of a lamp that is seen or not.

use glam::Vec3;

use super::config::Config;
use super::tiles::Tile;
use crate::effects::care::{self, Care, Told};

/// Rays that a sample costs beside those that are guided: to the surface, and to a lamp.
const OTHERS: f32 = 2.0;
/// Rays that a sample is worth beside those of the effect in question, `c` above. It also takes a
/// place among those that the display remembers, and its noise steers the sampler: tuned on the
/// scenes `cornell` and `cornell-mist` (2 is 3 to 9 % worse at equal rays).
const WORTH: f32 = 8.0;
/// Most rays of an effect in a sample: cells have four bits for it.
const MOST: f32 = 15.0;
/// Rays of each effect in the first samples of a tile: its error and their spread are not known
/// yet, and few samples show all their noise.
const FIRST: u8 = 9;
/// So many samples, the old ones discounted, make a tile known.
const KNOWN: f32 = 24.0;
/// The weight of what a neighbour knows, for a tile that knows nothing itself.
const HEARSAY: f32 = 0.5;
/// So many rays of a spread that is a guess count beside those that were seen.
const PRIOR: f32 = 2.0;
/// That guess, squared displayed levels.
const PRIOR_SPREAD: f32 = 20.0 * 20.0;
/// What was remembered is noisy too: the noise in a residual, over that of a sample.
const REMEMBERED: f32 = 1.5;
/// The least squared error of a tile without the noise of effects, displayed levels.
const LEAST: f32 = 2.0 * 2.0;

/// What a tile knows of its effects.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    /// Number, sum and sum of squares of what rays brought, by effect; the old discounted.
    sums: Told,
    /// Number of samples, the old ones discounted.
    samples: f32,
}

/// Seed and care of a sample of a pattern, in 32 bits: cells have no room for more.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Points(u32);

impl Points {
    pub(super) fn new(seed: u32, care: Care) -> Self {
        let rays = care
            .rays
            .into_iter()
            .fold(0, |all, rays| all << 4 | u32::from(rays.min(15)));
        Self(rays << care::FEW | (seed & ((1 << care::FEW) - 1)))
    }

    /// Both again.
    pub(super) fn get(self) -> (u32, Care) {
        let rays = [8, 4, 0].map(|shift| (self.0 >> (care::FEW + shift) & 15) as u8);
        let seed = self.0 & ((1 << care::FEW) - 1);
        let pattern = true;
        let care = Care {
            rays,
            pattern,
            ..Care::default()
        };
        (seed, care)
    }
}

/// The guidance of all tiles.
#[derive(Clone, Debug)]
pub(super) struct Guidance {
    /// Row by row.
    tiles: Vec<Spread>,
    /// Tiles in a row.
    columns: u32,
    /// Which effects were ever met: of the others there is nothing to keep.
    met: [bool; 3],
}

impl Guidance {
    pub(super) fn new(columns: u32, rows: u32) -> Self {
        Self {
            tiles: vec![Spread::default(); (columns * rows) as usize],
            columns,
            met: [false; 3],
        }
    }

    /// The care of a new sample of a tile. What is not called for takes no rays, whatever is
    /// said here.
    pub(super) fn care(&self, tile: u32, known: &Tile, config: &Config) -> Care {
        let mut care = Care {
            rays: [config.rays; 3],
            pattern: config.pattern > 0,
            ..Care::default()
        };
        if !config.guidance {
            return care;
        }
        care.rays = [FIRST; 3];
        if !self.guides() {
            return care;
        }
        let (samples, told) = self.known_of(tile);
        if samples < KNOWN {
            return care;
        }
        let slope = slope(known.mean());
        let spreads: [f32; 3] = std::array::from_fn(|effect| {
            if !self.met[effect] {
                return 0.0;
            }
            let [count, sum, squares] = told.0[effect];
            let squares = squares - sum * sum / count.max(1.0);
            let variance = squares.max(0.0) * slope * slope;
            (variance + PRIOR * PRIOR_SPREAD) / (count + PRIOR)
        });
        // The tile's error holds what is left of the noise of its effects.
        let error = known.squared_error(config);
        let noise = |(spread, sums): (f32, [f32; 3])| spread * samples / sums[0].max(samples);
        let noise: f32 = spreads.into_iter().zip(told.0).map(noise).sum();
        let rest = (error - REMEMBERED * noise).max(LEAST);
        for (rays, spread) in care.rays.iter_mut().zip(spreads) {
            *rays = (spread * WORTH / rest).sqrt().round().clamp(1.0, MOST) as u8;
        }
        care
    }

    /// Samples and sums of a tile and, the less it has seen itself, of the four beside it.
    fn known_of(&self, tile: u32) -> (f32, Told) {
        let Spread { samples, sums } = self.tiles[tile as usize];
        let mut known = (samples, sums);
        let weight = HEARSAY / (1.0 + samples / KNOWN);
        let column = tile % self.columns;
        let beside = [
            (column > 0).then(|| tile - 1),
            (column + 1 < self.columns).then(|| tile + 1),
            tile.checked_sub(self.columns),
            Some(tile + self.columns),
        ];
        for other in beside.into_iter().flatten() {
            let Some(other) = self.tiles.get(other as usize) else {
                continue;
            };
            known.0 += weight * other.samples;
            let sums = known.1.0.as_flattened_mut().iter_mut();
            sums.zip(other.sums.0.as_flattened())
                .for_each(|(sum, heard)| *sum += weight * heard);
        }
        known
    }

    /// Whether there is anything to guide: an effect was met.
    pub(super) fn guides(&self) -> bool {
        self.met != [false; 3]
    }

    /// Rays that samples of a tile cost lately, relative to one ray for each effect; 1 where
    /// nothing was met. Of tiles with equal error the cheaper ones give more for the same rays:
    /// n ∝ s/√cost.
    pub(super) fn cost(&self, tile: usize) -> f32 {
        let tile = &self.tiles[tile];
        if tile.samples <= 0.5 {
            return 1.0;
        }
        let rays: f32 = tile.sums.0.iter().map(|sums| sums[0]).sum();
        ((OTHERS + rays / tile.samples) / OTHERS).sqrt()
    }

    /// Learns from a sample of a tile.
    pub(super) fn learn(&mut self, tile: u32, told: &Told) {
        if told.0.iter().all(|effect| effect[0] == 0.0) {
            return;
        }
        for (met, told) in self.met.iter_mut().zip(told.0) {
            *met |= told[0] > 0.0;
        }
        let tile = &mut self.tiles[tile as usize];
        tile.samples += 1.0;
        let sums = tile.sums.0.as_flattened_mut().iter_mut();
        sums.zip(told.0.as_flattened())
            .for_each(|(sum, told)| *sum += told);
    }

    /// Forgets a little.
    pub(super) fn fade(&mut self, factor: f32) {
        if !self.guides() {
            return;
        }
        for tile in &mut self.tiles {
            tile.samples *= factor;
            let sums = tile.sums.0.as_flattened_mut().iter_mut();
            sums.for_each(|sum| *sum *= factor);
        }
    }
}

/// Displayed levels (0..=255) for a unit of linear light around a displayed colour: the slope of
/// the sRGB curve, about 255·x^(1/2.2).
fn slope(colour: Option<Vec3>) -> f32 {
    let level = colour.map_or(128.0, |c| c.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
    let shown = (level / 255.0).max(0.05);
    255.0 / 2.2 * shown.powf(-1.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_as_they_went() {
        for (seed, rays) in [
            (0, [1, 1, 1]),
            (0xf_ffff, [9, 1, 15]),
            (0x1_2345, [2, 9, 4]),
        ] {
            let care = Care {
                rays,
                pattern: true,
                ..Care::default()
            };
            assert_eq!(Points::new(seed, care).get(), (seed, care));
        }
    }

    /// Lets a tile see `n` samples whose rays of soft shadows brought `light` in turn.
    fn teach(guidance: &mut Guidance, tile: u32, n: usize, light: [f32; 2]) {
        for _ in 0..n {
            let mut told = Told::default();
            told.add(care::SOFT, &light);
            guidance.learn(tile, &told);
        }
    }

    /// A guidance of one tile that has seen that.
    fn taught(n: usize, light: [f32; 2]) -> Guidance {
        let mut guidance = Guidance::new(1, 1);
        teach(&mut guidance, 0, n, light);
        guidance
    }

    /// A grey tile that holds enough.
    fn grey() -> Tile {
        Tile {
            samples: 50.0,
            residuals: [50.0, 50.0 * 15.0 * 15.0],
            colour: Vec3::splat(50.0 * 128.0),
        }
    }

    #[test]
    fn rays_go_where_rays_disagree() {
        let config = Config::default();
        let tile = grey();
        let rays = |light| taught(60, light).care(0, &tile, &config).rays;
        assert_eq!(
            rays([0.3, 0.3]),
            [1; 3],
            "all agree, and nothing else is called for"
        );
        let penumbra = rays([0.0, 0.3]);
        assert!(penumbra[care::SOFT] >= 4, "{penumbra:?}");
        assert_eq!(penumbra[care::MEDIUM], 1);
        let unguided = Config {
            guidance: false,
            rays: 3,
            ..config.clone()
        };
        assert_eq!(
            taught(60, [0.0, 0.3]).care(0, &tile, &unguided).rays,
            [3; 3]
        );
        // What is not known yet takes care.
        assert_eq!(
            taught(2, [0.3, 0.3]).care(0, &tile, &config).rays,
            [FIRST; 3]
        );
    }

    #[test]
    fn a_tile_that_has_seen_little_listens_to_its_neighbours() {
        let config = Config::default();
        let tile = grey();
        let mut guidance = Guidance::new(3, 3);
        teach(&mut guidance, 0, 60, [0.3, 0.3]);
        let corner = guidance.care(4, &tile, &config).rays;
        assert_eq!(corner, [FIRST; 3], "a corner is no neighbour");
        for beside in [1, 3, 5] {
            teach(&mut guidance, beside, 60, [0.3, 0.3]);
        }
        assert_eq!(guidance.care(4, &tile, &config).rays, [1; 3]);
        // What it sees itself outweighs that.
        teach(&mut guidance, 4, 60, [0.0, 0.4]);
        assert!(guidance.care(4, &tile, &config).rays[care::SOFT] >= 4);
    }
}
