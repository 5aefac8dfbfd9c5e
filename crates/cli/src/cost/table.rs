//! From measured points to what is claimed of them: fronts, what a decibel costs, JSON, CSV.

use serde::Serialize;

use super::effort::Law;
use super::front::{Costs, dominated_by, on_front};
use super::knobs::{Described, Knobs, Planned, Preset};
use super::point::{ErrorParts, Measured};
use crate::measure::REFRESH_HZ;

/// A point of the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The knob that is turned.
    pub sweep: &'static str,
    /// The setting.
    pub knobs: Described,
    /// Mean squared error and its parts, displayed levels squared, at every tenth refresh; none
    /// where effects are on.
    pub error: Option<ErrorParts>,
    /// Over every refresh: root of the mean of squares, displayed levels.
    pub rmse: f64,
    /// Of that, dB.
    pub psnr: f64,
    /// RMSE against the same display in `f64`; none where effects are on.
    pub rmse_to_oracle: Option<f64>,
    /// Core seconds of the host for a second of animation.
    pub host_seconds: f64,
    /// Core seconds of the display for a second of animation.
    pub display_seconds: f64,
    /// RMSE on each scene, in their order.
    pub scenes: Vec<f64>,
    /// Instructions of a Cortex-M7 for each new sample, receiving and showing; none where they
    /// were not counted, and of floats.
    pub instructions_per_sample: Option<f64>,
    /// Instructions of a Cortex-M7 for a mean refresh at 60 Hz.
    pub instructions_per_refresh: Option<f64>,
    /// Stream bytes a second.
    pub bytes_per_second: f64,
    /// Rays of the host a second, of all kinds.
    pub rays_per_second: f64,
    /// RAM of the display, bytes.
    pub ram_bytes: u64,
    /// Whether no other point is as good in RMSE, display time, bytes and RAM, and better in one.
    pub on_front: bool,
    /// The preset that this is.
    pub preset: Option<&'static str>,
    /// By what share another point that is no worse in anything is better in something.
    pub dominated_by: f64,
    #[serde(skip)]
    settings: Knobs,
}

impl Point {
    /// What it costs, for fronts.
    #[must_use]
    pub fn costs(&self) -> Costs {
        let time = match self.knobs.format.is_real() {
            true => self.display_seconds,
            // It neither beats nor is beaten.
            false => f64::INFINITY,
        };
        [
            self.rmse,
            time,
            self.bytes_per_second,
            self.ram_bytes as f64,
        ]
    }

    /// The setting itself.
    #[must_use]
    pub fn settings(&self) -> &Knobs {
        &self.settings
    }
}

/// All points, each in each of its sweeps. `measured` has a row for each scene.
#[must_use]
pub fn points(
    planned: &[Planned],
    measured: &[Vec<Measured>],
    pixels: u32,
    law: &dyn Fn(&Knobs) -> Option<Law>,
) -> Vec<Point> {
    let mut points: Vec<Point> = planned
        .iter()
        .enumerate()
        .map(|(i, planned)| {
            let scenes: Vec<&Measured> = measured.iter().filter_map(|row| row.get(i)).collect();
            let m = Measured::mean(&scenes);
            let effort = m
                .work
                .and_then(|work| Some(law(&planned.knobs)?.predict(&work).total()));
            let each = f64::from(REFRESH_HZ) / f64::from(planned.knobs.rate(pixels));
            Point {
                sweep: planned.sweep,
                knobs: planned.knobs.described(pixels),
                error: m.error,
                rmse: m.rmse,
                psnr: psnr(m.rmse),
                scenes: scenes.iter().map(|m| m.rmse).collect(),
                rmse_to_oracle: m.rmse_to_oracle,
                host_seconds: m.host_seconds,
                display_seconds: m.display_seconds,
                instructions_per_sample: effort.map(|effort| effort * each),
                instructions_per_refresh: effort,
                bytes_per_second: m.bytes_per_second,
                rays_per_second: m.rays_per_second,
                ram_bytes: m.ram_bytes,
                on_front: false,
                preset: Preset::of(&planned.knobs),
                dominated_by: 0.0,
                settings: planned.knobs,
            }
        })
        .collect();
    let costs: Vec<Costs> = points.iter().map(Point::costs).collect();
    for ((point, front), own) in points.iter_mut().zip(on_front(&costs)).zip(&costs) {
        point.on_front = front && point.knobs.format.is_real();
        point.dominated_by = dominated_by(own, &costs);
    }
    points
}

