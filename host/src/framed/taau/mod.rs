//! Temporal antialiasing and upscaling, the renderer to beat: after Karis 2014 ("High-quality
//! temporal supersampling"), Salvi 2016 (variance clipping) and Yang, Liu & Salvi 2020 ("A survey
//! of temporal antialiasing techniques").
//!
//! At each refresh a frame of rate/60 samples is traced, its samples jittered together. Each pixel
//! of the panel finds its surface in a sample that fell into it, else in the history's own
//! surfaces, moved along, else in the samples around; follows it back to where the history has it,
//! exactly, by hit and pose; takes the history by Catmull-Rom interpolation, clips it to what the
//! new samples around allow, and adds the new samples by their distance. The frame is traced with
//! the view one refresh interval before it is shown, as [`super`] says, and is warped to the view
//! and the poses of the refresh at the last moment.

mod frame;
mod history;
mod motion;

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

use super::{Framed, REFRESH_HZ, render, resolution};
use crate::trace::camera::Camera;
use crate::trace::{World, srgb};
use frame::{Low, Past};
use history::{NOTHING, Surface, Texel, catmull_rom};
use motion::{Motion, find_source};

/// Settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Most samples that the history of a pixel counts for, above 0: long histories are sharp and
    /// free of noise, short ones follow changes. At a tenth of a sample a pixel and frame, 1 is
    /// about ten frames.
    pub history: f32,
    /// Standard deviation of a new sample's weight, pixels of the panel.
    pub sigma: f32,
    /// How many standard deviations of the new samples around the history may be off their mean.
    pub clip: f32,
}

impl Tuning {
    /// Follows changes: the better one where mirrors and highlights move. Tuned on the built-in
    /// scenes, as is [`Tuning::SHARP`]: of 20 settings these two together did best.
    pub const QUICK: Self = Self {
        history: 1.0,
        sigma: 0.6,
        clip: 2.0,
    };
    /// Keeps what it knows and hardly clips: the better one where surfaces keep their colours.
    pub const SHARP: Self = Self {
        history: 6.0,
        sigma: 0.45,
        clip: 100.0,
    };
}

/// The renderer.
pub struct Taau {
    world: World,
    size: UVec2,
    tuning: Tuning,
    frame: Low,
    /// Of the last frame, at the view of its instant.
    history: Vec<Texel>,
    /// The camera and the instant of the history.
    last: Option<(Camera, f64)>,
    picture: Vec<[u8; 3]>,
    samples: u64,
    count: u32,
}

impl Taau {
    /// With a budget of `rate` samples a second; `seed` decides where the jitter begins.
    #[must_use]
    pub fn new(world: World, rate: u32, tuning: Tuning, seed: u64) -> Self {
        let size = UVec2::from(world.size());
        let resolution = resolution(size, f64::from(rate) / REFRESH_HZ).min(size);
        let pixels = (size.x * size.y) as usize;
        Self {
            frame: Low {
                size,
                resolution,
                jitter: Vec2::ZERO,
                hits: Vec::new(),
                slopes: Vec::new(),
            },
            history: vec![NOTHING; pixels],
            picture: vec![[0; 3]; pixels],
            last: None,
            samples: 0,
            count: (seed % 64) as u32 * 97,
            world,
            size,
            tuning,
        }
    }

    /// Traces a frame of the instant `time` and adds it to the history.
    fn accumulate(&mut self, time: f64) {
        self.count += 1;
        self.frame.jitter = Vec2::new(halton(self.count, 2), halton(self.count, 3));
        let frame = &mut self.frame;
        render(
            &mut self.world,
            time,
            frame.resolution,
            frame.jitter,
            &mut frame.hits,
        );
        frame.measure_slopes();
        self.samples += frame.hits.len() as u64;
        let camera = self.world.camera(time);
        let past = self.last.map(|(past, then)| Past {
            back: Motion::new(&self.world, (&camera, time), (&past, then)),
            moved: self.move_surfaces(&Motion::new(&self.world, (&past, then), (&camera, time))),
            history: &self.history,
        });
        let (frame, tuning, size) = (&self.frame, &self.tuning, self.size);
        let blend = |i: usize| {
            let pixel = UVec2::new(i as u32 % size.x, i as u32 / size.x);
            frame.blend(pixel, past.as_ref(), tuning)
        };
        let next = (0..self.history.len())
            .into_par_iter()
            .with_min_len(256)
            .map(blend)
            .collect();
        self.history = next;
        self.last = Some((camera, time));
    }

    /// The history's surfaces in another view, where one of them falls into a pixel; the nearest
    /// counts.
    fn move_surfaces(&self, motion: &Motion) -> Vec<Option<Surface>> {
        let mut moved: Vec<Option<Surface>> = vec![None; self.history.len()];
        for (i, texel) in self.history.iter().enumerate() {
            let Some((at, inverse_depth)) = motion.carry(self.centre(i), texel.surface) else {
                continue;
            };
            if at.cmplt(Vec2::ZERO).any() || at.cmpge(self.size.as_vec2()).any() {
                continue;
            }
            let slot = &mut moved[(at.y as u32 * self.size.x + at.x as u32) as usize];
            if slot.is_none_or(|known| known.inverse_depth < inverse_depth) {
                *slot = Some(Surface {
                    inverse_depth,
                    ..texel.surface
                });
            }
        }
        moved
    }

    /// The centre of a pixel of the panel.
    fn centre(&self, i: usize) -> Vec2 {
        let i = i as u32;
        UVec2::new(i % self.size.x, i / self.size.x).as_vec2() + 0.5
    }

    /// Shows the history as seen at `time`.
    fn warp(&mut self, time: f64) {
        let Some((camera, then)) = self.last else {
            return;
        };
        let view = self.world.camera(time);
        let motion = Motion::new(&self.world, (&camera, then), (&view, time));
        let (size, history) = (self.size, &self.history);
        let centre = |i: usize| self.centre(i);
        let moved: Vec<Option<(Vec2, f32)>> = (0..history.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|i| motion.carry(centre(i), history[i].surface))
            .collect();
        let picture = (0..history.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|i| {
                let source = find_source(centre(i), &moved, size);
                srgb::encode8(catmull_rom(history, size, source).max(Vec3::ZERO))
            })
            .collect();
        self.picture = picture;
    }
}

impl Framed for Taau {
    fn show(&mut self, time: f64) -> f64 {
        let content = (time - 1.0 / REFRESH_HZ).max(0.0);
        self.accumulate(content);
        self.warp(time);
        content
    }

    fn picture(&self) -> &[[u8; 3]] {
        &self.picture
    }

    fn samples(&self) -> u64 {
        self.samples
    }
}

/// The radical inverse of `index` (Halton 1964), 0..1.
fn halton(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0f64, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value as f32
}

/// Where a hit seen at a place at `now` is at `then`.
#[cfg(test)]
pub(super) fn carry_for_tests(
    world: &World,
    now: f64,
    then: f64,
    at: Vec2,
    hit: &crate::trace::Hit,
) -> Option<(Vec2, f32)> {
    let (from, to) = (world.camera(now), world.camera(then));
    let surface = Surface {
        object: hit.object,
        inverse_depth: history::inverse_depth(hit),
    };
    Motion::new(world, (&from, now), (&to, then)).carry(at, surface)
}
