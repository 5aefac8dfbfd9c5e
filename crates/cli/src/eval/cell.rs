//! One method on one scene at one rate with one seed.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use unframed_host::drive::{Host, Spent};
use unframed_host::framed::Framed;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::World;
use unframed_metrics::{
    ErrorShares, Image, PixelClass, Sequence, SequenceOptions, SquaredError, Totals,
};
use unframed_recon::Fixed;

use super::ideals::{Reference, instant};
use super::methods::{EvalMethod, Setting, Way};
use super::rays;
use super::store::{Key, slug, write_whole};
use crate::args::{DisplayKind, Size};
use crate::measure::REFRESH_HZ;
use crate::panel::{Order, with_panel};
use crate::replica::Replica;
use crate::report::Picture;
use crate::work::Stopwatch;

/// Raise this when what a cell means changes: old files are not used any more.
const VERSION: u32 = 2;

/// What all cells of an evaluation share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Panel size, pixels.
    pub size: Size,
    /// Refreshes, all of which count from `first` on.
    pub refreshes: u32,
    /// The first refresh that counts: 0 but where only what follows a cut is of interest.
    pub first: u32,
    /// Samples that a display remembers.
    pub samples: u32,
    /// Measure ꟻLIP at every so many refreshes; 0 never.
    pub flip_every: u32,
    /// Measure ColorVideoVDP.
    pub cvvdp: bool,
    /// Find out how much of the error is age.
    pub causes: bool,
}

impl Settings {
    /// The refreshes whose pictures are kept: three, spread evenly.
    #[must_use]
    pub fn kept(&self) -> Vec<u32> {
        let counted = self.refreshes.saturating_sub(self.first);
        let mut kept: Vec<u32> = [1, 3, 5].map(|k| self.first + counted * k / 6).to_vec();
        kept.dedup();
        kept
    }
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    /// The scene as typed.
    pub scene: String,
    /// Key of the references that it is compared with.
    pub scene_key: String,
    /// The method.
    pub method: EvalMethod,
    /// Camera samples a second.
    pub rate: u32,
    /// Seed of everything random.
    pub seed: u64,
    /// What all cells share.
    pub settings: Settings,
}

impl Job {
    /// The name of its files: what a reader wants to know, and the key of all that decides the
    /// result, the method's own settings included.
    #[must_use]
    pub fn file_stem(&self) -> String {
        let key = Key::default().with(format_args!(
            "{VERSION} {} {} {} {:?} {REFRESH_HZ}",
            self.scene_key, self.rate, self.seed, self.settings,
        ));
        let key = key.with(format_args!("{}", self.method.fingerprint()));
        format!(
            "{}-{}-{}-{}-{key}",
            slug(&self.scene),
            self.method,
            self.rate,
            self.seed
        )
    }
}

/// A class's part of the error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassShare {
    /// Its name.
    pub class: String,
    /// Share of all squared error, 0..=1.
    pub error: f64,
    /// Share of all pixels, 0..=1.
    pub area: f64,
}

/// Seconds on one core, by what they were spent on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spending {
    /// Posing the scene.
    pub scene: f64,
    /// Rays and shading.
    pub tracing: f64,
    /// Moving the sampler's memory.
    pub reprojection: f64,
    /// Deciding and learning.
    pub control: f64,
    /// Quantising and packing.
    pub stream: f64,
}

impl Spending {
    /// Each with its name.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, f64); 5] {
        [
            ("tracing", self.tracing),
            ("reprojection", self.reprojection),
            ("control", self.control),
            ("stream", self.stream),
            ("scene", self.scene),
        ]
    }

    /// Reprojection and control as a share of all, 0..=1.
    #[must_use]
    pub fn overhead(&self) -> f64 {
        let all: f64 = self.parts().iter().map(|part| part.1).sum();
        (self.reprojection + self.control) / all.max(1e-12)
    }
}

impl From<Spent> for Spending {
    fn from(spent: Spent) -> Self {
        let Spent {
            scene,
            tracing,
            reprojection,
            control,
            stream,
        } = spent;
        Self {
            scene,
            tracing,
            reprojection,
            control,
            stream,
        }
    }
}

/// A refresh's numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Its instant, seconds.
    pub time: f64,
    /// Against the ideal image, 0..=255.
    pub rmse: f64,
    /// The same by ꟻLIP, 0..=1.
    pub flip: Option<f64>,
}

