//! Cells, caches and claims on small scenes.

use std::path::Path;
use std::time::Instant;

use indicatif::ProgressBar;
use unframed_host::scene::builtin::builtin;
use unframed_host::trace::{World, ideal};
use unframed_metrics::PixelClass;

use super::checks::{Outcome, checks};
use super::ideals::classify;
use super::probes::{CUT_AT, Recovery};
use super::schedule::{Task, Workshop, cell_path, finished};
use super::store::{Key, slug, write_whole};
use super::table::{Found, csv, rows, verdicts};
use super::{Cache, Cell, EvalMethod, Job, Reference, Settings};
use crate::args::Size;
use crate::measure::IDEAL_GRID;

const SIZE: [u32; 2] = [48, 32];

fn world(name: &str) -> World {
    World::new(builtin(name).unwrap(), SIZE).unwrap()
}

fn settings() -> Settings {
    Settings {
        size: Size {
            width: 48,
            height: 32,
        },
        refreshes: 6,
        first: 0,
        samples: 4000,
        flip_every: 1,
        cvvdp: false,
        causes: true,
    }
}

fn job(method: EvalMethod) -> Job {
    let rate = if method.is_tenfold() {
        48 * 32 * 60
    } else {
        12_000
    };
    Job {
        scene: "toycar".to_owned(),
        scene_key: Key::of_scene(world("toycar").scene()).to_string(),
        method,
        rate,
        seed: 1,
        settings: settings(),
    }
}

fn references(root: &Path, world: &World) -> Vec<Reference> {
    let cache = Cache::new(root, "toycar", world, IDEAL_GRID).unwrap();
    (0..6)
        .map(|i| cache.reference(&mut world.clone(), i).unwrap())
        .collect()
}

fn run(dir: &Path, threads: usize, jobs: &[Job], world: &World, refs: &[Reference]) -> Vec<Cell> {
    let progress = ProgressBar::hidden();
    progress.set_length(jobs.len() as u64 * refs.len() as u64);
    let begin = Instant::now();
    let workshop = Workshop {
        dir,
        threads,
        build: "test",
        progress: &progress,
        begin,
    };
    let task = |job| Task {
        job,
        world,
        references: refs,
    };
    workshop
        .run(&jobs.iter().map(task).collect::<Vec<_>>())
        .unwrap()
}

/// Without what may differ from run to run.
fn timeless(cell: &Cell) -> Cell {
    Cell {
        seconds_host: 0.0,
        seconds_display: 0.0,
        spent: None,
        ..cell.clone()
    }
}

#[test]
fn every_method_runs_alike_on_any_number_of_workers_and_counts_its_samples() {
    let (one, three) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let world = world("toycar");
    let refs = references(one.path(), &world);
    let jobs: Vec<Job> = EvalMethod::all().map(job).collect();
    let alone = run(one.path(), 1, &jobs, &world, &refs);
    let together = run(three.path(), 3, &jobs, &world, &refs);
    for ((a, b), job) in alone.iter().zip(&together).zip(&jobs) {
        assert_eq!(timeless(a), timeless(b), "{}", job.method);
        assert_eq!(a.method, job.method.name());
        assert_eq!(a.refreshes.len(), 6);
        assert!(a.rmse > 0.5 && a.rmse < 255.0, "{}: {}", job.method, a.rmse);
        assert!(a.flip.unwrap() > 0.0);
        // Never more than the rate allows in six refreshes.
        assert!(
            a.samples <= u64::from(job.rate) / 10,
            "{}: {}",
            job.method,
            a.samples
        );
        if job.method != EvalMethod::FramedFull && job.method != EvalMethod::Framed60LowRes {
            // The paper's sampler pays for tests of occlusion too.
            let least = if job.method == EvalMethod::Paper {
                6
            } else {
                9
            };
            assert!(
                a.samples * 100 >= u64::from(job.rate) * least,
                "{}: {}",
                job.method,
                a.samples
            );
        }
        let errors: f64 = a.classes.iter().map(|c| c.error).sum();
        assert!((errors - 1.0).abs() < 1e-9);
        let streams = matches!(
            job.method.name(),
            "uniform" | "adaptive" | "uniform-same-display" | "paper"
        );
        assert!(
            !streams || a.stale.is_some_and(|s| s < 1.0),
            "{}: {:?}",
            job.method,
            a.stale
        );
        // What is on disk is what was measured.
        let stored: Cell =
            serde_json::from_slice(&std::fs::read(cell_path(one.path(), job)).unwrap()).unwrap();
        assert_eq!((&stored.method, stored.samples), (&a.method, a.samples));
        // Reading a number from JSON may be off by its last bit.
        assert!((stored.rmse - a.rmse).abs() < 1e-9 && stored.refreshes.len() == 6);
        assert_eq!(finished(one.path(), job).unwrap(), stored);
    }
}