/// Peak signal-to-noise ratio, dB.
#[must_use]
pub fn psnr(rmse: f64) -> f64 {
    20.0 * (255.0 / rmse.max(1e-9)).log10()
}

/// Points that differ in their settings, each once.
#[must_use]
pub fn distinct(points: &[Point]) -> Vec<&Point> {
    let mut seen: Vec<&Point> = Vec::new();
    for point in points {
        if !seen.iter().any(|other| other.settings == point.settings) {
            seen.push(point);
        }
    }
    seen
}

/// The presets, from the greatest error to the least.
#[must_use]
pub fn presets(points: &[Point]) -> Vec<&Point> {
    let mut found: Vec<&Point> = distinct(points)
        .into_iter()
        .filter(|point| point.preset.is_some())
        .collect();
    found.sort_by(|a, b| b.rmse.total_cmp(&a.rmse));
    found
}

/// A way to count cost.
pub type CostOf = fn(&Point) -> f64;

/// Costs by name; what was not counted is not a number.
pub const COSTS: [(&str, CostOf); 5] = [
    ("display time", |p| p.display_seconds),
    ("host time", |p| p.host_seconds),
    ("bytes a second", |p| p.bytes_per_second),
    ("RAM", |p| p.ram_bytes as f64),
    ("Cortex-M7 instructions", |p| {
        p.instructions_per_refresh.unwrap_or(f64::NAN)
    }),
];

/// The front of error against one cost: from the cheapest to the best.
#[must_use]
pub fn front_of(points: &[Point], cost: CostOf) -> Vec<&Point> {
    let mut sorted: Vec<&Point> = distinct(points)
        .into_iter()
        .filter(|point| point.knobs.format == super::knobs::Format::Fixed)
        .filter(|point| cost(point).is_finite())
        .collect();
    sorted.sort_by(|a, b| cost(a).total_cmp(&cost(b)).then(a.rmse.total_cmp(&b.rmse)));
    let mut least = f64::INFINITY;
    sorted.retain(|point| {
        let better = point.rmse < least;
        least = least.min(point.rmse);
        better
    });
    sorted
}

/// By what factor one decibel more multiplies a cost, along its front: a straight line through
/// the logarithms, by least squares. None of fewer than three points.
#[must_use]
pub fn factor_per_decibel(points: &[Point], cost: CostOf) -> Option<f64> {
    let front = front_of(points, cost);
    let pairs: Vec<(f64, f64)> = front.iter().map(|p| (p.psnr, cost(p).ln())).collect();
    slope(&pairs).map(f64::exp)
}

/// The slope of the line through points, by least squares; none of fewer than three.
#[must_use]
pub fn slope(pairs: &[(f64, f64)]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let n = pairs.len() as f64;
    let (x, y) = pairs
        .iter()
        .fold((0.0, 0.0), |a, p| (a.0 + p.0 / n, a.1 + p.1 / n));
    let (xy, xx) = pairs.iter().fold((0.0, 0.0), |a, p| {
        (a.0 + (p.0 - x) * (p.1 - y), a.1 + (p.0 - x).powi(2))
    });
    (xx > 0.0).then(|| xy / xx)
}

