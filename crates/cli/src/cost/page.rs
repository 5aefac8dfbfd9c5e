//! The page: what a decibel costs, fronts, where the error comes from, each knob, budgets.

use std::path::Path;

use anyhow::Result;

use super::adapter::{self, OnAdapter};
use super::answer;
use super::budget::Answer;
use super::effects::{self, Framed};
use super::formats::FORMATS;
use super::knobs::{DEPTHS, Format, Knobs, MIDDLE};
use super::point::ErrorParts;
use super::scaling::{Curve, plots};
use super::short;
use super::table::{COSTS, CostOf, Point, distinct, factor_per_decibel, presets, slope};
use crate::method::Method;
use crate::report::{Axis, BarChart, Plot, Report, Scale, Section, Table, write_file};

/// All that was measured.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// The points of all sweeps.
    pub points: &'a [Point],
    /// Those on the scene of effects; none where they were not measured.
    pub on_effects: &'a [Point],
    /// Whole frames of that scene.
    pub framed: &'a [Framed],
    /// How cost grows.
    pub curves: &'a [Curve],
    /// The presets on a graphics adapter.
    pub adapter: Option<&'a OnAdapter>,
    /// What the budgets' answers are.
    pub answers: &'a [Answer],
}

/// Writes `report.html` and the fronts as SVG files under `dir`.
///
/// # Errors
/// A plot cannot be drawn or a file not be written.
pub fn write(found: &Found<'_>, facts: &[(&str, String)], pixels: u32, dir: &Path) -> Result<()> {
    let Found {
        points,
        on_effects,
        curves,
        answers,
        ..
    } = *found;
    let mut report = Report::new(
        "unframed: what accuracy costs",
        "Every knob that trades error for time, bytes or memory, turned and measured. Error is \
         against a supersampled picture of the same instant; 6 dB less is half the RMSE.",
    );
    for (name, cost) in COSTS {
        if let Some(factor) = factor_per_decibel(points, cost) {
            report.fact(format!("1 dB more: {name}"), format!("× {factor:.2}"));
        }
    }
    for (name, value) in facts {
        report.fact(*name, value);
    }
    report.section(decibels(points, dir)?);
    if points.iter().any(|p| p.sweep != "presets") {
        report.section(fronts(points, dir)?);
    }
    report.section(causes(points)?);
    for section in knobs(points, pixels)? {
        report.section(section);
    }
    if !on_effects.is_empty() {
        report.section(effects::section(on_effects, found.framed));
    }
    if !curves.is_empty() {
        let mut section = Section::new("How cost grows");
        for (file, plot) in plots(curves) {
            section.plot(&plot, "")?;
            write_file(&dir.join(file), plot.svg()?.as_bytes())?;
        }
        section.paragraph(
            "A refresh, what is received before it included, by the preset `medium`, as an \
             emulator counts it. Slope 1 is in proportion; 0 is not at all. At rest only what is \
             new is looked at.",
        );
        report.section(section);
    }
    if let Some(section) = scaling(points, dir)? {
        report.section(section);
    }
    if let Some(found) = found.adapter {
        report.section(adapter::section(found, &presets(points))?);
    }
    if !answers.is_empty() {
        report.section(answer::section(answers));
    }
    report.footer(
        "Seconds are of one core's work (thread time) for a second of animation at 60 Hz; the \
         display's is the median refresh times 60. Error parts are differences of mean squared \
         errors along a chain of pictures of the same stream: as shown; in f64; each sample \
         traced again at the instant; 16 fresh samples a pixel instead. They add up by \
         construction. RAM: a microcontroller's static storage for this and 16 KiB of stack. \
         Instructions of a Cortex-M7 are those of the work of this panel's refreshes, by a law \
         found from counts of an emulator.",
    );
    report.write(&dir.join("report.html"))?;
    Ok(())
}