#[test]
fn the_parts_of_reprojection_change_what_they_claim_to() {
    let dir = tempfile::tempdir().unwrap();
    let world = World::new(builtin("interactive").unwrap(), SIZE).unwrap();
    let cache = Cache::new(dir.path(), "interactive", &world, IDEAL_GRID).unwrap();
    // Long enough for the camera to have moved.
    let refs: Vec<Reference> = (0..45)
        .map(|i| cache.reference(&mut world.clone(), i).unwrap())
        .collect();
    let methods = [
        EvalMethod::Adaptive,
        EvalMethod::AdaptiveNoSamplerReprojection,
        EvalMethod::AdaptiveNoDisplayReprojection,
    ];
    let jobs = methods.map(|method| Job {
        scene: "interactive".to_owned(),
        settings: Settings {
            refreshes: 45,
            flip_every: 0,
            causes: false,
            ..settings()
        },
        ..job(method)
    });
    let cells = run(dir.path(), 2, &jobs, &world, &refs);
    let [whole, sampler, display] = [0, 1, 2].map(|i| cells[i].rmse);
    assert!(display > 1.1 * whole, "display: {display} against {whole}");
    assert!(sampler != whole, "the sampler did not notice");
}

#[test]
fn a_key_is_of_all_that_decides_the_result() {
    let base = job(EvalMethod::Taau);
    let mut stems = vec![base.file_stem()];
    let mut differ = |change: &dyn Fn(&mut Job)| {
        let mut other = base.clone();
        change(&mut other);
        stems.push(other.file_stem());
    };
    differ(&|j| j.rate += 1);
    differ(&|j| j.seed += 1);
    differ(&|j| j.method = EvalMethod::Uniform);
    differ(&|j| j.settings.refreshes += 1);
    differ(&|j| j.settings.samples += 1);
    differ(&|j| j.settings.size.width += 1);
    differ(&|j| j.settings.flip_every = 2);
    differ(&|j| j.settings.first += 1);
    differ(&|j| j.settings.cvvdp = true);
    differ(&|j| j.scene_key = "0".repeat(16));
    let count = stems.len();
    stems.sort();
    stems.dedup();
    assert_eq!(stems.len(), count);
    assert_eq!(base.file_stem(), job(EvalMethod::Taau).file_stem());

    let key = |change: &dyn Fn(&mut unframed_host::scene::Scene)| {
        let mut scene = builtin("toycar").unwrap();
        change(&mut scene);
        Key::of_scene(&scene).to_string()
    };
    let same = key(&|_| {});
    assert_eq!(same, key(&|_| {}));
    assert_ne!(same, key(&|scene| scene.duration += 1e-9));
    assert_ne!(same, key(&|scene| scene.materials[0].roughness += 1e-6));
    assert_eq!(slug("a/b c/Fox (1).glb"), "Fox__1_");
}