/// All points as comma-separated values (RFC 4180), with a line of heads.
#[must_use]
pub fn csv(points: &[Point]) -> String {
    let mut out = String::from(
        "sweep,method,rate,samples,format,sampling,detail,fit,hidden,extents,lifetime,kernel,cutoff,fill,light,rmse,psnr,\
         mse_sampling,mse_filtering,mse_arithmetic,mse_delay,mse_total,rmse_to_oracle,\
         host_seconds,display_seconds,instructions_per_sample,bytes_per_second,rays_per_second,ram_bytes,on_front,\
         preset\r\n",
    );
    for p in points {
        let k = &p.knobs;
        let counted = |number: Option<f64>| number.map(|v| v.to_string()).unwrap_or_default();
        let part = |of: fn(&ErrorParts) -> f64| counted(p.error.as_ref().map(of));
        let real = |number: String| {
            if k.format.is_real() {
                number
            } else {
                String::new()
            }
        };
        let cells = [
            p.sweep.to_owned(),
            k.method.to_owned(),
            k.rate.to_string(),
            k.samples.to_string(),
            k.format.name().to_owned(),
            k.sampling.clone(),
            k.detail.clone(),
            k.fit.to_owned(),
            k.hidden.to_string(),
            k.extents.clone(),
            k.lifetime.clone(),
            k.kernel.to_owned(),
            k.cutoff.clone(),
            k.fill.to_string(),
            k.light.to_owned(),
            p.rmse.to_string(),
            p.psnr.to_string(),
            part(|e| e.sampling),
            part(|e| e.filtering),
            part(|e| e.arithmetic),
            part(|e| e.delay),
            part(|e| e.total),
            counted(p.rmse_to_oracle),
            p.host_seconds.to_string(),
            real(p.display_seconds.to_string()),
            counted(p.instructions_per_sample),
            p.bytes_per_second.to_string(),
            p.rays_per_second.to_string(),
            real(p.ram_bytes.to_string()),
            p.on_front.to_string(),
            p.preset.unwrap_or("").to_owned(),
        ];
        out += &cells.join(",");
        out += "\r\n";
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cost::effects;
    use crate::cost::knobs::PRESETS;

    #[test]
    fn a_slope_is_a_slope() {
        let line = |x: f64| (x, 3.0 - 0.5 * x);
        let found = slope(&[line(0.0), line(1.0), line(5.0)]).unwrap();
        assert!((found + 0.5).abs() < 1e-12);
        assert_eq!(slope(&[line(0.0), line(1.0)]), None);
        assert_eq!(slope(&[line(1.0); 4]), None);
    }

    /// The sweep of three scenes at 128 × 128 pixels, as `docs/RESULTS.md` says it was made.
    const SWEPT: &str = include_str!("../../../../docs/cost.csv");

    /// What was measured once: names of columns to cells, a point each.
    fn swept() -> Vec<std::collections::BTreeMap<&'static str, &'static str>> {
        let mut lines = SWEPT.lines();
        let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
        lines
            .map(|line| heads.iter().copied().zip(line.split(',')).collect())
            .collect()
    }

    /// Held to the table: every preset is a point of it, and no point of it beats one. Instructions
    /// stand for time: they repeat exactly.
    #[test]
    fn no_preset_is_beaten_in_the_table() {
        // What was measured on another scene is neither better nor worse.
        let table: Vec<_> = swept()
            .into_iter()
            .filter(|row| row["sweep"] != effects::SWEEP)
            .collect();
        let costs = |row: &std::collections::BTreeMap<&str, &str>| -> Option<Costs> {
            let number = |name: &str| row[name].parse::<f64>().ok();
            let each = number("instructions_per_sample")?;
            Some([
                number("rmse")?,
                each * number("rate")?,
                number("bytes_per_second")?,
                number("ram_bytes")?,
            ])
        };
        let all: Vec<Costs> = table.iter().filter_map(costs).collect();
        assert!(all.len() > 80, "{}", all.len());
        let beaten = all.iter().filter(|own| dominated_by(own, &all) > 0.03);
        assert!(beaten.count() > 10, "nothing is found beaten");
        for preset in PRESETS {
            let knobs = preset.knobs().described(128 * 128);
            let cells = [
                ("method", knobs.method.to_owned()),
                ("rate", knobs.rate.to_string()),
                ("samples", knobs.samples.to_string()),
                ("format", "fixed".to_owned()),
                ("detail", String::new()),
                ("fit", knobs.fit.to_owned()),
                ("hidden", knobs.hidden.to_string()),
                ("extents", knobs.extents),
                ("lifetime", knobs.lifetime),
                ("kernel", knobs.kernel.to_owned()),
                ("cutoff", knobs.cutoff),
                ("fill", knobs.fill.to_string()),
                ("light", knobs.light.to_owned()),
            ];
            let name = preset.name;
            let row = table
                .iter()
                .find(|row| cells.iter().all(|(head, cell)| row[head] == cell))
                .unwrap_or_else(|| panic!("`{name}` is not in docs/cost.csv: sweep again"));
            let by = dominated_by(&costs(row).unwrap(), &all);
            assert!(by <= 0.03, "`{name}` is beaten by {by}");
        }
    }
}
