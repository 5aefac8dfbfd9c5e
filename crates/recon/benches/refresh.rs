//! A refresh with everything moving, its stages, and what they are measured against in the same
//! run: a plain scatter in `f32` and a copy of memory.
//! `cargo bench -p unframed-recon --features threads`; ratios: the example `refresh_rate`.

#[path = "load/mod.rs"]
mod load;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use load::plain::Plain;
use load::scene::Show;
use std::hint::black_box;
use unframed_recon::config::{Extents, Fit};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed, Threads};

const SAMPLES: usize = 400_000;
const SIZE: u16 = 256;

/// What the refresh is measured against.
fn baselines(c: &mut Criterion) {
    let mut group = c.benchmark_group("baseline");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    let mut plain = Plain::new(SIZE, SAMPLES);
    let mut index = 0;
    group.bench_function("plain f32 scatter", |b| {
        b.iter(|| {
            plain.refresh(index);
            index = (index + 1) % 30;
        });
    });
    // As many bytes as the deep buffer has.
    let bytes = 16 * SAMPLES;
    group.throughput(Throughput::Bytes(bytes as u64));
    group.bench_function("copy", |b| {
        b.iter_batched_ref(
            || (vec![1u8; bytes], vec![0u8; bytes]),
            |(from, to)| to.copy_from_slice(black_box(from)),
            BatchSize::LargeInput,
        );
    });
    group.finish();
}

/// Whole refreshes; the parts of [`Config`] left out one by one tell what each costs.
fn refreshes(c: &mut Criterion) {
    let constant = Config {
        fit: Fit::Constant,
        ..Config::ADAPTIVE
    };
    let configs = [
        ("linear", Config::ADAPTIVE),
        ("constant", constant),
        (
            "constant, nothing filled",
            Config {
                fill: false,
                ..constant
            },
        ),
        (
            "constant, nothing hidden",
            Config {
                hidden: false,
                ..constant
            },
        ),
        (
            "constant, one width",
            Config {
                extents: Extents::Constant(-256),
                ..constant
            },
        ),
    ];
    let mut group = c.benchmark_group("refresh");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    for (name, config) in configs {
        for threads in [1, 2] {
            let mut storage = HeapStorage::<Fixed>::new(SIZE, SIZE, SAMPLES);
            let workers = Threads::new(threads).expect("threads");
            let memory = storage.memory();
            let mut display =
                Display::with_workers(workers, config, SIZE, SIZE, memory).expect("it fits");
            let mut show = Show::begin(&mut display, SAMPLES, true);
            group.bench_function(format!("{name}, {threads} thread(s)"), |b| {
                b.iter_custom(|rounds| {
                    let mut total = std::time::Duration::ZERO;
                    for _ in 0..rounds {
                        show.next(&mut display, true);
                        let start = std::time::Instant::now();
                        display.refresh(&show.refresh());
                        total += start.elapsed();
                    }
                    total
                });
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = baselines, refreshes
}
criterion_main!(benches);
