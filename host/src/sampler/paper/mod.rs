//! Adaptive frameless sampling as in Dayal, Woolley, Watson & Luebke 2005, §4 and §6.1: the method
//! `paper`, beside which [`super::adaptive`] is measured.
//!
//! The loop of the paper's Figure 5, in chunks of 25 visits:
//!
//! 1. **Visit** ([`plan`]): a tile by a uniform choice ([`tiling`]); the sample that waits there
//!    becomes the old half of a crosshair ([`crosshair`]) and five new ones complete it; r = 5
//!    pixels' front crosshairs of the tile are reprojected, and a ray to each tests whether it is
//!    still seen; a new sample is left to wait.
//! 2. **Trace** all of the chunk in parallel.
//! 3. **Learn**: crosshairs enter the deep buffer ([`buffer`]) and the sums of the k-d tree
//!    ([`tree`]); where a ray found something in the way, the crosshair goes and a new one takes
//!    its place.
//! 4. **Adjust** the tiling, to as many tiles as gain control ([`error`]) asks for.
//!
//! Where this differs from the paper: the visits of a chunk do not see what the others of the same
//! chunk find (0.5 ms at 400,000 samples a second), and replacements are traced with the next chunk,
//! so that all rays of a chunk can be traced at once. Every ray is paid for from the budget of
//! samples, the occlusion tests too.
//!
//! A visit costs O(log pixels); none of the steps looks at all tiles or all samples.

mod buffer;
mod config;
mod crosshair;
mod error;
mod heap;
mod plan;
#[cfg(test)]
mod tests;
mod tiling;
mod tree;

use std::collections::VecDeque;
use std::time::Instant;

use glam::{UVec2, Vec2};
use rayon::prelude::*;
use unframed_wire::TileFields;
use unframed_wire::tiles::TileNode;

use super::noise::Random;
use super::{Effort, Eye, Plan, Sampler, Seen, Shot, Span, trace};
use crate::trace::Rays;
use buffer::DeepBuffer;
pub use config::Config;
use crosshair::{Crosshair, Initial, Point, luminance};
use plan::{Check, Errand};
use tiling::Tiling;
use tree::Tree;

/// Counts since the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Samples taken.
    pub samples: u64,
    /// Crosshairs completed.
    pub crosshairs: u64,
    /// Crosshairs reprojected.
    pub reprojected: u64,
    /// Occlusion rays.
    pub tests: u64,
    /// Those that found something in the way.
    pub occluded: u64,
    /// Splits and merges of tiles.
    pub moves: [u64; 2],
    /// Tiles now.
    pub tiles: usize,
    /// Crosshairs stored now.
    pub stored: usize,
    /// Wall-clock seconds spent planning (with reprojecting), tracing, learning, adjusting.
    pub seconds: [f64; 4],
    /// Of those of planning, the ones spent reprojecting.
    pub reprojecting: f64,
}

/// The sampler of an image of fixed size.
#[derive(Clone, Debug)]
pub struct Paper {
    config: Config,
    size: UVec2,
    buffer: DeepBuffer,
    tiling: Tiling,
    /// Crosshairs that were found occluded, where they now would be: new ones are due there.
    vacancies: VecDeque<Initial>,
    random: Random,
    /// Samples' worth of budget not spent yet.
    credit: f64,
    /// Crosshairs since the tiling was adjusted.
    crosshairs: u32,
    started: bool,
    /// Samples a second in the last epoch.
    rate: f64,
    /// Occlusion rays since they were last asked for.
    untold: u32,
    chunk: Chunk,
    stats: Stats,
}

/// What is to be done in a chunk; buffers that are reused.
#[derive(Clone, Debug, Default)]
struct Chunk {
    /// Rays that give samples.
    plans: Vec<Plan>,
    /// What they are for, in the same order.
    errands: Vec<Errand>,
    seen: Vec<Seen>,
    /// Occlusion tests.
    checks: Vec<Check>,
    clear: Vec<bool>,
}

impl Paper {
    /// For an image of `size` pixels (each side 1 to 65535).
    #[must_use]
    pub fn new(size: UVec2, config: Config) -> Self {
        let tree = Tree::new(size, config.decline);
        Self {
            buffer: DeepBuffer::new(size.element_product() as usize, config.depth),
            tiling: Tiling::new(tree, &config),
            vacancies: VecDeque::new(),
            random: Random::new(config.seed),
            credit: 0.0,
            crosshairs: 0,
            started: false,
            rate: 0.0,
            untold: 0,
            chunk: Chunk::default(),
            stats: Stats::default(),
            size,
            config,
        }
    }

    /// Counts since the beginning.
    #[must_use]
    pub fn stats(&self) -> Stats {
        Stats {
            moves: self.tiling.moves,
            tiles: self.tiling.len(),
            stored: self.buffer.len(),
            ..self.stats
        }
    }

    /// Traces what was planned: samples in the order of time, and tests.
    fn trace(&mut self, eye: &dyn Eye, out: &mut Vec<Shot>) {
        let Chunk {
            plans,
            seen,
            checks,
            clear,
            ..
        } = &mut self.chunk;
        trace(plans, self.size, eye, seen);
        checks
            .par_iter()
            .with_min_len(32)
            .map(|check| {
                eye.sees(
                    check.time,
                    check.crosshair.centre.object,
                    check.crosshair.centre.local,
                )
            })
            .collect_into_vec(clear);
        out.extend(seen.iter().map(|seen| seen.shot));
        self.stats.samples += seen.len() as u64;
        self.stats.tests += checks.len() as u64;
        self.untold += checks.len() as u32;
    }

