//! Notices that everything has become wrong at once: a cut, or an eye that passed a surface.

use std::ops::RangeInclusive;

/// Looks at the last few hundred verifications.
#[derive(Clone, Debug)]
pub(super) struct Alarm {
    /// Verifications that are remembered.
    memory: f32,
    /// Weights of the failed and of all verifications, the old ones discounted.
    failed: f32,
    all: f32,
    /// When the current run of failures began, seconds.
    since: Option<f64>,
}

/// Verifications that are remembered: those of a hundredth of a second, but enough to judge by.
/// Their weights are uneven, so that a hundred are few to tell a fast turn from a cut.
const SECONDS: f64 = 0.01;
const MEMORY: RangeInclusive<f32> = 96.0..=400.0;
/// Share of failures that means a cut.
const SHARE: f32 = 0.5;
/// Share of failures from which it may be one.
const SUSPICION: f32 = 0.15;

impl Default for Alarm {
    fn default() -> Self {
        Self {
            memory: *MEMORY.start(),
            failed: 0.0,
            all: 0.0,
            since: None,
        }
    }
}

impl Alarm {
    /// Sets how many verifications there are in a second.
    pub(super) fn set_rate(&mut self, verifications: f64) {
        self.memory = ((verifications * SECONDS) as f32).clamp(*MEMORY.start(), *MEMORY.end());
    }

    /// Whether so many fail of late that it may be a cut: time to look closer.
    pub(super) fn suspects(&self) -> bool {
        self.failed > SUSPICION * self.all && self.all > 0.1 * self.memory
    }

    /// Takes a verification in. Its `weight` makes up for the bias of the sampler towards places
    /// in trouble: 1 over how much likelier than a uniform choice it was, so that the weights are
    /// 1 on average and the share of failures is that of the image's area. When the alarm is
    /// raised: the instant at which the failures began.
    pub(super) fn verified(&mut self, time: f64, weight: f32, failed: bool) -> Option<f64> {
        let keep = 1.0 - 1.0 / self.memory;
        self.failed = self.failed * keep + if failed { weight } else { 0.0 };
        self.all = self.all * keep + weight;
        if self.failed < 0.3 * self.all {
            self.since = None;
        } else if self.since.is_none() {
            self.since = Some(time);
        }
        if self.all > 0.4 * self.memory && self.failed > SHARE * self.all {
            let since = self.since;
            *self = Self {
                memory: self.memory,
                ..Self::default()
            };
            return since;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::noise::Random;

    #[test]
    fn trouble_in_a_corner_is_no_cut() {
        // A twentieth of the image fails, and gets nine tenths of the looks.
        let (share, bias) = (0.05, 0.9);
        let mut alarm = Alarm::default();
        let mut random = Random::new(7);
        for i in 0..100_000 {
            let corner = random.unit() < bias;
            let weight = if corner {
                share / bias
            } else {
                (1.0 - share) / (1.0 - bias)
            };
            assert_eq!(alarm.verified(f64::from(i), weight, corner), None);
        }
    }

    #[test]
    fn raised_by_a_cut_and_not_by_a_third_of_failures() {
        let mut alarm = Alarm::default();
        let mut random = Random::new(2);
        for i in 0..100_000 {
            let failed = random.unit() < 0.33;
            assert_eq!(alarm.verified(f64::from(i), 1.0, failed), None);
        }
        let mut raised = None;
        for i in 0..200 {
            let failed = random.unit() < 0.9;
            raised = raised.or(alarm
                .verified(f64::from(100_000 + i), 1.0, failed)
                .map(|t| (i, t)));
        }
        let (after, since) = raised.expect("a cut is noticed");
        assert!(after < 120, "after {after} verifications");
        assert!(since >= 99_000.0);
    }
}
