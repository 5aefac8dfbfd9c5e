//! How long a refresh takes on the adapter and on the processor, with a full deep buffer, all
//! samples reprojected:
//! `cargo run --release -p unframed-sim --example twin_rate [SAMPLES [WIDTH HEIGHT]]`.

#[expect(dead_code, reason = "the tests need more of it")]
#[path = "../tests/equality/stream.rs"]
mod stream;

use std::time::{Duration, Instant};

use stream::Stream;
use unframed_recon::config::{Config, Extents, Fit};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Display, Fixed, Player, frame_hash};
use unframed_sim::{Gpu, GpuPlayer};
use unframed_wire::Layout;

/// Refreshes measured; the first fills the deep buffer and is left out.
const REFRESHES: u32 = 8;
/// Samples that arrive before each refresh: 400,000 a second at 60 Hz.
const ARRIVE: usize = 6667;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = Vec::new();
    for word in std::env::args().skip(1) {
        numbers.push(word.parse::<u32>()?);
    }
    let samples = numbers.first().copied().unwrap_or(400_000) as usize;
    let size = match numbers[..] {
        [_, width, height] => (u16::try_from(width)?, u16::try_from(height)?),
        _ => (256, 256),
    };
    let gpu = Gpu::new()?;
    println!("{}", gpu.describe());
    println!("{samples} samples, {} x {} pixels", size.0, size.1);
    let bytes = recording(size, samples);
    let configs = [
        ("adaptive", Config::ADAPTIVE),
        (
            "constant fit",
            Config {
                fit: Fit::Constant,
                ..Config::ADAPTIVE
            },
        ),
        (
            "gradient extents",
            Config {
                extents: Extents::Gradient,
                ..Config::ADAPTIVE
            },
        ),
        ("uniform", Config::UNIFORM),
        ("paper", Config::PAPER),
    ];
    println!("ms a refresh, least and median       adapter       processor");
    for (name, config) in configs {
        let mut twin = GpuPlayer::new(&gpu, config, size.0, size.1, samples)?;
        let mut input = &bytes[..];
        let mut on_adapter = Vec::new();
        let mut before = Instant::now();
        while twin.push(&mut input)?.is_some() {
            on_adapter.push(before.elapsed());
            before = Instant::now();
        }
        let mut storage = HeapStorage::<Fixed>::new(size.0, size.1, samples);
        let display = Display::new(config, size.0, size.1, storage.memory())?;
        let mut player = Player::new(display);
        let mut input = &bytes[..];
        let mut on_processor = Vec::new();
        let mut before = Instant::now();
        while player.push(&mut input).is_some() {
            on_processor.push(before.elapsed());
            before = Instant::now();
        }
        let (a, b) = (summary(on_adapter), summary(on_processor));
        println!(
            "{name:<32} {:6.1} {:6.1}   {:6.1} {:6.1}",
            a.0, a.1, b.0, b.1
        );
        let hashes = [twin.picture(), player.display().picture()].map(frame_hash);
        assert_eq!(hashes[0], hashes[1], "{name}: the pictures differ");
    }
    Ok(())
}

/// A second of samples, then refreshes at 60 Hz.
fn recording(size: (u16, u16), samples: usize) -> Vec<u8> {
    let mut stream = Stream::new(size, Layout::World, 1);
    let mut time = 0;
    for index in 0..=REFRESHES {
        let phase = f64::from(index) * 0.02;
        stream.view(time, phase);
        stream.poses(time, phase);
        stream.tiles(time, 64);
        let (count, span) = if index == 0 {
            (samples, 1_000_000)
        } else {
            (ARRIVE, 16_667)
        };
        stream.samples(count, time, span);
        time += span;
        stream.refresh(time, index);
    }
    stream.bytes
}

/// Least and median of all but the first, milliseconds.
fn summary(mut times: Vec<Duration>) -> (f64, f64) {
    times.remove(0);
    times.sort_unstable();
    let ms = |d: &Duration| d.as_secs_f64() * 1e3;
    let median = times.get(times.len() / 2).map_or(0.0, ms);
    (times.first().map_or(0.0, ms), median)
}
