//! What a step of control costs against the number of tiles and of stored samples, without rays:
//! `cargo run --release -p unframed --example step_cost [SVG]`
//!
//! A step is a sample of the adaptive sampler, or a crosshair (six samples, five reprojections) of
//! the paper's. Both look at an analytic wall, so that rays cost next to nothing; the times are the
//! least of several stretches. What scans grows with what it scans; a logarithm adds the same each
//! time, and so do caches that no longer hold everything.

use glam::{Affine3A, UVec2, Vec2, Vec3};
use unframed_cli::report::axis::{Axis, Scale};
use unframed_cli::report::plot::Plot;
use unframed_host::sampler::adaptive::{self, Adaptive};
use unframed_host::sampler::paper::{self, Paper};
use unframed_host::sampler::{Eye, Sampler, Span};
use unframed_host::trace::camera::Camera;
use unframed_host::trace::{Hit, Rays};

/// Samples a pixel and second: 400,000 a second on 256 × 256 pixels.
const DENSITY: f64 = 400_000.0 / 65_536.0;
/// Stretches of which the quickest counts.
const STRETCHES: usize = 6;

/// A plain wall with a patterned spot that circles, so that nothing comes to rest.
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
            shares: unframed_wire::Shares::default(),
        }
    }

    fn sees(&self, _: f64, _: u8, _: Vec3) -> bool {
        true
    }
}

/// Takes epochs of a sixtieth of a second.
struct Run<'a, S> {
    sampler: S,
    wall: &'a Wall,
    epoch: u32,
}

impl<S: Sampler> Run<'_, S> {
    fn take(&mut self, epochs: u32, shots: usize) {
        let mut out = Vec::new();
        for _ in 0..epochs {
            let [t0, t1] = [self.epoch, self.epoch + 1].map(|k| f64::from(k) / 60.0);
            self.epoch += 1;
            out.clear();
            let span = Span { t0, t1, shots };
            self.sampler.epoch(span, self.wall, &mut out);
        }
    }
}

/// The least of [`STRETCHES`] quotients of seconds and steps, µs; `each` takes a stretch and tells
/// both so far.
fn least(mut each: impl FnMut() -> (f64, f64)) -> f64 {
    let (mut seconds, mut steps) = each();
    (0..STRETCHES)
        .map(|_| {
            let before = (seconds, steps);
            (seconds, steps) = each();
            1e6 * (seconds - before.0) / (steps - before.1)
        })
        .fold(f64::INFINITY, f64::min)
}

/// A step of the adaptive sampler, µs, and the cells that it remembers. The memory is warped in
/// every epoch, as if all moved.
fn adaptive(side: u32, rate: f64) -> (f64, usize) {
    let wall = Wall {
        size: UVec2::splat(side),
    };
    let config = adaptive::Config {
        slack: 0.0,
        ..adaptive::Config::default()
    };
    let mut run = Run {
        sampler: Adaptive::new(wall.size, config),
        wall: &wall,
        epoch: 0,
    };
    let shots = (rate / 60.0).ceil() as usize;
    run.take(30, shots);
    let micros = least(|| {
        run.take(6, shots);
        let stats = run.sampler.stats();
        let [warp, plan, _, learn] = stats.seconds;
        (warp + plan + learn, stats.shots as f64)
    });
    (micros, run.sampler.stats().cells)
}

/// A step of the paper's sampler, µs, and the crosshairs stored, after `fill` samples a pixel.
fn paper(side: u32, tiles: u32, fill: usize) -> (f64, usize) {
    let wall = Wall {
        size: UVec2::splat(side),
    };
    let config = paper::Config {
        gain: false,
        tiles,
        finest: 1,
        ..paper::Config::default()
    };
    let mut run = Run {
        sampler: Paper::new(wall.size, config),
        wall: &wall,
        epoch: 0,
    };
    run.take(20, (side * side) as usize * fill / 20);
    let micros = least(|| {
        run.take(2, 20_000);
        let stats = run.sampler.stats();
        let [plan, _, learn, adjust] = stats.seconds;
        (plan + learn + adjust, stats.crosshairs as f64)
    });
    (micros, run.sampler.stats().stored)
}

/// Prints rows and makes a line of them.
fn series(
    name: &str,
    labels: &[u32],
    of: impl Fn(u32) -> (f64, usize),
    x: impl Fn(u32, usize) -> f64,
) -> Vec<(f64, f64)> {
    println!("\n{name}\n{:>10} {:>10} {:>10}", "", "µs a step", "stored");
    labels
        .iter()
        .map(|label| {
            let (micros, stored) = of(*label);
            println!("{label:10} {micros:10.3} {stored:10}");
            (x(*label, stored), micros)
        })
        .collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sides = [32, 64, 128, 256, 512, 1024];
    let stored = |_: u32, stored: usize| stored as f64;
    let tiles = |tiles: u32, _: usize| f64::from(tiles);
    let area = |side: u32| f64::from(side).powi(2);
    let steady = series(
        "Adaptive, by the side of the image, samples a pixel and second alike",
        &sides,
        |side| adaptive(side, DENSITY * area(side)),
        stored,
    );
    let fixed = series(
        "Adaptive, by the side of the image, 400,000 samples a second",
        &sides,
        |side| adaptive(side, 400_000.0),
        stored,
    );
    let by_tiles = series(
        "Paper, 256 × 256 pixels, by tiles",
        &[16, 128, 1024, 8192, 65536],
        |tiles| paper(256, tiles, 12),
        tiles,
    );
    let by_side = series(
        "Paper, 256 tiles, by the side of the image",
        &sides,
        |side| paper(side, 256, 12),
        stored,
    );
    let by_fill = series(
        "Paper, 256 × 256 pixels, 256 tiles, by samples a pixel before",
        &[1, 4, 16, 64],
        |fill| paper(256, 256, fill as usize),
        stored,
    );
    if let Some(file) = std::env::args().nth(1) {
        let plot = Plot::new(
            "Control, without rays",
            Axis::new("stored samples (or tiles)", Scale::Log),
            Axis::new("µs a step", Scale::Log),
        )
        .line("adaptive, 6.1 samples a pixel and second", steady)
        .line("adaptive, 400k samples a second", fixed)
        .line("paper, by tiles", by_tiles)
        .line("paper, by the image's side", by_side)
        .line("paper, by samples taken", by_fill);
        std::fs::write(file, plot.svg()?)?;
    }
    Ok(())
}
