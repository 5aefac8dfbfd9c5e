//! The page of a run.

use anyhow::Result;

use crate::args::RunArgs;
use crate::commands::run::{ideal_picture, per_sample};
use crate::measure::{Ideals, Outcome};
use crate::report::plot::rmse_axis;
use crate::report::{Axis, Figure, Picture, Plot, Report, Scale, Section, Table};

/// A difference of this many levels or more is the brightest of the error pictures.
const ERROR_FULL: u8 = 96;

/// Numbers, plot and pictures of a run.
///
/// # Errors
/// When a plot cannot be drawn.
pub fn run_page(
    args: &RunArgs,
    outcomes: &[Outcome],
    ideals: &mut Ideals,
    effects: &[&str],
) -> Result<Report> {
    let main = &outcomes[0];
    let mut report = Report::new(
        format!("unframed: {}", args.source.scene),
        "Host and display joined by bytes alone, compared with an ideal renderer that needs no \
         time.",
    );
    report
        .fact("rate", format!("{} samples/s", args.source.rate))
        .fact(
            "panel",
            format!("{}x{}", args.source.size.width, args.source.size.height),
        )
        .fact(
            "simulated",
            format!("{} s, seed {}", args.source.seconds, args.source.seed),
        )
        .fact("display", &main.display)
        .fact("stream", format!("{:.2} bytes a sample", per_sample(main)))
        .fact("effects", effects.join(", "));
    report.section(numbers(outcomes)?);
    for k in 0..main.keyframes.len() {
        report.section(pictures(outcomes, k, ideals)?);
    }
    report.footer("RMSE: root mean square over pixels and R, G, B of displayed sRGB values.");
    Ok(report)
}

fn numbers(outcomes: &[Outcome]) -> Result<Section> {
    let mut section = Section::new("Against the ideal");
    let heads = [
        "method",
        "RMSE",
        "PSNR, dB",
        "FLIP",
        "worst RMSE",
        "samples",
        "bytes a sample",
    ];
    let mut table = Table::new(heads);
    for outcome in outcomes {
        let totals = &outcome.totals;
        table.row([
            outcome.method.name().to_owned(),
            format!("{:.2}", totals.rmse),
            format!("{:.2}", totals.psnr),
            format!("{:.4}", totals.flip.unwrap_or(f64::NAN)),
            format!("{:.2}", totals.worst_rmse),
            outcome.samples.to_string(),
            format!("{:.2}", per_sample(outcome)),
        ]);
    }
    section.table(&table);
    let mut plot = Plot::new(
        "Error over time",
        Axis::new("time, s", Scale::Linear),
        rmse_axis(),
    );
    for outcome in outcomes {
        plot = plot.line(outcome.method.name(), outcome.errors.clone());
    }
    section.plot(
        &plot,
        "Both methods take the same number of samples a second.",
    )?;
    Ok(section)
}

fn pictures(outcomes: &[Outcome], k: usize, ideals: &mut Ideals) -> Result<Section> {
    let frame = &outcomes[0].keyframes[k];
    let ideal = ideal_picture(frame, ideals)?;
    let mut section = Section::new(format!("At {:.3} s", frame.time));
    let mut figures = vec![Figure::new(
        ideal.clone(),
        "ideal",
        "Supersampled, of this instant.",
    )];
    for outcome in outcomes {
        let shown = &outcome.keyframes[k].shown;
        figures.push(
            Figure::new(
                shown.clone(),
                outcome.method.name(),
                "Point at it for the ideal.",
            )
            .on_hover(ideal.clone()),
        );
    }
    if !frame.tiles.is_empty() {
        let mut net = frame.shown.enlarged(3)?;
        let rects: Vec<_> = frame
            .tiles
            .iter()
            .map(|r| crate::report::Rect {
                x: r.x * 3,
                y: r.y * 3,
                width: r.width * 3,
                height: r.height * 3,
            })
            .collect();
        net.draw_net(&rects, [255, 220, 60], 0.7);
        figures.push(Figure::new(
            net,
            "tiling",
            "The k-d cut whose side data the display got.",
        ));
    }
    for outcome in outcomes {
        let map = Picture::heat_map(&ideal, &outcome.keyframes[k].shown, ERROR_FULL)?;
        let caption = format!("Black: none; brightest: {ERROR_FULL} levels of 255 and more.");
        figures.push(Figure::new(
            map,
            format!("error of {}", outcome.method.name()),
            caption,
        ));
    }
    section.pictures(&figures)?;
    Ok(section)
}