/// What going from preset to preset costs.
fn decibels(points: &[Point], dir: &Path) -> Result<Section> {
    let mut section = Section::new("What does one decibel more cost?");
    let presets = presets(points);
    if let [least, .., _] = presets.as_slice() {
        let x = Axis::new(
            format!("dB gained over `{}`", least.preset.unwrap_or("")),
            Scale::Linear,
        );
        let y = Axis::new("times its cost (log)", Scale::Log);
        let mut plot = Plot::new("Each cost, from preset to preset", x, y);
        for (name, cost) in COSTS {
            let relative = |p: &&Point| (p.psnr - least.psnr, cost(p) / cost(least));
            let line: Vec<(f64, f64)> = presets.iter().map(relative).collect();
            let factor = factor_per_decibel(points, cost);
            let factor = factor.map_or_else(String::new, |f| format!(": × {f:.2} a dB"));
            if line.iter().all(|place| place.1.is_finite()) {
                plot = plot.line(format!("{name}{factor}"), line);
            }
        }
        section.plot(
            &plot,
            "Each dot is a preset. The factors are along the fronts of all points, where there \
             are such.",
        )?;
        write_file(&dir.join("decibel.svg"), plot.svg()?.as_bytes())?;
    }
    let heads = [
        "preset",
        "RMSE",
        "PSNR, dB",
        "samples/s",
        "N",
        "fit",
        "width",
        "hidden",
        "display, s",
        "host, s",
        "kB/s",
        "RAM, kB",
        "M7, million",
        "on front",
    ];
    let mut table = Table::new(heads);
    for p in &presets {
        table.row([
            p.preset.unwrap_or("").to_owned(),
            format!("{:.2}", p.rmse),
            format!("{:.2}", p.psnr),
            short(p.knobs.rate),
            short(p.knobs.samples),
            p.knobs.fit.to_owned(),
            p.knobs.extents.clone(),
            if p.knobs.hidden { "on" } else { "off" }.to_owned(),
            format!("{:.3}", p.display_seconds),
            format!("{:.3}", p.host_seconds),
            format!("{:.0}", p.bytes_per_second / 1e3),
            format!("{:.0}", p.ram_bytes as f64 / 1e3),
            p.instructions_per_refresh
                .map_or_else(|| "–".to_owned(), |count| format!("{:.1}", 1e-6 * count)),
            if p.dominated_by > 0.03 {
                format!("✗ beaten by {:.0} %", 100.0 * p.dominated_by)
            } else {
                "✓".to_owned()
            },
        ]);
    }
    let table = table.caption(
        "Display and host: core seconds of this machine for a second. M7: instructions of a \
         Cortex-M7 for a mean refresh.",
    );
    section.table(&table);
    let heads = ["from", "to", "gained, dB"].map(str::to_owned);
    let costs = COSTS.iter().map(|(name, _)| (*name).to_owned());
    let mut table = Table::new(heads.into_iter().chain(costs)).caption(
        "From preset to preset: by what factor each cost grows, and in brackets per decibel \
         gained.",
    );
    for pair in presets.windows(2) {
        let gained = pair[1].psnr - pair[0].psnr;
        let mut cells = vec![
            pair[0].preset.unwrap_or("").to_owned(),
            pair[1].preset.unwrap_or("").to_owned(),
            format!("{gained:+.2}"),
        ];
        for (_, cost) in COSTS {
            let factor = cost(pair[1]) / cost(pair[0]);
            cells.push(if factor.is_finite() {
                format!("× {factor:.2} ({:.2})", factor.powf(1.0 / gained))
            } else {
                "–".to_owned()
            });
        }
        table.row(cells);
    }
    if presets.len() > 1 {
        section.table(&table);
    }
    Ok(section)
}

