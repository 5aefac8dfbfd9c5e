//! `unframed run`: the main job.

use anyhow::Result;
use serde_json::{Value, json};
use unframed_host::scene::calls;
use unframed_wire::Kind;

use super::{bar, make_out};
use crate::args::RunArgs;
use crate::measure::{Ideals, Keyframe, Outcome, measure, open_world, refreshes};
use crate::method::Method;
use crate::pages::run_page;
use crate::report::{Picture, write_file};

/// Runs the asked method and traditional frameless rendering at the same rate, against the ideal.
///
/// # Errors
/// What the user asked for cannot be had: scene, output, hardware.
pub fn run(args: &RunArgs) -> Result<()> {
    if args.window {
        return super::live::show(args);
    }
    if let Some(dir) = &args.out {
        make_out(dir)?;
    }
    let world = open_world(&args.source)?;
    let effects = calls::effects(world.scene());
    let mut ideals = Ideals::new(world);
    let count = refreshes(&args.source);
    let keep = kept(count, args.every);
    let mut methods = vec![args.source.method];
    if args.source.method != Method::Frameless {
        methods.push(Method::Frameless);
    }
    let progress = bar(u64::from(count) * methods.len() as u64, &args.source.scene);
    let mut outcomes = Vec::new();
    for method in methods {
        let source = &args.source;
        outcomes.push(measure(
            source,
            &args.panel,
            method,
            args.every,
            &keep,
            &mut ideals,
            &progress,
        )?);
    }
    progress.finish_and_clear();
    let called: Vec<&str> = effects
        .iter()
        .filter(|e| e.called_for)
        .map(|e| e.name)
        .collect();
    let report = summary(args, &outcomes, &called);
    if let Some(dir) = &args.out {
        let main = &outcomes[0];
        let lines: String = main
            .hashes
            .iter()
            .enumerate()
            .map(|(index, hash)| format!("{index} {hash:016x}\n"))
            .collect();
        write_file(&dir.join("hashes.txt"), lines.as_bytes())?;
        let pretty = serde_json::to_vec_pretty(&report)?;
        write_file(&dir.join("report.json"), &pretty)?;
        write_pictures(dir, &outcomes, &mut ideals)?;
        run_page(args, &outcomes, &mut ideals, &called)?.write(&dir.join("report.html"))?;
    }
    if args.json {
        println!("{report}");
    } else {
        tell(args, &outcomes);
    }
    Ok(())
}

/// Which refreshes' pictures are kept: four, evenly, all measured ones.
fn kept(count: u32, every: u32) -> Vec<u32> {
    let measured: Vec<u32> = (0..count)
        .filter(|i| (i + 1).is_multiple_of(every) || i + 1 == count)
        .collect();
    let mut keep: Vec<u32> = (1..=4)
        .filter_map(|k| measured.get((measured.len() * k / 4).max(1) - 1))
        .copied()
        .collect();
    keep.dedup();
    keep
}

/// One hash of the whole run: of all refreshes' hashes in order.
fn run_hash(outcome: &Outcome) -> String {
    let bytes: Vec<[u8; 3]> = outcome
        .hashes
        .iter()
        .flat_map(|hash| hash.to_le_bytes())
        .map(|byte| [byte, 0, 0])
        .collect();
    format!("{:016x}", unframed_recon::frame_hash(&bytes))
}

fn summary(args: &RunArgs, outcomes: &[Outcome], effects: &[&str]) -> Value {
    let main = &outcomes[0];
    let methods: serde_json::Map<String, Value> = outcomes
        .iter()
        .map(|outcome| {
            let totals = &outcome.totals;
            let value = json!({
                "rmse": totals.rmse,
                "psnr": totals.psnr,
                "flip": totals.flip,
                "worst_rmse": totals.worst_rmse,
                "p95_rmse": totals.p95_rmse,
                "measured_refreshes": totals.refreshes,
                "samples": outcome.samples,
                "stream_bytes": outcome.stream_bytes,
                "seconds_host": outcome.seconds_host,
                "seconds_display": outcome.seconds_display,
            });
            (outcome.method.name().to_owned(), value)
        })
        .collect();
    json!({
        "scene": args.source.scene,
        "method": main.method.name(),
        "seed": args.source.seed,
        "rate": args.source.rate,
        "size": [args.source.size.width, args.source.size.height],
        "seconds": args.source.seconds,
        "display": main.display,
        "refreshes": main.hashes.len(),
        "samples": main.samples,
        "stream_bytes": main.stream_bytes,
        "bytes_per_sample": per_sample(main),
        "frame_hash": run_hash(main),
        "methods": methods,
        "effects": effects,
        "ledger": ledger(main),
    })
}

