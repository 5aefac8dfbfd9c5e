//! The path-traced reference: the same light transport without interleaving, filter, virtual
//! lights or clamp (Kajiya 1986), through pixel middles.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::care::Care;
use super::deferred::Deferred;
use super::vpl::cosine;
use crate::trace::moment::{Moment, Struck, unit_square};
use crate::trace::shade::Shader;
use crate::trace::{Rays, World};

/// Linear light of the instant `t` (seconds), `samples` paths a pixel, rows from the top. The
/// world's prepared epoch is `t` afterwards.
pub fn reference(world: &mut World, t: f64, samples: u32) -> Vec<Vec3> {
    world.prepare(t, t);
    let moment = world.moment(t);
    let [width, height] = world.size();
    (0..width * height)
        .into_par_iter()
        .map(|i| {
            let pixel = Vec2::new((i % width) as f32, (i / width) as f32) + 0.5;
            estimate(&moment, pixel, samples.max(1), i)
        })
        .collect()
}

/// The mean of `samples` estimates of what a pixel sees.
fn estimate(moment: &Moment<'_>, pixel: Vec2, samples: u32, seed: u32) -> Vec3 {
    let mut dice = Dice::new(seed);
    let middle = Deferred::look(moment, pixel, &mut Rays::default());
    // Without a lens, and where nothing is seen in a mirror or through glass, all paths begin alike.
    let aperture = moment.camera().aperture;
    let varies = aperture > 0.0 || !middle.is_matt(moment);
    let mut sum = Vec3::ZERO;
    for k in 0..samples {
        let mut seen = middle;
        if varies {
            let lens = on_disc(&mut dice) * aperture;
            let seed = seed << 16 ^ k;
            seen = Deferred::look_through(moment, pixel, lens, seed, &mut Rays::default());
        }
        let mut light = seen.own;
        if let Some(struck) = &seen.struck {
            light += seen.albedo * gathered(moment, struck, &mut dice);
        }
        if let Some(medium) = moment.medium()
            && let Some(inside) = medium.stretch(seen.eye, seen.direction, seen.distance)
        {
            let (s, weight) = medium.distance(inside.length(), dice.pair()[0]);
            let place = seen.eye + seen.direction * (inside.from + s);
            light *= medium.transmittance(inside.length());
            for lamp in 0..moment.lamp_count() {
                let thrown = moment.thrown(lamp, place, seen.direction, dice.pair(), &mut 0);
                light += thrown.map_or(Vec3::ZERO, |thrown| thrown.light) * weight;
            }
        }
        sum += light;
    }
    sum / samples as f32
}

/// A place in the unit disc, by rejection.
fn on_disc(dice: &mut Dice) -> Vec2 {
    loop {
        let place = Vec2::from(dice.pair()) * 2.0 - 1.0;
        if place.length_squared() <= 1.0 {
            return place;
        }
    }
}

/// Irradiance/π at a surface: lamps, then paths that go on by Russian roulette.
fn gathered(moment: &Moment<'_>, struck: &Struck, dice: &mut Dice) -> Vec3 {
    let mut sum = moment.ambient();
    let mut weight = Vec3::ONE;
    let mut at = *struck;
    loop {
        let mut light = moment.punctual(&at, &mut 0);
        for lamp in moment.area_lamps() {
            let arriving = moment.direct(lamp, &at, dice.pair(), &mut 0);
            light += arriving.unwrap_or(Vec3::ZERO) * FRAC_1_PI;
        }
        sum += weight * light;
        if !moment.indirect() {
            return sum;
        }
        let (origin, direction) = (at.clear(), cosine(at.smooth, dice.pair()));
        let Some(next) = moment.closest(origin, direction) else {
            return sum;
        };
        weight *= moment.between(origin, direction, next.t)
            * Shader::new(moment, 0, Care::default()).albedo(&next);
        let survives = weight.max_element().min(0.95);
        if dice.pair()[0] >= survives {
            return sum;
        }
        weight /= survives;
        at = next;
    }
}

/// Random numbers.
pub(crate) struct Dice(u32);

impl Dice {
    pub(crate) fn new(seed: u32) -> Self {
        // Hashed: seeds that differ by a step of the dice would throw the same numbers, one later.
        Self((unit_square(seed)[0] * 16_777_216.0) as u32 ^ seed << 24)
    }

    /// Two in 0..1.
    pub(crate) fn pair(&mut self) -> [f32; 2] {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        unit_square(self.0)
    }
}
