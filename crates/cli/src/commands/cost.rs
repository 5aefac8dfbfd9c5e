//! `unframed cost`: what accuracy costs.

use anyhow::{Context, Result, bail};
use serde_json::json;

use unframed_host::scene::Scene;
use unframed_host::trace::World;
use unframed_sim::Gpu;

use super::{bar, make_out};
use crate::args::{CostArgs, Size};
use crate::cost::adapter::OnAdapter;
use crate::cost::budget::{Answer, Budget, Candidate, solve};
use crate::cost::cores::{Core, Cores, or_say};
use crate::cost::effort::{Effort, Law};
use crate::cost::forecast::Forecast;
use crate::cost::knobs::{Knobs, PRESETS, Planned, Preset, sweeps};
use crate::cost::page::Found;
use crate::cost::scaling::curves;
use crate::cost::study::{Study, WARM_UP, parallel};
use crate::cost::table::{COSTS, Point, csv, factor_per_decibel, points, presets};
use crate::cost::{adapter, answer, effects, page, short};
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
    let points_dir = args.out.join("points");
    make_out(&points_dir)?;
    let study = |scene: &str, (size, seconds), split| {
        Ok(Study {
            name: scene.to_owned(),
            world: open_scene(scene, size)?,
            size,
            refreshes: refreshes(seconds),
            seed: args.seed,
            threads,
            split,
            dir: points_dir.clone(),
        })
    };
    let studies = args
        .scenes
        .iter()
        .map(|scene| study(scene, (args.size, args.seconds), true))
        .collect::<Result<Vec<Study>>>()?;
    let scenes: Vec<&Scene> = studies.iter().map(|study| study.world.scene()).collect();
    let first = *scenes.first().context("no scene")?;
    let counted = or_say(Core::CortexM7, first, args.seed, &points_dir)?;
    let progress = bar(0, "cost");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .context("cannot start the threads of --threads")?;
    let ideals = args.out.join("ideals");
    let measured = studies
        .iter()
        .map(|study| pool.install(|| study.run(&planned, &ideals, args.fresh, &progress)))
        .collect::<Result<Vec<_>>>()?;
    let (on_effects, framed) = if sweeps_all(args) {
        let within = effects::within(args.size, args.seconds);
        let (study, planned) = (study(effects::SCENE, within, false)?, effects::sweep());
        let measured = pool.install(|| study.run(&planned, &ideals, args.fresh, &progress))?;
        let framed = pool.install(|| effects::framed(&study.world, threads))?;
        let points = points(&planned, &[measured], study.pixels(), &|_| None);
        (points, framed)
    } else {
        (Vec::new(), Vec::new())
    };
    progress.set_message("instructions");
    let laws = match &counted {
        Some(cores) => laws(cores, planned.iter().map(|p| p.knobs), threads)?,
        None => Vec::new(),
    };
    let law = |knobs: &Knobs| {
        let found = laws.iter().find(|(other, _)| same_display(other, knobs));
        found.map(|found| found.1)
    };
    let pixels = u32::from(args.size.width) * u32::from(args.size.height);
    let points = points(&planned, &measured, pixels, &law);
    let curves = match &counted {
        Some(cores) if sweeps_all(args) => {
            progress.set_message("how cost grows");
            curves(cores, first, args.seed, threads)?
        }
        _ => Vec::new(),
    };
    progress.set_message("budgets");
    let answers = budgets
        .into_iter()
        .map(|budget| {
            let other;
            let cores = match (budget.core, &counted) {
                (None, _) => None,
                (Some(core), Some(cores)) if cores.core() == core => Some(cores),
                (Some(core), _) => {
                    other = or_say(core, first, args.seed, &points_dir)?;
                    other.as_ref()
                }
            };
            Ok(solve(
                budget,
                candidates(args, &points, &scenes, &budget, cores, threads)?,
            ))
        })
        .collect::<Result<Vec<Answer>>>()?;
    progress.set_message("graphics adapter");
    let study = studies.first().context("no scene")?;
    let adapter = on_adapter(args, study, &points)?;
    progress.finish_and_clear();
    let found = Found {
        points: &points,
        on_effects: &on_effects,
        framed: &framed,
        curves: &curves,
        adapter: adapter.as_ref(),
        answers: &answers,
    };
    write(args, pixels, &found)?;
    tell(&points, &answers);
    println!(
        "numbers, plots and fronts: {}",
        args.out.join("report.html").display()
    );
    Ok(())
}

fn refreshes(seconds: f64) -> u32 {
    ((WARM_UP + seconds) * f64::from(REFRESH_HZ)).round() as u32
}

/// Whether two settings cost the same for the same work.
fn same_display(a: &Knobs, b: &Knobs) -> bool {
    (a.method, a.display) == (b.method, b.display)
}

/// The law of each display among these settings.
fn laws(
    cores: &Cores,
    settings: impl Iterator<Item = Knobs>,
    threads: usize,
) -> Result<Vec<(Knobs, Law)>> {
    let mut displays: Vec<Knobs> = Vec::new();
    for knobs in settings {
        if !displays.iter().any(|other| same_display(other, &knobs)) {
            displays.push(knobs);
        }
    }
    parallel(threads, displays.len(), |i| {
        let knobs = displays[i];
        Ok((knobs, cores.law(knobs.method, knobs.display)?))
    })
}

