//! What is to be done: scenes, and the cells on each.

use std::path::Path;

use anyhow::{Context, Result};
use unframed_host::scene::Scene;
use unframed_host::trace::World;

use super::cell::{Job, Settings};
use super::ideals::{Cache, Reference, instant};
use super::methods::EvalMethod;
use super::probes;
use crate::args::{EvalArgs, EvalTable};
use crate::measure::{IDEAL_GRID, REFRESH_HZ};

/// Supersamples along each axis of the one ideal image of a still scene: so many that its own
/// error is small beside what is promised.
const STILL_GRID: u32 = 16;
/// The rate at which parts are left out and questions asked, if it is among those asked for.
const USUAL_RATE: u32 = 400_000;

/// A scene with its cells.
pub struct Stage {
    /// Its name in reports.
    pub name: String,
    /// The scene itself.
    pub world: World,
    /// What should be seen.
    pub cache: Cache,
    /// What is to be done.
    pub jobs: Vec<Job>,
    /// Whether nothing in it moves, so that one ideal image is all.
    still: bool,
    /// Refreshes, and the first that counts.
    refreshes: u32,
    first: u32,
}

impl Stage {
    /// How many ideal images there are to be.
    #[must_use]
    pub fn ideals(&self) -> u32 {
        if self.still {
            1
        } else {
            self.refreshes - self.first
        }
    }

    /// What should be seen at each refresh that counts; computed where it is not stored.
    ///
    /// # Errors
    /// It cannot be stored.
    pub fn references(&self, tick: &dyn Fn()) -> Result<Vec<Reference>> {
        let mut world = self.world.clone();
        let mut references = Vec::new();
        for index in self.first..self.refreshes {
            let known: Option<&Reference> = references.first().filter(|_| self.still);
            let reference = match known {
                Some(known) => Reference {
                    time: instant(index),
                    ..known.clone()
                },
                None => {
                    let reference = self.cache.reference(&mut world, index)?;
                    tick();
                    reference
                }
            };
            references.push(reference);
        }
        Ok(references)
    }

    /// The stored ideal image of a refresh.
    #[must_use]
    pub fn ideal(&self, index: u32) -> Option<Vec<[u8; 3]>> {
        let index = if self.still { self.first } else { index };
        Some(self.cache.stored(index)?.image)
    }
}

/// The stages of an evaluation, in the order of its scenes.
///
/// # Errors
/// A scene cannot be opened or rendered; the directory of ideal images cannot be made.
pub fn stages(args: &EvalArgs, root: &Path) -> Result<Vec<Stage>> {
    let mut stages = Vec::new();
    let wants = |table| args.tables.contains(&table);
    for name in &args.scenes {
        let opened = unframed_host::scene::open::open(name, None)?;
        for warning in &opened.warnings {
            eprintln!("{name}: {warning}");
        }
        let scene = opened.scene;
        if wants(EvalTable::Main) || wants(EvalTable::Ablation) {
            let mut stage = stage(args, root, name.clone(), &scene, Kind::Whole)?;
            if wants(EvalTable::Main) {
                main_jobs(args, &mut stage);
            }
            if wants(EvalTable::Ablation) {
                ablation_jobs(args, &mut stage);
            }
            stages.push(stage);
        }
        if wants(EvalTable::Golden) {
            let seconds = probes::CUT_AT + probes::CUT_WATCHED;
            let still = probes::still(&scene, 0.0);
            stages.push(probe(args, root, still_name(name), &still, Kind::Still)?);
            // A cut in what stands still shows the same again.
            if scene.duration > 0.0 {
                let cut = probes::baked(&scene, seconds, Some(probes::CUT_AT));
                stages.push(probe(args, root, cut_name(name), &cut, Kind::Cut)?);
                let steady = probes::baked(&scene, seconds, None);
                stages.push(probe(args, root, steady_name(name), &steady, Kind::Cut)?);
            }
        }
    }
    Ok(stages)
}

/// The still scene made of another.
#[must_use]
pub fn still_name(scene: &str) -> String {
    format!("{}-still", super::store::slug(scene))
}

/// The scene with a cut made of another.
#[must_use]
pub fn cut_name(scene: &str) -> String {
    format!("{}-cut", super::store::slug(scene))
}

