//! Instructions of a refresh, counted by callgrind: the same number each time, so that a change of
//! a percent is seen. 40,000 samples on 128 × 128 pixels, one thread. Beside each other in one
//! group: the plain `f32` scatter, means, planes; moving, then at rest.

#[path = "../../crates/recon/benches/load/mod.rs"]
mod load;

use gungraun::{library_benchmark, library_benchmark_group, main};
use load::plain::Plain;
use load::scene::Show;
use unframed_recon::config::Fit;
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed};

const SAMPLES: usize = 40_000;
const SIZE: u16 = 128;

/// A display that is due to show a picture.
fn ready(fit: Fit, moving: bool) -> (Display<'static, Fixed>, Show) {
    let config = Config {
        fit,
        ..Config::ADAPTIVE
    };
    // The process ends with the benchmark.
    let storage = Box::leak(Box::new(HeapStorage::<Fixed>::new(SIZE, SIZE, SAMPLES)));
    let mut display = Display::new(config, SIZE, SIZE, storage.memory()).expect("it fits");
    let mut show = Show::begin(&mut display, SAMPLES, moving);
    show.next(&mut display, moving);
    (display, show)
}

#[library_benchmark]
#[bench::moving(Plain::new(SIZE, SAMPLES))]
fn plain_scatter(mut plain: Plain) -> Plain {
    plain.refresh(1);
    plain
}

type Due = (Display<'static, Fixed>, Show);

fn show((mut display, show): Due) -> Display<'static, Fixed> {
    display.refresh(&show.refresh());
    display
}

#[library_benchmark]
#[bench::moving(ready(Fit::Constant, true))]
fn means(due: Due) -> Display<'static, Fixed> {
    show(due)
}

#[library_benchmark]
#[bench::moving(ready(Fit::Linear, true))]
fn planes(due: Due) -> Display<'static, Fixed> {
    show(due)
}

#[library_benchmark]
#[bench::means(ready(Fit::Constant, false))]
#[bench::planes(ready(Fit::Linear, false))]
fn at_rest(due: Due) -> Display<'static, Fixed> {
    show(due)
}

library_benchmark_group!(
    name = moving;
    compare_by_id = true;
    benchmarks = plain_scatter, means, planes
);

library_benchmark_group!(
    name = rest;
    benchmarks = at_rest
);

main!(library_benchmark_groups = moving, rest);