/// What was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// The scene as typed.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// The setting that did best, where the method has several.
    pub setting: String,
    /// Camera samples a second.
    pub rate: u32,
    /// Seed of everything random.
    pub seed: u64,
    /// Root of the mean of squares over all refreshes, pixels and R, G, B of displayed sRGB
    /// values, 0..=255.
    pub rmse: f64,
    /// Of that, dB; none where nothing differs.
    pub psnr: Option<f64>,
    /// Mean ꟻLIP of the refreshes at which it was measured.
    pub flip: Option<f64>,
    /// ColorVideoVDP over the whole, JOD, at most 10; of the first seed alone.
    pub cvvdp: Option<f64>,
    /// The worst refresh's.
    pub worst_rmse: f64,
    /// When that was, seconds.
    pub worst_time: f64,
    /// What 95 % of the refreshes do not exceed.
    pub p95_rmse: f64,
    /// Camera samples taken.
    pub samples: u64,
    /// Rays of all kinds; 0 of what has no stream.
    #[serde(default)]
    pub rays: u64,
    /// Bytes of the stream; 0 of what has none.
    pub stream_bytes: u64,
    /// Seconds on one core that the renderer took.
    pub seconds_host: f64,
    /// Seconds on one core that the display took.
    pub seconds_display: f64,
    /// Where the renderer's seconds went; none of what has no stream.
    pub spent: Option<Spending>,
    /// Instants at which the host announced a cut, seconds.
    pub cuts: Vec<f64>,
    /// Share of the squared error that would vanish if every stored sample were of the refresh
    /// instant, if it was asked for and there is a stream of places; at the kept refreshes.
    pub stale: Option<f64>,
    /// The error by class of pixel.
    pub classes: Vec<ClassShare>,
    /// Each refresh.
    pub refreshes: Vec<Point>,
    /// Which program measured it.
    pub build: String,
}

/// Runs a job, and writes the pictures that are kept beside `stem`. The best setting counts.
///
/// # Errors
/// When a display or a metric fails, or pictures cannot be written.
pub fn run(
    job: &Job,
    world: &World,
    references: &[Reference],
    stem: &Path,
    build: &str,
    tick: &(dyn Fn() + Sync),
) -> Result<Cell> {
    let mut best: Option<(Cell, Vec<(u32, Picture)>)> = None;
    for setting in job.method.settings() {
        let mut run = Run::new(job, references, tick)?;
        match job.method.way(world, job.rate, job.seed, setting) {
            Way::Frames(mut framed) => run.frames(framed.as_mut())?,
            way @ Way::Stream { .. } => {
                let rate = rays::rate(job, world, setting)?;
                run.stream(world, way, rate)?;
            }
        }
        let (cell, pictures) = run.finish(setting, build)?;
        if best
            .as_ref()
            .is_none_or(|(known, _)| cell.rmse < known.rmse)
        {
            best = Some((cell, pictures));
        }
    }
    let (cell, pictures) = best.context("a method has at least one setting")?;
    for (index, picture) in pictures {
        write_whole(&picture_path(stem, index), &picture.png()?)?;
    }
    Ok(cell)
}

/// Where the picture of a kept refresh is.
#[must_use]
pub fn picture_path(stem: &Path, index: u32) -> std::path::PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(format!("-{index:05}.png"));
    name.into()
}

/// A job under way.
struct Run<'a> {
    job: &'a Job,
    references: &'a [Reference],
    tick: &'a (dyn Fn() + Sync),
    kept: Vec<u32>,
    sequence: Sequence,
    shares: ErrorShares,
    pictures: Vec<(u32, Picture)>,
    samples: u64,
    rays: u64,
    stream_bytes: u64,
    seconds_host: f64,
    seconds_display: f64,
    spent: Option<Spending>,
    cuts: Vec<f64>,
    /// Squared errors as shown and without age.
    causes: Option<(u64, u64)>,
}

impl<'a> Run<'a> {
    fn new(job: &'a Job, references: &'a [Reference], tick: &'a (dyn Fn() + Sync)) -> Result<Self> {
        let settings = &job.settings;
        let options = SequenceOptions {
            flip_every: settings.flip_every as usize,
            video: settings.cvvdp,
            refresh_rate: REFRESH_HZ as f32,
            ..SequenceOptions::default()
        };
        let (width, height) = (settings.size.width, settings.size.height);
        Ok(Self {
            job,
            references,
            tick,
            kept: settings.kept(),
            sequence: Sequence::new(width.into(), height.into(), options)?,
            shares: ErrorShares::default(),
            pictures: Vec::new(),
            samples: 0,
            rays: 0,
            stream_bytes: 0,
            seconds_host: 0.0,
            seconds_display: 0.0,
            spent: None,
            cuts: Vec::new(),
            causes: None,
        })
    }

