//! `unframed firmware`: the display on microcontrollers, emulated.

use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};
use unframed_recon::Config;
use unframed_recon::config::NAMED;
use unframed_sim::boards::elf::Contents;
use unframed_sim::boards::{Board, Firmware, Image, Job, Report, Target};
use unframed_wire::{Packet, Receiver};

use super::read_stream;
use crate::args::{BoardKind, FirmwareArgs, FirmwareCommand, FirmwareRunArgs};

/// When a board counts as hung.
const TIMEOUT: Duration = Duration::from_secs(600);

/// Builds, runs or looks into the images.
///
/// # Errors
/// A tool is missing, an image does not build or does not do its job, or holds what it must not.
pub fn firmware(command: &FirmwareCommand) -> Result<()> {
    let here = std::env::current_dir().context("no current directory")?;
    let source = Firmware::find(&here)?;
    match command {
        FirmwareCommand::Build(args) => build(&source, args),
        FirmwareCommand::Run(args) => run(&source, args),
        FirmwareCommand::Size(args) => size(&source, args),
    }
}

fn images() -> impl Iterator<Item = (Image, Target)> {
    Target::ALL
        .into_iter()
        .flat_map(|target| Image::ALL.map(|image| (image, target)))
}

fn build(source: &Firmware, args: &FirmwareArgs) -> Result<()> {
    let mut files = Vec::new();
    for (image, target) in images() {
        eprintln!("building {} for {}", image.name(), target.triple());
        let elf = source.build(image, target)?;
        if !args.json {
            println!("{}", elf.display());
        }
        files.push(elf.display().to_string());
    }
    if args.json {
        println!("{}", json!({ "files": files }));
    }
    Ok(())
}

/// The three things that deployed code must not hold.
fn blemishes(contents: &Contents) -> [(&'static str, &[String]); 3] {
    [
        ("panics", &contents.panics),
        ("allocators", &contents.allocators),
        ("floats", &contents.floats),
    ]
}

fn size(source: &Firmware, args: &FirmwareArgs) -> Result<()> {
    let mut rows = Vec::new();
    let mut wrong = Vec::new();
    if !args.json {
        println!(
            "| image | target | code | constants | flash | RAM | panics | allocators | floats |"
        );
        println!("|---|---|---|---|---|---|---|---|---|");
    }
    for (image, target) in images() {
        let contents = Contents::of(&source.build(image, target)?)?;
        let [panics, allocators, floats] = blemishes(&contents).map(|(_, found)| found.len());
        let (name, triple) = (image.name(), target.triple());
        if image == Image::Play {
            for (what, found) in blemishes(&contents) {
                if let Some(first) = found.first() {
                    wrong.push(format!("{name} for {triple} holds {what}: {first}"));
                }
            }
        }
        let (code, constants) = (contents.code, contents.constants);
        let (flash, ram) = (contents.flash(), contents.ram());
        if !args.json {
            println!(
                "| {name} | {triple} | {code} | {constants} | {flash} | {ram} | {panics} | {allocators} | {floats} |"
            );
        }
        rows.push(json!({
            "image": name, "target": triple, "code": code, "constants": constants,
            "flash": flash, "ram": ram, "panics": panics, "allocators": allocators,
            "floats": floats,
        }));
    }
    if args.json {
        println!("{}", json!({ "images": rows }));
    }
    ensure!(wrong.is_empty(), "{}", wrong.join("; "));
    Ok(())
}

/// Instructions of a refresh as a line over the samples remembered: what it costs anyway, and each
/// sample. From the refreshes with fewest and most samples; `None` where these are equally many.
fn line(report: &Report) -> Option<(f64, f64)> {
    let least = report.shown.iter().min_by_key(|shown| shown.samples)?;
    let most = report
        .shown
        .iter()
        .max_by_key(|shown| (shown.samples, shown.index))?;
    let samples = most.samples.checked_sub(least.samples).filter(|n| *n > 0)?;
    let slope = (most.show as f64 - least.show as f64) / samples as f64;
    Some((least.show as f64 - slope * least.samples as f64, slope))
}

/// Whether a stream's samples leave shadows to the display.
fn has_lamps(mut stream: &[u8]) -> bool {
    let mut receiver = Receiver::new();
    while let Some(packet) = receiver.push(&mut stream) {
        if let Packet::Hello(hello) = packet {
            return hello.lamps > 0;
        }
    }
    false
}

fn run(source: &Firmware, args: &FirmwareRunArgs) -> Result<()> {
    let method = &args.method;
    if Config::parse(method.as_bytes()).is_none() {
        let known: Vec<_> = NAMED.iter().map(|(name, _)| *name).collect();
        bail!(
            "no method `{method}`: choose one of {}, and say after commas what differs, as in \
             adaptive,fit=mean,hidden=off",
            known.join(", ")
        );
    }
    let stream = read_stream(&args.file)?;
    ensure!(
        !has_lamps(&stream),
        "{}: its samples leave shadows to the display, and the images draw none; record it again \
         with --no-lamps",
        args.file.display()
    );
    let job = Job {
        stream: &stream,
        method,
        samples: args.samples as usize,
        timeout: TIMEOUT,
    };
    let image = if args.f32 {
        Image::PlayF32
    } else {
        Image::Play
    };
    let mut rows = Vec::new();
    if !args.hashes && !args.json {
        println!(
            "| board | image | receive, a sample | show, a refresh at most | = anyway | + a sample | stack | last picture |"
        );
        println!("|---|---|---|---|---|---|---|---|");
    }
    for board in boards(args.board) {
        let elf = source.build(image, board.target())?;
        let report = board.run(&elf, &job)?;
        let (name, last) = (board.name(), report.shown.last());
        let received: u64 = report.shown.iter().map(|shown| shown.receive).sum();
        let a_sample = received as f64 / report.taken.max(1) as f64;
        let most = report
            .shown
            .iter()
            .map(|shown| shown.show)
            .max()
            .unwrap_or(0);
        let hash = format!("{:016x}", last.map_or(0, |shown| shown.hash));
        let (anyway, each) = line(&report).unwrap_or((most as f64, 0.0));
        if args.hashes {
            for shown in &report.shown {
                let (index, hash) = (shown.index, shown.hash);
                println!(
                    "{name} {index} {hash:016x} {} {}",
                    shown.receive, shown.show
                );
            }
        } else if !args.json {
            println!(
                "| {name} | {} | {a_sample:.0} | {most} | {anyway:.0} | {each:.0} | {} | {hash} |",
                image.name(),
                report.stack
            );
        }
        let refreshes: Vec<Value> = report
            .shown
            .iter()
            .map(|shown| {
                json!({
                    "index": shown.index, "hash": format!("{:016x}", shown.hash),
                    "receive": shown.receive, "show": shown.show, "samples": shown.samples,
                })
            })
            .collect();
        rows.push(json!({
            "board": name, "image": image.name(), "samples": report.taken,
            "instructions_per_sample_received": a_sample, "instructions_per_refresh": most,
            "stack": report.stack, "lost": report.lost, "damaged": report.damaged,
            "refreshes": refreshes,
        }));
    }
    if args.json {
        println!("{}", json!({ "method": method, "boards": rows }));
    }
    Ok(())
}

fn boards(kind: BoardKind) -> Vec<Board> {
    match kind {
        BoardKind::All => Board::ALL.to_vec(),
        BoardKind::CortexM4f => vec![Board::CortexM4F],
        BoardKind::CortexM7 => vec![Board::CortexM7],
        BoardKind::Rv32imac => vec![Board::RiscV],
    }
}
