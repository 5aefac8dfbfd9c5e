//! From cells to what is claimed: means over seeds, ratios, JSON, CSV.

use serde::Serialize;
use serde_json::{Value, json};

use super::cell::{Cell, ClassShare, Spending};
use super::methods::EvalMethod;
use super::probes::{Convergence, Recovery};
use super::{page, plan};

/// A method on a scene at a rate: the mean over its seeds, and their spread.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The scene as typed.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// Camera samples a second.
    pub rate: u32,
    /// Number of seeds; methods without chance have one.
    pub seeds: usize,
    /// Mean over seeds; as are all numbers of that kind here.
    pub rmse: f64,
    /// The least of a seed.
    pub rmse_min: f64,
    /// The greatest of a seed.
    pub rmse_max: f64,
    /// dB, of the mean RMSE; none where nothing differs.
    pub psnr: Option<f64>,
    /// Mean ꟻLIP.
    pub flip: Option<f64>,
    /// ColorVideoVDP, JOD, of the first seed.
    pub cvvdp: Option<f64>,
    /// The worst refresh of any seed.
    pub worst_rmse: f64,
    /// What 95 % of the refreshes do not exceed.
    pub p95_rmse: f64,
    /// Camera samples taken.
    pub samples: u64,
    /// Rays of all kinds; 0 of what has no stream.
    pub rays: u64,
    /// Stream bytes a sample; none without a stream.
    pub bytes_per_sample: Option<f64>,
    /// Seconds on one core of the renderer.
    pub seconds_host: f64,
    /// Seconds on one core of the display.
    pub seconds_display: f64,
    /// What the renderer's seconds were spent on; none without a stream.
    pub spent: Option<Spending>,
    /// Share of the renderer's seconds that is not tracing, stream or scene, 0..=1.
    pub overhead: Option<f64>,
    /// The setting that did best with the first seed, of methods that have several.
    pub setting: String,
    /// Milliseconds from each announced cut (of the first seed) until the RMSE is back at 1.2
    /// times its median.
    pub recovery_ms: Vec<f64>,
    /// Share of the squared error that is age.
    pub stale: Option<f64>,
    /// The error by class of pixel.
    pub classes: Vec<ClassShare>,
}

/// Means over seeds, in the order in which the rows first come.
#[must_use]
pub fn rows(cells: &[Cell]) -> Vec<Row> {
    let mut groups: Vec<Vec<&Cell>> = Vec::new();
    for cell in cells {
        let same = |g: &&mut Vec<&Cell>| {
            (&g[0].scene, &g[0].method, g[0].rate) == (&cell.scene, &cell.method, cell.rate)
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(cell),
            None => groups.push(vec![cell]),
        }
    }
    groups.iter().map(|group| row(group)).collect()
}

fn row(group: &[&Cell]) -> Row {
    let first = group[0];
    let count = group.len() as f64;
    let mean = |value: fn(&Cell) -> f64| group.iter().map(|c| value(c)).sum::<f64>() / count;
    // Of the seeds that have it: some measures are of the first alone.
    let maybe = |value: fn(&Cell) -> Option<f64>| {
        let values: Vec<f64> = group.iter().filter_map(|c| value(c)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let rmse = mean(|c| c.rmse);
    let class = |(i, share): (usize, &ClassShare)| ClassShare {
        class: share.class.clone(),
        error: group.iter().map(|c| c.classes[i].error).sum::<f64>() / count,
        area: share.area,
    };
    Row {
        scene: first.scene.clone(),
        method: first.method.clone(),
        rate: first.rate,
        seeds: group.len(),
        rmse,
        rmse_min: group.iter().map(|c| c.rmse).fold(f64::INFINITY, f64::min),
        rmse_max: group.iter().map(|c| c.rmse).fold(0.0, f64::max),
        psnr: (rmse > 0.0).then(|| 20.0 * (255.0 / rmse).log10()),
        flip: maybe(|c| c.flip),
        cvvdp: maybe(|c| c.cvvdp),
        worst_rmse: group.iter().map(|c| c.worst_rmse).fold(0.0, f64::max),
        p95_rmse: mean(|c| c.p95_rmse),
        samples: mean(|c| c.samples as f64).round() as u64,
        rays: mean(|c| c.rays as f64).round() as u64,
        bytes_per_sample: (first.stream_bytes > 0)
            .then(|| first.stream_bytes as f64 / first.samples.max(1) as f64),
        seconds_host: mean(|c| c.seconds_host),
        seconds_display: mean(|c| c.seconds_display),
        spent: first.spent,
        overhead: maybe(|c| c.spent.map(|spent| spent.overhead())),
        setting: first.setting.clone(),
        recovery_ms: first
            .cuts
            .iter()
            .filter_map(|cut| recovery(first, *cut))
            .collect(),
        stale: maybe(|c| c.stale),
        classes: first.classes.iter().enumerate().map(class).collect(),
    }
}

/// Milliseconds from a cut until the RMSE is at most 1.2 times the median; none if it never is.
fn recovery(cell: &Cell, cut: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = cell.refreshes.iter().map(|r| r.rmse).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2)?;
    let back = cell
        .refreshes
        .iter()
        .find(|r| r.time >= cut && r.rmse <= 1.2 * median)?;
    Some(1000.0 * (back.time - cut))
}

/// A claim: that the error of `adaptive` is at most `limit` of that of another method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The rate of `adaptive`, and of the other where it has a choice.
    pub rate: u32,
    /// The other.
    pub against: EvalMethod,
    /// Greatest ratio of RMSE.
    pub limit: f64,
    /// Hoped for, not promised.
    pub moonshot: bool,
}