    /// Puts into buffer and statistics what was found.
    fn learn(&mut self) {
        for i in 0..self.chunk.checks.len() {
            let Check {
                place, crosshair, ..
            } = self.chunk.checks[i];
            if self.chunk.clear[i] {
                continue;
            }
            self.stats.occluded += 1;
            // Unless it fell out of its queue, or was moved once more, in the same chunk.
            if self.buffer.remove(&crosshair).is_some() {
                self.tiling.update(crosshair.pixel, &self.buffer);
            }
            self.vacancies.push_back(Initial {
                place,
                time: crosshair.time,
                luminance: crosshair.centre.luminance,
            });
        }
        for i in 0..self.chunk.seen.len() {
            let Shot {
                time, pixel, hit, ..
            } = self.chunk.seen[i].shot;
            match self.chunk.errands[i] {
                Errand::Initial => {
                    let initial = Initial {
                        place: pixel,
                        time,
                        luminance: luminance(&hit),
                    };
                    self.tiling.set_initial(self.pixel(pixel), initial);
                }
                Errand::Arm => {}
                Errand::Centre {
                    arms,
                    before,
                    occluded,
                } => self.complete(i, arms, before, occluded),
            }
        }
    }

    /// Makes a crosshair of sample `first` of the chunk and the arms that follow it.
    fn complete(&mut self, first: usize, arms: [bool; 4], before: Option<Initial>, occluded: bool) {
        let Shot {
            time, pixel, hit, ..
        } = self.chunk.seen[first].shot;
        let mut next = first;
        let arms = arms.map(|there| {
            there.then(|| {
                next += 1;
                Point::of(&self.chunk.seen[next].shot.hit)
            })
        });
        let centre = Point::of(&hit);
        let at = self.pixel(pixel);
        let [gx, gy] = if self.config.arms {
            Crosshair::spatial(&centre, &arms)
        } else {
            self.around(at, &centre)
        };
        let gt = before.map_or(0.0, |before| {
            self.temporal(centre.luminance - before.luminance, time - before.time)
        });
        let crosshair = Crosshair {
            time,
            centre,
            arms,
            gradients: [gx, gy, gt],
            occluded,
            pixel: at,
        };
        self.crosshairs += 1;
        self.stats.crosshairs += 1;
        self.buffer.push_front(crosshair);
        self.tiling.update(at, &self.buffer);
    }

    /// Spatial gradients without arms: against the newest samples of the pixels around.
    fn around(&self, pixel: u32, centre: &Point) -> [f32; 2] {
        let (x, y) = ((pixel % self.size.x) as i32, (pixel / self.size.x) as i32);
        let neighbours = crosshair::ARMS.map(|step| {
            let (x, y) = (x + step.x as i32, y + step.y as i32);
            let inside = x >= 0 && y >= 0 && x < self.size.x as i32 && y < self.size.y as i32;
            let newest = inside.then(|| self.buffer.newest(y as u32 * self.size.x + x as u32));
            newest.flatten().map(|crosshair| crosshair.centre)
        });
        Crosshair::spatial(centre, &neighbours)
    }

    /// |ΔL|/Δt, 1/s.
    fn temporal(&self, difference: f32, interval: f64) -> f32 {
        difference.abs() / interval.max(self.config.least_interval) as f32
    }

    /// The pixel of a place on the image.
    fn pixel(&self, place: Vec2) -> u32 {
        place.y as u32 * self.size.x + place.x as u32
    }

    /// Lets gain control and errors move the tiling.
    fn adjust(&mut self, now: f64) {
        let target = if self.config.gain {
            let [spatial, temporal, age] = self.tiling.averages(now);
            let pixels = f64::from(self.size.element_product());
            error::target(pixels, spatial, temporal, age, &self.config)
        } else {
            self.config.tiles
        };
        self.tiling.adjust(target, &self.config);
    }
}

impl Sampler for Paper {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        let first = out.len();
        self.credit += span.shots as f64;
        let mut clock = plan::Clock::new(span, self.credit);
        let mut now = span.t0;
        loop {
            let begin = Instant::now();
            self.plan(&mut clock, eye);
            let planned = Instant::now();
            if self.chunk.plans.is_empty() {
                break;
            }
            self.trace(eye, out);
            let traced = Instant::now();
            self.learn();
            let learnt = Instant::now();
            now = clock.now().max(now);
            if self.crosshairs >= self.config.chunk {
                self.crosshairs = 0;
                self.adjust(now);
            }
            let marks = [begin, planned, traced, learnt, Instant::now()];
            for (sum, pair) in self.stats.seconds.iter_mut().zip(marks.windows(2)) {
                *sum += pair[1].duration_since(pair[0]).as_secs_f64();
            }
        }
        self.credit = clock.left();
        if span.length() > 0.0 {
            self.rate = (out.len() - first) as f64 / span.length();
        }
    }

    fn tiles(&mut self, fields: TileFields, out: &mut Vec<TileNode>) {
        self.tiling.side_data(fields, self.rate, out);
    }

    fn effort(&self) -> Option<Effort> {
        Some(Effort {
            tracing: self.stats.seconds[1],
            reprojection: self.stats.reprojecting,
        })
    }

    fn take_rays(&mut self) -> Rays {
        Rays {
            shadow: std::mem::take(&mut self.untold),
            ..Rays::default()
        }
    }
}
