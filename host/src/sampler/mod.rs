//! Where and when to look next: the samplers.
//!
//! A [`Sampler`] is asked for a [`Span`] of simulated time at a time. It plans its shots serially
//! (cheap, seeded), lets an [`Eye`] trace them in parallel and learns from them serially, in the
//! order of time: the result is the same whatever the number of threads. Every ray towards the
//! scene is paid for; all but tests of visibility are samples of the stream.
//!
//! - [`uniform`]: samplers that learn nothing (the baselines);
//! - [`paper`]: the sampler of Dayal et al. 2005;
//! - [`adaptive`]: the sampler of this project;
//! - [`kdtree`]: the k-d cut of the image that carries a sampler's side data to the display.

pub mod adaptive;
pub mod kdtree;
mod noise;
pub mod paper;
pub mod srgb;
#[cfg(test)]
mod stage;
pub mod uniform;

use glam::{Affine3A, UVec2, Vec2, Vec3};
use rayon::prelude::*;
use unframed_wire::tiles::TileNode;
use unframed_wire::{SKY, Status, TileFields};

use crate::effects::care::{Care, Told};
use crate::trace::camera::Camera;
use crate::trace::{Hit, Rays, World};

/// All that a sampler may know of the scene: the view, the poses, and what a ray finds.
///
/// Times are seconds of simulated time, within the span in question. What a sampler that looks ahead
/// ([`Sampler::looks_ahead`]) sees at an instant is the end of the span, as foreseen then.
pub trait Eye: Sync {
    /// The camera at an instant.
    fn camera(&self, time: f64) -> Camera;
    /// From an object's own coordinates to the world, metres. Object 0 is the static world; for
    /// [`unframed_wire::SKY`] the translation to the eye.
    fn pose(&self, object: u8, time: f64) -> Affine3A;
    /// The instant, seconds, of which that tells what is seen at `time`: the same, or the end of the span.
    fn as_of(&self, time: f64) -> f64 {
        time
    }
    /// What is seen through a place of the image, in pixels from the top left corner.
    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit;
    /// What is seen from the eye in a direction whose component along the camera's axis is 1.
    fn look_along(&self, time: f64, direction: Vec3, seed: u32) -> Hit;

    /// [`Self::look`] with care for effects, and what these told.
    fn look_with(&self, time: f64, pixel: Vec2, seed: u32, _care: Care) -> (Hit, Told) {
        (self.look(time, pixel, seed), Told::default())
    }
    /// [`Self::look_along`] with care for effects, and what these told.
    fn look_along_with(&self, time: f64, direction: Vec3, seed: u32, _care: Care) -> (Hit, Told) {
        (self.look_along(time, direction, seed), Told::default())
    }

    /// Whether a place of an object (its own coordinates, metres; a direction for the sky) is seen
    /// from the eye: before it, with nothing in between. One ray, which need not be shaded.
    fn sees(&self, time: f64, object: u8, local: Vec3) -> bool {
        let camera = self.camera(time);
        let offset = self.pose(object, time).transform_point3(local) - camera.eye;
        let Some((_, depth)) = camera.project_direction(offset) else {
            return false;
        };
        let found = self.look_along(time, offset / depth, 0);
        if object == SKY {
            found.object == SKY
        } else {
            found.depth >= depth * SEEN
        }
    }
}

/// How much of the way to a place must be free for the place to be seen: rounding puts it a little
/// behind its own surface.
pub(crate) const SEEN: f32 = 0.999;

/// Rays at the instants that were prepared; views and poses at any.
impl Eye for World {
    fn camera(&self, time: f64) -> Camera {
        World::camera(self, time)
    }

    fn pose(&self, object: u8, time: f64) -> Affine3A {
        World::pose(self, object, time)
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        self.moment(time).look(pixel, seed)
    }

    fn look_along(&self, time: f64, direction: Vec3, seed: u32) -> Hit {
        self.moment(time).look_along(direction, seed)
    }

    fn look_with(&self, time: f64, pixel: Vec2, seed: u32, care: Care) -> (Hit, Told) {
        self.moment(time).look_with(pixel, seed, care)
    }

    fn look_along_with(&self, time: f64, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        self.moment(time).look_along_with(direction, seed, care)
    }

    fn sees(&self, time: f64, object: u8, local: Vec3) -> bool {
        let moment = self.moment(time);
        let camera = moment.camera();
        let offset = World::pose(self, object, time).transform_point3(local) - camera.eye;
        let end = if object == SKY { f32::INFINITY } else { SEEN };
        camera.project_direction(offset).is_some() && moment.is_clear(offset, end)
    }
}

/// A stretch of simulated time and its budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Begin, seconds; the instant of the first shot.
    pub t0: f64,
    /// End, seconds, not included.
    pub t1: f64,
    /// How many shots there are to take; shot `i` is taken at `t0 + (t1 − t0)·i/shots`.
    pub shots: usize,
}

