//! How long a sample stays true: measured where places are looked at a second time.
//!
//! A verification traces a stored hit again, so that what it measures is the change of the light
//! that leaves *a point of a surface* towards the eye: camera motion and the motion of objects,
//! which reprojection undoes, do not count; moving shadows, highlights and mirrors do.

use glam::UVec2;

use super::config::Config;

/// Side of a lifetime tile, pixels of the map: 8 of the image.
pub(super) const TILE: u32 = 8 / super::SIDE;

/// The `k` of [`Lifetimes::solve`]: what a squared change over a lifetime costs. Measured, not derived:
/// 1 is 1.5 % worse on the mean of six scenes, most of it on `atelier` and the room.
const STALENESS: f32 = 2.83;

/// A tile whose measured lifetime comes this near to the longest rests: it is sent as infinite, and
/// a display whose view rests too may average there for as long as it likes.
const RESTS: f32 = 0.95;

/// How long a change that one pixel saw waits for another, seconds.
const CORROBORATION: f64 = 0.1;

/// Gradients on a grid of 8×8-pixel tiles, and the lifetimes made of them.
#[derive(Clone, Debug)]
pub(super) struct Lifetimes {
    pub(super) grid: UVec2,
    /// Σ Δc² and Σ Δt² of each tile.
    sums: Vec<[f32; 2]>,
    rows: Vec<[f32; 2]>,
    /// Seconds.
    pub(super) tau: Vec<f32>,
    /// The pixel in each tile that last saw a change while all stood still, and when.
    witnesses: Vec<(u32, f64)>,
    enabled: bool,
    longest: f32,
    shortest: f32,
    recovery: f32,
    tolerance: f32,
}

impl Lifetimes {
    pub(super) fn new(size: UVec2, config: &Config) -> Self {
        let grid = (size + UVec2::splat(TILE - 1)) / TILE;
        let tiles = (grid.x * grid.y) as usize;
        Self {
            grid,
            sums: vec![[0.0; 2]; tiles],
            rows: vec![[0.0; 2]; tiles],
            tau: vec![config.lifetime_max; tiles],
            witnesses: vec![(0, f64::NEG_INFINITY); tiles],
            enabled: config.lifetimes,
            longest: config.lifetime_max,
            shortest: config.lifetime_min,
            recovery: config.recovery,
            tolerance: config.tolerance,
        }
    }

    pub(super) fn clear(&mut self) {
        self.sums.fill([0.0; 2]);
    }

    /// Multiplies the sums.
    pub(super) fn fade(&mut self, factor: f32) {
        for sums in &mut self.sums {
            *sums = sums.map(|sum| sum * factor);
        }
    }

    pub(super) fn add(&mut self, tile: usize, gradients: [f32; 2]) {
        self.sums[tile][0] += gradients[0];
        self.sums[tile][1] += gradients[1];
    }

