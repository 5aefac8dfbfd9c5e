//! One method run end to end, its pictures compared with the ideal renderer's.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use glam::UVec2;
use indicatif::ProgressBar;
use unframed_host::drive::Host;
use unframed_host::stream::Detail;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{Rays, World, ideal};
use unframed_metrics::{Sequence, SequenceOptions, Totals};
use unframed_recon::frame_hash;
use unframed_wire::ledger::Ledger;
use unframed_wire::{Counters, TileNode};

use crate::args::{DisplayArgs, Size, Source};
use crate::method::{Method, Sampling};
use crate::panel::{Order, all_cores, with_panel};
use crate::report::{Picture, Rect};

/// Refreshes a second.
pub const REFRESH_HZ: u32 = 60;
/// Supersamples along each axis of a pixel of the ideal image.
pub const IDEAL_GRID: u32 = 4;

/// Ideal images, each computed once.
pub struct Ideals {
    world: World,
    images: BTreeMap<u32, Vec<[u8; 3]>>,
}

impl Ideals {
    /// None computed yet.
    #[must_use]
    pub fn new(world: World) -> Self {
        Self {
            world,
            images: BTreeMap::new(),
        }
    }

    /// The ideal image of refresh `index` at `time` seconds.
    pub fn at(&mut self, index: u32, time: f64) -> &[[u8; 3]] {
        let world = &mut self.world;
        self.images
            .entry(index)
            .or_insert_with(|| ideal(world, time, IDEAL_GRID))
    }
}

/// What was shown at one refresh, kept for the report.
#[derive(Debug)]
pub struct Keyframe {
    /// The refresh.
    pub index: u32,
    /// Its instant, seconds.
    pub time: f64,
    /// What the display showed.
    pub shown: Picture,
    /// The tiles that came with it.
    pub tiles: Vec<Rect>,
}

/// A method's outcome.
#[derive(Debug)]
pub struct Outcome {
    /// The method.
    pub method: Method,
    /// The display hardware.
    pub display: String,
    /// Against the ideal.
    pub totals: Totals,
    /// (seconds, RMSE) of each measured refresh.
    pub errors: Vec<(f64, f64)>,
    /// Hash of each refresh's picture.
    pub hashes: Vec<u64>,
    /// Samples sent.
    pub samples: u64,
    /// Bytes sent.
    pub stream_bytes: u64,
    /// Where they went.
    pub ledger: Ledger,
    /// Rays traced.
    pub rays: Rays,
    /// Cuts announced.
    pub cuts: u32,
    /// What the display received.
    pub link: Counters,
    /// Wall-clock seconds of the host.
    pub seconds_host: f64,
    /// Wall-clock seconds of the display.
    pub seconds_display: f64,
    /// Pictures kept.
    pub keyframes: Vec<Keyframe>,
}

/// Opens the scene as a world and says on stderr what of a file is shown otherwise than meant.
///
/// # Errors
/// There is no such scene, or it cannot be rendered.
pub fn open_world(source: &Source) -> Result<World> {
    open_clip(&source.scene, source.clip.as_deref(), source.size)
}

/// The same of a scene with all its clips.
///
/// # Errors
/// There is no such scene, or it cannot be rendered.
pub fn open_scene(scene: &str, size: Size) -> Result<World> {
    open_clip(scene, None, size)
}

fn open_clip(scene: &str, clip: Option<&str>, size: Size) -> Result<World> {
    let opened = unframed_host::scene::open::open(scene, clip)?;
    for warning in &opened.warnings {
        eprintln!("{scene}: {warning}");
    }
    let size = [size.width, size.height].map(u32::from);
    World::new(opened.scene, size).with_context(|| format!("cannot render {scene}"))
}

/// The host of a method.
#[must_use]
pub fn host(source: &Source, method: Method, world: World) -> Host {
    detailed(
        source,
        method,
        world,
        Sampling::default(),
        Detail {
            lamps: !source.no_lamps,
            ..Detail::default()
        },
    )
}

/// The same with a sampler and a stream that are set otherwise.
#[must_use]
pub fn detailed(
    source: &Source,
    method: Method,
    world: World,
    sampling: Sampling,
    detail: Detail,
) -> Host {
    let size = UVec2::new(source.size.width.into(), source.size.height.into());
    let promise = Promise {
        layout: method.layout(),
        lamps: method.lamps(),
        tile_fields: method.tile_fields(),
        rate: source.rate,
        refresh_millihertz: REFRESH_HZ * 1000,
    };
    let sampler = method.sampler_with(size, source.seed, sampling);
    Host::with_detail(world, sampler, promise, detail)
}

