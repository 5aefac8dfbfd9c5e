//! The components that are interleaved: what each samples and what it tells the guidance
//! (Dubla et al. 2009, Listings 2 to 4).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::deferred::Deferred;
use super::reference::Dice;
use super::sets::Sets;
use super::vpl::Vpls;
use crate::trace::Rays;
use crate::trace::moment::{Moment, scramble};

/// Steps of the march through a medium.
const STEPS: u32 = 8;
/// The share of its variance that indirect light keeps in a whole pattern, whose subsets are all
/// lights there are: light from each is hidden from some pixels.
const KEPT: f32 = 0.1;
/// Distance, metres, below which a lamp's halo needs care, less the extinction (Listing 4).
const HALO: f32 = 1.0;

/// One effect of a frame.
pub(crate) trait Component: Sync {
    /// Light that sample `set` of pattern pixel `pixel` finds, and what it tells about the need
    /// of more (0..=1).
    fn sample(&self, at: &Deferred, pixel: u32, set: u32, rays: &mut Rays) -> (Vec3, Told);

    /// The share of the most refinement that a pattern needs, 0..=1, from what its pixels told:
    /// the paper's guidance.
    fn listing(&self, told: &[Told]) -> f32;

    /// What of the light goes to the eye.
    fn weight(&self, at: &Deferred) -> Vec3 {
        at.albedo
    }

    /// The share of a sample's variance that an average over a pattern keeps beyond 1/n, where
    /// only the share `alike` of neighbours are averaged.
    fn left(&self, _alike: f32) -> f32 {
        1.0
    }
}

/// What a sample tells the paper's guidance, 0..=1.
pub(crate) type Told = f32;

fn mean(told: &[f32]) -> f32 {
    told.iter().sum::<f32>() / told.len().max(1) as f32
}

/// Soft shadows: irradiance/π from area lights.
pub(crate) struct SoftShadows<'a> {
    pub(crate) moment: &'a Moment<'a>,
    pub(crate) sets: &'a Sets,
}

impl Component for SoftShadows<'_> {
    fn sample(&self, at: &Deferred, pixel: u32, set: u32, rays: &mut Rays) -> (Vec3, Told) {
        let Some(struck) = &at.struck else {
            return (Vec3::ZERO, 0.0);
        };
        let (mut light, mut missed, mut lamps) = (Vec3::ZERO, 0.0, 0.0);
        for lamp in self.moment.area_lamps() {
            let point = self.sets.point(pixel, set);
            lamps += 1.0;
            match self.moment.direct(lamp, struck, point, &mut rays.soft) {
                Some(arriving) => light += arriving * FRAC_1_PI,
                None => missed += 1.0,
            }
        }
        (light, if lamps > 0.0 { missed / lamps } else { 0.0 })
    }

    /// Listing 3: the share that is hidden, unless all or nothing is.
    fn listing(&self, told: &[Told]) -> f32 {
        let refine = mean(told);
        if refine < 1.0 { refine } else { 0.0 }
    }
}

/// Indirect diffuse: irradiance/π from virtual point lights, one subset a sample.
pub(crate) struct Indirect<'a> {
    pub(crate) moment: &'a Moment<'a>,
    pub(crate) vpls: &'a Vpls,
    /// Number of subsets: pixels of the pattern.
    pub(crate) subsets: u32,
    /// Estimates a sample of what the lights leave out near by.
    pub(crate) corrections: u32,
}