impl Span {
    /// The instant of a shot, seconds.
    #[must_use]
    pub fn instant(&self, shot: usize) -> f64 {
        self.t0 + (self.t1 - self.t0) * (shot as f64 / self.shots.max(1) as f64)
    }

    /// Length, seconds.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.t1 - self.t0
    }
}

/// One sample: when, where on the image, and what was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// The instant at which it was taken, seconds.
    pub time: f64,
    /// The instant of which it tells, seconds: that, or later if it was foreseen.
    pub as_of: f64,
    /// Place on the image then, pixels from the top left corner; within the image.
    pub pixel: Vec2,
    /// What the ray found.
    pub hit: Hit,
}

/// Where the wall-clock time of a sampler's epochs went since its beginning, seconds; the rest is
/// control: deciding where to look, and learning from it. Decides nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Looking: rays and shading.
    pub tracing: f64,
    /// Moving what is remembered to a new view.
    pub reprojection: f64,
}

/// A way of choosing where to look.
pub trait Sampler: Send {
    /// Takes `span.shots` shots in the order of time and appends them to `out`. Spans follow each
    /// other without gaps. A sampler that also traces rays that are no samples takes so many fewer
    /// shots as they cost; what is left of a budget may be spent in the next span.
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>);

    /// The best length of a span for this sampler, seconds.
    fn preferred_span(&self) -> f64 {
        1.0 / 60.0
    }

    /// The k-d cut of the image with side data for the display, in preorder, as of the end of
    /// the last epoch; only `fields` are wanted. Empty if the sampler has nothing to tell.
    fn tiles(&mut self, _fields: TileFields, out: &mut Vec<TileNode>) {
        out.clear();
    }

    /// If the scene changed wholly since the last call: the instant (seconds) at which it did, as
    /// far as the sampler can tell. The display should forget all samples before it.
    fn take_cut(&mut self) -> Option<f64> {
        None
    }

    /// Rays traced since the last call that gave no samples.
    fn take_rays(&mut self) -> Rays {
        Rays::default()
    }

    /// Whether its samples see everything, the eye included, as it is foreseen to be at the end of a span.
    fn looks_ahead(&self) -> bool {
        false
    }

    /// The display's report.
    fn status(&mut self, _status: &Status) {}

    /// Where the time of all epochs went; `None` if the sampler does not keep count: then it
    /// counts as tracing.
    fn effort(&self) -> Option<Effort> {
        None
    }
}

/// Where a planned shot goes.
#[derive(Clone, Copy, Debug)]
enum Aim {
    /// Through a place of the image, pixels.
    Pixel(Vec2),
    /// At a place of an object (its own coordinates, metres) seen before; through the pixel
    /// instead if the place is not within the image any more.
    Again {
        object: u8,
        local: Vec3,
        instead: Vec2,
    },
}

/// A planned shot.
#[derive(Clone, Copy, Debug)]
struct Plan {
    time: f64,
    aim: Aim,
    seed: u32,
    care: Care,
}

/// A shot as its planner sees it.
#[derive(Clone, Copy, Debug)]
struct Seen {
    shot: Shot,
    /// For a place looked at again: the depth at which it must be, metres (infinite: the sky).
    expected: Option<f32>,
    /// What its effects told.
    told: Told,
}

/// Traces planned shots of an image of `size` pixels in parallel; `seen[i]` is that of `plans[i]`.
fn trace(plans: &[Plan], size: UVec2, eye: &dyn Eye, seen: &mut Vec<Seen>) {
    let through = |plan: &Plan, pixel: Vec2| {
        let (hit, told) = eye.look_with(plan.time, pixel, plan.seed, plan.care);
        Seen {
            shot: Shot {
                time: plan.time,
                as_of: eye.as_of(plan.time),
                pixel,
                hit,
            },
            expected: None,
            told,
        }
    };
    let look = |plan: &Plan| match plan.aim {
        Aim::Pixel(pixel) => through(plan, pixel),
        Aim::Again {
            object,
            local,
            instead,
        } => {
            let camera = eye.camera(plan.time);
            let offset = eye.pose(object, plan.time).transform_point3(local) - camera.eye;
            let inside =
                |p: &(Vec2, f32)| p.0.cmpge(Vec2::ZERO).all() && p.0.cmplt(size.as_vec2()).all();
            let Some((pixel, depth)) = camera.project_direction(offset).filter(inside) else {
                return through(plan, instead);
            };
            let towards = offset / depth;
            let (hit, told) = eye.look_along_with(plan.time, towards, plan.seed, plan.care);
            let expected = if object == SKY { f32::INFINITY } else { depth };
            Seen {
                shot: Shot {
                    time: plan.time,
                    as_of: eye.as_of(plan.time),
                    pixel,
                    hit,
                },
                expected: Some(expected),
                told,
            }
        }
    };
    plans
        .par_iter()
        .with_min_len(32)
        .map(look)
        .collect_into_vec(seen);
}
