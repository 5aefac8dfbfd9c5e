//! How long each metric takes on a picture of this size: `cargo run --release -p
//! unframed-metrics --example speed [SIDE]` (256 if not given), one thread.

use std::time::Instant;

use unframed_metrics::scatter::{blur_to_remove, gradient_ratio};
use unframed_metrics::{Image, MetricError, Scatter, VideoMetric, Viewing, flip, rmse};

/// Refreshes to average over; more than one window of ColorVideoVDP's history at 60 Hz.
const REFRESHES: usize = 24;

fn main() -> Result<(), MetricError> {
    let side = std::env::args().nth(1).and_then(|a| a.parse().ok());
    let side: usize = side.unwrap_or(256);
    let picture = |shift: usize| -> Vec<[u8; 3]> {
        let pixel = |i: usize| (((i % side + shift) * 7) ^ ((i / side) * 13)) as u8;
        (0..side * side)
            .map(|i| [pixel(i), pixel(i / 2), pixel(i / 3)])
            .collect()
    };
    let pictures: Vec<_> = (0..=REFRESHES).map(picture).collect();
    let pairs: Vec<_> = pictures
        .windows(2)
        .map(|p| {
            Ok((
                Image::new(&p[0], side, side)?,
                Image::new(&p[1], side, side)?,
            ))
        })
        .collect::<Result<_, MetricError>>()?;
    let report = |name: &str, start: Instant| {
        let ms = start.elapsed().as_secs_f64() * 1e3 / REFRESHES as f64;
        println!("{name:<16} {ms:8.2} ms a refresh of {side}x{side}");
    };

    let start = Instant::now();
    for (a, b) in &pairs {
        rmse(*a, *b)?;
    }
    report("rmse", start);

    let start = Instant::now();
    for (a, b) in &pairs {
        flip(*a, *b, Viewing::default())?;
    }
    report("flip", start);

    let start = Instant::now();
    let mut video = VideoMetric::new(side, side, 60.0, Viewing::default())?;
    for (a, b) in &pairs {
        video.push(*a, *b)?;
    }
    let score = video.finish()?;
    report("cvvdp", start);

    let ages: Vec<_> = (0..side * side)
        .map(|i| Some((i * 7919 % 65536) as u32))
        .collect();
    let motion = vec![[30.0, 10.0]; side * side];
    let start = Instant::now();
    for _ in 0..REFRESHES {
        Scatter::measure(side, side, &ages, &motion)?;
    }
    report("scatter", start);

    let start = Instant::now();
    for (a, b) in &pairs {
        blur_to_remove(*a, *b, 0.25)?;
    }
    report("blur_to_remove", start);

    let start = Instant::now();
    for (a, b) in &pairs {
        gradient_ratio(*a, *b, 1.0)?;
    }
    report("gradient_ratio", start);
    println!("(ColorVideoVDP of it all: {:.3} JOD)", score.jod);
    Ok(())
}