impl Component for Indirect<'_> {
    fn sample(&self, at: &Deferred, pixel: u32, set: u32, rays: &mut Rays) -> (Vec3, Told) {
        let Some(struck) = &at.struck else {
            return (Vec3::ZERO, 0.0);
        };
        let subset = (pixel + set) % self.subsets;
        let (mut light, mut missed, mut tried) = (Vec3::ZERO, 0.0f32, 0.0f32);
        let every = self.subsets as usize;
        let of_subset = self.vpls.lights.iter().skip(subset as usize).step_by(every);
        for vpl in of_subset {
            let incoming = vpl.incoming(struck.place, struck.smooth, self.vpls.near);
            let Some((towards, distance, arriving)) = incoming else {
                continue;
            };
            rays.indirect += 1;
            tried += 1.0;
            let origin = struck.clear();
            if self.moment.blocked(origin, towards, distance * 0.999) {
                missed += 1.0;
            } else {
                light += arriving * self.moment.between(origin, towards, distance);
            }
        }
        light *= self.subsets as f32 * FRAC_1_PI;
        let mut dice = Dice::new(scramble(at.direction) ^ set);
        for _ in 0..self.corrections {
            let (vpls, rays) = (self.vpls, &mut rays.indirect);
            let left_out = self.moment.left_out(vpls, struck, || dice.pair(), rays);
            light += left_out / self.corrections as f32;
        }
        (light, missed / tried.max(1.0))
    }

    /// The subsets of a whole pattern are all lights there are: what differs between them is
    /// noise only as far as the filter leaves members out, or as lights are hidden from some.
    fn left(&self, alike: f32) -> f32 {
        (1.0 - alike).max(KEPT)
    }

    /// Listing 2: the mean share of hidden lights.
    fn listing(&self, told: &[Told]) -> f32 {
        mean(told)
    }
}

/// A medium: light thrown towards the eye.
pub(crate) struct Haze<'a> {
    pub(crate) moment: &'a Moment<'a>,
    pub(crate) sets: &'a Sets,
    /// Pixels of the pattern and number of sets.
    pub(crate) pattern: [u32; 2],
}

impl Component for Haze<'_> {
    fn sample(&self, at: &Deferred, pixel: u32, set: u32, rays: &mut Rays) -> (Vec3, Told) {
        let Some(medium) = self.moment.medium() else {
            return (Vec3::ZERO, 0.0);
        };
        let Some(inside) = medium.stretch(at.eye, at.direction, at.distance) else {
            return (Vec3::ZERO, 0.0);
        };
        // Each pixel has a part of the step, each set a part of that (§3.4).
        let [pixels, sets] = self.pattern.map(|n| n as f32);
        let offset = (pixel as f32 + (set as f32 + 0.5) / sets) / pixels;
        let start = at.eye + at.direction * inside.from;
        let (mut light, mut asked) = (Vec3::ZERO, 0.0f32);
        let (mut missed, mut halo) = (0.0f32, 0.0f32);
        for lamp in 0..self.moment.lamp_count() {
            let source = self.moment.source(lamp, start, at.direction);
            for i in 0..STEPS {
                let part = (i as f32 + offset) / STEPS as f32;
                let (s, metres) = medium.place(inside.length(), source, part);
                let place = start + at.direction * s;
                // Another point of the lamp at each step.
                let point = self
                    .sets
                    .point(pixel + i * self.pattern[0] / STEPS, set + i);
                let rays = &mut rays.medium;
                let thrown = self.moment.thrown(lamp, place, at.direction, point, rays);
                asked += 1.0;
                if let Some(thrown) = thrown {
                    light += thrown.light * (metres / STEPS as f32);
                    missed += f32::from(u8::from(thrown.hidden));
                    halo += f32::from(u8::from(thrown.distance < HALO - medium.extinction()));
                }
            }
        }
        // Listing 4: both shares where they are neither none nor all.
        let (mut value, mut parts) = (0.0, 0.0);
        for share in [missed, halo].map(|n| n / asked.max(1.0)) {
            if share > 0.0 && share < 1.0 {
                value += share;
                parts += 1.0;
            }
        }
        (light, if parts > 1.0 { value / parts } else { value })
    }

    fn weight(&self, _at: &Deferred) -> Vec3 {
        Vec3::ONE
    }

    /// Listing 4: the share of pixels that differ from the one before.
    fn listing(&self, told: &[Told]) -> f32 {
        let differ = told.windows(2).filter(|w| w[0] != w[1]).count();
        differ as f32 / told.len().max(1) as f32
    }
}
