//! What `unframed cost --budget` promises, against what a board then counts: on the budget's own
//! panel, in an image made for it, with samples of another seed than those the promise was made
//! from.

use std::path::Path;
use std::time::Duration;

use crate::common::succeed;
use serde_json::Value;
use unframed_cli::args::Size;
use unframed_cli::cost::budget::Budget;
use unframed_cli::cost::cores::{Core, or_say};
use unframed_cli::cost::knobs::{Knobs, PRESETS};
use unframed_cli::cost::ram::STACK;
use unframed_cli::cost::stream::Stream;
use unframed_cli::eval::probes::still;
use unframed_host::scene::Scene;
use unframed_host::scene::builtin::builtin;
use unframed_host::trace::World;
use unframed_sim::boards::elf::Contents;
use unframed_sim::boards::{Firmware, Fitted, Job, Report, Shown};

/// How far instructions may be off, as a share.
const TOLERANCE: f64 = 0.05;
/// Seconds that count, and refreshes: before them half a second fills the display.
const SECONDS: f64 = 0.2;
const FIRST: usize = 30;
const REFRESHES: u32 = 42;
/// `unframed cost` takes 1 if not told.
const OTHER_SEED: u64 = 77;

/// What the command answers that may choose of these presets: its report's budget.
fn ask(scene: &str, presets: &str, budget: &str, out: &Path) -> Value {
    let json = out.join("numbers.json");
    let seconds = SECONDS.to_string();
    let (dir, file) = (out.to_str().unwrap(), json.to_str().unwrap());
    let small = ["cost", scene, "--preset", presets, "--size", "32x32"];
    let more = [
        "--seconds",
        &seconds,
        "--budget",
        budget,
        "--out",
        dir,
        "--json",
        file,
    ];
    succeed(small.iter().chain(&more));
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    report["budgets"][0].clone()
}

/// The preset on a board: an image of just its size, a stream of the other seed.
fn play(scene: &str, budget: &Budget, knobs: &Knobs) -> (Report, u64) {
    let (width, height) = (budget.width, budget.height);
    let scene = builtin(scene).expect("a built-in scene");
    let world = World::new(scene, [width, height].map(u32::from)).expect("a sound scene");
    let pixels = u32::from(width) * u32::from(height);
    let samples = knobs.samples(pixels) as usize;
    let size = Size { width, height };
    let stream = Stream::record(knobs, size, OTHER_SEED, &world, REFRESHES, 0);
    let bytes = stream.expect("a sound stream").refreshes.concat();
    let board = budget.core.expect("a core").board();
    let fitted = Fitted {
        width,
        height,
        samples,
        slots: world.object_count() + 1,
        config: knobs.display,
    };
    let source = Firmware::find(Path::new(env!("CARGO_MANIFEST_DIR"))).expect("the source");
    let elf = source.build_fitted(board.target(), &fitted);
    let elf = elf.expect("it builds");
    let job = Job {
        stream: &bytes,
        method: &knobs.display.to_string(),
        samples,
        timeout: Duration::from_secs(300),
    };
    let report = board.run(&elf, &job).expect("the board works");
    let ram = Contents::of(&elf).expect("an ELF file").ram() + STACK;
    (report, ram)
}

#[test]
fn what_the_solver_promises_a_board_counts() {
    // Each asks for as much as its answer just about takes: RAM, time and the link bind in turn.
    const USUAL: &str = "small,low,medium";
    for (scene, presets, budget, binds) in [
        (
            "interactive",
            USUAL,
            "cortex-m7@2GHz link=20Mbit/s ram=600KiB 72x56@60Hz",
            "RAM",
        ),
        (
            "walkthrough",
            USUAL,
            "cortex-m4@500MHz ram=4MiB 96x40@60Hz",
            "time",
        ),
        (
            "toycar",
            USUAL,
            "rv32imac@9GHz link=1.1Mbit/s 60x80@60Hz",
            "link",
        ),
        // Samples that count for their pixels alone, in an image with no room for more.
        (
            "interactive",
            "tiny,small",
            "cortex-m7@180MHz ram=256KiB 64x64@60Hz",
            "time",
        ),
    ] {
        let out = tempfile::tempdir().expect("a directory");
        let answer = ask(scene, presets, budget, out.path());
        let budget: Budget = budget.parse().expect("a budget");
        if answer["all"][0][0]["mean"].is_null() && std::env::var_os("CI").is_none() {
            eprintln!("SKIPPED, not tested: the promises on {scene}: no emulator or compiler");
            continue;
        }
        let preset = &answer["preset"];
        let name = preset["preset"].as_str().expect("something fits");
        let missing = answer["binds"]["of"].to_string();
        assert!(missing.contains(binds), "{scene}: {name}, then {missing}");
        let preset_knobs = PRESETS
            .iter()
            .find(|p| p.name == name)
            .expect("a preset")
            .knobs();
        let (report, ram) = play(scene, &budget, &preset_knobs);
        assert_eq!(preset["ram_bytes"].as_u64(), Some(ram), "{scene}: RAM");
        let counted = &report.shown[FIRST..];
        let instructions = |what: &str| {
            let part = |part: &str| preset[what][part].as_f64().expect("instructions");
            part("picture") + part("receive")
        };
        let counted = counted
            .iter()
            .map(|shown: &Shown| shown.show + shown.receive);
        let mean = counted.clone().sum::<u64>() as f64 / counted.len() as f64;
        let most = counted.max().expect("refreshes") as f64;
        // The dearest refresh is one alone, and another seed's: it may be off by twice as much.
        for (what, counted, tolerance) in
            [("mean", mean, TOLERANCE), ("worst", most, 2.0 * TOLERANCE)]
        {
            let promised = instructions(what);
            let off = promised / counted - 1.0;
            println!(
                "{scene}, {name}: {what} refresh {promised:.0} promised, {counted:.0} counted, \
                 {:+.2} %",
                100.0 * off
            );
            assert!(
                off.abs() <= tolerance,
                "{scene}, {name}: {what} off by {off}"
            );
        }
    }
}

/// At rest a refresh costs what is new, however much is remembered; in motion it costs what is
/// remembered.
#[test]
fn at_rest_cost_does_not_grow_with_what_is_remembered() {
    let dir = tempfile::tempdir().unwrap();
    let scene = builtin("interactive").expect("a built-in scene");
    let Some(cores) = or_say(Core::CortexM4, &scene, 1, dir.path()).expect("a working emulator")
    else {
        return;
    };
    let preset = PRESETS
        .iter()
        .find(|p| p.name == "medium")
        .expect("it is there");
    let knobs = Knobs {
        density: 8.0,
        ..preset.knobs()
    };
    let size = Size {
        width: 32,
        height: 32,
    };
    let count = |scene: &Scene, samples: usize| {
        let world = World::new(scene.clone(), [32, 32]).expect("a sound scene");
        let stream = Stream::record(&knobs, size, 1, &world, 70, 0).expect("a sound stream");
        let counted = cores.count(size, samples, knobs.display, &stream);
        counted
            .expect("it counts")
            .last()
            .expect("refreshes")
            .1
            .picture
    };
    let resting = still(&scene, 0.0);
    let (few, many) = (count(&resting, 1024), count(&resting, 8192));
    assert!((many / few - 1.0).abs() < 0.02, "at rest: {few} and {many}");
    let (few, many) = (count(&scene, 1024), count(&scene, 8192));
    assert!(many > 2.0 * few, "in motion: {few} and {many}");
}
