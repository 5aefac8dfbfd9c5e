//! How far things moved since a sample was taken, and which samples that could have hidden.
//!
//! A sample was in sight when it was taken. It can only be hidden now if since then it and what
//! lies before it moved against each other on the screen: with eye (or object) moved by `D` and
//! the occluder at depth `z`, by at most `f·D/z` pixels, `f` the focal length in pixels. Without
//! this, a wire thinner than a pixel would hide the wall behind it as soon as every pixel had met
//! one sample of the wire.
//!
//! [`Motion`] keeps the way travelled up to each refresh, of the eye and of the fastest object;
//! the way is no shorter than the distance, so nothing that may be hidden is spared.

use crate::arith::Arith;
use crate::memory::Slot;
use crate::num::log2_q11;
use unframed_wire::{Pose, Tick, View};

/// Refreshes remembered.
const STEPS: usize = 32;
/// log2 of the microseconds in a bucket of ages.
pub const BUCKET_BITS: u32 = 12;
/// Buckets of ages; the last holds all older samples.
pub const BUCKETS: usize = 64;
/// log2 of the parallax, pixels, from which a sample may be hidden, 11 fractional bits.
const LEAST_PARALLAX: i32 = 0;
/// Slots of the sky and of the static world: they do not move by themselves.
const RESTING_SLOTS: usize = 2;

/// The way travelled up to a refresh, world units modulo 2^32.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    time: Tick,
    eye: u32,
    objects: u32,
}

/// For each bucket of ages, the depth up to which an occluder can have hidden a sample: without
/// and with moving objects, in the unit of [`Arith::depth_of_log`].
#[derive(Clone, Copy, Debug)]
pub struct Reach<A: Arith> {
    /// Occluder and sample rest: the eye's way alone.
    pub resting: [A::Depth; BUCKETS],
    /// One of them may move.
    pub moving: [A::Depth; BUCKETS],
}

impl<A: Arith> Reach<A> {
    /// The depth for a sample, where a moving object is near it and where none is.
    #[inline]
    #[must_use]
    pub fn of(&self, past: Past, near_mover: bool) -> A::Depth {
        let bucket = usize::from(past.0) % BUCKETS;
        if near_mover || past.moves() {
            self.moving[bucket]
        } else {
            self.resting[bucket]
        }
    }
}

/// What may have hidden a sample since it was taken: the bucket of its age, and whether it belongs
/// to an object that moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Past(u8);

impl Past {
    /// Moving or not; the other bits hold the bucket.
    const MOVES: u8 = 0x80;
    /// Of a sample at rest when it was taken a moment ago.
    pub const NONE: Self = Self(0);

    /// Of a sample of this age, microseconds.
    #[inline]
    #[must_use]
    pub fn new(age: u32, moves: bool) -> Self {
        let bucket = (age >> BUCKET_BITS).min(BUCKETS as u32 - 1) as u8;
        Self(bucket).moving(moves)
    }

    /// The same of a sample that moves, or not.
    #[inline]
    #[must_use]
    pub const fn moving(self, moves: bool) -> Self {
        Self(self.0 & !Self::MOVES | if moves { Self::MOVES } else { 0 })
    }

    /// Whether it belongs to an object that moves.
    #[inline]
    #[must_use]
    pub const fn moves(self) -> bool {
        self.0 & Self::MOVES != 0
    }
}

const _: () = assert!(BUCKETS <= Past::MOVES as usize && BUCKETS.is_power_of_two());

/// The ways travelled, refresh by refresh.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    steps: [Step; STEPS],
    len: usize,
    eye: Option<[i32; 3]>,
}

impl Default for Motion {
    fn default() -> Self {
        Self::new()
    }
}

impl Motion {
    /// Nothing seen yet.
    #[must_use]
    pub const fn new() -> Self {
        let step = Step {
            time: Tick(0),
            eye: 0,
            objects: 0,
        };
        Self {
            steps: [step; STEPS],
            len: 0,
            eye: None,
        }
    }

    /// Forgets all ways.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// Notes what moved since the last refresh: the eye, and the poses that are not those `shown`
    /// then (which it brings up to date).
    pub fn refresh<A: Arith>(&mut self, now: Tick, view: &View, slots: &mut [Slot<A>]) {
        let mut last = self.known().last().copied().unwrap_or_default();
        let eye = self.eye.map_or(0, |eye| distance(eye, view.eye));
        self.eye = Some(view.eye);
        let mut objects = 0;
        for (index, slot) in slots.iter_mut().enumerate() {
            if let (Some(old), Some(new)) = (&slot.shown, &slot.pose)
                && index >= RESTING_SLOTS
            {
                objects = objects.max(way(old, new));
            }
            slot.shown = slot.pose;
        }
        last.time = now;
        last.eye = last.eye.wrapping_add(eye);
        last.objects = last.objects.wrapping_add(objects);
        if self.len >= STEPS {
            self.steps.rotate_left(1);
            self.len = STEPS - 1;
        }
        if let Some(step) = self.steps.get_mut(self.len) {
            *step = last;
            self.len += 1;
        }
    }

