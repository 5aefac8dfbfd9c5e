//! One scene: pictures, error over time, where the error is, what the time went into, all numbers.

use std::path::Path;

use anyhow::Result;
use unframed_metrics::PixelClass;

use super::{Findings, find, methods, rates, short};
use crate::eval::cell::picture_path;
use crate::eval::ideals::{instant, read_png};
use crate::eval::methods::EvalMethod;
use crate::eval::plan::usual_rate;
use crate::eval::store::slug;
use crate::eval::table::Row;
use crate::report::plot::rmse_axis;
use crate::report::{
    Axis, BarChart, Figure, Picture, Plot, Report, Scale, Section, Table, write_file,
};

/// A difference of this many levels or more is the brightest of the error pictures.
const ERROR_FULL: u8 = 96;

/// Adds the sections of a scene.
pub(super) fn sections(
    findings: &Findings<'_>,
    scene: &str,
    dir: &Path,
    report: &mut Report,
) -> Result<()> {
    let rows = &findings.found.rows;
    if let Some(section) = pictures(findings, scene)? {
        report.section(section);
    }
    report.section(over_time(findings, scene, dir)?);
    report.section(shares(rows, scene)?);
    if let Some(section) = spending(rows, scene)? {
        report.section(section);
    }
    report.section(numbers(rows, scene));
    Ok(())
}

/// Figure 8 leaves out these: they stretch the scale, or say the same as another.
fn plotted(method: EvalMethod) -> bool {
    use EvalMethod as M;
    !matches!(
        method,
        M::Framed60LowRes
            | M::FramedFull
            | M::AdaptiveNoSamplerReprojection
            | M::AdaptiveNoDisplayReprojection
    )
}

/// Figure 8: the error of each refresh, one plot a rate.
fn over_time(findings: &Findings<'_>, scene: &str, dir: &Path) -> Result<Section> {
    let name = slug(scene);
    let mut section = Section::new(format!("{name}: error over time (Figure 8)"));
    for rate in rates(&findings.found.rows) {
        let title = format!("{name}, {} samples/s", short(rate));
        let mut plot = Plot::new(title, Axis::new("time, s", Scale::Linear), rmse_axis());
        let mut any = false;
        for method in methods(&findings.found.rows).filter(|m| plotted(*m)) {
            let first = findings.cells.iter().find(|(job, _)| {
                job.scene == scene
                    && job.method == method
                    && (job.rate == rate || method.is_tenfold())
            });
            if let Some((_, cell)) = first {
                any |= !method.is_tenfold();
                let points = cell.refreshes.iter().map(|r| (r.time, r.rmse)).collect();
                plot = plot.line(method.name(), points);
            }
        }
        if any {
            section.plot(
                &plot,
                "Each refresh against the ideal image of its instant; first seed.",
            )?;
            let file = format!("rmse-{name}-{}.svg", short(rate));
            write_file(&dir.join(file), plot.svg()?.as_bytes())?;
        }
    }
    Ok(section)
}

/// Where the error is, by class of pixel.
fn shares(rows: &[Row], scene: &str) -> Result<Section> {
    let name = slug(scene);
    let mut section = Section::new(format!("{name}: where the error is"));
    let rate = usual_rate(&rates(rows));
    let parts = PixelClass::ALL
        .iter()
        .map(|class| class.name().to_owned())
        .collect();
    let title = format!("{name}, {} samples/s", short(rate));
    let label = "mean squared error, levels squared: the square of the RMSE";
    let mut chart = BarChart::stacked(title, label, parts);
    for method in methods(rows).filter(|m| plotted(*m) && *m != EvalMethod::Frameless) {
        if let Some(row) = find(rows, scene, method, rate) {
            let square = row.rmse * row.rmse;
            let values = row.classes.iter().map(|c| c.error * square).collect();
            chart = chart.parts_bar(method.name(), values);
        }
    }
    section.bars(
        &chart,
        "By class of pixel. Disocclusion: hidden or off screen 0.1 s before. Moving: an object \
         that moves. View-dependent: mirrors, glass, highlights. Edge: of depth or object. \
         Texture: 16 levels or more within 3 × 3 pixels. The first that applies counts.",
    )?;
    let causes = ["stale", "rest"].map(str::to_owned).to_vec();
    let title = format!("{name}, {} samples/s, by cause", short(rate));
    let mut chart = BarChart::stacked(title, label, causes);
    let mut any = false;
    for method in methods(rows) {
        if let Some(row) = find(rows, scene, method, rate)
            && let Some(stale) = row.stale
        {
            any = true;
            let square = row.rmse * row.rmse;
            // Fresh samples can be worse by a little where a lag hides noise.
            let old = stale.max(0.0) * square;
            chart = chart.parts_bar(method.name(), vec![old, square - old]);
        }
    }
    if any {
        section.bars(
            &chart,
            "Stale: what would vanish if each stored sample were of the refresh's instant, by \
             tracing all of them again (share at three refreshes, applied to the whole). Rest: \
             too few samples, the filter, places not sampled.",
        )?;
    }
    Ok(section)
}

