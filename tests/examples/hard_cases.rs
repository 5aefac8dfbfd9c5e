//! The table of hard cases in `docs/NUMERICS.md`:
//! `cargo run -p unframed-tests --example hard_cases`. Fails where a case fails.

use unframed_recon::frame_hash;
use unframed_sim::Gpu;
use unframed_sim::boards::{Board, Image};
use unframed_tests::accuracy::compare;
use unframed_tests::backends::Outcome;
use unframed_tests::cases::{self, Case, Room};

/// The back ends that show the same bits, and the most instructions that a refresh took.
fn equal_on(case: &Case, here: &Outcome, gpu: &Gpu) -> Result<(String, u64), String> {
    let failed = |name: &str| format!("{}: other pictures on {name}", case.name);
    let mut names = vec!["x86-64"];
    let twin = case.show().twin(gpu).map_err(|error| error.to_string())?;
    if twin != *here {
        return Err(failed("wgpu"));
    }
    names.push("wgpu");
    let mut most = 0;
    for board in Board::ALL.iter().filter(|_| case.room == Room::Boards) {
        let report = case
            .show()
            .board(*board, Image::Play)
            .map_err(|e| e.to_string())?;
        let hashes = report.shown.iter().map(|shown| shown.hash);
        if !hashes.eq(here.pictures.iter().map(|p| frame_hash(p))) {
            return Err(failed(board.name()));
        }
        let took = report.shown.iter().map(|shown| shown.receive + shown.show);
        most = took.fold(most, u64::max);
        names.push(board.name());
    }
    let names = if names.len() == 5 {
        "all five".to_owned()
    } else {
        names.join(", ")
    };
    Ok((names, most))
}

fn main() -> Result<(), String> {
    let gpu = Gpu::new().map_err(|error| error.to_string())?;
    println!(
        "| case | expected | panel, samples kept | worst against `f64` | where no decision flipped | beyond 1 level | most instructions a refresh | back ends, equal |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for case in cases::all() {
        let here = case.show().fixed();
        case.judge(&here)
            .map_err(|wrong| format!("{}: {wrong}", case.name))?;
        let found = compare(case.show().bytes, &case.show().setting());
        let reached = found.reached.iter().rposition(|n| *n > 0).unwrap_or(0);
        let alone = if found.others.iter().any(|n| *n > 0) {
            found.worst().to_string()
        } else {
            "–".to_owned()
        };
        let worst = reached.max(found.worst());
        let beyond = 1.0 - found.within(1) + found.flipped(1);
        let (names, most) = equal_on(&case, &here, &gpu)?;
        let most = if most > 0 {
            format!("{:.1} M", most as f64 / 1e6)
        } else {
            "–".to_owned()
        };
        println!(
            "| {} | {} | {} × {}, {} | {worst} | {alone} | {:.2} % | {most} | {names} |",
            case.name,
            case.expected,
            case.size.0,
            case.size.1,
            case.samples,
            100.0 * beyond
        );
    }
    Ok(())
}
