//! Adaptive interleaved sampling of whole frames (Dubla et al. 2009, §3): for each component an
//! initial sample a pixel, guidance by pattern, refinement, a filter by component, then albedo.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::components::{Component, Haze, Indirect, SoftShadows};
use super::deferred::Deferred;
use super::interleave::{Canvas, interleave};
use super::sets::Sets;
use super::vpl;
use crate::trace::{Rays, World};

/// Side of the interleaving pattern, pixels (§4.2).
pub const SIDE: u32 = 3;
/// Most samples of a component a pixel (§4.2).
pub const MOST: u32 = 9;
/// Paths of virtual point lights in a frame: about the 256 lights of §4.2.
const PATHS: usize = 144;
/// Estimates a sample of what they leave out near by: few beside some thirty rays to lights.
const CORRECTIONS: u32 = 4;
/// Within this distance, metres, they grow no stronger.
const NEAR: f32 = 0.2;

/// How many samples pixels get, of 1..=[`MOST`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refinement {
    /// What the paper's guidance asks for (Listings 2 to 4; "A" in the paper).
    Listings,
    /// As many as bring the noise that the filter leaves below a displayed level.
    Adaptive,
    /// All there are ("A-MAX").
    All,
    /// The same everywhere, by component: soft shadows, indirect diffuse, medium.
    Plain([u32; 3]),
}

/// A component of a finished frame.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Name of the effect.
    pub name: &'static str,
    /// Samples that each pixel took, rows from the top, at the layer's own resolution.
    pub samples: Vec<u8>,
    /// Pixels in a row of the layer.
    pub width: u32,
}

impl Layer {
    /// Mean samples a pixel.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.samples.iter().map(|&n| f64::from(n)).sum();
        sum / self.samples.len().max(1) as f64
    }
}

/// A finished frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Linear light, rows from the top, not clamped.
    pub light: Vec<Vec3>,
    /// Rays by effect.
    pub rays: Rays,
    /// Layers of the effects that the scene calls for.
    pub layers: Vec<Layer>,
}

/// Renders the instant `t`, seconds; the world's prepared epoch is `t` afterwards.
pub fn render(world: &mut World, t: f64, refinement: Refinement) -> Frame {
    render_with(world, t, refinement, SIDE)
}

/// The same with a pattern of another side, pixels. The filter's box is as large and has its pixel
/// in the middle, so the side is odd: what is even counts as one more, 0 as 1.
pub fn render_with(world: &mut World, t: f64, refinement: Refinement, side: u32) -> Frame {
    let side = side | 1;
    let pixels = side * side;
    world.prepare(t, t);
    let moment = world.moment(t);
    let [width, height] = world.size();
    let mut rays = Rays::default();
    let seen = looks(&moment, [width, height], 1, &mut rays);
    let hard = |at: &Deferred| {
        let mut rays = 0;
        let light = at.struck.as_ref().map_or(Vec3::ZERO, |struck| {
            moment.ambient() + moment.punctual(struck, &mut rays)
        });
        (light, rays)
    };
    let (mut light, hard_rays): (Vec<Vec3>, Vec<u32>) = seen.par_iter().map(hard).unzip();
    rays.shadow += hard_rays.iter().sum::<u32>();
    let mut layers = Vec::new();
    let sets = Sets::new(pixels, MOST);
    if moment.area_lamps().next().is_some() {
        let soft = SoftShadows {
            moment: &moment,
            sets: &sets,
        };
        let known = shaded(&light, &seen);
        let canvas = Canvas {
            seen: &seen,
            width,
            side,
            known: &known,
        };
        let name = "soft_shadows";
        let (found, layer) = interleave(&soft, name, &canvas, refinement, 0, &mut rays);
        add(&mut light, &filtered(&found, &seen, width, side));
        layers.push(layer);
    }
    if moment.indirect() {
        // At a quarter of the pixels (§4.1).
        let vpls = vpl::scatter(&moment, PATHS, NEAR);
        rays.indirect += vpls.rays;
        let indirect = Indirect {
            moment: &moment,
            vpls: &vpls,
            subsets: pixels,
            corrections: CORRECTIONS,
        };
        let half = [width.div_ceil(2), height.div_ceil(2)];
        let few = looks(&moment, half, 2, &mut Rays::default());
        let known = shaded(&light, &seen);
        let known: Vec<Vec3> = (0..half[0] * half[1])
            .map(|i| known[(i / half[0] * 2 * width + i % half[0] * 2) as usize])
            .collect();
        let canvas = Canvas {
            seen: &few,
            width: half[0],
            side,
            known: &known,
        };
        let name = "indirect_diffuse";
        let (found, layer) = interleave(&indirect, name, &canvas, refinement, 1, &mut rays);
        let found = filtered(&found, &few, half[0], side);
        add(&mut light, &upsampled(&found, &few, half[0], &seen, width));
        layers.push(layer);
    }
    light = shaded(&light, &seen);
    if let Some(medium) = moment.medium() {
        let haze = Haze {
            moment: &moment,
            sets: &sets,
            pattern: [pixels, MOST],
        };
        for (sum, at) in light.iter_mut().zip(&seen) {
            *sum *= medium.between(at.eye, at.direction, at.distance);
        }
        let canvas = Canvas {
            seen: &seen,
            width,
            side,
            known: &light,
        };
        let (found, layer) = interleave(&haze, "medium", &canvas, refinement, 2, &mut rays);
        add(&mut light, &filtered(&found, &seen, width, side));
        layers.push(layer);
    }
    Frame {
        light,
        rays,
        layers,
    }
}

