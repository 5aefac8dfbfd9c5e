//! The page of an evaluation: Table 1 and Figure 8 of Dayal et al. 2005, claims, causes, pictures.

use std::path::Path;

use anyhow::Result;
use unframed_metrics::PixelClass;

use super::cell::{Cell, Job, picture_path};
use super::methods::EvalMethod;
use super::table::{Row, Verdict};
use crate::report::plot::rmse_axis;
use crate::report::{
    Axis, BarChart, Figure, Picture, Plot, Report, Scale, Section, Table, write_file,
};

/// A difference of this many levels or more is the brightest of the error pictures.
const ERROR_FULL: u8 = 96;

/// What the page is made from.
pub struct Findings<'a> {
    /// Means over seeds.
    pub rows: &'a [Row],
    /// Claims.
    pub verdicts: &'a [Verdict],
    /// Each with its job, in the same order.
    pub cells: &'a [(Job, Cell)],
    /// The ideal picture of a scene at a refresh, if it is still there.
    pub ideal: &'a dyn Fn(&str, u32) -> Option<Picture>,
    /// Where cells and their pictures are.
    pub cell_dir: &'a Path,
    /// Names and values for the head of the page.
    pub facts: Vec<(String, String)>,
}

/// Writes `report.html` and the plots as SVG files under `dir`.
///
/// # Errors
/// A plot cannot be drawn or a file not be written.
pub fn write(findings: &Findings<'_>, dir: &Path) -> Result<()> {
    let mut report = Report::new(
        "unframed: against the ideal renderer",
        "All methods take the same number of camera samples a second, unless their name says \
         10x. Each picture that the display shows is compared with a supersampled image of the \
         same instant; every refresh counts.",
    );
    for (name, value) in &findings.facts {
        report.fact(name, value);
    }
    report.section(table_1(findings.rows));
    if !findings.verdicts.is_empty() {
        report.section(claims(findings.verdicts));
    }
    report.section(perception(findings.rows));
    for scene in scenes(findings.rows) {
        report.section(over_time(findings, scene, dir)?);
        report.section(shares(findings.rows, scene)?);
        if let Some(section) = pictures(findings, scene)? {
            report.section(section);
        }
    }
    report.footer(
        "RMSE: root mean square over pixels and R, G, B of displayed sRGB values, 0 to 255; over \
         an animation the root of the mean of squares.",
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

fn methods(rows: &[Row]) -> impl Iterator<Item = EvalMethod> {
    EvalMethod::all().filter(|method| rows.iter().any(|row| row.method == method.name()))
}

/// Rates at which not only the tenfold renderers were run.
fn rates(rows: &[Row]) -> Vec<u32> {
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

fn short(rate: u32) -> String {
    if rate.is_multiple_of(1000) {
        format!("{}k", rate / 1000)
    } else {
        rate.to_string()
    }
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
        .map(|(scene, rate)| format!("{scene} {}", short(*rate)));
    let mut table = Table::new(["method".to_owned()].into_iter().chain(heads)).caption(
        "Mean over seeds; ± half the spread where there are several. 10x: 60 frames a second of \
         full resolution, whatever the column says.",
    );
    for method in methods(rows) {
        let cell = |(scene, rate): &(&str, u32)| match find(rows, scene, method, *rate) {
            Some(row) if row.seeds > 1 => {
                format!(
                    "{:.2} ± {:.2}",
                    row.rmse,
                    0.5 * (row.rmse_max - row.rmse_min)
                )
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

fn claims(verdicts: &[Verdict]) -> Section {
    let mut section = Section::new("Claims");
    let heads = [
        "scene",
        "adaptive at",
        "against",
        "RMSE ratio",
        "at most",
        "holds",
        "FLIP ratio",
        "JOD gained",
        "metrics agree",
    ];
    let mut table = Table::new(heads);
    for v in verdicts {
        let holds = match (v.holds, v.moonshot) {
            (true, _) => "yes",
            (false, true) => "no (hoped for)",
            (false, false) => "NO",
        };
        table.row([
            v.scene.clone(),
            short(v.rate),
            v.against.clone(),
            format!("{:.3}", v.ratio),
            format!("{:.2}", v.limit),
            holds.to_owned(),
            v.flip_ratio
                .map_or_else(|| "–".to_owned(), |r| format!("{r:.3}")),
            v.cvvdp_gain
                .map_or_else(|| "–".to_owned(), |r| format!("{r:+.2}")),
            if v.metrics_agree { "yes" } else { "no" }.to_owned(),
        ]);
    }
    section.table(&table);
    section
}

/// Every number of every row.
fn perception(rows: &[Row]) -> Section {
    let mut section = Section::new("All measures");
    let heads = [
        "scene",
        "method",
        "rate",
        "RMSE",
        "p95",
        "worst",
        "PSNR, dB",
        "FLIP",
        "JOD",
        "bytes a sample",
        "age, % of error",
        "host, s",
        "display, s",
    ];
    let mut table = Table::new(heads).caption(
        "Seconds on one core for the whole animation; bytes with all packets counted; JOD by \
         ColorVideoVDP, of 10.",
    );
    let maybe = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
    };
    for row in rows {
        let method = match row.setting.as_str() {
            "" => row.method.clone(),
            setting => format!("{} ({setting})", row.method),
        };
        table.row([
            row.scene.clone(),
            method,
            short(row.rate),
            format!("{:.2}", row.rmse),
            format!("{:.2}", row.p95_rmse),
            format!("{:.2}", row.worst_rmse),
            maybe(row.psnr, 2),
            maybe(row.flip, 4),
            maybe(row.cvvdp, 2),
            maybe(row.bytes_per_sample, 2),
            maybe(row.stale.map(|s| 100.0 * s), 0),
            format!("{:.1}", row.seconds_host),
            format!("{:.1}", row.seconds_display),
        ]);
    }
    section.table(&table);
    section
}

/// Figure 8: the error of each refresh, one plot a rate.
fn over_time(findings: &Findings<'_>, scene: &str, dir: &Path) -> Result<Section> {
    let mut section = Section::new(format!("{scene}: error over time (Figure 8)"));
    for rate in rates(findings.rows) {
        let title = format!("{scene}, {} samples/s", short(rate));
        let mut plot = Plot::new(title, Axis::new("time, s", Scale::Linear), rmse_axis());
        for method in methods(findings.rows) {
            let first = findings.cells.iter().find(|(job, _)| {
                job.scene == scene
                    && job.method == method
                    && (job.rate == rate || method.is_tenfold())
            });
            if let Some((_, cell)) = first {
                let points = cell.refreshes.iter().map(|r| (r.time, r.rmse)).collect();
                plot = plot.line(method.name(), points);
            }
        }
        section.plot(
            &plot,
            "Each refresh against the ideal image of its instant; first seed.",
        )?;
        let name = format!("rmse-{}-{}.svg", super::store::slug(scene), short(rate));
        write_file(&dir.join(name), plot.svg()?.as_bytes())?;
    }
    Ok(section)
}

/// Where the error is, at the middle rate.
fn shares(rows: &[Row], scene: &str) -> Result<Section> {
    let mut section = Section::new(format!("{scene}: where the error is"));
    let rates = rates(rows);
    let rate = rates.get(rates.len() / 2).copied().unwrap_or(0);
    let parts = PixelClass::ALL
        .iter()
        .map(|class| class.name().to_owned())
        .collect();
    let title = format!("{scene}, {} samples/s", short(rate));
    let mut chart = BarChart::stacked(title, "mean squared error, levels squared", parts);
    for method in methods(rows) {
        if let Some(row) = find(rows, scene, method, rate) {
            let square = row.rmse * row.rmse;
            let values = row
                .classes
                .iter()
                .map(|share| share.error * square)
                .collect();
            chart = chart.parts_bar(method.name(), values);
        }
    }
    section.bars(
        &chart,
        "Disocclusion: hidden or off screen 0.1 s before. Moving: an object that moves. \
         View-dependent: mirrors, glass, highlights. Edge: of depth or object. Texture: 16 levels \
         or more within 3 x 3 pixels. The first that applies counts.",
    )?;
    Ok(section)
}

/// What was shown in the middle of the animation, at the middle rate.
fn pictures(findings: &Findings<'_>, scene: &str) -> Result<Option<Section>> {
    let rates = rates(findings.rows);
    let rate = rates.get(rates.len() / 2).copied().unwrap_or(0);
    let mut figures = Vec::new();
    let mut time = 0.0;
    for method in methods(findings.rows) {
        let found = findings.cells.iter().find(|(job, _)| {
            job.scene == scene && job.method == method && (job.rate == rate || method.is_tenfold())
        });
        let Some((job, cell)) = found else { continue };
        let kept = job.settings.kept();
        let index = kept[kept.len() / 2];
        time = super::ideals::instant(index);
        let path = picture_path(&findings.cell_dir.join(job.file_stem()), index);
        let size = (
            u32::from(job.settings.size.width),
            u32::from(job.settings.size.height),
        );
        let pixels = super::ideals::read_png(&path, size.0, size.1);
        let (Some(pixels), Some(ideal)) = (pixels, (findings.ideal)(scene, index)) else {
            continue;
        };
        let shown = Picture::new(size.0 as usize, size.1 as usize, pixels)?;
        let rmse = cell
            .refreshes
            .get(index as usize)
            .map_or(f64::NAN, |r| r.rmse);
        let map = Picture::heat_map(&ideal, &shown, ERROR_FULL)?;
        if figures.is_empty() {
            figures.push(Figure::new(
                ideal.clone(),
                "ideal",
                "Supersampled, of this instant.",
            ));
        }
        let caption = format!("RMSE {rmse:.2}. Point at it for the ideal.");
        figures.push(Figure::new(shown, method.name(), caption).on_hover(ideal));
        let caption = format!("Black: none; brightest: {ERROR_FULL} levels and more.");
        figures.push(Figure::new(map, format!("error of {method}"), caption));
    }
    if figures.is_empty() {
        return Ok(None);
    }
    let mut section = Section::new(format!("{scene} at {time:.3} s, {} samples/s", short(rate)));
    section.pictures(&figures)?;
    Ok(Some(section))
}
