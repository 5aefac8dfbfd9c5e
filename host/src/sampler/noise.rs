//! Seeded noise and low-discrepancy points.

use glam::Vec2;

/// A 32-bit hash with good avalanche ("lowbias32", found by C. Wellons' search, 2018).
pub(super) const fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A small generator: SplitMix64 (Steele, Lea & Flood 2014), its upper half.
#[derive(Clone, Debug)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed ^ 0x9e37_79b9_7f4a_7c15)
    }

    pub(super) fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// In `0..n`, by multiplication (bias below n/2^32).
    pub(super) fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(n)) >> 32) as u32
    }

    /// In 0 (included) to 1 (not included), 24 bits.
    pub(super) fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 16_777_216.0
    }
}

/// The R2 sequence in the unit square (M. Roberts 2018: the additive recurrence of the plastic
/// number), in 32-bit fixed point so that it never loses precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct R2([u32; 2]);

impl R2 {
    pub(super) fn new(seed: u32) -> Self {
        Self([hash(seed), hash(seed ^ 0x5bd1_e995)])
    }

    /// The next point; both coordinates from 0 (included) to 1 (not included).
    pub(super) fn next(&mut self) -> Vec2 {
        *self = self.skip(1);
        self.place()
    }

    /// The `n`-th point from now on: that which [`Self::next`] gives is the 0th.
    pub(super) fn nth(self, n: u32) -> Vec2 {
        self.skip(n.wrapping_add(1)).place()
    }

    fn skip(self, n: u32) -> Self {
        // 2^32/ρ and 2^32/ρ² with ρ = 1.3247… the plastic number.
        let Self([x, y]) = self;
        Self([
            x.wrapping_add(n.wrapping_mul(3_242_174_889)),
            y.wrapping_add(n.wrapping_mul(2_447_445_413)),
        ])
    }

    fn place(self) -> Vec2 {
        Vec2::new((self.0[0] >> 8) as f32, (self.0[1] >> 8) as f32) / 16_777_216.0
    }
}

/// A stride that visits all of `0..n` in an order that is spread evenly at every length: the
/// coprime of `n` nearest to n/φ from below. At least 1.
pub(super) fn golden_stride(n: usize) -> usize {
    let gcd = |mut a: usize, mut b: usize| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let start = (n as f64 * 0.618_033_988_749_895) as usize;
    (1..=start.max(1))
        .rev()
        .find(|&s| gcd(s, n) == 1)
        .unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stride_visits_everything_once() {
        for n in 1..400 {
            let stride = golden_stride(n);
            let mut seen = vec![false; n];
            for i in 0..n {
                seen[i * stride % n] = true;
            }
            assert!(seen.iter().all(|&s| s), "{n} with stride {stride}");
        }
    }

    #[test]
    fn any_point_is_the_one_that_is_come_to() {
        let start = R2::new(7);
        let mut walked = start;
        for n in 0..100 {
            assert_eq!(start.nth(n), walked.next());
        }
        assert_eq!(start.nth(u32::MAX - 1), start.skip(u32::MAX).place());
    }

    #[test]
    fn r2_is_more_even_than_random() {
        // Counts in 16×16 boxes of 4096 points: variance 16 for random points.
        let count = |mut next: Box<dyn FnMut() -> Vec2>| {
            let mut boxes = [0.0f32; 256];
            for _ in 0..4096 {
                let p = next() * 16.0;
                boxes[p.y as usize * 16 + p.x as usize] += 1.0;
            }
            boxes.iter().map(|n| (n - 16.0) * (n - 16.0)).sum::<f32>() / 256.0
        };
        let mut r2 = R2::new(1);
        let mut random = Random::new(1);
        let even = count(Box::new(move || r2.next()));
        let rough = count(Box::new(move || Vec2::new(random.unit(), random.unit())));
        assert!(even < 2.0, "R2: variance {even}");
        assert!((10.0..24.0).contains(&rough), "random: variance {rough}");
    }
}