/// Error against each cost.
fn fronts(points: &[Point], dir: &Path) -> Result<Section> {
    let mut section = Section::new("Fronts");
    let units: [(&str, &str, CostOf); 5] = [
        (
            "display time",
            "core seconds of the display a second (log)",
            |p| p.display_seconds,
        ),
        (
            "host time",
            "core seconds of the host a second (log)",
            |p| p.host_seconds,
        ),
        ("bytes", "stream, kB a second (log)", |p| {
            p.bytes_per_second / 1e3
        }),
        ("RAM", "RAM of the display, kB (log)", |p| {
            p.ram_bytes as f64 / 1e3
        }),
        (
            "instructions",
            "million instructions a refresh on a Cortex-M7 (log)",
            |p| 1e-6 * p.instructions_per_refresh.unwrap_or(f64::NAN),
        ),
    ];
    for (name, label, cost) in units {
        let place = |p: &&Point| (cost(p), p.rmse);
        let fixed: Vec<&Point> = distinct(points)
            .into_iter()
            .filter(|p| p.knobs.format == Format::Fixed && cost(p).is_finite())
            .collect();
        if fixed.is_empty() {
            continue;
        }
        let of = |method: Method| -> Vec<(f64, f64)> {
            let same = fixed.iter().filter(|p| p.settings().method == method);
            same.map(place).collect()
        };
        let y = Axis::new("RMSE of displayed sRGB values", Scale::Linear);
        let mut plot = Plot::new(
            format!("Error against {name}"),
            Axis::new(label, Scale::Log),
            y,
        )
        .front("front", fixed.iter().map(place).collect())
        .points("adaptive", of(Method::Adaptive))
        .points("uniform, same display", of(Method::UniformSameDisplay))
        .points("uniform", of(Method::Uniform))
        .points("paper", of(Method::Paper));
        plot = plot.points("presets", presets(points).iter().map(place).collect());
        section.plot(&plot, "Lower left is better; the line is the front.")?;
        let file = format!("front-{}.svg", name.replace(' ', "-").to_lowercase());
        write_file(&dir.join(file), plot.svg()?.as_bytes())?;
    }
    Ok(section)
}

fn parts_chart(title: &str) -> BarChart {
    let parts = ["sampling", "filtering", "delay", "arithmetic"].map(str::to_owned);
    BarChart::stacked(title, "mean squared error, levels squared", parts.to_vec())
}

fn parts_bar(chart: BarChart, name: String, point: &Point) -> BarChart {
    let e = point.error.unwrap_or_default();
    let parts = [e.sampling, e.filtering, e.delay, e.arithmetic];
    chart.parts_bar(name, parts.map(|part| part.max(0.0)).to_vec())
}

/// Where the error comes from.
fn causes(points: &[Point]) -> Result<Section> {
    let mut section = Section::new("Where the error comes from");
    let mut chart = parts_chart("Error by cause");
    for p in presets(points) {
        chart = parts_bar(chart, p.preset.unwrap_or("").to_owned(), p);
    }
    for p in points.iter().filter(|p| p.sweep == "method and rate") {
        chart = parts_bar(
            chart,
            format!("{} {}", p.knobs.method, short(p.knobs.rate)),
            p,
        );
    }
    section.bars(
        &chart,
        "Sampling: too few samples, the blur that hides it included. Filtering: what 16 fresh \
         samples a pixel leave. Delay: samples that are not of the instant. Arithmetic: integers \
         against f64. Parts below zero are drawn as nothing; \
         the numbers are in points.csv.",
    )?;
    Ok(section)
}

/// What a point is called within its sweep.
fn label(sweep: &str, p: &Point) -> String {
    let on = |on: bool| if on { "on" } else { "off" }.to_owned();
    match sweep {
        "number format" => p.knobs.format.name().to_owned(),
        "samples remembered" => {
            format!("{} ({:.2} s)", short(p.knobs.samples), p.settings().memory)
        }
        DEPTHS => p.settings().sampling.depth.to_string(),
        "fit" => p.knobs.fit.to_owned(),
        "hidden-point test" => on(p.knobs.hidden),
        "filling" => on(p.knobs.fill),
        "filter width" => p.knobs.extents.clone(),
        "decline with age" => p.knobs.kernel.to_owned(),
        "cut-off of weights" => p.knobs.cutoff.clone(),
        "lifetime" => p.knobs.lifetime.clone(),
        "light" => p.knobs.light.to_owned(),
        _ if sweep.starts_with("wire: ") => match p.knobs.detail.as_str() {
            "" => "all".to_owned(),
            less => less.to_owned(),
        },
        _ if FORMATS.iter().any(|(name, _)| *name == sweep) => match p.knobs.format {
            Format::Narrow(narrow) => narrow.label().to_owned(),
            _ => "as deployed".to_owned(),
        },
        _ => format!("{} {}/s", p.knobs.method, short(p.knobs.rate)),
    }
}

