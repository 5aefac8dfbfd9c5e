//! The error of a tile (Dayal et al. 2005 §6.1) and the gain of the control (§4.1).

use super::config::Config;

/// What the terms of a tile's error are measured against: as of the beginning of an era, see
/// [`super::tiling`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Norms {
    /// ē: the mean number of empty places of the deep buffer a tile.
    pub(super) empty: f64,
    /// Σv, Σu and Σo over all tiles.
    pub(super) sums: [f64; 3],
}

/// v, u and o of a tile.
pub(super) type Terms = [f64; 3];

/// u: how undersampled a tile is, 0..1.
///
/// The paper prints u = 1 − min(1, m·Σⱼ((whb − |buffer|)/|tiles|)/(sb − |tile|)), which cannot be
/// meant: the summand does not depend on j, so the sum is *all* empty places, m times as many as
/// any one tile can have, and u would be zero always. Derived anew from the sentence below the
/// formula, "the number of empty samples in a tile must be m times greater than the mean number of
/// empty samples in all tiles":
///
/// - A tile of s pixels has e = s·b − |tile| empty places. Tiles partition the image, so
///   Σⱼ sⱼ = w·h and Σⱼ |tileⱼ| = |buffer|: the mean over the tiles is
///   ē = Σⱼ (sⱼ·b − |tileⱼ|)/|tiles| = (w·h·b − |buffer|)/|tiles|. (Here both sides of this
///   identity are printed at once.)
/// - Of its e places, m·ē are no more than the threshold allows; what exceeds it is the
///   undersampling. As a share of the tile's own empty places, so that it lies in 0..1 as v and o
///   do: u = (e − m·ē)⁺/e = 1 − min(1, m·ē/e).
/// - A full tile has e = 0 and is not undersampled: u = 0, the limit of no excess, where the
///   quotient is not defined.
pub(super) fn undersampling(empty: f64, mean_empty: f64, m: f64) -> f64 {
    if empty <= 0.0 {
        return 0.0;
    }
    1.0 - (m * mean_empty / empty).min(1.0)
}

/// o = |O|/(s·b), with |O| discounted by age like everything else in the statistics: the share of
/// the tile's weight that took the place of occluded samples, times how full the tile is. Equal to
/// the paper's where all samples are of one age, and unlike it not moved by time alone.
pub(super) fn occlusion(occluded_share: f64, stored: f64, places: f64) -> f64 {
    occluded_share * stored / places
}

/// E: `area` times the shares of the tile in all variance, undersampling and occlusion, weighted
/// κ, λ and 1 − κ − λ. A term that no tile has counts nothing.
pub(super) fn error(terms: Terms, area: f64, norms: &Norms, config: &Config) -> f64 {
    let weights = [
        config.kappa,
        config.lambda,
        (1.0 - config.kappa - config.lambda).max(0.0),
    ];
    let share = |k: usize| match norms.sums[k] {
        sum if sum > 0.0 => weights[k] * terms[k] / sum,
        _ => 0.0,
    };
    area * (share(0) + share(1) + share(2))
}

/// Gain control: the number of tiles for which dC/ds·S = i·dC/dt·T, S being their width in
/// pixels: `pixels`/S². Within the configured limits.
///
/// `spatial` is the mean gradient a pixel, `temporal` that a second, `age` T in seconds. Below
/// 0.004 and 0.02 a gradient is noise, and a quotient of two noises would swing the gain from one
/// end to the other.
pub(super) fn target(pixels: f64, spatial: f64, temporal: f64, age: f64, config: &Config) -> u32 {
    let width = config.importance * temporal.max(0.02) * age / spatial.max(0.004);
    let count = (pixels / (width * width)).round();
    // The cast saturates; age 0 gives infinity.
    (count as u32).clamp(config.least_tiles, config.most_tiles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undersampling_is_the_share_beyond_the_threshold() {
        assert_eq!(undersampling(0.0, 0.0, 1.5), 0.0, "full");
        assert_eq!(undersampling(100.0, 100.0, 1.5), 0.0);
        assert_eq!(undersampling(150.0, 100.0, 1.5), 0.0, "at the threshold");
        assert!((undersampling(200.0, 100.0, 1.5) - 0.25).abs() < 1e-12);
        assert_eq!(undersampling(5.0, 0.0, 1.5), 1.0);
    }

    #[test]
    fn errors_of_all_tiles_add_up_to_the_shares() {
        let config = Config::default();
        let norms = Norms {
            empty: 1.0,
            sums: [2.0, 4.0, 0.0],
        };
        let total: f64 = [[0.5, 3.0, 0.0], [1.5, 1.0, 0.0]]
            .iter()
            .map(|&terms| error(terms, 1.0, &norms, &config))
            .sum();
        let sound = config.kappa + config.lambda;
        assert!((total - sound).abs() < 1e-12, "nothing is occluded");
    }

    #[test]
    fn gain_solves_its_equation() {
        let config = Config {
            importance: 0.7,
            least_tiles: 1,
            most_tiles: 1 << 20,
            ..Config::default()
        };
        let (spatial, temporal, age) = (0.05, 1.3, 0.4);
        let tiles = f64::from(target(65536.0, spatial, temporal, age, &config));
        let width = (65536.0 / tiles).sqrt();
        assert!((spatial * width / (0.7 * temporal * age) - 1.0).abs() < 0.01);
        // The more moves, the fewer tiles; at rest as many as there may be.
        assert!(f64::from(target(65536.0, spatial, 2.0, age, &config)) < tiles);
        assert_eq!(target(65536.0, 0.05, 0.0, 0.0, &config), 1 << 20);
    }
}