fn sweeps_all(args: &CostArgs) -> bool {
    args.preset.is_empty() && !args.presets_only
}

/// What is to be measured: all sweeps, or the presets alone.
fn planned(args: &CostArgs) -> Result<Vec<Planned>> {
    if sweeps_all(args) {
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

/// The presets on the panel of a budget: all scenes must fit, so that the dearest counts.
fn candidates(
    args: &CostArgs,
    points: &[Point],
    scenes: &[&Scene],
    budget: &Budget,
    cores: Option<&Cores>,
    threads: usize,
) -> Result<Vec<Candidate>> {
    let size = Size {
        width: budget.width,
        height: budget.height,
    };
    let first = (WARM_UP * f64::from(REFRESH_HZ)) as u32;
    let presets = presets(points);
    let laws = match cores {
        Some(cores) => laws(cores, presets.iter().map(|p| *p.settings()), threads)?,
        None => Vec::new(),
    };
    let jobs = presets.len() * scenes.len();
    let forecasts = parallel(threads, jobs, |i| {
        let (preset, scene) = (i / scenes.len(), i % scenes.len());
        let knobs = presets[preset].settings();
        Forecast::new(
            knobs,
            scenes[scene],
            size,
            args.seed,
            refreshes(args.seconds),
            first,
        )
    })?;
    let slots = scenes
        .iter()
        .map(|scene| Ok(World::new((*scene).clone(), [1, 1])?.object_count() + 1))
        .collect::<Result<Vec<usize>>>()?;
    let candidate = |(point, forecasts): (&&Point, &[Forecast])| {
        let knobs = *point.settings();
        let law = laws.iter().find(|(other, _)| same_display(other, &knobs));
        let efforts: Option<Vec<(Effort, Effort)>> =
            law.map(|(_, law)| forecasts.iter().map(|f| f.efforts(law)).collect());
        let most = |f: fn(&Forecast) -> f64| forecasts.iter().map(f).fold(0.0, f64::max);
        let worst = |f: fn(&(Effort, Effort)) -> Effort| {
            let all = efforts.iter().flatten().map(f);
            all.max_by(|a, b| a.total().total_cmp(&b.total()))
        };
        let candidate = Candidate {
            preset: point.preset?,
            rmse: point.rmse,
            rate: 0,
            samples: 0,
            bytes_per_second: most(|f| f.bytes_per_second),
            ram_bytes: 0,
            display_seconds: most(|f| f.display_seconds),
            mean: worst(|efforts| efforts.0),
            worst: worst(|efforts| efforts.1),
            slots: slots.iter().copied().max().unwrap_or(2),
            panel: (size.width, size.height),
            knobs,
        };
        Some(candidate.on((size.width, size.height)))
    };
    let each = presets.iter().zip(forecasts.chunks(scenes.len().max(1)));
    Ok(each.filter_map(candidate).collect())
}

/// The presets among the points on the graphics adapter, if there is one.
fn on_adapter(args: &CostArgs, study: &Study, points: &[Point]) -> Result<Option<OnAdapter>> {
    let gpu = match Gpu::new() {
        Ok(gpu) => gpu,
        Err(reason) => {
            eprintln!("left out: the presets on a graphics adapter ({reason})");
            return Ok(None);
        }
    };
    let measured = |preset: &&Preset| points.iter().any(|p| p.preset == Some(preset.name));
    let presets: Vec<&Preset> = PRESETS.iter().filter(measured).collect();
    let counted = [
        (WARM_UP * f64::from(REFRESH_HZ)) as u32,
        refreshes(args.seconds),
    ];
    let world = &study.world;
    adapter::measure(&gpu, &presets, world, args.size, args.seed, counted).map(Some)
}

fn write(args: &CostArgs, pixels: u32, found: &Found<'_>) -> Result<()> {
    let points = found.points;
    let factors: serde_json::Map<String, serde_json::Value> = COSTS
        .iter()
        .map(|(name, cost)| ((*name).to_owned(), json!(factor_per_decibel(points, *cost))))
        .collect();
    let (size, seconds) = effects::within(args.size, args.seconds);
    let report = json!({
        "settings": {
            "scenes": args.scenes,
            "size": [args.size.width, args.size.height],
            "seconds": args.seconds,
            "warm_up_seconds": WARM_UP,
            "seed": args.seed,
            "refresh_hz": REFRESH_HZ,
        },
        "points": points,
        "effects": {
            "scene": effects::SCENE,
            "size": [size.width, size.height],
            "seconds": seconds,
            "points": found.on_effects,
            "framed": found.framed,
        },
        "factor_per_decibel": factors,
        "scaling": found.curves,
        "adapter": found.adapter,
        "budgets": found.answers,
    });
    let bytes = serde_json::to_vec_pretty(&report)?;
    write_whole(&args.out.join("report.json"), &bytes)?;
    if let Some(path) = &args.json {
        write_whole(path, &bytes)?;
    }
    let all = [points, found.on_effects].concat();
    write_file(&args.out.join("points.csv"), csv(&all).as_bytes())?;
    let facts = [
        ("scenes", args.scenes.join(", ")),
        ("panel", format!("{}x{}", args.size.width, args.size.height)),
        ("simulated", format!("{} s", args.seconds)),
    ];
    page::write(found, &facts, pixels, &args.out)
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
        println!("{}", answer::sentence(answer));
    }
}
