//! How many shots each tile is due, and in what order they are taken.
//!
//! With `n` samples of error `s` each, the squared error of a tile of `a` pixels is about
//! `a·s²/(n/a)`. Under a budget the sum over all tiles is least where `n ∝ a·s`; a tile that
//! already has more keeps what it has. That is water-filling (Cover & Thomas, §9.4, in another
//! dress): `new = max(0, λ·a·s − n)`.

/// Running sums of [`active`].
const LANES: usize = 16;

/// The level λ at which `Σ max(0, λ·s_i − n_i) = budget`, and how many rounds it took from a
/// `guess` (infinity is one).
/// Tiles with `s_i ≤ 0` get nothing. 0 if no tile wants anything.
pub(super) fn water_level(s: &[f32], n: &[f32], budget: f32, guess: f32) -> (f32, u32) {
    // Newton's method on a convex function. From any guess the first round ends above the level, for
    // a tangent lies below; from there dropping overfull tiles lowers λ, which may drop more: at
    // most one round a tile, in practice few.
    let mut lambda = guess;
    for round in 1..=32 {
        let (sum_s, sum_n) = active(s, n, lambda);
        if sum_s <= 0.0 {
            if lambda == f32::INFINITY {
                return (0.0, round);
            }
            // A guess below every tile's need.
            lambda = f32::INFINITY;
            continue;
        }
        let next = ((f64::from(budget) + sum_n) / sum_s) as f32;
        if next == lambda || round > 1 && next >= lambda * (1.0 - 1e-6) {
            return (next, round);
        }
        lambda = next;
    }
    (lambda, 32)
}

/// Σ s and Σ n over the tiles with `λ·s > n`. Sixteen running sums: additions that do not wait for
/// each other, and lengths at which f32 is exact enough.
fn active(s: &[f32], n: &[f32], lambda: f32) -> (f64, f64) {
    let (mut sums, mut fills) = ([0.0f32; LANES], [0.0f32; LANES]);
    let (s, rest_s) = s.as_chunks::<LANES>();
    let (n, rest_n) = n.as_chunks::<LANES>();
    let mut add = |lane: usize, s: f32, n: f32| {
        // The product with infinity is not a number where s is 0: not active, as it should be.
        let active = if lambda * s > n { 1.0 } else { 0.0 };
        sums[lane] += active * s;
        fills[lane] += active * n;
    };
    for (s, n) in s.iter().zip(n) {
        for lane in 0..LANES {
            add(lane, s[lane], n[lane]);
        }
    }
    for (lane, (&s, &n)) in rest_s.iter().zip(rest_n).enumerate() {
        add(lane, s, n);
    }
    let total = |lanes: [f32; LANES]| lanes.iter().map(|&v| f64::from(v)).sum();
    (total(sums), total(fills))
}

/// The sum in f64, of running sums as in [`active`].
fn sum(values: &[f32]) -> f64 {
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut sums = [0.0f32; LANES];
    for chunk in chunks {
        for (sum, v) in sums.iter_mut().zip(chunk) {
            *sum += v;
        }
    }
    sums.iter().chain(rest).map(|&v| f64::from(v)).sum()
}

/// Bits before and behind the point of shares counted in visits.
const BITS: u32 = 30;

/// Turns fractional shares into whole visits: tile `order[k]` stands in `out` so often that every prefix
/// of the order has got its share within one visit (systematic sampling; the same expectation for
/// each tile as its share). `offset` in 0..1. Exactly `count` visits.
///
/// In integers, whose sums have no rounding to wait for: how many visits are due up to a tile is
/// their sum, shifted. Each tile is written where its first visit would stand, and stays if it has one:
/// which tiles have, no processor foresees. `dues` is a buffer.
pub(super) fn visits(
    order: &[u32],
    shares: &[f32],
    count: usize,
    offset: f32,
    dues: &mut Vec<i32>,
    out: &mut Vec<u32>,
) {
    out.clear();
    if count == 0 || order.is_empty() {
        return;
    }
    let fraction = BITS.saturating_sub(usize::BITS - count.leading_zeros());
    let one = (1u64 << fraction) as f64;
    let scale = (one * count as f64 / sum(shares)) as f32;
    dues.clear();
    dues.extend(shares.iter().map(|&s| (s * scale) as i32));
    out.resize(count + 1, 0);
    let mut sum = ((one * (1.0 - f64::from(offset))) as u64).saturating_sub(1);
    let mut taken = 0;
    for &tile in order {
        sum += dues[tile as usize] as u64;
        let due = ((sum >> fraction) as usize).min(count);
        out[taken] = tile;
        if due > taken + 1 {
            out[taken + 1..due].fill(tile);
        }
        taken = due;
    }
    // Rounding at the end, or shares that are all zero.
    for (at, out) in out.iter_mut().enumerate().take(count).skip(taken) {
        *out = order[order.len() - 1 - (at * 7919) % order.len()];
    }
    out.truncate(count);
}

