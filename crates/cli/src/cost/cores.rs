//! Instructions of a display on small cores, counted on an emulator.
//!
//! Nothing is guessed: for each configuration an image plays two short drills on small panels, and
//! from their refreshes the [`Law`] of this configuration is found. Every picture must be, bit by
//! bit, the one whose [`Work`] was counted on this machine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use serde::Serialize;
use unframed_host::scene::Scene;
use unframed_host::trace::World;
use unframed_recon::{Config, frame_hash};
use unframed_sim::boards::{Board, BoardError, Firmware, Image, Job};

use super::effort::{Effort, Law, Work};
use super::forecast::Played;
use super::knobs::Knobs;
use super::stream::Stream;
use crate::args::Size;
use crate::eval::store::{Key, write_whole};
use crate::method::Method;

/// A core whose instructions can be counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Core {
    /// Arm Cortex-M4F.
    CortexM4,
    /// Arm Cortex-M7.
    CortexM7,
    /// A 32-bit RISC-V without an FPU.
    RiscV,
}

const CORES: [(&str, Core, Board); 3] = [
    ("cortex-m4", Core::CortexM4, Board::CortexM4F),
    ("cortex-m7", Core::CortexM7, Board::CortexM7),
    ("rv32imac", Core::RiscV, Board::RiscV),
];

impl Core {
    /// By name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let found = CORES.iter().find(|core| core.0 == name);
        found.map(|core| core.1)
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        let found = CORES.iter().find(|core| core.1 == self);
        found.map_or("", |core| core.0)
    }

    /// All names.
    #[must_use]
    pub fn names() -> String {
        CORES.map(|core| core.0).join(", ") + ", or `this` machine"
    }

    /// The emulated board that has it.
    #[must_use]
    pub fn board(self) -> Board {
        let found = CORES.iter().find(|core| core.1 == self);
        found.map_or(Board::CortexM7, |core| core.2)
    }
}

/// Panels (pixels a side) and densities of the drills: one where pixels count most and one where
/// samples do. The image has room for no more than 64 × 64 pixels.
const DRILLS: [(u16, f64); 3] = [(24, 24.0), (40, 16.0), (64, 1.5)];
/// Seconds of the stream that a drill's display remembers.
const MEMORY: f64 = 0.4;
/// Refreshes of a drill. The buffer fills meanwhile, so that each is another piece of work.
const REFRESHES: u32 = 36;
/// The first of these say little: nothing was shown before them.
const SKIPPED: usize = 3;
/// When a board counts as hung.
const TIMEOUT: Duration = Duration::from_secs(300);

/// A stream on a small panel.
struct Drill {
    size: Size,
    samples: usize,
    stream: Stream,
}

/// One core under emulation, and a scene for its drills.
pub struct Cores {
    core: Core,
    elf: PathBuf,
    scene: Scene,
    seed: u64,
    /// Where laws are kept, and what they depend on.
    dir: PathBuf,
    key: Key,
    drills: Mutex<BTreeMap<Method, std::sync::Arc<Vec<Drill>>>>,
}

impl Cores {
    /// Builds the image; the scene is that of the drills. Laws are kept in `dir`.
    ///
    /// # Errors
    /// [`BoardError::Missing`] where there is no compiler or emulator; the image does not build.
    pub fn new(core: Core, scene: &Scene, seed: u64, dir: &Path) -> Result<Self> {
        let here = std::env::current_dir().context("no current directory")?;
        let board = core.board();
        board.emulator_is_there()?;
        let elf = Firmware::find(&here)?.build(Image::Play, board.target())?;
        let image =
            std::fs::read(&elf).with_context(|| format!("cannot read {}", elf.display()))?;
        let key = Key::of_scene(scene).with(format_args!(
            "{} {DRILLS:?} {MEMORY} {REFRESHES} {seed} {}",
            Key::of_bytes(&image),
            board.name()
        ));
        Ok(Self {
            core,
            elf,
            scene: scene.clone(),
            seed,
            dir: dir.to_owned(),
            key,
            drills: Mutex::default(),
        })
    }