/// The same without the cut.
#[must_use]
pub fn steady_name(scene: &str) -> String {
    format!("{}-without-cut", super::store::slug(scene))
}

/// The rate at which parts are left out and questions asked.
#[must_use]
pub fn usual_rate(rates: &[u32]) -> u32 {
    let mut sorted = rates.to_vec();
    sorted.sort_unstable();
    let middle = sorted.get(sorted.len() / 2).copied();
    let usual = sorted.contains(&USUAL_RATE).then_some(USUAL_RATE);
    usual.or(middle).unwrap_or(USUAL_RATE)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Whole,
    Still,
    Cut,
}

fn refreshes(seconds: f64) -> u32 {
    (seconds * f64::from(REFRESH_HZ)).round().max(1.0) as u32
}

fn stage(args: &EvalArgs, root: &Path, name: String, scene: &Scene, kind: Kind) -> Result<Stage> {
    let size = [args.size.width, args.size.height].map(u32::from);
    let world = World::new(scene.clone(), size).with_context(|| format!("cannot render {name}"))?;
    let (grid, seconds, first) = match kind {
        Kind::Whole => (IDEAL_GRID, args.seconds.of(scene.duration), 0),
        Kind::Still => (STILL_GRID, probes::STILL_SECONDS, 0),
        Kind::Cut => {
            // Refresh k is that of (k + 1)/60 s.
            let before = (probes::CUT_AT * f64::from(REFRESH_HZ)).floor() as u32;
            (IDEAL_GRID, probes::CUT_AT + probes::CUT_WATCHED, before)
        }
    };
    Ok(Stage {
        cache: Cache::new(root, &name, &world, grid)?,
        name,
        world,
        jobs: Vec::new(),
        still: kind == Kind::Still,
        refreshes: refreshes(seconds),
        first,
    })
}

fn main_jobs(args: &EvalArgs, stage: &mut Stage) {
    let methods: Vec<EvalMethod> = if args.methods.is_empty() {
        EvalMethod::all().collect()
    } else {
        args.methods.clone()
    };
    for method in methods {
        for rate in &args.rates {
            add(args, stage, method, *rate);
        }
    }
}

fn ablation_jobs(args: &EvalArgs, stage: &mut Stage) {
    let rate = usual_rate(&args.rates);
    for method in [EvalMethod::Adaptive]
        .into_iter()
        .chain(EvalMethod::ablations())
    {
        add(args, stage, method, rate);
    }
}

/// A stage that asks one question, at one rate.
fn probe(args: &EvalArgs, root: &Path, name: String, scene: &Scene, kind: Kind) -> Result<Stage> {
    let mut stage = stage(args, root, name, scene, kind)?;
    let rate = usual_rate(&args.rates);
    let methods = if args.methods.is_empty() {
        vec![EvalMethod::Adaptive, EvalMethod::UniformSameDisplay]
    } else {
        args.methods.clone()
    };
    for method in methods {
        add(args, &mut stage, method, rate);
    }
    Ok(stage)
}

/// Adds the cells of a method at a rate, one a seed, unless they are there already.
fn add(args: &EvalArgs, stage: &mut Stage, method: EvalMethod, rate: u32) {
    let size = args.size;
    // A sample a pixel and refresh, whatever the rate asked for.
    let tenfold = u32::from(size.width) * u32::from(size.height) * REFRESH_HZ;
    let probes = stage.still || stage.first > 0;
    // What becomes of a still picture is asked once.
    let seeds = if stage.still {
        1
    } else {
        u64::from(args.seeds)
    };
    for seed in 1..=seeds {
        let seed = if method.is_random() { seed } else { 1 };
        let job = Job {
            scene: stage.name.clone(),
            scene_key: stage.cache.key().to_string(),
            method,
            rate: if method.is_tenfold() { tenfold } else { rate },
            seed,
            settings: Settings {
                size,
                refreshes: stage.refreshes,
                first: stage.first,
                samples: args.samples,
                flip_every: if probes { 0 } else { args.flip_every },
                // One seed's impression is enough: it takes as long as the display.
                cvvdp: !args.no_cvvdp && !probes && seed == 1,
                causes: args.causes && !probes,
            },
        };
        if !stage.jobs.contains(&job) {
            stage.jobs.push(job);
        }
    }
}