#[test]
fn ideals_are_computed_once_and_damaged_files_again() {
    let dir = tempfile::tempdir().unwrap();
    let world = world("toycar");
    let cache = Cache::new(dir.path(), "toycar", &world, IDEAL_GRID).unwrap();
    assert!(cache.stored(2).is_none());
    let made = cache.reference(&mut world.clone(), 2).unwrap();
    assert_eq!(cache.stored(2).as_ref(), Some(&made));
    assert!(made.image == ideal(&mut world.clone(), 3.0 / 60.0, IDEAL_GRID));
    // What is stored is taken for true: it is not made again.
    let path = cache.dir().join("ideal-00002.png");
    let other = crate::report::picture::png_bytes(48, 32, &[[7; 3]; 48 * 32]).unwrap();
    std::fs::write(&path, &other).unwrap();
    assert!(cache.reference(&mut world.clone(), 2).unwrap().image == [[7; 3]; 48 * 32]);
    // Unless it is not whole.
    std::fs::write(&path, &other[..other.len() / 2]).unwrap();
    assert_eq!(cache.reference(&mut world.clone(), 2).unwrap(), made);
    let codes = cache.dir().join("classes-00002.bin");
    std::fs::write(&codes, [9; 48 * 32]).unwrap();
    assert_eq!(cache.reference(&mut world.clone(), 2).unwrap(), made);
    // Another size is another directory.
    let large = World::new(builtin("toycar").unwrap(), [64, 32]).unwrap();
    assert_ne!(
        Cache::new(dir.path(), "toycar", &large, IDEAL_GRID)
            .unwrap()
            .dir(),
        cache.dir()
    );
}

#[test]
fn pixels_have_the_class_of_what_they_show() {
    let mut world = world("toycar");
    let time = 1.0;
    let image = ideal(&mut world, time, 2);
    let classes = classify(&mut world, time, &image);
    world.prepare(time, time);
    let count = |class| classes.iter().filter(|c| **c == class).count();
    // The camera of this scene stands still: only what the car hid can come to light.
    assert!(count(PixelClass::Moving) > 20);
    assert!(count(PixelClass::Disocclusion) < classes.len() / 8);
    assert!(count(PixelClass::Texture) + count(PixelClass::Flat) > classes.len() / 4);
    for (i, class) in classes.iter().enumerate() {
        let pixel = glam::Vec2::new((i % 48) as f32, (i / 48) as f32) + 0.5;
        let object = world.moment(time).look(pixel, i as u32).object;
        let moves = object != 0 && object != unframed_wire::SKY;
        assert!(*class != PixelClass::Moving || moves, "{pixel}");
    }
    // At time 0 there is no moment ago: nothing has moved, nothing was hidden.
    let image = ideal(&mut world, 0.0, 2);
    let classes = classify(&mut world, 0.0, &image);
    assert!(!classes.contains(&PixelClass::Moving));
    let hidden = classes
        .iter()
        .filter(|c| **c == PixelClass::Disocclusion)
        .count();
    assert!(hidden < 8, "{hidden}");
}

/// A cell of four refreshes around a cut, the second of them nine times as bad.
fn cell(method: EvalMethod, rate: u32, seed: u64, rmse: f64, flip: f64) -> Cell {
    Cell {
        scene: "a,b".to_owned(),
        method: method.name().to_owned(),
        setting: String::new(),
        rate,
        seed,
        rmse,
        psnr: None,
        flip: Some(flip),
        cvvdp: None,
        worst_rmse: 2.0 * rmse,
        worst_time: 0.0,
        p95_rmse: rmse,
        samples: 10,
        rays: 0,
        stream_bytes: 0,
        seconds_host: 1.0,
        seconds_display: 1.0,
        spent: None,
        cuts: vec![0.25],
        stale: None,
        classes: Vec::new(),
        refreshes: [(0.1, rmse), (0.3, 9.0 * rmse), (0.4, rmse), (0.5, rmse)]
            .map(|(time, rmse)| super::cell::Point {
                time,
                rmse,
                flip: None,
            })
            .to_vec(),
        build: String::new(),
    }
}

