//! The picture does not depend on how the work is shared: sorted by tile or not, one thread or
//! several.

#[path = "../benches/load/scene.rs"]
mod scene;

use scene::Show;
use unframed_recon::config::{Extents, Fit, Lifetime};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Alone, Config, Display, Fixed, Threads, Workers, frame_hash};

/// A hash a refresh.
fn hashes(
    workers: impl Workers,
    sorted: bool,
    config: Config,
    size: u16,
    samples: usize,
) -> Vec<u64> {
    let mut storage = HeapStorage::<Fixed>::new(size, size, samples);
    let mut memory = storage.memory();
    if !sorted {
        memory.sorted = &mut [];
    }
    let mut display = Display::with_workers(workers, config, size, size, memory).expect("it fits");
    let mut show = Show::begin(&mut display, samples, true);
    let mut hashes = vec![frame_hash(display.picture())];
    for _ in 0..2 {
        show.next(&mut display, true);
        display.refresh(&show.refresh());
        hashes.push(frame_hash(display.picture()));
    }
    hashes
}

#[test]
fn sharing_the_work_does_not_change_the_picture() {
    let constant = Config {
        fit: Fit::Constant,
        ..Config::ADAPTIVE
    };
    let gradient = Config {
        extents: Extents::Gradient,
        lifetime: Lifetime::Gradient,
        ..Config::ADAPTIVE
    };
    let pixels = Config {
        extents: Extents::Pixel,
        ..Config::ADAPTIVE
    };
    // What is not sorted goes straight to its pixel.
    let own = Config {
        fit: Fit::Constant,
        hidden: false,
        ..pixels
    };
    for (config, size, samples) in [
        (pixels, 70, 3000),
        (own, 100, 9000),
        (own, 33, 3000),
        (own, 481, 3000),
        (Config::ADAPTIVE, 100, 9000),
        (constant, 33, 3000),
        (constant, 1, 60),
        (gradient, 70, 3000),
        // Coordinates with less than 7 fractional bits: no tap table.
        (constant, 481, 3000),
    ] {
        let plain = hashes(Alone, false, config, size, samples);
        assert!(plain.windows(2).all(|pair| pair[0] != pair[1]) || size == 1);
        assert_eq!(
            plain,
            hashes(Alone, true, config, size, samples),
            "{size}: sorted"
        );
        for threads in if size < 200 { 2..4 } else { 3..4 } {
            let workers = Threads::new(threads).expect("threads");
            let shared = hashes(workers, true, config, size, samples);
            assert_eq!(plain, shared, "{size}: {threads} threads");
        }
    }
}
