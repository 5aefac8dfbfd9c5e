//! The ideal image: what a display with infinite rate would show at an instant.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::srgb;
use super::world::World;

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
                for i in 0..n * n {
                    let at = Vec2::new((i % n) as f32, (i / n) as f32) + 0.5;
                    let place = Vec2::new(x as f32, y as f32) + at / n as f32;
                    // The same places on the lens in every pixel would show as a pattern.
                    let seed = (y as u32).wrapping_mul(width).wrapping_add(x as u32);
                    sum += moment
                        .look(place, seed.wrapping_mul(n * n).wrapping_add(i))
                        .colour;
                }
                *pixel = srgb::encode8(sum / (n * n) as f32);
            }
        });
    image
}