/// One table and one chart a knob.
fn knobs(points: &[Point], pixels: u32) -> Result<Vec<Section>> {
    let middle = Knobs::new(Method::Adaptive, MIDDLE);
    let mut sweeps: Vec<&str> = Vec::new();
    for p in points {
        if !sweeps.contains(&p.sweep) && !["all together", "presets"].contains(&p.sweep) {
            sweeps.push(p.sweep);
        }
    }
    let mut section = Section::new("Knob by knob");
    section.paragraph(&format!(
        "One knob turned, all else as `adaptive` has it at {} samples a second (or `paper`, for \
         the depth of its sampler's buffer); changes against that.",
        short(middle.rate(pixels))
    ));
    let percent = |a: f64, b: f64| format!("{:+.0}", 100.0 * (a / b - 1.0)).replace('-', "−");
    for sweep in sweeps {
        let usual = match sweep {
            DEPTHS => Knobs::new(Method::Paper, MIDDLE),
            _ => middle,
        };
        let Some(base) = points.iter().find(|p| *p.settings() == usual) else {
            continue;
        };
        let heads = [
            sweep,
            "RMSE",
            "dB",
            "sampling",
            "filtering",
            "delay",
            "arithmetic",
            "to f64",
            "display, %",
            "host, %",
            "bytes, %",
            "RAM, %",
        ];
        let mut table = Table::new(heads);
        for p in points.iter().filter(|p| p.sweep == sweep) {
            let real = |cell: String| match p.knobs.format.is_real() {
                true => cell,
                false => "–".to_owned(),
            };
            let part = |of: fn(&ErrorParts) -> f64, digits| {
                let error = p.error.as_ref().map(of);
                error.map_or_else(|| "–".to_owned(), |e| format!("{e:.digits$}"))
            };
            let cells = [
                label(sweep, p),
                format!("{:.2}", p.rmse),
                format!("{:+.2}", p.psnr - base.psnr).replace('-', "−"),
                part(|e| e.sampling, 1),
                part(|e| e.filtering, 1),
                part(|e| e.delay, 1),
                part(|e| e.arithmetic, 2),
                p.rmse_to_oracle
                    .map_or_else(|| "–".to_owned(), |rmse| format!("{rmse:.2}")),
                real(percent(p.display_seconds, base.display_seconds)),
                percent(p.host_seconds, base.host_seconds),
                percent(p.bytes_per_second, base.bytes_per_second),
                real(percent(p.ram_bytes as f64, base.ram_bytes as f64)),
            ];
            if *p.settings() == usual {
                table.strong_row(cells);
            } else {
                table.row(cells);
            }
        }
        section.table(&table);
    }
    section.paragraph(
        "Sampling, filtering, delay and arithmetic in levels squared; “to f64”: RMSE against the \
         same display in f64. Narrower numbers are emulated (rounded where integers would be), so \
         that they have an error but no time.",
    );
    Ok(vec![section])
}

/// How cost grows.
fn scaling(points: &[Point], dir: &Path) -> Result<Option<Section>> {
    let of = |sweep: &str, x: fn(&Point) -> f64| -> Vec<(f64, f64)> {
        let mut pairs: Vec<(f64, f64)> = points
            .iter()
            .filter(|p| p.sweep == sweep && p.settings().method == Method::Adaptive)
            .map(|p| (x(p), 1e3 * p.display_seconds / 60.0))
            .collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs
    };
    let by_n = of("samples remembered", |p| f64::from(p.knobs.samples));
    let by_rate = of("method and rate", |p| f64::from(p.knobs.rate));
    if by_n.len() < 3 || by_rate.len() < 3 {
        return Ok(None);
    }
    let logs = |pairs: &[(f64, f64)]| -> Vec<(f64, f64)> {
        pairs.iter().map(|p| (p.0.ln(), p.1.ln())).collect()
    };
    let text = |pairs| slope(&logs(pairs)).map_or_else(|| "–".to_owned(), |s| format!("{s:.2}"));
    let y = Axis::new("display, ms a refresh (log)", Scale::Log);
    let x = Axis::new("samples remembered, or samples a second (log)", Scale::Log);
    let mut section = Section::new("How time grows here");
    let plot = Plot::new("A refresh's time", x, y)
        .line(
            format!("N at one rate: slope {}", text(&by_n)),
            by_n.clone(),
        )
        .line(
            format!("rate, N = 1 s: slope {}", text(&by_rate)),
            by_rate.clone(),
        );
    section.plot(
        &plot,
        "Slope 1 is in proportion; below 1 there is a part that pixels alone cost.",
    )?;
    write_file(&dir.join("scaling-time.svg"), plot.svg()?.as_bytes())?;
    Ok(Some(section))
}
