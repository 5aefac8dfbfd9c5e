//! What the control of the paper's sampler costs: a step against the number of tiles and of stored
//! samples, and an occlusion ray against a sample.
//!
//! `cargo run --release -p unframed-host --example paper_cost`
//!
//! The first two tables look at an analytic picture, so that rays cost next to nothing; the times
//! are those of planning, reprojecting, learning and moving the tiling. If a step scanned tiles or
//! samples, its time would grow tenfold from line to line; a logarithm adds the same each time,
//! and so do caches that no longer hold everything.

use std::time::Instant;

use glam::{Affine3A, UVec2, Vec2, Vec3};
use unframed_host::sampler::paper::{Config, Paper};
use unframed_host::sampler::{Eye, Sampler, Span};
use unframed_host::scene::builtin;
use unframed_host::trace::camera::Camera;
use unframed_host::trace::{Hit, Rays, World};

/// A plain wall with a patterned spot that circles, so that the tiling never comes to rest.
struct Wall {
    size: UVec2,
}

impl Eye for Wall {
    fn camera(&self, _: f64) -> Camera {
        Camera {
            eye: Vec3::ZERO,
            right: Vec3::X,
            down: Vec3::Y,
            forward: Vec3::Z,
            focal: self.size.y as f32,
            centre: self.size.as_vec2() * 0.5,
            aperture: 0.0,
            focus: 1.0,
        }
    }

    fn pose(&self, _: u8, _: f64) -> Affine3A {
        Affine3A::IDENTITY
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        self.look_along(time, self.camera(time).direction(pixel), seed)
    }

    fn look_along(&self, time: f64, direction: Vec3, _: u32) -> Hit {
        let spot = Vec2::from_angle(6.0 * time as f32) * 0.3;
        let near = direction.truncate().distance(spot) < 0.15;
        let at = direction.truncate() * 40.0;
        let odd = (at.x.floor() as i32 ^ at.y.floor() as i32) & 1 == 1;
        Hit {
            colour: Vec3::splat(if near && odd { 0.7 } else { 0.2 }),
            object: 0,
            local: direction,
            depth: 1.0,
            rays: Rays::default(),
        }
    }

    fn sees(&self, _: f64, _: u8, _: Vec3) -> bool {
        true
    }
}

/// Microseconds of control a crosshair, once the buffer is as full as it gets in `fill` samples a
/// pixel: planning, learning, adjusting; then crosshairs stored and moves of the tiling.
fn step(side: u32, tiles: u32, fill: usize) -> ([f64; 3], usize, u64) {
    let wall = Wall {
        size: UVec2::splat(side),
    };
    let config = Config {
        gain: false,
        tiles,
        finest: 1,
        ..Config::default()
    };
    let mut sampler = Paper::new(wall.size, config);
    let mut out = Vec::new();
    let mut epoch = 0;
    let mut run = |sampler: &mut Paper, shots: usize| {
        let [t0, t1] = [epoch, epoch + 1].map(|k| f64::from(k) / 60.0);
        epoch += 1;
        out.clear();
        sampler.epoch(Span { t0, t1, shots }, &wall, &mut out);
    };
    for _ in 0..20 {
        run(&mut sampler, (side * side) as usize * fill / 20);
    }
    let before = sampler.stats();
    for _ in 0..10 {
        run(&mut sampler, 20_000);
    }
    let after = sampler.stats();
    let crosshairs = (after.crosshairs - before.crosshairs) as f64;
    let each = |k: usize| (after.seconds[k] - before.seconds[k]) * 1e6 / crosshairs;
    let moves = after.moves[0] - before.moves[0];
    ([each(0), each(2), each(3)], after.stored, moves)
}

fn print(label: u32, ([plan, learn, adjust], stored, moves): ([f64; 3], usize, u64)) {
    let all = plan + learn + adjust;
    println!("{label:8} {all:8.2} {plan:8.2} {learn:8.2} {adjust:8.2} {stored:9} {moves:8}");
}

fn main() {
    let head = "µs/step     plan    learn   adjust    stored   splits";
    println!("A step (one crosshair, five reprojections), 256×256 pixels\n   tiles  {head}");
    for tiles in [16, 128, 1024, 8192, 65536] {
        print(tiles, step(256, tiles, 12));
    }
    println!("\nThe same, 256 tiles, by the side of the image\n    side  {head}");
    for side in [32, 64, 128, 256, 512, 1024] {
        print(side, step(side, 256, 12));
    }
    println!(
        "\nThe same, 256×256 pixels, 256 tiles, by samples taken a pixel before\n    fill  {head}"
    );
    for fill in [1, 4, 16, 64] {
        print(fill, step(256, 256, fill as usize));
    }
    println!("\nAn occlusion ray against a sample\n");
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
