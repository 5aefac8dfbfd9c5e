//! The page of an evaluation: who wins by how much, which promises hold, then Table 1 and
//! Figure 8 of Dayal et al. 2005, causes, pictures ([`scene`]), parts and probes ([`parts`]).

mod parts;
mod scene;

use std::path::Path;

use anyhow::Result;

use super::cell::{Cell, Job};
use super::checks::{Outcome, checks};
use super::methods::EvalMethod;
use super::plan::usual_rate;
use super::store::slug;
use super::table::{Found, Row};
use crate::report::{BarChart, Picture, Report, Section, Table};

/// What the page is made from.
pub struct Findings<'a> {
    /// What was found out.
    pub found: &'a Found,
    /// Each with its job, in the same order.
    pub cells: &'a [(Job, Cell)],
    /// The ideal picture of a scene at a refresh, if it is still there.
    pub ideal: &'a dyn Fn(&str, u32) -> Option<Picture>,
    /// Where cells and their pictures are.
    pub cell_dir: &'a Path,
    /// Names and values for the head of the page.
    pub facts: Vec<(&'static str, String)>,
}

/// Writes `report.html` and the plots as SVG files under `dir`.
///
/// # Errors
/// A plot cannot be drawn or a file not be written.
pub fn write(findings: &Findings<'_>, dir: &Path) -> Result<()> {
    let found = findings.found;
    let mut report = Report::new(
        "unframed: against the ideal renderer",
        "All methods take the same number of camera samples a second, unless their name says \
         10x. Each picture that the display shows is compared with a supersampled image of the \
         same instant; every refresh counts.",
    );
    let checked = checks(found);
    if !checked.is_empty() {
        let holds = checked.iter().filter(|c| c.outcome == Outcome::Holds);
        report.fact(
            "claims that hold",
            format!("{} of {}", holds.count(), checked.len()),
        );
    }
    for (name, value) in &findings.facts {
        report.fact(*name, value);
    }
    if let Some(section) = glance(&found.rows)? {
        report.section(section);
    }
    if !checked.is_empty() {
        let mut section = Section::new("What must be shown");
        let mut table = Table::new(["scene", "claim", "found", ""]).caption(
            "Ratios are of RMSE. “Same rank by eye”: the perceptual metrics agree with RMSE which \
             of the two is better (FLIP below 1 and JOD above 0 favour adaptive).",
        );
        for check in &checked {
            let mark = check.mark();
            let cells = [&check.scene, &check.claim, &check.found];
            table.row(cells.map(String::as_str).into_iter().chain([mark]));
        }
        section.table(&table);
        report.section(section);
    }
    if !found.rows.is_empty() {
        report.section(table_1(&found.rows));
    }
    if !found.ablations.is_empty() {
        report.section(parts::ablations(&found.ablations, &found.rows));
    }
    for section in parts::probes(findings, dir)? {
        report.section(section);
    }
    for name in scenes(&found.rows) {
        scene::sections(findings, name, dir, &mut report)?;
    }
    report.footer(
        "RMSE: root mean square over pixels and R, G, B of displayed sRGB values, 0 to 255; over \
         an animation the root of the mean of squares. JOD: ColorVideoVDP over the whole \
         animation of the first seed, of 10. FLIP: mean over the refreshes at which it was \
         measured, 67 pixels a degree. Seconds are of the thread that did the work, not of the clock on the wall.",
    );
    report.write(&dir.join("report.html"))?;
    Ok(())
}

fn scenes(rows: &[Row]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.scene.as_str()) {
            names.push(&row.scene);
        }
    }
    names
}

/// The methods of the main table that were run.
fn methods(rows: &[Row]) -> impl Iterator<Item = EvalMethod> {
    EvalMethod::all().filter(|method| rows.iter().any(|row| row.method == method.name()))
}

/// Rates at which not only the tenfold renderers were run, ascending.
pub(super) fn rates(rows: &[Row]) -> Vec<u32> {
    let tenfold = |row: &&Row| {
        EvalMethod::all().any(|method| method.is_tenfold() && method.name() == row.method)
    };
    let mut rates: Vec<u32> = rows
        .iter()
        .filter(|row| !tenfold(row))
        .map(|row| row.rate)
        .collect();
    rates.sort_unstable();
    rates.dedup();
    rates
}