/// Number of refreshes in the simulated time, at least one.
#[must_use]
pub fn refreshes(source: &Source) -> u32 {
    (source.seconds * f64::from(REFRESH_HZ)).round().max(1.0) as u32
}

/// Runs a method and measures every `every`-th refresh; keeps the pictures of `keep`.
///
/// # Errors
/// When the display's hardware or the metrics fail.
pub fn measure(
    source: &Source,
    panel: &DisplayArgs,
    method: Method,
    every: u32,
    keep: &[u32],
    ideals: &mut Ideals,
    progress: &ProgressBar,
) -> Result<Outcome> {
    let (width, height) = (source.size.width, source.size.height);
    let order = Order {
        kind: panel.display,
        config: method.display(),
        width,
        height,
        samples: panel.samples,
        threads: all_cores(),
    };
    let world = ideals.world.clone();
    with_panel(&order, |panel, display| {
        let mut host = host(source, method, world);
        let options = SequenceOptions {
            flip_every: 1,
            ..SequenceOptions::default()
        };
        let mut sequence = Sequence::new(width.into(), height.into(), options)?;
        let mut outcome = Outcome {
            method,
            display: display.to_owned(),
            totals: empty_totals(),
            errors: Vec::new(),
            hashes: Vec::new(),
            samples: 0,
            stream_bytes: 0,
            ledger: Ledger::default(),
            rays: Rays::default(),
            cuts: 0,
            link: Counters::default(),
            seconds_host: 0.0,
            seconds_display: 0.0,
            keyframes: Vec::new(),
        };
        let mut bytes = Vec::new();
        for index in 0..refreshes(source) {
            bytes.clear();
            let clock = Instant::now();
            let step = host.advance(&mut bytes)?;
            outcome.seconds_host += clock.elapsed().as_secs_f64();
            outcome.rays += step.rays;
            outcome.cuts += u32::from(step.cut);
            let clock = Instant::now();
            let mut input = &bytes[..];
            while panel.push(&mut input)?.is_some() {}
            outcome.seconds_display += clock.elapsed().as_secs_f64();
            outcome.hashes.push(frame_hash(panel.picture()));
            if (index + 1).is_multiple_of(every) || index + 1 == refreshes(source) {
                sequence.push(ideals.at(index, step.time), panel.picture(), step.time)?;
            }
            if keep.contains(&index) {
                let pixels = panel.picture().to_vec();
                outcome.keyframes.push(Keyframe {
                    index,
                    time: step.time,
                    shown: Picture::new(width.into(), height.into(), pixels)?,
                    tiles: rects(host.tiles()),
                });
            }
            progress.inc(1);
        }
        bytes.clear();
        host.end(&mut bytes)?;
        panel.push(&mut &bytes[..])?;
        outcome.errors = sequence
            .refreshes()
            .iter()
            .map(|r| (r.time, r.rmse))
            .collect();
        outcome.totals = sequence.finish()?;
        outcome.ledger = *host.ledger();
        outcome.samples = outcome.ledger.samples;
        outcome.stream_bytes = outcome.ledger.total_bytes();
        outcome.link = panel.link();
        ensure!(
            outcome.link.lost == 0 && outcome.link.damaged == 0,
            "the display lost {} packets and found {} damaged on a perfect link",
            outcome.link.lost,
            outcome.link.damaged
        );
        Ok(outcome)
    })
}

/// The leaves of a cut, for drawing.
fn rects(nodes: &[TileNode]) -> Vec<Rect> {
    nodes
        .iter()
        .filter_map(|node| match node {
            TileNode::Leaf(tile) => Some(Rect {
                x: tile.rect.x.into(),
                y: tile.rect.y.into(),
                width: tile.rect.w.into(),
                height: tile.rect.h.into(),
            }),
            TileNode::Split(_) => None,
        })
        .collect()
}

fn empty_totals() -> Totals {
    Totals {
        refreshes: 0,
        rmse: 0.0,
        psnr: 0.0,
        flip: None,
        cvvdp: None,
        cvvdp_each: Vec::new(),
        worst_rmse: 0.0,
        worst_time: 0.0,
        p95_rmse: 0.0,
        p95_flip: None,
    }
}
