//! `unframed eval`: every method against the ideal renderer.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use serde_json::json;

use super::{bar, make_out};
use crate::args::{EvalArgs, Stretch};
use crate::eval::checks::checks;
use crate::eval::page::{Findings, short};
use crate::eval::plan::{Stage, stages};
use crate::eval::schedule::{Task, Workshop, finished};
use crate::eval::store::{Key, slug, write_whole};
use crate::eval::table::{Found, csv};
use crate::eval::{Cell, Job, Reference, page};
use crate::measure::REFRESH_HZ;
use crate::report::Picture;

/// Evaluates; cells that are done already are not computed again.
///
/// # Errors
/// A scene cannot be opened, a file not be written, a method fails.
pub fn eval(args: &EvalArgs) -> Result<()> {
    make_out(&args.out)?;
    let threads = args.threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    );
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .context("cannot start the threads of --threads")?;
    pool.install(|| evaluate(args, threads))
}

fn evaluate(args: &EvalArgs, threads: usize) -> Result<()> {
    let begin = Instant::now();
    let build = build()?;
    let cell_dir = args.out.join("cells");
    make_out(&cell_dir)?;
    let root = args
        .cache
        .clone()
        .unwrap_or_else(|| args.out.join("ideals"));
    let stages = stages(args, &root)?;
    let open: Vec<Vec<&Job>> = stages
        .iter()
        .map(|stage| {
            let undone = |job: &&Job| args.fresh || finished(&cell_dir, job).is_none();
            stage.jobs.iter().filter(undone).collect()
        })
        .collect();

    // Refreshes to come: of methods, and of ideal images, which take as long as a few.
    let busy = || {
        stages
            .iter()
            .zip(&open)
            .filter(|(_, open)| !open.is_empty())
    };
    let ideals: u64 = busy().map(|(stage, _)| u64::from(stage.ideals())).sum();
    let methods: u64 = open
        .iter()
        .flatten()
        .map(|job| u64::from(job.settings.refreshes) * job.method.settings().len() as u64)
        .sum();
    let progress = bar(ideals + methods, "eval");
    let references: Vec<Vec<Reference>> = stages
        .iter()
        .zip(&open)
        .map(|(stage, open)| {
            if open.is_empty() {
                return Ok(Vec::new());
            }
            progress.set_message(format!("ideal {}", stage.name));
            stage.references(&|| progress.inc(1))
        })
        .collect::<Result<_>>()?;
    progress.set_message("methods");
    let workshop = Workshop {
        dir: &cell_dir,
        threads,
        build: &build,
        progress: &progress,
        begin,
    };
    let tasks: Vec<Task<'_>> = stages
        .iter()
        .zip(&open)
        .zip(&references)
        .flat_map(|((stage, open), references)| {
            open.iter().map(move |job| Task {
                job,
                world: &stage.world,
                references,
            })
        })
        .collect();
    workshop.run(&tasks)?;
    progress.finish_and_clear();
    let mut cells: Vec<(Job, Cell)> = Vec::new();
    for job in stages.iter().flat_map(|stage| &stage.jobs) {
        let cell = finished(&cell_dir, job)
            .with_context(|| format!("the cell {} has vanished", job.file_stem()))?;
        cells.push((job.clone(), cell));
    }
    let strangers = cells.iter().filter(|(_, cell)| cell.build != build).count();
    if strangers > 0 {
        eprintln!(
            "{strangers} of {} cells were measured by another build of this program; --fresh \
             measures them again",
            cells.len()
        );
    }
    write(args, &stages, &cells, &cell_dir)
}

/// Which program this is: cells of another one are reused, but not in silence.
fn build() -> Result<String> {
    let path = std::env::current_exe().context("cannot find this program's own file")?;
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(Key::of_bytes(&bytes).to_string())
}

fn write(args: &EvalArgs, stages: &[Stage], cells: &[(Job, Cell)], dir: &Path) -> Result<()> {
    let plain: Vec<Cell> = cells.iter().map(|(_, cell)| cell.clone()).collect();
    let found = Found::new(&plain, &args.scenes);
    let facts = json!({
        "size": [args.size.width, args.size.height],
        "seconds": match args.seconds {
            Stretch::Loop => serde_json::Value::from("loop"),
            Stretch::Seconds(seconds) => seconds.into(),
        },
        "refresh_hz": REFRESH_HZ,
        "seeds": args.seeds,
        "display_samples": args.samples,
        "flip_every": args.flip_every,
    });
    let json = serde_json::to_vec_pretty(&found.report(&plain, facts))?;
    write_whole(&args.out.join("report.json"), &json)?;
    if let Some(path) = &args.json {
        write_whole(path, &json)?;
    }
    write_whole(&args.out.join("cells.csv"), csv(&found.rows).as_bytes())?;
    let ideal = |scene: &str, index: u32| {
        let stage = stages.iter().find(|stage| stage.name == scene)?;
        let [width, height] = stage.world.size().map(|s| s as usize);
        Picture::new(width, height, stage.ideal(index)?).ok()
    };
    let flip = match args.flip_every {
        0 => "not measured".to_owned(),
        1 => "every refresh".to_owned(),
        every => format!("1 refresh in {every}"),
    };
    let findings = Findings {
        found: &found,
        cells,
        ideal: &ideal,
        cell_dir: dir,
        facts: vec![
            ("panel", format!("{}x{}", args.size.width, args.size.height)),
            (
                "simulated",
                match args.seconds {
                    Stretch::Loop => format!("each animation once, {REFRESH_HZ} Hz"),
                    Stretch::Seconds(seconds) => format!("{seconds} s at {REFRESH_HZ} Hz"),
                },
            ),
            ("seeds", args.seeds.to_string()),
            ("display keeps", format!("{} samples", short(args.samples))),
            ("FLIP", flip),
        ],
    };
    page::write(&findings, &args.out)?;
    tell(&found);
    println!(
        "numbers, plots and pictures: {}",
        args.out.join("report.html").display()
    );
    Ok(())
}

fn tell(found: &Found) {
    let maybe = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
    };
    if !found.rows.is_empty() {
        println!(
            "{:14} {:33} {:>8} {:>7} {:>7} {:>7} {:>7} {:>6}",
            "scene", "method", "rate", "RMSE", "p95", "worst", "FLIP", "JOD"
        );
    }
    for row in &found.rows {
        println!(
            "{:14} {:33} {:>8} {:7.2} {:7.2} {:7.2} {:>7} {:>6}",
            slug(&row.scene),
            row.method,
            row.rate,
            row.rmse,
            row.p95_rmse,
            row.worst_rmse,
            maybe(row.flip, 4),
            maybe(row.cvvdp, 2),
        );
    }
    for check in checks(found) {
        println!(
            "{:14} {:44} {:>22}  {}",
            check.scene,
            check.claim,
            check.found,
            check.mark()
        );
    }
}
