//! Samplers that learn nothing: the baselines.

use glam::{UVec2, Vec2};

use super::noise::{R2, Random, hash};
use super::{Aim, Care, Eye, Plan, Sampler, Seen, Shot, Span, trace};

/// Where in a pixel the traditional sampler looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At the centre: as displayed by whoever shows a sample as its pixel.
    Centre,
    /// Anywhere in it: antialiased over time, noisier at an instant.
    Jittered,
}

/// Traditional frameless sampling (Bishop, Fuchs, McMillan & Scher Zagier 1994): every pixel once
/// in random order, then again in another.
#[derive(Clone, Debug)]
pub struct Traditional {
    size: UVec2,
    order: Vec<u32>,
    next: usize,
    place: Place,
    random: Random,
    plans: Vec<Plan>,
    seen: Vec<Seen>,
}

impl Traditional {
    /// For an image of `size` pixels.
    #[must_use]
    pub fn new(size: UVec2, place: Place, seed: u64) -> Self {
        Self {
            size,
            order: (0..size.x * size.y).collect(),
            next: 0,
            place,
            random: Random::new(seed),
            plans: Vec::new(),
            seen: Vec::new(),
        }
    }

    fn pixel(&mut self) -> Vec2 {
        if self.next == 0 {
            // Fisher and Yates, so that all orders are equally likely.
            for i in (1..self.order.len()).rev() {
                self.order.swap(i, self.random.below(i as u32 + 1) as usize);
            }
        }
        let pixel = self.order[self.next];
        self.next = (self.next + 1) % self.order.len();
        let within = match self.place {
            Place::Centre => Vec2::splat(0.5),
            // A step of 1/256, so that no coordinate rounds up to the next pixel.
            Place::Jittered => {
                let step = |bits: u32| (bits & 255) as f32 / 256.0 + 1.0 / 512.0;
                let bits = self.random.next();
                Vec2::new(step(bits), step(bits >> 8))
            }
        };
        Vec2::new((pixel % self.size.x) as f32, (pixel / self.size.x) as f32) + within
    }
}

impl Sampler for Traditional {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        if self.order.is_empty() {
            return;
        }
        self.plans.clear();
        for i in 0..span.shots {
            let aim = Aim::Pixel(self.pixel());
            let seed = self.random.next();
            self.plans.push(Plan {
                time: span.instant(i),
                aim,
                seed,
                care: Care::default(),
            });
        }
        trace(&self.plans, self.size, eye, &mut self.seen);
        out.extend(self.seen.iter().map(|s| s.shot));
    }
}

/// Single samples spread evenly over the image by a low-discrepancy sequence.
#[derive(Clone, Debug)]
pub struct Uniform {
    size: UVec2,
    points: R2,
    count: u32,
    seed: u32,
    plans: Vec<Plan>,
    seen: Vec<Seen>,
}

impl Uniform {
    /// For an image of `size` pixels.
    #[must_use]
    pub fn new(size: UVec2, seed: u64) -> Self {
        let seed = hash(seed as u32 ^ hash((seed >> 32) as u32));
        Self {
            size,
            points: R2::new(seed),
            count: 0,
            seed,
            plans: Vec::new(),
            seen: Vec::new(),
        }
    }
}

impl Sampler for Uniform {
    fn epoch(&mut self, span: Span, eye: &dyn Eye, out: &mut Vec<Shot>) {
        self.plans.clear();
        for i in 0..span.shots {
            let pixel = within(self.points.next() * self.size.as_vec2(), self.size);
            self.count = self.count.wrapping_add(1);
            let seed = hash(self.count ^ self.seed);
            self.plans.push(Plan {
                time: span.instant(i),
                aim: Aim::Pixel(pixel),
                seed,
                care: Care::default(),
            });
        }
        trace(&self.plans, self.size, eye, &mut self.seen);
        out.extend(self.seen.iter().map(|s| s.shot));
    }
}

/// Moves a place into the image: a product such as `u·width` with u < 1 can round up to the
/// width.
pub(super) fn within(pixel: Vec2, size: UVec2) -> Vec2 {
    let last = Vec2::new((size.x as f32).next_down(), (size.y as f32).next_down());
    pixel.clamp(Vec2::ZERO, last.max(Vec2::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::stage::Stage;

    fn span(shots: usize) -> Span {
        Span {
            t0: 0.0,
            t1: 1.0,
            shots,
        }
    }

    #[test]
    fn traditional_visits_each_pixel_once_a_pass() {
        let stage = Stage::new(UVec2::new(16, 12));
        let mut sampler = Traditional::new(stage.size, Place::Jittered, 3);
        let mut out = Vec::new();
        sampler.epoch(span(16 * 12 * 2), &stage, &mut out);
        let index = |s: &Shot| s.pixel.y as usize * 16 + s.pixel.x as usize;
        let (first, second) = out.split_at(16 * 12);
        for pass in [first, second] {
            let mut seen = [0; 16 * 12];
            pass.iter().for_each(|s| seen[index(s)] += 1);
            assert!(seen.iter().all(|&n| n == 1));
        }
        assert!(
            first.iter().zip(second).any(|(a, b)| index(a) != index(b)),
            "a new order"
        );
    }

    #[test]
    fn uniform_covers_the_image_evenly_and_stays_inside() {
        let stage = Stage::new(UVec2::new(64, 48));
        let mut sampler = Uniform::new(stage.size, 9);
        let mut out = Vec::new();
        sampler.epoch(span(64 * 48), &stage, &mut out);
        assert_eq!(out.len(), 64 * 48);
        let mut boxes = [0i32; 8 * 6];
        for shot in &out {
            assert!(shot.pixel.cmpge(Vec2::ZERO).all());
            assert!(shot.pixel.x < 64.0 && shot.pixel.y < 48.0);
            boxes[(shot.pixel.y / 8.0) as usize * 8 + (shot.pixel.x / 8.0) as usize] += 1;
        }
        assert!(boxes.iter().all(|n| (n - 64).abs() <= 6), "{boxes:?}");
    }

    #[test]
    fn instants_are_those_of_the_rate() {
        let stage = Stage::new(UVec2::new(8, 8));
        let mut out = Vec::new();
        Uniform::new(stage.size, 1).epoch(
            Span {
                t0: 2.0,
                t1: 2.5,
                shots: 5,
            },
            &stage,
            &mut out,
        );
        let times: Vec<f64> = out.iter().map(|s| s.time).collect();
        assert_eq!(times, [2.0, 2.1, 2.2, 2.3, 2.4]);
    }
}