    /// Which core.
    #[must_use]
    pub fn core(&self) -> Core {
        self.core
    }

    /// What a display of this method and configuration costs here.
    ///
    /// # Errors
    /// The emulator fails, or shows another picture than this machine.
    pub fn law(&self, method: Method, config: Config) -> Result<Law> {
        let key = self.key.with(format_args!("{} {config}", method.name()));
        let path = self.dir.join(format!("law-{key}.json"));
        let kept = std::fs::read(&path).ok();
        if let Some(law) = kept.and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            return Ok(law);
        }
        let mut counted = Vec::new();
        for drill in self.drills(method)?.iter() {
            let refreshes = self.count(drill.size, drill.samples, config, &drill.stream)?;
            counted.extend(refreshes.into_iter().skip(SKIPPED));
        }
        let law = Law::fit(&counted).context("the drills have too few refreshes")?;
        write_whole(&path, &serde_json::to_vec_pretty(&law)?)?;
        Ok(law)
    }

    /// Plays a stream for at most 64 × 64 pixels here and on the core: what each refresh had to do,
    /// and what it took.
    ///
    /// # Errors
    /// The emulator fails, or shows another picture than this machine.
    pub fn count(
        &self,
        size: Size,
        samples: usize,
        config: Config,
        stream: &Stream,
    ) -> Result<Vec<(Work, Effort)>> {
        let played = Played::new(config, size, samples, stream)?;
        let bytes = stream.refreshes.concat();
        let job = Job {
            stream: &bytes,
            method: &config.to_string(),
            samples,
            timeout: TIMEOUT,
        };
        let board = self.core.board();
        let report = board.run(&self.elf, &job)?;
        let here: Vec<u64> = played.pictures.iter().map(|p| frame_hash(p)).collect();
        let there: Vec<u64> = report.shown.iter().map(|shown| shown.hash).collect();
        ensure!(
            here == there,
            "{} does not show what this machine shows of `{config}`",
            board.name()
        );
        let efforts = report.shown.iter().map(|shown| Effort {
            receive: shown.receive as f64,
            picture: shown.show as f64,
        });
        Ok(played.work.into_iter().zip(efforts).collect())
    }

    fn drills(&self, method: Method) -> Result<std::sync::Arc<Vec<Drill>>> {
        let mut all = self.drills.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(drills) = all.get(&method) {
            return Ok(drills.clone());
        }
        let record = |(side, density): (u16, f64)| {
            let size = Size {
                width: side,
                height: side,
            };
            let knobs = Knobs {
                memory: MEMORY,
                ..Knobs::new(method, density)
            };
            let world = World::new(self.scene.clone(), [u32::from(side); 2])?;
            Ok(Drill {
                size,
                samples: knobs.samples(u32::from(side).pow(2)) as usize,
                stream: Stream::record(&knobs, size, self.seed, &world, REFRESHES, 0)?,
            })
        };
        let drills: Vec<Drill> = DRILLS.into_iter().map(record).collect::<Result<_>>()?;
        Ok(all.entry(method).or_insert(drills.into()).clone())
    }
}

/// The core where it can be emulated, else `None` after a line that says what is missing. In CI
/// what is missing is an error.
///
/// # Errors
/// The image does not build; in CI also a tool that is missing.
pub fn or_say(core: Core, scene: &Scene, seed: u64, dir: &Path) -> Result<Option<Cores>> {
    match Cores::new(core, scene, seed, dir) {
        Ok(cores) => Ok(Some(cores)),
        Err(error) => match error.downcast_ref::<BoardError>() {
            Some(BoardError::Missing { .. }) if std::env::var_os("CI").is_none() => {
                eprintln!("instructions of a {} are not counted: {error}", core.name());
                Ok(None)
            }
            _ => Err(error),
        },
    }
}
