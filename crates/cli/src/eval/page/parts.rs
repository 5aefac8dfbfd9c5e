//! What parts are worth; still pictures and cuts.

use std::path::Path;

use anyhow::Result;

use super::{Findings, scenes, short};
use crate::eval::cell::Cell;
use crate::eval::methods::EvalMethod;
use crate::eval::probes::{CUT_AT, RECOVERED, STILL_LIMIT, over_seeds};
use crate::eval::store::slug;
use crate::eval::table::{Ablation, Row};
use crate::report::{Axis, Plot, Scale, Section, Table, write_file};

/// The ablation table: a row a part, three columns a scene.
pub(super) fn ablations(ablations: &[Ablation], rows: &[Row]) -> Section {
    let mut section = Section::new("What each part is worth");
    let scenes: Vec<&str> = scenes(rows)
        .into_iter()
        .filter(|scene| ablations.iter().any(|a| a.scene == *scene))
        .collect();
    let rate = ablations.first().map_or(0, |a| a.rate);
    let columns = scenes
        .iter()
        .flat_map(|scene| [slug(scene), "host".to_owned(), "display".to_owned()]);
    let heads = ["adaptive with".to_owned()].into_iter().chain(columns);
    let mut table = Table::new(heads.chain(["instead".to_owned()])).caption(
        "Each part off, all else on: change of RMSE (under the scene's name), of the host's and \
         of the display's time, in percent of adaptive's. RMSE above 0: the part helps. Time \
         below 0: the part costs that much; a few percent of time mean nothing. In brackets: \
         within the spread over seeds.",
    );
    let percent = |v: f64| format!("{:+.1}", 100.0 * v).replace('-', "−");
    for method in EvalMethod::ablations() {
        let find = |scene: &&str| {
            ablations
                .iter()
                .find(|a| a.scene == **scene && a.method == method.name())
        };
        if scenes.iter().all(|scene| find(scene).is_none()) {
            continue;
        }
        let mut cells = vec![method.name().replace("adaptive-", "").replace('-', " ")];
        for scene in &scenes {
            let Some(a) = find(scene) else {
                cells.extend(["–"; 3].map(str::to_owned));
                continue;
            };
            let rmse = percent(a.rmse_change);
            let noise = a.noise.is_some_and(|noise| a.rmse_change.abs() <= noise);
            cells.push(if noise { format!("({rmse})") } else { rmse });
            cells.push(percent(a.host_change));
            cells.push(percent(a.display_change));
        }
        cells.push(method.instead().unwrap_or("").to_owned());
        table.row(cells);
    }
    section.paragraph(&format!("At {} samples a second.", short(rate)));
    section.table(&table);
    section
}

/// Error over time of still scenes and after cuts.
pub(super) fn probes(findings: &Findings<'_>, dir: &Path) -> Result<Vec<Section>> {
    let found = findings.found;
    let all = |scene: &str, method: &str| -> Vec<&Cell> {
        let cells = findings.cells.iter().map(|(_, cell)| cell);
        cells
            .filter(|cell| cell.scene == scene && cell.method == method)
            .collect()
    };
    let mut sections = Vec::new();
    if !found.stills.is_empty() {
        let mut section = Section::new("The golden thread: a still picture converges");
        let rmse = Axis::new("RMSE of displayed sRGB values (log)", Scale::Log);
        let title = "RMSE of a still scene";
        let mut plot = Plot::new(title, Axis::new("time, s", Scale::Linear), rmse);
        let mut table = Table::new([
            "scene",
            "method",
            "rate",
            "last RMSE",
            "below 1.5 from",
            "worst rise of a half second",
            "",
        ]);
        for still in &found.stills {
            let name = format!("{} {}", still.scene, still.method);
            plot = plot.line(name, over_seeds(&all(&still.scene, &still.method)));
            let from = still.below_limit_from;
            table.row([
                still.scene.clone(),
                still.method.clone(),
                short(still.rate),
                format!("{:.2}", still.last_rmse),
                from.map_or_else(|| "never".to_owned(), |t| format!("{t:.2} s")),
                format!("{:+.1} %", 100.0 * (still.worst_rise - 1.0)),
                if still.holds { "✓ holds" } else { "✗" }.to_owned(),
            ]);
        }
        let ends = vec![(0.0, STILL_LIMIT), (5.0, STILL_LIMIT)];
        plot = plot.line("limit", ends);
        section.plot(&plot, "Camera and objects stand as at time 0.")?;
        section.table(&table);
        write_file(&dir.join("golden.svg"), plot.svg()?.as_bytes())?;
        sections.push(section);
    }
    if !found.cuts.is_empty() {
        let mut section = Section::new("Cuts are forgotten");
        let mut table = Table::new([
            "scene",
            "method",
            "rate",
            "first RMSE",
            "of the animation",
            "back to it, ms",
            "of this second",
            "back to it, ms",
            "back to the same refresh, ms",
            "",
        ])
        .caption(
            "Everything jumps half a loop at the cut. Back: three refreshes in a row whose RMSE \
             is at most 1.2 times that of the whole animation, of the second that was watched, had \
             there been no cut, and of the same refresh without it. Squared errors are \
             averaged over the seeds; in brackets, each seed alone.",
        );
        for cut in &found.cuts {
            let told = |ms: Option<f64>| ms.map_or_else(|| "never".into(), |ms| format!("{ms:.0}"));
            let mut same = told(cut.of_same);
            if cut.of_same_each.len() > 1 {
                let each: Vec<String> = cut.of_same_each.iter().map(|ms| told(*ms)).collect();
                same += &format!(" ({})", each.join(", "));
            }
            let (animation, of_animation) = match cut.animation_rmse {
                None => <(String, String)>::default(),
                Some(rmse) => (format!("{rmse:.2}"), told(cut.of_animation)),
            };
            let mark = match cut.holds {
                None => "",
                Some(true) => "✓ holds",
                Some(false) => "✗",
            };
            table.row([
                cut.scene.clone(),
                cut.method.clone(),
                short(cut.rate),
                format!("{:.2}", cut.first_rmse),
                animation,
                of_animation,
                format!("{:.2}", cut.steady_rmse),
                told(cut.of_steady),
                same,
                mark.to_owned(),
            ]);
            let steady = cut.scene.replace("-cut", "-without-cut");
            if cut.method == EvalMethod::Adaptive.name() {
                let with = over_seeds(&all(&cut.scene, &cut.method));
                let without = over_seeds(&all(&steady, &cut.method));
                let without = without.into_iter().map(|(t, rmse)| (t, RECOVERED * rmse));
                let title = format!("{}: RMSE around the cut", cut.scene);
                let time = Axis::new("time, s", Scale::Linear);
                let plot = Plot::new(title, time, crate::report::plot::rmse_axis())
                    .line("with the cut", with)
                    .line("1.2 × without", without.collect::<Vec<_>>())
                    .mark(CUT_AT, "cut");
                section.plot(&plot, "Adaptive; mean of seeds.")?;
                let name = format!("{}.svg", cut.scene);
                write_file(&dir.join(name), plot.svg()?.as_bytes())?;
            }
        }
        section.table(&table);
        sections.push(section);
    }
    Ok(sections)
}