/// The cost of control.
fn spending(rows: &[Row], scene: &str) -> Result<Option<Section>> {
    let rate = usual_rate(&rates(rows));
    let spent: Vec<_> = methods(rows)
        .filter(|m| !matches!(m, EvalMethod::AdaptiveNoDisplayReprojection))
        .filter_map(|method| {
            let row = find(rows, scene, method, rate)?;
            Some((method, row, row.spent?))
        })
        .collect();
    let Some((_, _, first)) = spent.first() else {
        return Ok(None);
    };
    let name = slug(scene);
    let parts = first.parts().map(|part| part.0.to_owned()).to_vec();
    let title = format!("{name}, {} samples/s: the host's time", short(rate));
    let mut chart = BarChart::stacked(title, "µs a sample, one core; first seed", parts);
    let mut overheads = Vec::new();
    for (method, row, spent) in &spent {
        let each = 1e6 / row.samples.max(1) as f64;
        let values = spent.parts().map(|part| part.1 * each).to_vec();
        chart = chart.parts_bar(method.name(), values);
        overheads.push(format!("{method} {:.1} %", 100.0 * spent.overhead()));
    }
    let mut section = Section::new(format!("{name}: the cost of control"));
    section.bars(
        &chart,
        "Scene: posing it and fitting its bounds. Samplers that keep no count of their own have \
         their planning within tracing.",
    )?;
    section.paragraph(&format!(
        "Reprojection and control together, as a share of all: {}.",
        overheads.join(", ")
    ));
    Ok(Some(section))
}

/// Every number of a scene.
fn numbers(rows: &[Row], scene: &str) -> Section {
    let mut section = Section::new(format!("{}: all measures", slug(scene)));
    let heads = [
        "method",
        "rate",
        "RMSE",
        "p95",
        "worst",
        "PSNR, dB",
        "FLIP",
        "JOD",
        "B/sample",
        "stale, %",
        "host, s",
        "display, s",
    ];
    let mut table = Table::new(heads).caption(
        "Seconds on one core for the whole animation; bytes with all packets counted; stale: \
         share of the squared error that is age.",
    );
    let maybe = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
    };
    for row in rows.iter().filter(|row| row.scene == scene) {
        let method = match row.setting.as_str() {
            "" => row.method.clone(),
            setting => format!("{} ({setting})", row.method),
        };
        table.row([
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

/// What was shown in the middle of the animation: for each method the picture and its error map.
fn pictures(findings: &Findings<'_>, scene: &str) -> Result<Option<Section>> {
    let rows = &findings.found.rows;
    let rate = usual_rate(&rates(rows));
    let mut figures = Vec::new();
    let mut time = 0.0;
    for method in methods(rows) {
        let found = findings.cells.iter().find(|(job, _)| {
            job.scene == scene && job.method == method && (job.rate == rate || method.is_tenfold())
        });
        let Some((job, cell)) = found else { continue };
        let kept = job.settings.kept();
        let index = kept[kept.len() / 2];
        time = instant(index);
        let path = picture_path(&findings.cell_dir.join(job.file_stem()), index);
        let size = (
            u32::from(job.settings.size.width),
            u32::from(job.settings.size.height),
        );
        let pixels = read_png(&path, size.0, size.1);
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
            let white = Picture::heat_map(&ideal, &ideal, ERROR_FULL)?;
            let caption = "Supersampled, of this instant.";
            figures.push(Figure::new(ideal.clone(), "ideal", caption));
            let caption = format!("Black: none; brightest: {ERROR_FULL} levels and more.");
            figures.push(Figure::new(white, "error of the ideal", caption));
        }
        let caption = format!("RMSE {rmse:.2}. Point at it for the ideal.");
        figures.push(Figure::new(shown, method.name(), caption).on_hover(ideal));
        figures.push(Figure::new(map, format!("error of {method}"), ""));
    }
    if figures.is_empty() {
        return Ok(None);
    }
    let title = format!("{} at {time:.3} s, {} samples/s", slug(scene), short(rate));
    let mut section = Section::new(title);
    section.pictures(&figures)?;
    Ok(Some(section))
}