    /// How far occlusion can reach now.
    #[must_use]
    pub fn reach<A: Arith>(&self, view: &View) -> Reach<A> {
        let mut reach = Reach {
            resting: [A::depth_of_log(i32::MIN); BUCKETS],
            moving: [A::depth_of_log(i32::MIN); BUCKETS],
        };
        let Some(now) = self.known().last().copied() else {
            return reach;
        };
        let focal = focal_log(view);
        let depths = reach.resting.iter_mut().zip(&mut reach.moving);
        for (bucket, (resting, moving)) in depths.enumerate() {
            let age = ((bucket as u32) << BUCKET_BITS) + (1 << BUCKET_BITS >> 1);
            let (eye, objects) = self.since(now, age);
            let log = |way: u64| {
                let log = if way == 0 { i32::MIN } else { log2_q11(way) };
                log.saturating_add(focal - LEAST_PARALLAX)
            };
            *resting = A::depth_of_log(log(u64::from(eye)));
            *moving = A::depth_of_log(log(u64::from(eye) + u64::from(objects)));
        }
        reach
    }

    /// The refreshes remembered, oldest first.
    fn known(&self) -> &[Step] {
        self.steps.get(..self.len).unwrap_or_default()
    }

    /// The ways since `age` before the newest refresh, linear between refreshes.
    fn since(&self, now: Step, age: u32) -> (u32, u32) {
        let mut later = now;
        for step in self.known().iter().rev() {
            let before = now.time.since(step.time).max(0) as u32;
            if before >= age {
                let span = u64::from(later.time.since(step.time).max(1).unsigned_abs());
                let part = u64::from(before - age);
                let along = |a: u32, b: u32| {
                    let way = u64::from(b.wrapping_sub(a));
                    // The part of the step after the sample was taken.
                    (way - way * part.min(span) / span) as u32
                };
                let rest = |a: u32, b: u32| b.wrapping_sub(a);
                return (
                    along(step.eye, later.eye).saturating_add(rest(later.eye, now.eye)),
                    along(step.objects, later.objects)
                        .saturating_add(rest(later.objects, now.objects)),
                );
            }
            later = *step;
        }
        (
            now.eye.wrapping_sub(later.eye),
            now.objects.wrapping_sub(later.objects),
        )
    }
}

/// log2 of the focal length in pixels, at most 1/2 too large, with 11 fractional bits.
fn focal_log(view: &View) -> i32 {
    let square: u64 = view.rows[0]
        .iter()
        .map(|v| u64::from(v.unsigned_abs()).pow(2))
        .sum();
    (log2_q11(square) >> 1) - (i32::from(view.frac_bits) << 11)
}

/// Distance of two sound places ([`crate::transform::PLACE_LIMIT`]), rounded up.
fn distance(a: [i32; 3], b: [i32; 3]) -> u32 {
    // Three squares of at most 2^60.
    let square: u64 = a
        .iter()
        .zip(b)
        .map(|(a, b)| (i64::from(*a) - i64::from(b)).unsigned_abs())
        .map(|d| d.min(1 << 30).pow(2))
        .sum();
    let root = square.isqrt();
    (root + u64::from(root * root < square)) as u32
}

/// An upper bound of how far any point of an object's lattice moved between two poses.
fn way(old: &Pose, new: &Pose) -> u32 {
    let corner =
        |pose: &Pose, k: usize, j: usize| (i64::from(pose.matrix[k][j]) << 15) >> pose.frac_bits;
    let sum: u64 = (0..3)
        .map(|k| {
            let shift = i64::from(old.translation[k]) - i64::from(new.translation[k]);
            let turn: u64 = (0..3)
                .map(|j| (corner(old, k, j) - corner(new, k, j)).unsigned_abs())
                .sum();
            shift.unsigned_abs() + turn
        })
        .sum();
    sum.min(u64::from(u32::MAX)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Fixed;

    fn view(eye: [i32; 3]) -> View {
        let one = 1 << 20;
        View {
            time: Tick(0),
            eye,
            rows: [[256 * one, 0, 0], [0, 256 * one, 0], [0, 0, one]],
            frac_bits: 20,
        }
    }

    fn moved(speed: i32) -> Reach<Fixed> {
        let mut motion = Motion::new();
        let mut slots = [Slot::<Fixed>::default(); 3];
        for k in 0..8 {
            motion.refresh(
                Tick(k * 16_384),
                &view([k as i32 * speed, 0, 0]),
                &mut slots,
            );
        }
        motion.reach(&view([7 * speed, 0, 0]))
    }

    #[test]
    fn at_rest_nothing_is_hidden() {
        let reach = moved(0);
        assert!(
            reach
                .resting
                .iter()
                .chain(&reach.moving)
                .all(|depth| *depth == 0)
        );
    }

    #[test]
    fn reach_is_that_of_one_pixel_of_parallax() {
        // 1000 units a refresh: after two refreshes 2000, times 256 px: one pixel at 512,000.
        let reach = moved(1000);
        let got = f64::from(reach.of(Past::new(2 * 16_384, false), false));
        let exact = 512_000f64.log2() * 2048.0;
        // The bucket's middle is half a bucket (an eighth of a refresh) later.
        assert!((got - exact).abs() < 0.1 * 2048.0, "{got} {exact}");
        assert!(reach.resting.windows(2).all(|pair| pair[0] <= pair[1]));
    }

    #[test]
    fn distances_and_ways_are_upper_bounds() {
        assert_eq!(distance([0; 3], [0; 3]), 0);
        for d in [
            [3, 4, 0],
            [1, 1, 0],
            [1 << 30, 1 << 30, 1 << 30],
            [0, -77, 5],
        ] {
            let exact = d.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
            let got = f64::from(distance([0; 3], d));
            assert!(got >= exact - 1e-3 && got < exact + 1.0, "{got} {exact}");
        }
    }
}
