//! How long a refresh takes, against a plain scatter in f32 and a copy of the same memory:
//! `cargo run --release -p unframed-recon --features threads --example refresh_rate [SAMPLES [SIZE [ROUNDS [WORD]]]]`
//! ROUNDS refreshes are measured of each kind, or of the kinds with WORD in their names.

#[path = "../benches/load/mod.rs"]
mod load;

use load::{plain, scene::Show};
use std::time::{Duration, Instant};
use unframed_recon::config::Fit;
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed, Threads, frame_hash};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<_> = std::env::args().skip(1).collect();
    let numbers: Result<Vec<usize>, _> = words.iter().take(3).map(|w| w.parse()).collect();
    let numbers = numbers?;
    let rounds = numbers.get(2).copied().unwrap_or(30).max(1);
    let wanted = words.get(3).cloned().unwrap_or_default();
    let samples = numbers.first().copied().unwrap_or(400_000);
    let size = u16::try_from(numbers.get(1).copied().unwrap_or(256))?;
    println!(
        "{samples} samples, {size} x {size} pixels; ms a refresh, least and median (one thread: of the processor)"
    );

    let mut plain = plain::Plain::new(size, samples);
    let times: Vec<_> = (0..rounds)
        .map(|k| measure(|| plain.refresh(k as u32)))
        .collect();
    let scatter = report("plain f32 scatter, 1 thread", times, None);
    let mut copy = vec![0u8; 16 * samples];
    let source = vec![1u8; 16 * samples];
    let times = (0..rounds)
        .map(|_| {
            measure(|| {
                std::hint::black_box(&mut copy).copy_from_slice(std::hint::black_box(&source));
            })
        })
        .collect();
    report("copy of the samples' memory", times, Some(scatter));

    for (name, fit) in [("constant", Fit::Constant), ("linear", Fit::Linear)] {
        for (moves, moving) in [("moving", true), ("at rest", false)] {
            let mut hashes = Vec::new();
            for threads in [1, 2] {
                let label = format!("{name}, {moves}, {threads} thread(s)");
                if !label.contains(&wanted) {
                    continue;
                }
                let mut storage = HeapStorage::<Fixed>::new(size, size, samples);
                let config = Config {
                    fit,
                    ..Config::ADAPTIVE
                };
                let mut display = Display::with_workers(
                    Threads::new(threads)?,
                    config,
                    size,
                    size,
                    storage.memory(),
                )?;
                let mut show = Show::begin(&mut display, samples, moving);
                let times = (0..rounds)
                    .map(|_| {
                        show.next(&mut display, moving);
                        let start = Instant::now();
                        let busy = measure(|| display.refresh(&show.refresh()));
                        if threads == 1 { busy } else { start.elapsed() }
                    })
                    .collect();
                report(&label, times, Some(scatter));
                hashes.push(frame_hash(display.picture()));
            }
            hashes.iter().for_each(|hash| println!("  {hash:016x}"));
            assert!(
                hashes.iter().all(|hash| *hash == hashes[0]),
                "threads change the picture"
            );
        }
    }
    Ok(())
}

/// Time that this thread has spent on a processor, where the system tells (Linux): unlike the
/// clock on the wall it does not count what others run meanwhile.
fn busy() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds = stat.split(' ').next()?.parse().ok()?;
    Some(Duration::from_nanos(nanoseconds))
}

/// What `work` takes of one thread: processor time, or else time.
fn measure(work: impl FnOnce()) -> Duration {
    let (start, before) = (Instant::now(), busy());
    work();
    match (before, busy()) {
        (Some(before), Some(after)) => after.saturating_sub(before),
        _ => start.elapsed(),
    }
}

/// Prints a row; the mean in ms.
fn report(name: &str, mut times: Vec<Duration>, scatter: Option<f64>) -> f64 {
    times.sort_unstable();
    let ms = |d: &Duration| d.as_secs_f64() * 1e3;
    let (least, median) = (ms(&times[0]), ms(&times[times.len() / 2]));
    let mean = ms(&times.iter().sum()) / times.len() as f64;
    let ratio = scatter.map_or(String::new(), |s| format!("  {:6.2} x", s / mean));
    println!("{name:<32} {least:7.2} {median:7.2} {mean:7.2}{ratio}");
    mean
}
