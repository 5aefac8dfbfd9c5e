//! Every hard case on every back end: what must come of it, and the same bits everywhere.

use unframed_recon::frame_hash;
use unframed_sim::boards::{Board, Image};
use unframed_tests::backends::{adapter_or_skip, boards_or_skip};
use unframed_tests::cases::{self, Case, Expected, Room};

#[test]
fn each_case_shows_what_it_must() {
    let wrong = |case: &Case| {
        let wrong = case.judge(&case.show().fixed()).err()?;
        Some(format!("{}: {}: {wrong}", case.name, case.expected))
    };
    let all: Vec<_> = cases::all().iter().filter_map(wrong).collect();
    assert!(all.is_empty(), "{all:#?}");
}

#[test]
fn the_oracle_shows_it_too() {
    let mut all = Vec::new();
    for case in cases::all() {
        let outcome = case.show().here::<f64>();
        // Two streams that give the same integers may differ in the last bits of a float sum.
        if matches!(case.expected, Expected::SameAs(..)) {
            assert_eq!(outcome.counts, case.show().fixed().counts, "{}", case.name);
        } else if let Err(wrong) = case.judge(&outcome) {
            all.push(format!("{}: {}: {wrong}", case.name, case.expected));
        }
    }
    assert!(all.is_empty(), "{all:#?}");
}

#[test]
fn the_twin_shows_the_same_bits() {
    let Some(gpu) = adapter_or_skip("hard cases on the adapter") else {
        return;
    };
    for case in cases::all() {
        let here = case.show().fixed();
        let there = case.show().twin(&gpu).expect("the adapter has room");
        assert_eq!(there.hashes(), here.hashes(), "{}", case.name);
        assert_eq!(there.counts, here.counts, "{}", case.name);
    }
}

fn on_board(board: Board) {
    if !boards_or_skip(Image::Play, "hard cases on the boards") {
        return;
    }
    for case in cases::all().iter().filter(|case| case.room == Room::Boards) {
        let here = case.show().fixed();
        let report = case.show().board(board, Image::Play).expect(case.name);
        let hashes: Vec<_> = report.shown.iter().map(|shown| shown.hash).collect();
        assert_eq!(hashes, here.hashes(), "{} on {}", case.name, board.name());
        let counts = (report.taken, report.unplaced, report.refused);
        let expected = (
            here.counts.samples,
            here.counts.unplaced,
            here.counts.refused,
        );
        assert_eq!(counts, expected, "{} on {}", case.name, board.name());
        assert_eq!(
            Some(frame_hash(&report.picture)),
            hashes.last().copied(),
            "the picture written is not the one shown"
        );
        for shown in &report.shown {
            let (took, bound) = (shown.receive + shown.show, case.bound(report.taken));
            assert!(
                took <= bound,
                "{}: {took} instructions, at most {bound}",
                case.name
            );
        }
    }
}

#[test]
fn a_cortex_m4f_shows_the_same_bits() {
    on_board(Board::CortexM4F);
}

#[test]
fn a_cortex_m7_shows_the_same_bits() {
    on_board(Board::CortexM7);
}

#[test]
fn a_riscv_shows_the_same_bits() {
    on_board(Board::RiscV);
}

/// What judges must be able to fail.
#[test]
fn a_wrong_picture_is_judged_wrong() {
    for case in cases::all().iter().filter(|case| case.room == Room::Boards) {
        let mut outcome = case.show().fixed();
        let Some(last) = outcome.pictures.last_mut() else {
            panic!("{}: no refresh", case.name);
        };
        if case.expected == Expected::Lit {
            last.fill([0; 3]);
        } else {
            last[0] = [255, last[0][1] ^ 0x80, 255];
        }
        assert!(case.judge(&outcome).is_err(), "{}", case.name);
    }
}
