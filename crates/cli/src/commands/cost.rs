//! `unframed cost`: what accuracy costs.

use anyhow::{Context, Result, bail};
use serde_json::json;

use super::{bar, make_out};
use crate::args::CostArgs;
use crate::cost::budget::{Answer, Budget, Candidate, solve};
use crate::cost::knobs::{PRESETS, Planned, Preset, sweeps};
use crate::cost::study::{Study, WARM_UP};
use crate::cost::table::{COSTS, Point, csv, factor_per_decibel, points, presets};
use crate::cost::{page, ram, short};
use crate::eval::store::write_whole;
use crate::measure::{REFRESH_HZ, open_scene};
use crate::report::write_file;

/// Measures; points that are done already are not measured again.
///
/// # Errors
/// The scene cannot be opened, a file not be written, a preset or budget not be understood.
pub fn cost(args: &CostArgs) -> Result<()> {
    let budgets: Vec<Budget> = args
        .budget
        .iter()
        .map(|text| Ok(text.parse::<Budget>()?))
        .collect::<Result<_>>()?;
    let planned = planned(args)?;
    make_out(&args.out)?;
    let threads = args.threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    );
    let study = Study {
        name: args.scene.clone(),
        world: open_scene(&args.scene, args.size)?,
        size: args.size,
        refreshes: ((WARM_UP + args.seconds) * f64::from(REFRESH_HZ)).round() as u32,
        seed: args.seed,
        threads,
        dir: args.out.join("points"),
    };
    make_out(&study.dir)?;
    let progress = bar(0, "cost");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .context("cannot start the threads of --threads")?;
    let ideals = args.out.join("ideals");
    let measured = pool.install(|| study.run(&planned, &ideals, args.fresh, &progress))?;
    progress.finish_and_clear();
    let points = points(&planned, &measured, study.pixels(), &|_| None);
    let answers: Vec<Answer> = budgets
        .into_iter()
        .map(|budget| solve(budget, candidates(&points, &study, &budget)))
        .collect();
    write(args, &study, &points, &answers)?;
    tell(&points, &answers);
    println!(
        "numbers, plots and fronts: {}",
        args.out.join("report.html").display()
    );
    Ok(())
}

/// What is to be measured: all sweeps, or the presets alone.
fn planned(args: &CostArgs) -> Result<Vec<Planned>> {
    if args.preset.is_empty() && !args.presets_only {
        return Ok(sweeps());
    }
    let wanted: Vec<&Preset> = if args.preset.is_empty() {
        PRESETS.iter().collect()
    } else {
        let find = |name: &String| {
            let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            let found = PRESETS.iter().find(|preset| preset.name == name);
            found.with_context(|| format!("no preset `{name}`; there are {}", known.join(", ")))
        };
        args.preset.iter().map(find).collect::<Result<_>>()?
    };
    if wanted.is_empty() {
        bail!("no preset to measure");
    }
    let point = |preset: &&Preset| Planned {
        sweep: "presets",
        knobs: preset.knobs(),
    };
    Ok(wanted.iter().map(point).collect())
}

/// The presets on the panel of a budget: samples a pixel stay, all else follows.
fn candidates(points: &[Point], study: &Study, budget: &Budget) -> Vec<Candidate> {
    let pixels = u32::from(budget.width) * u32::from(budget.height);
    let scale = f64::from(pixels) / f64::from(study.pixels());
    presets(points)
        .into_iter()
        .filter_map(|point| {
            let knobs = point.settings();
            let samples = knobs.samples(pixels);
            Some(Candidate {
                preset: point.preset?,
                rmse: point.rmse,
                rate: knobs.rate(pixels),
                samples,
                bytes_per_second: point.bytes_per_second * scale,
                ram_bytes: ram::bytes::<unframed_recon::Fixed>(
                    budget.width,
                    budget.height,
                    samples as usize,
                    knobs.display.fit,
                    study.world.object_count() + 1,
                ),
                display_seconds: point.display_seconds * scale,
                effort: None,
            })
        })
        .collect()
}

fn write(args: &CostArgs, study: &Study, points: &[Point], answers: &[Answer]) -> Result<()> {
    let factors: serde_json::Map<String, serde_json::Value> = COSTS
        .iter()
        .map(|(name, cost)| ((*name).to_owned(), json!(factor_per_decibel(points, *cost))))
        .collect();
    let report = json!({
        "settings": {
            "scene": args.scene,
            "size": [args.size.width, args.size.height],
            "seconds": args.seconds,
            "warm_up_seconds": WARM_UP,
            "seed": args.seed,
            "refresh_hz": REFRESH_HZ,
        },
        "points": points,
        "factor_per_decibel": factors,
        "budgets": answers,
    });
    let bytes = serde_json::to_vec_pretty(&report)?;
    write_whole(&args.out.join("report.json"), &bytes)?;
    if let Some(path) = &args.json {
        write_whole(path, &bytes)?;
    }
    write_file(&args.out.join("points.csv"), csv(points).as_bytes())?;
    let facts = [
        ("scene", args.scene.clone()),
        ("panel", format!("{}x{}", args.size.width, args.size.height)),
        ("simulated", format!("{} s", args.seconds)),
    ];
    page::write(points, answers, &facts, study.pixels(), &args.out)?;
    Ok(())
}

fn tell(points: &[Point], answers: &[Answer]) {
    println!(
        "{:8} {:>6} {:>6} {:>7} {:>6} {:>9} {:>10} {:>10} {:>9}",
        "preset", "RMSE", "dB", "rate", "N", "host, s", "display, s", "kB/s", "RAM, kB"
    );
    for p in presets(points) {
        println!(
            "{:8} {:6.2} {:6.2} {:>7} {:>6} {:9.3} {:10.3} {:10.1} {:9.0}{}",
            p.preset.unwrap_or(""),
            p.rmse,
            p.psnr,
            short(p.knobs.rate),
            short(p.knobs.samples),
            p.host_seconds,
            p.display_seconds,
            p.bytes_per_second / 1e3,
            p.ram_bytes as f64 / 1e3,
            if p.dominated_by > 0.03 {
                "  dominated"
            } else {
                ""
            },
        );
    }
    for (name, cost) in COSTS {
        if let Some(factor) = factor_per_decibel(points, cost) {
            println!("one decibel more: {name} × {factor:.2}");
        }
    }
    for answer in answers {
        println!("{}", page::sentence(answer));
    }
}
