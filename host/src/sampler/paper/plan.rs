//! What a chunk does: visits (Dayal et al. 2005, Figure 5) and reprojection (§6.1).

use std::time::Instant;

use glam::Vec2;

use super::Paper;
use super::crosshair::{ARMS, Crosshair, Initial};
use crate::sampler::adaptive::projection::Projection;
use crate::sampler::uniform::within;
use crate::sampler::{Aim, Care, Eye, Plan, Span};

/// What a sample is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Errand {
    /// To wait in its tile for a crosshair.
    Initial,
    /// The centre of a crosshair; its arms follow.
    Centre {
        /// Which of [`ARMS`] there are.
        arms: [bool; 4],
        /// What was seen at the same place before.
        before: Option<Initial>,
        /// Whether it takes the place of an occluded one.
        occluded: bool,
    },
    /// An arm of the centre before it.
    Arm,
}

/// A test whether a reprojected crosshair is still seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    pub(super) time: f64,
    /// Where it now is on the image, pixels.
    pub(super) place: Vec2,
    pub(super) crosshair: Crosshair,
}

/// What was spent of an epoch's budget, and the instant that belongs to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    span: Span,
    budget: f64,
    spent: f64,
}

impl Clock {
    pub(super) fn new(span: Span, budget: f64) -> Self {
        Self {
            span,
            budget,
            spent: 0.0,
        }
    }

    /// Samples' worth left.
    pub(super) fn left(&self) -> f64 {
        self.budget - self.spent
    }

    /// The instant of the next ray, seconds: before the end of the span.
    pub(super) fn now(&self) -> f64 {
        let share = (self.spent / self.budget.max(1.0)).min(1.0);
        (self.span.t0 + self.span.length() * share).min(self.span.t1.next_down())
    }

    fn spend(&mut self, samples: f64) {
        self.spent += samples;
    }
}

impl Paper {
    /// Plans a chunk, as much of it as there is budget for.
    pub(super) fn plan(&mut self, clock: &mut Clock, eye: &dyn Eye) {
        self.chunk.plans.clear();
        self.chunk.errands.clear();
        self.chunk.checks.clear();
        if !self.started {
            self.started = true;
            self.begin(clock);
            return;
        }
        let crosshair = if self.config.arms { 5.0 } else { 1.0 };
        while clock.left() >= crosshair {
            let Some(gone) = self.vacancies.pop_front() else {
                break;
            };
            self.aim_crosshair(gone.place, Some(gone), true, clock);
        }
        let checks = if self.config.occlusion {
            f64::from(self.config.reprojections) * self.config.occlusion_cost
        } else {
            0.0
        };
        let mut projection = Projection::new(clock.now());
        for _ in 0..self.config.chunk {
            if clock.left() < crosshair + checks + 1.0 {
                break;
            }
            self.visit(clock, &mut projection, eye);
        }
    }

    /// The first samples: "a spatially gridded, cotemporal sampling pattern" (§4.2), as fine as
    /// half of the first epoch's budget allows.
    fn begin(&mut self, clock: &mut Clock) {
        let size = self.size.as_vec2();
        let crosshairs = (0.5 * clock.left() / 5.0) as f32;
        let step = (size.element_product() / crosshairs.max(1.0))
            .sqrt()
            .max(1.0);
        let counts = (size / step).floor().max(Vec2::ONE);
        let cell = size / counts;
        let start = *clock;
        for y in 0..counts.y as u32 {
            for x in 0..counts.x as u32 {
                if clock.left() < 5.0 {
                    return;
                }
                let place = (Vec2::new(x as f32, y as f32) + 0.5) * cell;
                let mut cotemporal = start;
                let before = cotemporal.left();
                self.aim_crosshair(within(place, self.size), None, false, &mut cotemporal);
                clock.spend(before - cotemporal.left());
            }
        }
    }