    /// Whether a change that a pixel of a tile saw while nothing moved is to be believed. A ray
    /// that grazes an edge falls to either side of it by rounding: one such look would end the
    /// rest of 3×3 tiles. Light that changes is soon seen by another pixel near by.
    pub(super) fn corroborated(&mut self, tile: usize, pixel: u32, time: f64) -> bool {
        let (w, h) = (self.grid.x as usize, self.grid.y as usize);
        let (x, y) = (tile % w, tile / w);
        let mut near = (y.saturating_sub(1)..(y + 2).min(h))
            .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(w)).map(move |x| y * w + x));
        let believed = near.any(|tile| {
            let (other, when) = self.witnesses[tile];
            other != pixel && time - when < CORROBORATION
        });
        self.witnesses[tile] = (pixel, time);
        believed
    }

    /// Lifetimes from the sums, each smoothed over 3×3 tiles:
    /// `g² = ΣΔc²/ΣΔt²`, `1/τ² = 1/τ_max² + g²/tolerance²`. With `noise` (s²/r of each tile) the
    /// tolerance is what balances staleness, `k` times `g²τ²`, against noise: `τ³ = noise/(2·k·g²)`. `step` seconds after
    /// the last time, lifetimes may have grown by so much; the first time, to anything.
    pub(super) fn solve(&mut self, noise: &[f32], step: f32) {
        if !self.enabled {
            return;
        }
        let (w, h) = (self.grid.x as usize, self.grid.y as usize);
        let add = |a: [f32; 2], b: [f32; 2]| [a[0] + b[0], a[1] + b[1]];
        for y in 0..h {
            let row = &self.sums[y * w..(y + 1) * w];
            for x in 0..w {
                let near = &row[x.saturating_sub(1)..(x + 2).min(w)];
                self.rows[y * w + x] = near.iter().fold([0.0; 2], |a, &b| add(a, b));
            }
        }
        for y in 0..h {
            for x in 0..w {
                let near = y.saturating_sub(1)..(y + 2).min(h);
                let [dc2, dt2] = near.fold([0.0; 2], |a, r| add(a, self.rows[r * w + x]));
                let tau = self.lifetime(dc2, dt2, noise.get(y * w + x).copied());
                let before = self.tau[y * w + x];
                // Not a number the first time: then the bound is none.
                self.tau[y * w + x] = tau.min(before + self.recovery * step);
            }
        }
    }

    /// The lifetime of a tile as the display is told, seconds.
    pub(super) fn told(&self, tile: usize) -> f32 {
        let tau = self.tau[tile];
        if self.enabled && tau >= RESTS * self.longest {
            f32::INFINITY
        } else {
            tau
        }
    }

    /// The lifetime in seconds that squared changes over squared times make.
    fn lifetime(&self, dc2: f32, dt2: f32, noise: Option<f32>) -> f32 {
        let g2 = if dt2 > 0.0 { dc2 / dt2 } else { 0.0 };
        let rate2 = match noise {
            Some(noise) => (2.0 * STALENESS * g2 / noise).powf(2.0 / 3.0),
            None => g2 / (self.tolerance * self.tolerance),
        };
        (1.0 / (rate2 + 1.0 / (self.longest * self.longest)).sqrt()).max(self.shortest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lifetime_is_where_staleness_and_noise_are_least() {
        let config = Config {
            lifetime_max: 100.0,
            ..Config::default()
        };
        for (g2, noise) in [(900.0f32, 4.0f32), (1e4, 0.5), (40.0, 30.0)] {
            let mut lifetimes = Lifetimes::new(UVec2::splat(TILE), &config);
            // Looks of uneven ages at a slope: Δc² = g²·Δt².
            for dt in [0.01f32, 0.1, 0.3] {
                lifetimes.add(0, [g2 * dt * dt, dt * dt]);
            }
            lifetimes.solve(&[noise], f32::NAN);
            let error = |tau: f32| STALENESS * g2 * tau * tau + noise / tau;
            let least = (0..4000)
                .map(|i| 0.012 * 1.002f32.powi(i))
                .min_by(|&a, &b| error(a).total_cmp(&error(b)));
            let (tau, least) = (lifetimes.tau[0], least.expect("some"));
            assert!((tau / least - 1.0).abs() < 0.01, "{tau} for {least}");
        }
    }

    #[test]
    fn what_was_seen_before_a_jump_stays_two_lifetimes_old() {
        let config = Config::default();
        let mut lifetimes = Lifetimes::new(UVec2::splat(TILE), &config);
        lifetimes.add(0, [1e6, 1e-3]);
        lifetimes.solve(&[4.0], f32::NAN);
        let after_jump = lifetimes.tau[0];
        assert!(after_jump < 0.02, "{after_jump}");
        // Nothing changes any more.
        lifetimes.clear();
        let step = 1.0 / 60.0;
        for epoch in 1..60 {
            lifetimes.solve(&[4.0], step);
            let age = epoch as f32 * step;
            let tau = lifetimes.tau[0];
            assert!(age > 2.0 * (tau - after_jump) - 1e-3, "{tau} s after {age}");
            assert!(tau > 0.4 * age, "but it grows: {tau} s after {age}");
        }
    }
}
