//! `unframed eval`: every method against the ideal renderer.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use serde_json::json;
use unframed_host::trace::World;

use super::{bar, make_out};
use crate::args::EvalArgs;
use crate::eval::page::Findings;
use crate::eval::schedule::{Workshop, finished};
use crate::eval::store::{Key, write_whole};
use crate::eval::table::{Row, Verdict, csv, report, rows, verdicts};
use crate::eval::{Cache, Cell, EvalMethod, Job, Reference, Settings, page};
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

/// A scene of the evaluation.
struct Stage {
    name: String,
    world: World,
    cache: Cache,
    jobs: Vec<Job>,
    /// Those not done yet, as indices.
    open: Vec<usize>,
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
    let stages: Vec<Stage> = args
        .scenes
        .iter()
        .map(|name| stage(args, name, &root, &cell_dir))
        .collect::<Result<_>>()?;
    let count = settings(args).refreshes;

    // Refreshes to come: of methods, and of ideal images, which take as long as a few.
    let missing: u64 = stages
        .iter()
        .filter(|s| !s.open.is_empty())
        .map(|_| u64::from(count))
        .sum();
    let methods: u64 = stages
        .iter()
        .flat_map(|stage| stage.open.iter().map(|i| &stage.jobs[*i]))
        .map(|job| u64::from(count) * job.method.settings().len() as u64)
        .sum();
    let progress = bar(missing + methods, "eval");
    let workshop = Workshop {
        dir: &cell_dir,
        threads,
        build: &build,
        progress: &progress,
        begin,
    };
    let mut cells: Vec<(Job, Cell)> = Vec::new();
    for stage in &stages {
        progress.set_message(stage.name.clone());
        run_stage(stage, &workshop, count)?;
        for job in &stage.jobs {
            let cell = finished(&cell_dir, job)
                .with_context(|| format!("the cell {} has vanished", job.file_stem()))?;
            cells.push((job.clone(), cell));
        }
    }
    progress.finish_and_clear();
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

fn settings(args: &EvalArgs) -> Settings {
    Settings {
        size: args.size,
        refreshes: (args.seconds * f64::from(REFRESH_HZ)).round().max(1.0) as u32,
        samples: args.samples,
        flip: !args.no_flip,
        cvvdp: args.cvvdp,
        causes: args.causes,
    }
}

fn stage(args: &EvalArgs, name: &str, root: &Path, cell_dir: &Path) -> Result<Stage> {
    let opened = unframed_host::scene::open::open(name, None)?;
    for warning in &opened.warnings {
        eprintln!("{name}: {warning}");
    }
    let scene_key = Key::of_scene(&opened.scene).to_string();
    let size = [args.size.width, args.size.height].map(u32::from);
    let world = World::new(opened.scene, size).with_context(|| format!("cannot render {name}"))?;
    let cache = Cache::new(root, name, &world)?;
    let mut jobs: Vec<Job> = Vec::new();
    let methods: Vec<EvalMethod> = if args.methods.is_empty() {
        EvalMethod::all().collect()
    } else {
        args.methods.clone()
    };
    for method in methods {
        for rate in &args.rates {
            for seed in 1..=u64::from(args.seeds) {
                // A sample a pixel and refresh, whatever the rate asked for.
                let tenfold = size[0] * size[1] * REFRESH_HZ;
                let job = Job {
                    scene: name.to_owned(),
                    scene_key: scene_key.clone(),
                    method,
                    rate: if method.is_tenfold() { tenfold } else { *rate },
                    seed: if method.is_random() { seed } else { 1 },
                    settings: settings(args),
                };
                if !jobs.contains(&job) {
                    jobs.push(job);
                }
            }
        }
    }
    let open = (0..jobs.len())
        .filter(|i| args.fresh || finished(cell_dir, &jobs[*i]).is_none())
        .collect();
    Ok(Stage {
        name: name.to_owned(),
        world,
        cache,
        jobs,
        open,
    })
}

/// Does what is to be done on one scene.
fn run_stage(stage: &Stage, workshop: &Workshop<'_>, count: u32) -> Result<()> {
    if stage.open.is_empty() {
        return Ok(());
    }
    let mut world = stage.world.clone();
    let mut references: Vec<Reference> = Vec::with_capacity(count as usize);
    for index in 0..count {
        references.push(stage.cache.reference(&mut world, index)?);
        workshop.progress.inc(1);
    }
    let open: Vec<Job> = stage.open.iter().map(|i| stage.jobs[*i].clone()).collect();
    workshop.run(&open, &stage.world, &references)?;
    Ok(())
}

/// Which program this is: cells of another one are reused, but not in silence.
fn build() -> Result<String> {
    let path = std::env::current_exe().context("cannot find this program's own file")?;
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(Key::of_bytes(&bytes).to_string())
}

fn write(args: &EvalArgs, stages: &[Stage], cells: &[(Job, Cell)], dir: &Path) -> Result<()> {
    let plain: Vec<Cell> = cells.iter().map(|(_, cell)| cell.clone()).collect();
    let rows = rows(&plain);
    let verdicts = verdicts(&rows);
    let facts = json!({
        "size": [args.size.width, args.size.height],
        "seconds": args.seconds,
        "refresh_hz": REFRESH_HZ,
        "seeds": args.seeds,
        "display_samples": args.samples,
    });
    let json = serde_json::to_vec_pretty(&report(&rows, &verdicts, &plain, facts))?;
    write_whole(&args.out.join("report.json"), &json)?;
    if let Some(path) = &args.json {
        write_whole(path, &json)?;
    }
    write_whole(&args.out.join("cells.csv"), csv(&rows).as_bytes())?;
    let ideal = |scene: &str, index: u32| {
        let stage = stages.iter().find(|stage| stage.name == scene)?;
        let image = stage.cache.stored(index)?.image;
        let [width, height] = stage.world.size().map(|s| s as usize);
        Picture::new(width, height, image).ok()
    };
    let findings = Findings {
        rows: &rows,
        verdicts: &verdicts,
        cells,
        ideal: &ideal,
        cell_dir: dir,
        facts: vec![
            (
                "panel".to_owned(),
                format!("{}x{}", args.size.width, args.size.height),
            ),
            (
                "simulated".to_owned(),
                format!("{} s at {REFRESH_HZ} Hz", args.seconds),
            ),
            ("seeds".to_owned(), args.seeds.to_string()),
            (
                "display remembers".to_owned(),
                format!("{} samples", args.samples),
            ),
        ],
    };
    page::write(&findings, &args.out)?;
    tell(&rows, &verdicts);
    println!(
        "numbers, plots and pictures: {}",
        args.out.join("report.html").display()
    );
    Ok(())
}

fn tell(rows: &[Row], verdicts: &[Verdict]) {
    println!(
        "{:14} {:33} {:>8} {:>7} {:>7} {:>7} {:>7} {:>6}",
        "scene", "method", "rate", "RMSE", "p95", "worst", "FLIP", "JOD"
    );
    let maybe = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
    };
    for row in rows {
        println!(
            "{:14} {:33} {:>8} {:7.2} {:7.2} {:7.2} {:>7} {:>6}",
            crate::eval::store::slug(&row.scene),
            row.method,
            row.rate,
            row.rmse,
            row.p95_rmse,
            row.worst_rmse,
            maybe(row.flip, 4),
            maybe(row.cvvdp, 2),
        );
    }
    for v in verdicts {
        let mark = match (v.holds, v.moonshot) {
            (true, _) => "holds",
            (false, true) => "not reached (hoped for)",
            (false, false) => "DOES NOT HOLD",
        };
        println!(
            "{:14} adaptive at {} / {}: {:.3}, at most {:.2}: {mark}",
            crate::eval::store::slug(&v.scene),
            v.rate,
            v.against,
            v.ratio,
            v.limit,
        );
    }
}
