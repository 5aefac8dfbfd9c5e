//! Framed renderers: what frameless rendering is measured against. They have no stream; a picture
//! appears all at once, and nothing else of them reaches the display.
//!
//! **Latency.** A renderer that makes a frame in F seconds renders frame `k` during
//! `k·F..(k + 1)·F` with the camera and the scene of `k·F`, into the hidden buffer, and the
//! display shows it from the first refresh at or after `(k + 1)·F` on. At a refresh the picture is
//! therefore F to 2·F old; at 60 Hz exactly one refresh interval. (This is the "double-buffering
//! delay" of Dayal et al. 2005 §7. A renderer that waits for the vertical blank would be slower
//! still: what is here is the best that double buffering can do.) Before time 0 the scene is
//! taken to stand as it does at 0, and the renderer to have been running, so that no black frames
//! count against it.
//!
//! **Budget.** Every camera sample counts, as it does for the samplers.
//!
//! - [`Frames`]: low resolution at 60 Hz, full resolution at whatever rate the budget allows, full
//!   resolution at each refresh with or without the delay;
//! - [`taau`]: temporal antialiasing and upscaling.

mod resize;
pub mod taau;
#[cfg(test)]
mod tests;

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

pub use resize::Upscale;
pub use taau::{Taau, Tuning};

use crate::trace::{Hit, World, srgb};

/// Refreshes a second of the display behind a framed renderer.
pub const REFRESH_HZ: f64 = 60.0;

/// A renderer that shows whole frames.
pub trait Framed: Send {
    /// Shows the picture of the refresh at `time` (seconds; refreshes come in order) and says of
    /// which instant its content is.
    fn show(&mut self, time: f64) -> f64;
    /// The picture shown: sRGB codes, rows from the top.
    fn picture(&self) -> &[[u8; 3]];
    /// Camera samples taken since time 0 for what was shown so far.
    fn samples(&self) -> u64;
}

/// Plain frames: one sample a pixel of the frame, at its centre, and no memory.
pub struct Frames {
    world: World,
    /// Pixels of a frame, which need not be those of the panel.
    resolution: UVec2,
    /// Seconds from one frame to the next.
    interval: f64,
    delayed: bool,
    upscale: Upscale,
    hits: Vec<Hit>,
    picture: Vec<[u8; 3]>,
    /// The frame shown.
    shown: Option<i64>,
    samples: u64,
}

impl Frames {
    /// 60 frames a second of as many pixels as `rate` samples a second allow, in the panel's
    /// proportions; more than the panel's if the budget is that large.
    #[must_use]
    pub fn low_resolution(world: World, rate: u32, upscale: Upscale) -> Self {
        let resolution = resolution(world.size().into(), f64::from(rate) / REFRESH_HZ);
        Self::new(world, resolution, 1.0 / REFRESH_HZ, true, upscale)
    }

    /// Frames of the panel's resolution, as many a second as `rate` samples a second allow, at
    /// most 60.
    #[must_use]
    pub fn full_resolution(world: World, rate: u32) -> Self {
        let size = UVec2::from(world.size());
        let interval = (f64::from(size.x * size.y) / f64::from(rate)).max(1.0 / REFRESH_HZ);
        Self::new(world, size, interval, true, Upscale::Linear)
    }

    /// A frame of the panel's resolution at each of 60 refreshes a second, whatever that costs;
    /// without `delayed`, of the refresh instant itself, which no renderer can do.
    #[must_use]
    pub fn every_refresh(world: World, delayed: bool) -> Self {
        let size = UVec2::from(world.size());
        Self::new(world, size, 1.0 / REFRESH_HZ, delayed, Upscale::Linear)
    }

    fn new(
        world: World,
        resolution: UVec2,
        interval: f64,
        delayed: bool,
        upscale: Upscale,
    ) -> Self {
        let [width, height] = world.size();
        Self {
            world,
            resolution,
            interval,
            delayed,
            upscale,
            hits: Vec::new(),
            picture: vec![[0; 3]; width as usize * height as usize],
            shown: None,
            samples: 0,
        }
    }

    /// Pixels of a frame.
    #[must_use]
    pub fn resolution(&self) -> UVec2 {
        self.resolution
    }
}

impl Framed for Frames {
    fn show(&mut self, time: f64) -> f64 {
        // The thousandth forgives the rounding of times that are multiples of the interval.
        let finished = (time / self.interval + 1e-3).floor() as i64;
        let frame = finished - i64::from(self.delayed);
        let content = if self.delayed {
            (frame as f64 * self.interval).max(0.0)
        } else {
            time
        };
        if self.shown != Some(frame) {
            self.shown = Some(frame);
            self.samples = u64::try_from(frame + i64::from(self.delayed)).unwrap_or(0)
                * u64::from(self.resolution.x * self.resolution.y);
            render(
                &mut self.world,
                content,
                self.resolution,
                Vec2::splat(0.5),
                &mut self.hits,
            );
            let size = UVec2::from(self.world.size());
            let colours: Vec<Vec3> = self.hits.iter().map(|hit| hit.colour).collect();
            let image = resize::resize(&colours, self.resolution, size, self.upscale);
            self.picture.clear();
            self.picture.extend(image.into_iter().map(srgb::encode8));
        }
        content
    }

    fn picture(&self) -> &[[u8; 3]] {
        &self.picture
    }

    fn samples(&self) -> u64 {
        self.samples
    }
}

/// The resolution nearest to the proportions of `size` with at most `budget` pixels, at least 1.
fn resolution(size: UVec2, budget: f64) -> UVec2 {
    let scale = (budget / (f64::from(size.x) * f64::from(size.y))).sqrt();
    let width = (f64::from(size.x) * scale).round().clamp(1.0, 4096.0);
    let height = (budget / width).floor().clamp(1.0, 4096.0);
    UVec2::new(width as u32, height as u32)
}

/// Traces one sample for each pixel of a frame of `resolution` over the whole panel, all at the
/// instant `time`, each at the place `within` its pixel (0..1). The world's prepared epoch is
/// `time` afterwards.
fn render(world: &mut World, time: f64, resolution: UVec2, within: Vec2, hits: &mut Vec<Hit>) {
    world.prepare(time, time);
    let moment = world.moment(time);
    let step = UVec2::from(world.size()).as_vec2() / resolution.as_vec2();
    (0..resolution.x * resolution.y)
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            let pixel = UVec2::new(i % resolution.x, i / resolution.x).as_vec2();
            // The seed that the ideal renderer takes for a sample a pixel.
            moment.look((pixel + within) * step, i)
        })
        .collect_into_vec(hits);
}