/// Indirect light alone, of all lights of `paths` paths, without interleaving or filter, with
/// `corrections` estimates a pixel of what the lights leave out near by. What it
/// converges to as both grow is the reference. Linear light, rows from the top; the world's
/// prepared epoch is `t` afterwards.
pub fn indirect_alone(world: &mut World, t: f64, paths: usize, corrections: u32) -> Vec<Vec3> {
    world.prepare(t, t);
    let moment = world.moment(t);
    let vpls = vpl::scatter(&moment, paths, vpl::NEAR);
    let indirect = Indirect {
        moment: &moment,
        vpls: &vpls,
        subsets: 1,
        corrections,
    };
    let seen = looks(&moment, world.size(), 1, &mut Rays::default());
    let light = |at: &Deferred| {
        let (light, _) = indirect.sample(at, 0, 0, &mut Rays::default());
        light * at.albedo
    };
    seen.par_iter().map(light).collect()
}

/// Looks through the middles of blocks of `side` × `side` pixels.
fn looks(
    moment: &crate::trace::Moment<'_>,
    [width, height]: [u32; 2],
    side: u32,
    rays: &mut Rays,
) -> Vec<Deferred> {
    let (seen, counts): (Vec<_>, Vec<_>) = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let block = Vec2::new((i % width) as f32, (i / width) as f32);
            let mut rays = Rays::default();
            let at = Deferred::look(moment, block * side as f32 + 0.5, &mut rays);
            (at, rays)
        })
        .unzip();
    counts.into_iter().for_each(|r| *rays += r);
    seen
}

/// Light as it leaves towards the eye, from light as it arrives.
fn shaded(light: &[Vec3], seen: &[Deferred]) -> Vec<Vec3> {
    let shaded = |(light, at): (&Vec3, &Deferred)| *light * at.albedo + at.own;
    light.iter().zip(seen).map(shaded).collect()
}

fn add(sum: &mut [Vec3], more: &[Vec3]) {
    sum.iter_mut().zip(more).for_each(|(a, b)| *a += *b);
}

/// The discontinuity buffer: a box of the pattern's size over pixels that are alike. Any such
/// box holds each pixel of the pattern once.
fn filtered(light: &[Vec3], seen: &[Deferred], width: u32, side: u32) -> Vec<Vec3> {
    let (w, h) = (width as i32, seen.len() as i32 / width as i32);
    let reach = side as i32 / 2;
    let at = |i: usize| {
        let (x, y) = (i as i32 % w, i as i32 / w);
        let (mut sum, mut n) = (Vec3::ZERO, 0.0);
        for ny in (y - reach).max(0)..=(y + reach).min(h - 1) {
            for nx in (x - reach).max(0)..=(x + reach).min(w - 1) {
                let k = (ny * w + nx) as usize;
                if seen[i].like(&seen[k]) {
                    sum += light[k];
                    n += 1.0;
                }
            }
        }
        sum / n
    };
    (0..seen.len()).into_par_iter().map(at).collect()
}

/// Joint bilateral upsampling from every second pixel (Kopf et al. 2007; bilinear weights as in
/// Dubla §4.1). Where no neighbour is alike, the nearest counts.
fn upsampled(
    few: &[Vec3],
    few_seen: &[Deferred],
    few_width: u32,
    seen: &[Deferred],
    width: u32,
) -> Vec<Vec3> {
    let few_height = few.len() as u32 / few_width;
    let at = |i: usize| {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (fx, fy) = (
                (x / 2 + dx).min(few_width - 1),
                (y / 2 + dy).min(few_height - 1),
            );
            let k = (fy * few_width + fx) as usize;
            let part = |d: u32, at: u32| {
                if at.is_multiple_of(2) {
                    1.0 - d as f32
                } else {
                    0.5
                }
            };
            let weight = part(dx, x) * part(dy, y);
            if weight > 0.0 && seen[i].like(&few_seen[k]) {
                sum += few[k] * weight;
                weights += weight;
            }
        }
        if weights > 0.0 {
            sum / weights
        } else {
            few[((y / 2) * few_width + x / 2) as usize]
        }
    };
    (0..seen.len()).into_par_iter().map(at).collect()
}