fn find<'a>(rows: &'a [Row], scene: &str, method: EvalMethod, rate: u32) -> Option<&'a Row> {
    rows.iter().find(|row| {
        row.scene == scene
            && row.method == method.name()
            && (row.rate == rate || method.is_tenfold())
    })
}

/// A number of samples as people say it: 400k.
#[must_use]
pub fn short(count: u32) -> String {
    let number = f64::from(count);
    match count {
        1_000_000.. => format!("{:.2}M", number / 1e6),
        _ if count.is_multiple_of(1000) => format!("{}k", count / 1000),
        100_000.. => format!("{:.0}k", number / 1e3),
        10_000.. => format!("{:.1}k", number / 1e3),
        _ => count.to_string(),
    }
}

/// Who wins by how much: RMSE as a multiple of that of `adaptive`, best first.
fn glance(rows: &[Row]) -> Result<Option<Section>> {
    let (scenes, rate) = (scenes(rows), usual_rate(&rates(rows)));
    let ratio = |method: EvalMethod| {
        let logs: Option<Vec<f64>> = scenes
            .iter()
            .map(|scene| {
                let subject = find(rows, scene, EvalMethod::Adaptive, rate)?;
                Some((find(rows, scene, method, rate)?.rmse / subject.rmse).ln())
            })
            .collect();
        let logs = logs.filter(|logs| !logs.is_empty())?;
        let spread = |pick: fn(f64, f64) -> f64| logs.iter().copied().reduce(pick);
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        Some((mean.exp(), spread(f64::min)?.exp(), spread(f64::max)?.exp()))
    };
    let mut found: Vec<_> = methods(rows)
        .filter(|method| method.instead().is_none())
        .filter_map(|method| Some((method, ratio(method)?)))
        .collect();
    if found.len() < 2 {
        return Ok(None);
    }
    found.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    let parts = ["adaptive", "as many samples", "10x as many"].map(str::to_owned);
    let title = format!(
        "RMSE at {} samples/s, as a multiple of adaptive's",
        short(rate)
    );
    let label = "geometric mean over the scenes; shorter is better";
    let mut chart = BarChart::stacked(title, label, parts.to_vec());
    for (method, (mean, low, high)) in &found {
        let mut values = vec![0.0; 3];
        let part = match method {
            EvalMethod::Adaptive => 0,
            method if method.is_tenfold() => 2,
            _ => 1,
        };
        values[part] = *mean;
        let name = if scenes.len() > 1 && *method != EvalMethod::Adaptive {
            format!("{method} ({low:.2} to {high:.2})")
        } else {
            method.name().to_owned()
        };
        chart = chart.parts_bar(name, values);
    }
    let mut section = Section::new("At a glance");
    section.bars(
        &chart,
        "In brackets the least and the greatest ratio of a scene. Below 1: better than adaptive.",
    )?;
    Ok(Some(section))
}

/// RMSE by method, scene and rate.
fn table_1(rows: &[Row]) -> Section {
    let mut section = Section::new("RMSE (Table 1 of Dayal et al. 2005)");
    let (scenes, rates) = (scenes(rows), rates(rows));
    let columns: Vec<(&str, u32)> = scenes
        .iter()
        .flat_map(|scene| rates.iter().map(|rate| (*scene, *rate)))
        .collect();
    let heads = columns
        .iter()
        .map(|(scene, rate)| format!("{} {}", slug(scene), short(*rate)));
    let mut table = Table::new(["method".to_owned()].into_iter().chain(heads)).caption(
        "Mean over seeds; ± half the spread where there are several. 10x: 60 frames a second of \
         full resolution, whatever the column says.",
    );
    for method in methods(rows) {
        let cell = |(scene, rate): &(&str, u32)| match find(rows, scene, method, *rate) {
            Some(row) if row.seeds > 1 => {
                let half = 0.5 * (row.rmse_max - row.rmse_min);
                format!("{:.2} ± {half:.2}", row.rmse)
            }
            Some(row) => format!("{:.2}", row.rmse),
            None => "–".to_owned(),
        };
        let line: Vec<String> = [method.name().to_owned()]
            .into_iter()
            .chain(columns.iter().map(cell))
            .collect();
        if method == EvalMethod::Adaptive {
            table.strong_row(line);
        } else {
            table.row(line);
        }
    }
    section.table(&table);
    section
}
