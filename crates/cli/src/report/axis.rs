//! An axis of a plot: what it measures, its range, where its ticks go and what they say.

use std::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps for equal differences, from 0 if no value is negative.
    FromZero,
    /// Equal steps for equal differences, from the least value to the greatest.
    Linear,
    /// Equal steps for equal ratios. Values of 0 and below have no place on it and are left out.
    Log,
}

/// What is measured along an axis, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What is measured, with its unit: "time, s".
    pub label: String,
    /// How values are spread.
    pub scale: Scale,
}

impl Axis {
    /// An axis for `label` ("RMSE, of 255").
    pub fn new(label: impl Into<String>, scale: Scale) -> Self {
        Self {
            label: label.into(),
            scale,
        }
    }

    /// Whether a value has a place on the axis.
    pub(super) fn holds(&self, value: f64) -> bool {
        // Beyond 1e300 even differences overflow.
        value.abs() <= 1e300 && (self.scale != Scale::Log || value >= 1e-300)
    }

    /// The range that shows all these values: never empty, never infinite.
    pub(super) fn span(&self, values: impl Iterator<Item = f64>) -> Span {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| self.holds(*v)) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            (low, high) = match self.scale {
                Scale::Log => (1.0, 10.0),
                Scale::FromZero | Scale::Linear => (0.0, 1.0),
            };
        }
        if self.scale == Scale::Log {
            // Out to the next of 1, 2, 5, so that both ends have a tick nearby.
            let (mut low, mut high) = (low * 0.93, high * 1.07);
            if high / low < 2.0 {
                (low, high) = (low / 1.5, high * 1.5);
            }
            return Span {
                low,
                high,
                log: true,
            };
        }
        if self.scale == Scale::FromZero && low >= 0.0 {
            low = 0.0;
            high *= 1.05;
        }
        if high - low <= f64::EPSILON * high.abs().max(low.abs()) {
            let half = (0.5 * high.abs()).max(0.5);
            (low, high) = if self.scale == Scale::FromZero && low >= 0.0 {
                (0.0, 1.0)
            } else {
                (low - half, high + half)
            };
        }
        Span {
            low,
            high,
            log: false,
        }
    }
}

/// The range of an axis as plotters wants it. Invariant: `low < high`, both finite; both above 0
/// if `log`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) log: bool,
}

impl Span {
    /// Where a value lies: 0 at the low end, 1 at the high one.
    pub(super) fn place(&self, value: f64) -> f64 {
        let place = if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        if place.is_nan() {
            0.0
        } else {
            place.clamp(0.0, 1.0)
        }
    }

    /// About `count` round values in the range.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        let count = count.clamp(2, 20);
        if self.log {
            let decades = (self.high / self.low).log10();
            let steps: &[f64] = if decades * 3.0 <= count as f64 + 2.0 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let every = (decades / count as f64).ceil().max(1.0) as i32;
            let first = self.low.log10().floor() as i32;
            let last = self.high.log10().ceil() as i32;
            return (first..=last)
                .filter(|e| e.rem_euclid(every) == 0)
                .flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)))
                .filter(|v| (self.low..=self.high).contains(v))
                .collect();
        }
        let rough = (self.high - self.low) / count as f64;
        let unit = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|m| m * unit)
            .find(|s| *s >= rough * 0.999)
            .unwrap_or(10.0 * unit);
        let first = (self.low / step).ceil();
        (0..=2 * count)
            .map(|i| (first + i as f64) * step)
            .take_while(|v| *v <= self.high + 1e-9 * step)
            .collect()
    }
}

impl Ranged for Span {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let (from, to) = (f64::from(limit.0), f64::from(limit.1));
        (from + self.place(*value) * (to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.ticks(hint.max_num_points())
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

/// A number for a tick or a bar: four significant digits at most, thousands as k, M, G.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let size = value.abs();
    let (scaled, suffix) = match size {
        s if s >= 9.9995e12 || (s > 0.0 && s < 9.9995e-5) => {
            return format!("{value:.2e}").replace('-', "−");
        }
        s if s >= 9.9995e8 => (value / 1e9, "G"),
        s if s >= 9.9995e5 => (value / 1e6, "M"),
        s if s >= 9.9995e3 => (value / 1e3, "k"),
        _ => (value, ""),
    };
    let digits = match scaled.abs() {
        s if s >= 999.95 => 0,
        s if s >= 99.995 => 1,
        s if s >= 9.9995 => 2,
        s if s >= 0.99995 => 3,
        _ => 4,
    };
    let text = format!("{scaled:.digits$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    // A minus in front of nothing.
    let text = if text == "-0" { "0" } else { text };
    format!("{text}{suffix}").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_right() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (400_000.0, "400k"),
            (3_932_160.0, "3.932M"),
            (12_346.0, "12.35k"),
            (999.96, "1000"),
            (99.996, "100"),
            (-7.5, "−7.5"),
            (0.00012, "0.0001"),
            (0.000_01, "1.00e−5"),
            (1e20, "1.00e20"),
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        let axis = Axis::new("t", Scale::Linear);
        let span = axis.span([0.0, 3.0].into_iter());
        assert_eq!(span.ticks(6), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        let span = axis.span([-7.3, 11.0].into_iter());
        assert_eq!(span.ticks(5), [-5.0, 0.0, 5.0, 10.0]);
    }

    #[test]
    fn log_ticks_thin_out_as_the_range_grows() {
        let axis = Axis::new("rate", Scale::Log);
        let span = axis.span([100e3, 800e3].into_iter());
        assert_eq!(span.ticks(6), [1e5, 2e5, 5e5]);
        let wide = axis.span([1e-6, 1e6].into_iter()).ticks(6);
        assert!((4..=8).contains(&wide.len()), "{wide:?}");
        assert!(axis.span([0.0, -4.0, 10.0].into_iter()).low > 1.0);
    }

    #[test]
    fn any_data_gives_a_range_that_can_be_drawn() {
        let sets: [&[f64]; 8] = [
            &[],
            &[f64::NAN, f64::INFINITY],
            &[0.0],
            &[-3.0, -3.0],
            &[f64::MAX, f64::MIN],
            &[1e300, -1e300],
            &[5e-324, 1e-299],
            &[1e15, 1e15 + 0.125],
        ];
        for scale in [Scale::FromZero, Scale::Linear, Scale::Log] {
            let axis = Axis::new("", scale);
            for set in sets {
                let span = axis.span(set.iter().copied());
                assert!(span.low < span.high, "{scale:?} {set:?} {span:?}");
                assert!(span.low.is_finite() && span.high.is_finite());
                assert!((0.0..=1.0).contains(&span.place(set.first().copied().unwrap_or(0.0))));
                let ticks = span.ticks(6);
                assert!(ticks.len() <= 25, "{scale:?} {set:?} {ticks:?}");
                assert!(ticks.iter().all(|t| t.is_finite()));
            }
        }
    }
}
