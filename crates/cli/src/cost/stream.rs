//! A stream in memory, refresh by refresh, so that many displays can be shown the same.

use anyhow::Result;
use glam::Vec2;
use rayon::prelude::*;
use unframed_host::sampler::Shot;
use unframed_host::stream::Sender;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::World;
use unframed_wire::{Layout, TileFields};

use super::knobs::Knobs;
use crate::args::{Size, Source};
use crate::measure::{REFRESH_HZ, detailed};
use crate::work::Stopwatch;

/// What one host sent.
#[derive(Debug)]
pub struct Stream {
    /// The bytes up to and with each Refresh.
    pub refreshes: Vec<Vec<u8>>,
    /// Core seconds of the host for a second of animation, from `first` on.
    pub host_seconds: f64,
    /// Bytes a second of animation, from `first` on.
    pub bytes_per_second: f64,
    /// Rays a second of animation, of all kinds, from `first` on.
    pub rays_per_second: f64,
}

impl Stream {
    /// Runs the host of a setting for `refreshes`; costs are counted from refresh `first` on.
    /// To be called on a pool of one thread, or other threads' work is not counted.
    ///
    /// # Errors
    /// The scene cannot be sent.
    pub fn record(
        knobs: &Knobs,
        size: Size,
        seed: u64,
        world: &World,
        refreshes: u32,
        first: u32,
    ) -> Result<Self> {
        let source = Source {
            scene: String::new(),
            clip: None,
            rate: knobs.rate(u32::from(size.width) * u32::from(size.height)),
            seconds: f64::from(refreshes) / f64::from(REFRESH_HZ),
            size,
            seed,
            method: knobs.method,
            no_lamps: false,
        };
        let mut host = detailed(
            &source,
            knobs.method,
            world.clone(),
            knobs.sampling,
            knobs.detail,
        );
        let mut stream = Self {
            refreshes: Vec::new(),
            host_seconds: 0.0,
            bytes_per_second: 0.0,
            rays_per_second: 0.0,
        };
        for index in 0..refreshes {
            let mut bytes = Vec::new();
            let watch = Stopwatch::start();
            let progress = host.advance(&mut bytes)?;
            if index >= first {
                stream.host_seconds += watch.seconds();
                stream.bytes_per_second += bytes.len() as f64;
                stream.rays_per_second += f64::from(progress.rays.total());
            }
            stream.refreshes.push(bytes);
        }
        let seconds = f64::from(refreshes.saturating_sub(first).max(1)) / f64::from(REFRESH_HZ);
        stream.host_seconds /= seconds;
        stream.bytes_per_second /= seconds;
        stream.rays_per_second /= seconds;
        Ok(stream)
    }
}

/// Samples along each axis of a pixel where there are to be plenty.
const PLENTY: u32 = 4;

/// A stream of one refresh at `time` seconds, all of whose samples are of that instant: a regular
/// grid of 16 a pixel. Its bytes and the number of its samples.
///
/// # Errors
/// The scene cannot be sent.
pub fn dense(world: &World, time: f64) -> Result<(Vec<u8>, usize)> {
    let mut world = world.clone();
    world.prepare(time, time);
    let [width, height] = world.size().map(|side| side * PLENTY);
    let moment = world.moment(time);
    let shots: Vec<Shot> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let place = Vec2::new((i % width) as f32, (i / width) as f32) + 0.5;
            let pixel = place / PLENTY as f32;
            let hit = moment.look(pixel, i);
            Shot {
                time,
                as_of: time,
                pixel,
                hit,
            }
        })
        .collect();
    let promise = Promise {
        layout: Layout::World,
        lamps: false,
        tile_fields: TileFields::default(),
        rate: shots.len() as u32 * REFRESH_HZ,
        refresh_millihertz: REFRESH_HZ * 1000,
    };
    let mut sender = Sender::new(&world, promise);
    let mut bytes = Vec::new();
    sender.samples(&shots, &mut bytes)?;
    sender.refresh(&world, time, &[], &mut bytes)?;
    Ok((bytes, shots.len()))
}