/// Stream bytes a sample, all packets counted.
#[must_use]
pub fn per_sample(outcome: &Outcome) -> f64 {
    outcome.stream_bytes as f64 / outcome.samples.max(1) as f64
}

fn ledger(outcome: &Outcome) -> Value {
    let ledger = &outcome.ledger;
    let packets: serde_json::Map<String, Value> = Kind::ALL
        .iter()
        .filter(|kind| ledger.packets_of(**kind) > 0)
        .map(|kind| {
            let value =
                json!({ "packets": ledger.packets_of(*kind), "bytes": ledger.bytes_of(*kind) });
            (kind.name().to_owned(), value)
        })
        .collect();
    let bits = &ledger.sample_bits;
    json!({
        "rays": {
            "primary": outcome.rays.primary,
            "shadow": outcome.rays.shadow,
            "bounce": outcome.rays.bounce,
            "soft": outcome.rays.soft,
            "refraction": outcome.rays.refraction,
            "medium": outcome.rays.medium,
            "indirect": outcome.rays.indirect,
        },
        "wire": packets,
        "sample_bits": {
            "place": bits.place,
            "colour": bits.colour,
            "object": bits.object,
            "parameters": bits.parameters,
            "shares": bits.shares,
        },
        "cuts": outcome.cuts,
    })
}

fn write_pictures(dir: &std::path::Path, outcomes: &[Outcome], ideals: &mut Ideals) -> Result<()> {
    for outcome in outcomes {
        for frame in &outcome.keyframes {
            let name = format!("{}-{:04}.png", outcome.method.name(), frame.index);
            frame.shown.write_png(&dir.join(name))?;
        }
    }
    for frame in &outcomes[0].keyframes {
        let name = format!("ideal-{:04}.png", frame.index);
        ideal_picture(frame, ideals)?.write_png(&dir.join(name))?;
    }
    Ok(())
}

/// The ideal picture of a kept refresh.
///
/// # Errors
/// None: sizes agree.
pub fn ideal_picture(frame: &Keyframe, ideals: &mut Ideals) -> Result<Picture> {
    let pixels = ideals.at(frame.index, frame.time).to_vec();
    Ok(Picture::new(
        frame.shown.width(),
        frame.shown.height(),
        pixels,
    )?)
}

fn tell(args: &RunArgs, outcomes: &[Outcome]) {
    let main = &outcomes[0];
    println!(
        "{}: {} samples/s for {} s on {}x{} pixels, seed {}, display {}",
        args.source.scene,
        args.source.rate,
        args.source.seconds,
        args.source.size.width,
        args.source.size.height,
        args.source.seed,
        main.display,
    );
    println!(
        "{} refreshes, {} of them against the ideal; {} samples in {} bytes, {:.2} bytes a sample",
        main.hashes.len(),
        main.totals.refreshes,
        main.samples,
        main.stream_bytes,
        per_sample(main),
    );
    for outcome in outcomes {
        let totals = &outcome.totals;
        println!(
            "{:>20}  RMSE {:6.2} of 255   PSNR {:5.2} dB   FLIP {:.4}   worst RMSE {:6.2}",
            outcome.method.name(),
            totals.rmse,
            totals.psnr,
            totals.flip.unwrap_or(f64::NAN),
            totals.worst_rmse,
        );
    }
    println!("hash {}", run_hash(main));
    if let Some(dir) = &args.out {
        println!("pictures and plots: {}", dir.join("report.html").display());
    }
}