/// What must be shown.
pub const BOUNDS: [Bound; 6] = [
    bound(400_000, EvalMethod::Framed60Tenfold, 0.45, false),
    bound(400_000, EvalMethod::Uniform, 0.6, false),
    bound(400_000, EvalMethod::UniformSameDisplay, 0.85, false),
    bound(400_000, EvalMethod::Taau, 0.55, false),
    bound(100_000, EvalMethod::Framed60Tenfold, 0.7, false),
    bound(400_000, EvalMethod::Framed60TenfoldNoDelay, 0.9, true),
];

const fn bound(rate: u32, against: EvalMethod, limit: f64, moonshot: bool) -> Bound {
    Bound {
        rate,
        against,
        limit,
        moonshot,
    }
}

/// A claim on a scene, and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The scene as typed.
    pub scene: String,
    /// The rate of `adaptive`.
    pub rate: u32,
    /// The other method.
    pub against: String,
    /// Greatest ratio of RMSE.
    pub limit: f64,
    /// The ratio found.
    pub ratio: f64,
    /// Whether the ratio is within the limit.
    pub holds: bool,
    /// Hoped for, not promised.
    pub moonshot: bool,
    /// The ratio of ꟻLIP.
    pub flip_ratio: Option<f64>,
    /// How much better by ColorVideoVDP, JOD; above 0 is better.
    pub cvvdp_gain: Option<f64>,
    /// Whether the perceptual metrics that were measured agree which of the two is better.
    pub metrics_agree: bool,
}

/// The claims of which both sides were measured, scene by scene.
#[must_use]
pub fn verdicts(rows: &[Row]) -> Vec<Verdict> {
    let mut scenes: Vec<&str> = Vec::new();
    for row in rows {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let mut verdicts = Vec::new();
    for scene in scenes {
        let find = |method: EvalMethod, rate: u32| {
            let rate_fits = |row: &Row| method.is_tenfold() || row.rate == rate;
            rows.iter()
                .find(|r| r.scene == scene && r.method == method.name() && rate_fits(r))
        };
        for bound in BOUNDS {
            let adaptive = find(EvalMethod::Adaptive, bound.rate);
            if let (Some(adaptive), Some(other)) = (adaptive, find(bound.against, bound.rate)) {
                verdicts.push(verdict(&bound, adaptive, other));
            }
        }
    }
    verdicts
}

fn verdict(bound: &Bound, adaptive: &Row, other: &Row) -> Verdict {
    let ratio = adaptive.rmse / other.rmse;
    let flip_ratio = adaptive.flip.zip(other.flip).map(|(a, b)| a / b);
    let cvvdp_gain = adaptive.cvvdp.zip(other.cvvdp).map(|(a, b)| a - b);
    let better = ratio < 1.0;
    Verdict {
        scene: adaptive.scene.clone(),
        rate: bound.rate,
        against: other.method.clone(),
        limit: bound.limit,
        ratio,
        holds: ratio <= bound.limit,
        moonshot: bound.moonshot,
        flip_ratio,
        cvvdp_gain,
        metrics_agree: flip_ratio.is_none_or(|flip| (flip < 1.0) == better)
            && cvvdp_gain.is_none_or(|gain| (gain > 0.0) == better),
    }
}

/// The greatest share of the renderer's time that control may take (Dayal et al. 2005 §7.1).
pub const OVERHEAD_LIMIT: f64 = 0.15;

/// What leaving a part out changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ablation {
    /// The scene as typed.
    pub scene: String,
    /// The method without the part.
    pub method: String,
    /// What is different without it.
    pub instead: &'static str,
    /// Camera samples a second.
    pub rate: u32,
    /// RMSE over that of `adaptive`, less 1: above 0 the part helps.
    pub rmse_change: f64,
    /// Half the spread over seeds of either, over the RMSE of `adaptive`: changes below it are
    /// noise. None of one seed.
    pub noise: Option<f64>,
    /// The renderer's seconds over those of `adaptive`, less 1: below 0 the part costs time.
    pub host_change: f64,
    /// The same of the display's.
    pub display_change: f64,
}