    /// One visit to one tile.
    fn visit(&mut self, clock: &mut Clock, projection: &mut Projection, eye: &dyn Eye) {
        let tile = self.tiling.at(self.random.below(self.tiling.len() as u32));
        if let Some(initial) = self.tiling.take_initial(tile) {
            self.aim_crosshair(initial.place, Some(initial), false, clock);
        }
        let rect = self.tiling.tree.nodes[tile as usize].rect;
        let begin = Instant::now();
        for _ in 0..self.config.reprojections {
            let x = u32::from(rect.x) + self.random.below(rect.w.into());
            let y = u32::from(rect.y) + self.random.below(rect.h.into());
            self.reproject(y * self.size.x + x, clock, projection, eye);
        }
        self.stats.reprojecting += begin.elapsed().as_secs_f64();
        let corner = Vec2::new(rect.x.into(), rect.y.into());
        let point = Vec2::new(self.random.unit(), self.random.unit());
        let place = corner + point * Vec2::new(rect.w.into(), rect.h.into());
        // A product such as u·w with u < 1 can round up to the next tile.
        let last = (corner + Vec2::new(rect.w.into(), rect.h.into())).map(f32::next_down);
        self.aim(place.min(last), Errand::Initial, clock.now());
        clock.spend(1.0);
    }

    /// Plans a crosshair, its samples cotemporal.
    fn aim_crosshair(
        &mut self,
        place: Vec2,
        before: Option<Initial>,
        occluded: bool,
        clock: &mut Clock,
    ) {
        let time = clock.now();
        let limit = self.size.as_vec2();
        let inside = |p: Vec2| p.cmpge(Vec2::ZERO).all() && p.cmplt(limit).all();
        let arms = ARMS.map(|step| self.config.arms && inside(place + step));
        let centre = Errand::Centre {
            arms,
            before,
            occluded,
        };
        self.aim(place, centre, time);
        clock.spend(1.0);
        for (step, there) in ARMS.into_iter().zip(arms) {
            if there {
                self.aim(place + step, Errand::Arm, time);
                clock.spend(1.0);
            }
        }
    }

    fn aim(&mut self, place: Vec2, errand: Errand, time: f64) {
        self.chunk.plans.push(Plan {
            time,
            aim: Aim::Pixel(place),
            seed: self.random.next(),
            care: Care::default(),
        });
        self.chunk.errands.push(errand);
    }

    /// Moves the crosshair at the front of a pixel's queue to where it is seen now.
    ///
    /// Spatial gradients are taken anew from where its samples are now; the temporal gradient is
    /// the difference from the newest sample of the pixel that it comes to, over the age of that.
    fn reproject(
        &mut self,
        pixel: u32,
        clock: &mut Clock,
        projection: &mut Projection,
        eye: &dyn Eye,
    ) {
        let Some(old) = self.buffer.pop_front(pixel) else {
            return;
        };
        self.stats.reprojected += 1;
        for point in old.arms.iter().flatten().chain([&old.centre]) {
            projection.prepare(point.object, eye);
        }
        let seen = projection.project(old.centre.object, old.centre.local);
        let limit = self.size.as_vec2();
        let inside = |p: &Vec2| p.cmpge(Vec2::ZERO).all() && p.cmplt(limit).all();
        let Some(place) = seen.map(|(place, _)| place).filter(inside) else {
            self.tiling.update(pixel, &self.buffer);
            return;
        };
        let now = clock.now();
        let to = self.pixel(place);
        let mut moved = Crosshair { pixel: to, ..old };
        let [gx, gy] = old.respaced(place, projection);
        let gt = self.buffer.newest(to).map_or(old.gradients[2], |newest| {
            let difference = old.centre.luminance - newest.centre.luminance;
            self.temporal(difference, now - newest.time)
        });
        moved.gradients = [gx, gy, gt];
        self.buffer.push_back(moved);
        if to != pixel {
            self.tiling.update(pixel, &self.buffer);
        }
        self.tiling.update(to, &self.buffer);
        if self.config.occlusion {
            self.chunk.checks.push(Check {
                time: now,
                place,
                crosshair: moved,
            });
            clock.spend(self.config.occlusion_cost);
        }
    }
}
