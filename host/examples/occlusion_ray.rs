//! What an occlusion ray of the paper's sampler costs beside a shaded sample, on one thread:
//! `cargo run --release -p unframed-host --example occlusion_ray`

use std::time::Instant;

use glam::Vec2;
use unframed_host::sampler::Eye;
use unframed_host::scene::builtin;
use unframed_host::trace::{Hit, World};

fn main() {
    for name in builtin::BUILTIN {
        let model = builtin::builtin(name).expect("a built-in scene");
        let mut world = World::new(model, [256, 256]).expect("a built-in scene is sound");
        world.prepare(0.5, 0.501);
        let hits: Vec<Hit> = (0..256 * 256)
            .map(|i| Vec2::new((i % 256) as f32, (i / 256) as f32) + 0.5)
            .map(|pixel| world.look(0.5, pixel, 1))
            .collect();
        let clock = Instant::now();
        let again = (0..256 * 256)
            .map(|i| Vec2::new((i % 256) as f32, (i / 256) as f32) + 0.25)
            .filter(|&pixel| world.look(0.5, pixel, 1).depth.is_finite())
            .count();
        let sample = clock.elapsed().as_secs_f64() / 65536.0;
        let clock = Instant::now();
        let seen = hits
            .iter()
            .filter(|hit| world.sees(0.5, hit.object, hit.local))
            .count();
        let test = clock.elapsed().as_secs_f64() / 65536.0;
        println!(
            "{name:12} sample {:.2} µs, test {:.2} µs, ratio {:.2} ({again} and {seen} of 65536)",
            sample * 1e6,
            test * 1e6,
            test / sample
        );
    }
}