/// The parts that were left out, scene by scene, at the usual rate.
#[must_use]
pub fn ablations(rows: &[Row]) -> Vec<Ablation> {
    let mut found = Vec::new();
    let usual = plan::usual_rate(&page::rates(rows));
    for row in rows.iter().filter(|row| row.rate == usual) {
        let Some(method) = EvalMethod::ablations().find(|m| m.name() == row.method) else {
            continue;
        };
        let whole = rows.iter().find(|whole| {
            whole.method == EvalMethod::Adaptive.name()
                && (&whole.scene, whole.rate) == (&row.scene, row.rate)
        });
        let Some(whole) = whole else { continue };
        let spread = |row: &Row| 0.5 * (row.rmse_max - row.rmse_min);
        found.push(Ablation {
            scene: row.scene.clone(),
            method: row.method.clone(),
            instead: method.instead().unwrap_or(""),
            rate: row.rate,
            rmse_change: row.rmse / whole.rmse - 1.0,
            noise: (row.seeds > 1).then(|| spread(row).max(spread(whole)) / whole.rmse),
            host_change: row.seconds_host / whole.seconds_host - 1.0,
            display_change: row.seconds_display / whole.seconds_display - 1.0,
        });
    }
    found
}

/// Stills and cuts among the cells.
#[must_use]
pub fn probed(cells: &[Cell], scenes: &[String]) -> (Vec<Convergence>, Vec<Recovery>) {
    let (mut stills, mut cuts) = (Vec::new(), Vec::new());
    for scene in scenes {
        let still = plan::still_name(scene);
        stills.extend(
            cells
                .iter()
                .filter(|c| c.scene == still)
                .map(Convergence::of),
        );
        let (cut, steady) = (plan::cut_name(scene), plan::steady_name(scene));
        let mut asked: Vec<(&str, u32)> = Vec::new();
        for cell in cells.iter().filter(|c| c.scene == cut) {
            let question = (cell.method.as_str(), cell.rate);
            if asked.contains(&question) {
                continue;
            }
            asked.push(question);
            let of = |scene: &str| -> Vec<&Cell> {
                let same = |c: &&Cell| c.scene == scene && (c.method.as_str(), c.rate) == question;
                cells.iter().filter(same).collect()
            };
            cuts.extend(Recovery::of(&of(&cut), &of(&steady), &of(scene)));
        }
    }
    (stills, cuts)
}

/// All that was found out.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Means over seeds.
    pub rows: Vec<Row>,
    /// Claims.
    pub verdicts: Vec<Verdict>,
    /// What parts are worth.
    pub ablations: Vec<Ablation>,
    /// What became of still pictures.
    pub stills: Vec<Convergence>,
    /// How cuts were forgotten.
    pub cuts: Vec<Recovery>,
}

impl Found {
    /// From cells of `scenes` (as typed).
    #[must_use]
    pub fn new(cells: &[Cell], scenes: &[String]) -> Self {
        let (stills, cuts) = probed(cells, scenes);
        let whole: Vec<Cell> = cells
            .iter()
            .filter(|cell| scenes.contains(&cell.scene))
            .cloned()
            .collect();
        let rows = rows(&whole);
        Self {
            verdicts: verdicts(&rows),
            ablations: ablations(&rows),
            rows,
            stills,
            cuts,
        }
    }

    /// As JSON: the rows as `cells`, the claims, each seed's numbers over time as `runs`.
    #[must_use]
    pub fn report(&self, cells: &[Cell], facts: Value) -> Value {
        json!({
            "settings": facts,
            "cells": self.rows,
            "bounds": self.verdicts,
            "ablations": self.ablations,
            "golden": self.stills,
            "recovery": self.cuts,
            "runs": cells,
        })
    }
}

/// The rows as comma-separated values (RFC 4180), with a line of heads.
#[must_use]
pub fn csv(rows: &[Row]) -> String {
    let mut out = String::from(
        "scene,method,rate,seeds,rmse,rmse_min,rmse_max,psnr,flip,cvvdp,worst_rmse,p95_rmse,\
         samples,bytes_per_sample,seconds_host,seconds_display,overhead,stale\r\n",
    );
    let maybe = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    for r in rows {
        let cells = [
            quoted(&r.scene),
            r.method.clone(),
            r.rate.to_string(),
            r.seeds.to_string(),
            r.rmse.to_string(),
            r.rmse_min.to_string(),
            r.rmse_max.to_string(),
            maybe(r.psnr),
            maybe(r.flip),
            maybe(r.cvvdp),
            r.worst_rmse.to_string(),
            r.p95_rmse.to_string(),
            r.samples.to_string(),
            maybe(r.bytes_per_sample),
            r.seconds_host.to_string(),
            r.seconds_display.to_string(),
            maybe(r.overhead),
            maybe(r.stale),
        ];
        out += &cells.join(",");
        out += "\r\n";
    }
    out
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
