//! The ideal image: what a display with infinite rate would show at an instant.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::srgb;
use super::world::World;
use crate::effects::care::{self, Care, MOST};

/// Rays of effects for each sample of a pixel: with 16 samples a pixel sees an area light through
/// 128 points, 256 choices of virtual lights and 64 places in a medium.
const CARE: Care = Care {
    rays: [8, 16, 4],
    pattern: true,
    open: false,
};

/// The image at instant `t` (seconds), row by row from the top, sRGB codes.
///
/// Each pixel is the mean, in linear light, of `n`×`n` samples on a regular grid; `n` of 0
/// counts as 1. All see the same instant. The result does not depend on the number of threads.
/// The world's prepared epoch is `t` afterwards.
pub fn ideal(world: &mut World, t: f64, n: u32) -> Vec<[u8; 3]> {
    world.prepare(t, t);
    let moment = world.moment(t);
    let [width, height] = world.size();
    let n = n.max(1);
    let mut image = vec![[0; 3]; width as usize * height as usize];
    image
        .par_chunks_mut(width as usize)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let mut sum = Vec3::ZERO;
                let set = care::set(y as u32 * width + x as u32);
                for i in 0..n * n {
                    let at = Vec2::new((i % n) as f32, (i / n) as f32) + 0.5;
                    let place = Vec2::new(x as f32, y as f32) + at / n as f32;
                    // Points of one set in a pixel, another set in the next.
                    sum += moment
                        .look_with(place, set | (i * MOST as u32), CARE)
                        .0
                        .colour;
                }
                *pixel = srgb::encode8(sum / (n * n) as f32);
            }
        });
    image
}