    fn image<'p>(&self, pixels: &'p [[u8; 3]]) -> Result<Image<'p>> {
        let size = self.job.settings.size;
        Ok(Image::new(pixels, size.width.into(), size.height.into())?)
    }

    /// Takes the picture of a refresh.
    fn score(&mut self, index: u32, shown: &[[u8; 3]]) -> Result<()> {
        (self.tick)();
        let Some(reference) = self.reference(index) else {
            return Ok(());
        };
        self.sequence
            .push(&reference.image, shown, reference.time)?;
        let (ideal, image) = (self.image(&reference.image)?, self.image(shown)?);
        self.shares.push(ideal, image, &reference.classes)?;
        if self.kept.contains(&index) {
            let picture = Picture::new(image.width(), image.height(), shown.to_vec())?;
            self.pictures.push((index, picture));
        }
        Ok(())
    }

    /// What should be seen at a refresh; none before the first that counts.
    fn reference(&self, index: u32) -> Option<&'a Reference> {
        let counted = index.checked_sub(self.job.settings.first)?;
        self.references.get(counted as usize)
    }

    fn frames(&mut self, framed: &mut dyn Framed) -> Result<()> {
        for index in 0..self.job.settings.refreshes {
            let clock = Stopwatch::start();
            framed.show(instant(index));
            self.seconds_host += clock.seconds();
            self.score(index, framed.picture())?;
        }
        self.samples = framed.samples();
        Ok(())
    }

    fn stream(&mut self, world: &World, way: Way, rate: u32) -> Result<()> {
        let Way::Stream {
            sampler,
            layout,
            tile_fields,
            display,
        } = way
        else {
            return Ok(());
        };
        let job = self.job;
        let promise = Promise {
            layout,
            lamps: true,
            tile_fields,
            rate,
            refresh_millihertz: REFRESH_HZ * 1000,
        };
        let order = Order {
            kind: DisplayKind::Cpu,
            config: display,
            width: job.settings.size.width,
            height: job.settings.size.height,
            samples: job.settings.samples,
            // Cells run side by side already.
            threads: 1,
        };
        let mut host = Host::new(world.clone(), sampler, promise);
        let reprojects = display.reproject && layout == unframed_wire::Layout::World;
        let mut replica = (job.settings.causes && reprojects)
            .then(|| Replica::new(order.width, order.height, order.samples as usize));
        with_panel(&order, |panel, _| {
            let mut bytes = Vec::new();
            for index in 0..self.job.settings.refreshes {
                bytes.clear();
                let clock = Stopwatch::start();
                let step = host.advance(&mut bytes)?;
                self.seconds_host += clock.seconds();
                self.rays += u64::from(step.rays.total());
                if step.cut {
                    self.cuts.push(step.time);
                }
                let clock = Stopwatch::start();
                let mut input = &bytes[..];
                while panel.push(&mut input)?.is_some() {}
                self.seconds_display += clock.seconds();
                self.score(index, panel.picture())?;
                if let Some(replica) = &mut replica {
                    replica.receive(&bytes);
                    if self.kept.contains(&index) {
                        let colours = replica.fresh_colours(world, step.time)?;
                        let fresh = replica.picture::<Fixed>(display, &colours)?;
                        self.compare_with_fresh(index, panel.picture(), &fresh)?;
                    }
                }
            }
            bytes.clear();
            host.end(&mut bytes)?;
            panel.push(&mut &bytes[..])?;
            let link = panel.link();
            ensure!(
                link.lost == 0 && link.damaged == 0,
                "the display lost {} packets and found {} damaged on a perfect link",
                link.lost,
                link.damaged
            );
            Ok(())
        })?;
        self.spent = Some(host.spent().into());
        self.samples = host.ledger().samples;
        self.stream_bytes = host.ledger().total_bytes();
        Ok(())
    }

    fn compare_with_fresh(
        &mut self,
        index: u32,
        shown: &[[u8; 3]],
        fresh: &[[u8; 3]],
    ) -> Result<()> {
        let Some(reference) = self.reference(index) else {
            return Ok(());
        };
        let ideal = self.image(&reference.image)?;
        let error =
            |pixels| -> Result<u64> { Ok(SquaredError::between(ideal, self.image(pixels)?)?.sum) };
        let (as_shown, without_age) = (error(shown)?, error(fresh)?);
        let sums = self.causes.get_or_insert((0, 0));
        sums.0 += as_shown;
        sums.1 += without_age;
        Ok(())
    }

    fn finish(self, setting: Setting, build: &str) -> Result<(Cell, Vec<(u32, Picture)>)> {
        let refreshes = self.sequence.refreshes().to_vec();
        let totals: Totals = self.sequence.finish()?;
        let class = |class: &PixelClass| ClassShare {
            class: class.name().to_owned(),
            error: self.shares.share(*class),
            area: self.shares.area(*class),
        };
        let cell = Cell {
            scene: self.job.scene.clone(),
            method: self.job.method.name().to_owned(),
            setting: setting.name().to_owned(),
            rate: self.job.rate,
            seed: self.job.seed,
            rmse: totals.rmse,
            psnr: Some(totals.psnr).filter(|psnr| psnr.is_finite()),
            flip: totals.flip,
            cvvdp: totals.cvvdp,
            worst_rmse: totals.worst_rmse,
            worst_time: totals.worst_time,
            p95_rmse: totals.p95_rmse,
            samples: self.samples,
            rays: self.rays,
            stream_bytes: self.stream_bytes,
            seconds_host: self.seconds_host,
            seconds_display: self.seconds_display,
            spent: self.spent,
            cuts: self.cuts,
            stale: self
                .causes
                .map(|(shown, fresh)| 1.0 - fresh as f64 / (shown as f64).max(1.0)),
            classes: PixelClass::ALL.iter().map(class).collect(),
            refreshes: refreshes
                .iter()
                .map(|r| Point {
                    time: r.time,
                    rmse: r.rmse,
                    flip: r.flip,
                })
                .collect(),
            build: build.to_owned(),
        };
        Ok((cell, self.pictures))
    }
}
