//! How old things are when they are shown: ages of samples, latencies of refreshes.
//!
//! A histogram of logarithmic bins, eight to the octave, so that one structure of fixed size holds
//! microseconds and minutes with a relative error of at most 1/8, and histograms of many
//! refreshes, threads or seeds add up exactly.

use crate::MetricError;

/// Bins to the octave, as a power of two.
const SUB_BITS: u32 = 3;
/// Ages below this have a bin each.
const EXACT: u64 = 1 << (SUB_BITS + 1);
/// Enough for all of `u32`.
const BINS: usize = ((32 - SUB_BITS) as usize + 1) << SUB_BITS;

/// A histogram of ages, in microseconds, with a count of places that had nothing to show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AgeHistogram {
    counts: Vec<u64>,
    count: u64,
    sum: u128,
    max: u32,
    empty: u64,
}

impl Default for AgeHistogram {
    fn default() -> Self {
        Self {
            counts: vec![0; BINS],
            count: 0,
            sum: 0,
            max: 0,
            empty: 0,
        }
    }
}

/// One bin: ages of `from..until` µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AgeBin {
    /// Least age, µs, included.
    pub from: u64,
    /// Greatest age, µs, excluded.
    pub until: u64,
    /// Ages in it.
    pub count: u64,
}

impl AgeHistogram {
    /// Adds one age, µs.
    pub fn push(&mut self, age: u32) {
        // The index is below `BINS` for every u32: `the_bins_tile_the_range` shows it.
        self.counts[bin_of(age)] += 1;
        self.count += 1;
        self.sum += u128::from(age);
        self.max = self.max.max(age);
    }

    /// Adds a picture's ages, µs; `None` is a pixel that shows no sample yet.
    pub fn push_all(&mut self, ages: &[Option<u32>]) {
        for age in ages {
            match age {
                Some(age) => self.push(*age),
                None => self.empty += 1,
            }
        }
    }

    /// Adds all that another histogram holds.
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.counts.iter_mut().zip(&other.counts) {
            *a += b;
        }
        self.count += other.count;
        self.sum += other.sum;
        self.max = self.max.max(other.max);
        self.empty += other.empty;
    }

    /// Ages held.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Pixels that had no sample to be old.
    pub fn empty(&self) -> u64 {
        self.empty
    }

    /// The mean age, µs, exact; `None` without ages.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum as f64 / self.count as f64)
    }

    /// The greatest age, µs, exact; `None` without ages.
    pub fn max(&self) -> Option<u32> {
        (self.count > 0).then_some(self.max)
    }

    /// The age that a share `q` of ages does not exceed (nearest rank), µs: the upper end of its
    /// bin, at most 1/8 too much, never beyond [`AgeHistogram::max`]. `None` without ages.
    ///
    /// # Errors
    ///
    /// [`MetricError::Parameter`] if `q` is not in 0..=1.
    pub fn quantile(&self, q: f64) -> Result<Option<u32>, MetricError> {
        if !(0.0..=1.0).contains(&q) {
            return Err(MetricError::Parameter {
                what: "quantile",
                value: q,
                range: "in 0..=1",
            });
        }
        let rank = ((q * self.count as f64).ceil() as u64).max(1);
        let mut seen = 0;
        for bin in self.bins() {
            seen += bin.count;
            if seen >= rank {
                let last = u32::try_from(bin.until - 1).unwrap_or(u32::MAX);
                return Ok(Some(last.min(self.max)));
            }
        }
        Ok(None)
    }

    /// The bins that hold something, youngest first.
    pub fn bins(&self) -> impl Iterator<Item = AgeBin> + '_ {
        let held = self.counts.iter().enumerate().filter(|(_, n)| **n > 0);
        held.map(|(i, n)| AgeBin {
            from: start_of(i),
            until: start_of(i + 1),
            count: *n,
        })
    }
}

/// The bin of an age: its three bits after the leading one, behind the octave.
fn bin_of(age: u32) -> usize {
    if u64::from(age) < EXACT {
        return age as usize;
    }
    let octave = 31 - age.leading_zeros() - SUB_BITS;
    ((octave << SUB_BITS) + (age >> octave)) as usize
}

/// The least age in a bin.
fn start_of(bin: usize) -> u64 {
    let bin = bin as u64;
    if bin < EXACT {
        return bin;
    }
    let octave = (bin >> SUB_BITS) - 1;
    (bin - (octave << SUB_BITS)) << octave
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_pictures::next;

    #[test]
    fn the_bins_tile_the_range() {
        assert_eq!(start_of(0), 0);
        for bin in 0..BINS {
            let (from, until) = (start_of(bin), start_of(bin + 1));
            assert!(from < until, "bin {bin}");
            assert!((until - from) * 8 <= from.max(8), "bin {bin} is too wide");
            assert_eq!(bin_of(from as u32), bin);
            assert_eq!(bin_of((until - 1) as u32), bin);
        }
        assert_eq!(start_of(BINS), 1 << 32);
    }

    #[test]
    fn against_a_sorted_list() {
        let mut histogram = AgeHistogram::default();
        let mut state = 5;
        let mut ages: Vec<u32> = (0..5000)
            .map(|_| next(&mut state) >> (next(&mut state) % 32))
            .collect();
        for &age in &ages {
            histogram.push(age);
        }
        ages.sort_unstable();
        for q in [0.0, 0.01, 0.25, 0.5, 0.95, 0.99, 1.0] {
            let rank = ((q * 5000.0) as usize).clamp(1, 5000);
            let (exact, got) = (ages[rank - 1], histogram.quantile(q).unwrap().unwrap());
            assert!(got >= exact, "{q}: {got} under {exact}");
            assert!(
                u64::from(got) * 8 <= u64::from(exact) * 9 + 8,
                "{q}: {got} for {exact}"
            );
        }
        let mean = ages.iter().map(|&a| f64::from(a)).sum::<f64>() / 5000.0;
        assert!((histogram.mean().unwrap() - mean).abs() < 1e-6 * mean);
        assert_eq!(histogram.max(), ages.last().copied());
        assert_eq!(histogram.bins().map(|b| b.count).sum::<u64>(), 5000);
    }

    #[test]
    fn merged_is_as_if_pushed_together() {
        let (left, right) = (
            [Some(3), None, Some(70_000)],
            [Some(16), Some(u32::MAX), None],
        );
        let [mut a, mut b, mut both] = [0; 3].map(|_: u8| AgeHistogram::default());
        a.push_all(&left);
        b.push_all(&right);
        both.push_all(&left);
        both.push_all(&right);
        a.merge(&b);
        assert_eq!(a, both);
        assert_eq!((a.count(), a.empty()), (4, 2));
    }

    #[test]
    fn nothing_has_no_age() {
        let histogram = AgeHistogram::default();
        assert_eq!(histogram.mean(), None);
        assert_eq!(histogram.max(), None);
        assert_eq!(histogram.quantile(0.5), Ok(None));
        assert!(histogram.quantile(1.5).is_err());
        assert!(histogram.quantile(f64::NAN).is_err());
    }
}