#[test]
fn claims_are_ratios_of_means_over_seeds() {
    let cells = [
        cell(EvalMethod::Adaptive, 400_000, 1, 4.0, 0.1),
        cell(EvalMethod::Adaptive, 400_000, 2, 6.0, 0.1),
        cell(EvalMethod::Uniform, 400_000, 1, 10.0, 0.2),
        cell(EvalMethod::Taau, 400_000, 1, 9.0, 0.05),
        cell(EvalMethod::Framed60Tenfold, 77, 1, 10.0, 0.2),
        cell(EvalMethod::Taau, 100_000, 1, 1.0, 0.3),
    ];
    let rows = rows(&cells);
    assert_eq!(rows.len(), 5);
    assert_eq!((rows[0].seeds, rows[0].rmse), (2, 5.0));
    assert_eq!(
        (rows[0].rmse_min, rows[0].rmse_max, rows[0].worst_rmse),
        (4.0, 6.0, 12.0)
    );
    assert_eq!(rows[0].recovery_ms.len(), 1);
    assert!((rows[0].recovery_ms[0] - 150.0).abs() < 1e-9);
    let found = verdicts(&rows);
    let of = |name: &str| found.iter().find(|v| v.against == name).unwrap();
    assert_eq!(found.len(), 3, "only what was measured");
    assert_eq!((of("uniform").ratio, of("uniform").holds), (0.5, true));
    assert_eq!((of("taau").ratio, of("taau").holds), (5.0 / 9.0, false));
    assert!(of("uniform").metrics_agree && !of("taau").metrics_agree);
    assert!(!of("framed60-10x").holds && of("framed60-10x").rate == 400_000);
    let text = csv(&rows);
    assert_eq!(text.lines().count(), 6);
    let columns = text.lines().next().unwrap().split(',').count();
    assert!(text.lines().skip(1).all(|l| l.starts_with("\"a,b\",")));
    assert!(
        text.lines()
            .skip(1)
            .all(|l| l.split(',').count() == columns + 1)
    );
}

#[test]
fn a_file_is_written_whole() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.json");
    write_whole(&path, b"one").unwrap();
    write_whole(&path, b"two").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"two");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    assert!(write_whole(&dir.path().join("no/x"), b"").is_err());
}

#[test]
fn a_cut_is_held_against_the_animation_the_second_and_the_same_refresh() {
    let over = |rmses: &[f64], rmse: f64| Cell {
        rmse,
        refreshes: (1..)
            .zip(rmses)
            .map(|(refresh, &rmse)| super::cell::Point {
                time: CUT_AT + 0.05 * f64::from(refresh),
                rmse,
                flip: None,
            })
            .collect(),
        ..cell(EvalMethod::Adaptive, 400_000, 1, rmse, 0.1)
    };
    let cut = over(&[30.0, 10.0, 9.0, 8.0, 5.0, 4.0, 3.0, 2.0, 2.0, 2.0], 10.0);
    let without = over(&[2.0; 10], 4.5);
    let animation = over(&[9.0; 4], 9.0);
    let near = |found: Option<f64>, ms: f64| found.is_some_and(|found| (found - ms).abs() < 1e-6);
    let found = Recovery::of(&[&cut], &[&without], &[&animation]).unwrap();
    assert!(near(found.of_animation, 100.0), "{found:?}");
    assert!(near(found.of_steady, 250.0), "{found:?}");
    assert!(near(found.of_same, 400.0), "{found:?}");
    assert_eq!((found.animation_rmse, found.holds), (Some(9.0), Some(true)));
    let late = over(&[30.0, 30.0, 30.0, 30.0, 10.0, 9.0, 9.0], 20.0);
    let found = Recovery::of(&[&late], &[&without], &[&animation]).unwrap();
    assert_eq!(found.holds, Some(false));
    let found = Recovery::of(&[&cut], &[&without], &[]).unwrap();
    assert_eq!((found.of_animation, found.holds), (None, None));
    let found = Found {
        cuts: vec![found],
        ..Found::default()
    };
    let outcomes: Vec<Outcome> = checks(&found).iter().map(|check| check.outcome).collect();
    assert_eq!(
        outcomes,
        [Outcome::Missed; 2],
        "nothing is promised of these"
    );
}