/// The tiles of a `w`×`h` grid along a Z-order curve, so that neighbours in the order are
/// neighbours in the image.
pub(super) fn z_order(w: u32, h: u32) -> Vec<u32> {
    let spread = |x: u32| {
        (0..16).fold(0u64, |code, bit| {
            code | u64::from(x >> bit & 1) << (2 * bit)
        })
    };
    let mut tiles: Vec<(u64, u32)> = (0..h)
        .flat_map(|y| (0..w).map(move |x| (spread(x) | spread(y) << 1, y * w + x)))
        .collect();
    tiles.sort_unstable();
    tiles.into_iter().map(|(_, tile)| tile).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::noise::Random;

    /// The oracle: λ by bisection in f64.
    fn by_bisection(s: &[f32], n: &[f32], budget: f32) -> f64 {
        let given = |lambda: f64| -> f64 {
            s.iter()
                .zip(n)
                .filter(|(s, _)| **s > 0.0)
                .map(|(&s, &n)| (lambda * f64::from(s) - f64::from(n)).max(0.0))
                .sum()
        };
        let (mut low, mut high) = (0.0, 1e9);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if given(middle) < f64::from(budget) {
                low = middle
            } else {
                high = middle
            }
        }
        low
    }

    #[test]
    fn level_is_that_of_bisection() {
        let mut random = Random::new(5);
        for _ in 0..300 {
            let tiles = 1 + random.below(300) as usize;
            let s: Vec<f32> = (0..tiles)
                .map(|_| random.unit().powi(4) * 200.0 + 0.1)
                .collect();
            let n: Vec<f32> = (0..tiles).map(|_| random.unit().powi(3) * 500.0).collect();
            let budget = 1.0 + random.unit() * 2000.0;
            let exact = by_bisection(&s, &n, budget);
            let near = exact as f32;
            for guess in [
                f32::INFINITY,
                0.0,
                0.3 * near,
                0.99 * near,
                1.01 * near,
                1e9,
            ] {
                let (lambda, rounds) = water_level(&s, &n, budget, guess);
                assert!(
                    (f64::from(lambda) / exact - 1.0).abs() < 1e-4,
                    "{lambda} {exact} from {guess}"
                );
                assert!(rounds <= 20, "{rounds} rounds from {guess}");
            }
        }
        for guess in [f32::INFINITY, 0.0, 3.0] {
            assert_eq!(water_level(&[0.0, 0.0], &[1.0, 2.0], 5.0, guess).0, 0.0);
        }
    }

    #[test]
    fn visits_follow_the_shares() {
        let order = z_order(8, 4);
        let mut random = Random::new(8);
        let shares: Vec<f32> = (0..32).map(|_| random.unit()).collect();
        let total: f32 = shares.iter().sum();
        let mut sums = [0.0f32; 32];
        let (mut dues, mut out) = (Vec::new(), Vec::new());
        for round in 0..200 {
            let offset = (round as f32 + 0.5) / 200.0;
            visits(&order, &shares, 17, offset, &mut dues, &mut out);
            assert_eq!(out.len(), 17);
            out.iter().for_each(|&t| sums[t as usize] += 1.0);
        }
        for (tile, sum) in sums.iter().enumerate() {
            let due = shares[tile] / total * 17.0 * 200.0;
            assert!((sum - due).abs() < 1.5, "tile {tile}: {sum} for {due}");
        }
    }

    #[test]
    fn z_order_is_a_permutation_of_neighbours() {
        let order = z_order(8, 8);
        assert_eq!(&order[..8], &[0, 1, 8, 9, 2, 3, 10, 11]);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &t)| i as u32 == t));
    }
}
