//! The reconstructor on the adapter against the one on the processor: equal to the bit.

mod hard;
mod light;
mod rest;
mod stages;
mod stream;

use stages::Stages;
use stream::Stream;
use unframed_recon::config::{Extents, Fit, Lifetime, Light, Mode, TimeKernel};
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed, Player};
use unframed_sim::twin::{Probe, Tables};
use unframed_sim::{Gpu, GpuError, GpuPlayer};
use unframed_wire::Layout;

/// An adapter, or `None` after a line that says so. Where `CI` is set its absence fails the test.
fn adapter_or_skip(left_out: &str) -> Option<Gpu> {
    match Gpu::new() {
        Ok(gpu) => Some(gpu),
        Err(error @ GpuError::NoAdapter { .. }) if std::env::var_os("CI").is_none() => {
            eprintln!("SKIPPED, not tested: {left_out}: {error}");
            None
        }
        Err(error) => panic!("{left_out}: {error}"),
    }
}

/// One case: a configuration, a panel, the deep buffer's capacity.
#[derive(Clone, Copy, Debug)]
struct Case {
    config: Config,
    size: (u16, u16),
    samples: usize,
}

/// What came of a comparison.
struct Found {
    /// Where the displays first differ, in words.
    first_difference: Option<String>,
    /// Whether the last picture shows anything.
    lit: bool,
}

/// Feeds both displays and compares everything that can be seen of them at each refresh.
fn compare(gpu: &Gpu, case: Case, tables: &Tables, bytes: &[u8]) -> Found {
    let (width, height) = case.size;
    let mut storage = HeapStorage::<Fixed>::new(width, height, case.samples);
    let display = Display::new(case.config, width, height, storage.memory()).expect("it fits");
    let mut cpu = Player::new(display);
    let mut twin = GpuPlayer::with_tables(gpu, case.config, width, height, case.samples, tables)
        .expect("the adapter has room");
    let (mut left, mut right) = (bytes, bytes);
    let mut refreshes = 0;
    let mut first_difference = None;
    while first_difference.is_none() {
        let ours = twin.push(&mut left).expect("the device answers");
        let theirs = cpu.push(&mut right);
        assert_eq!(ours, theirs, "{case:?}");
        if ours.is_none() {
            break;
        }
        refreshes += 1;
        assert_eq!(twin.counts(), cpu.display().counts(), "{case:?}");
        assert_eq!(twin.status(), cpu.status(), "{case:?}");
        let pictures = twin.picture().iter().zip(cpu.display().picture());
        let wrong: Vec<_> = pictures.enumerate().filter(|(_, (a, b))| a != b).collect();
        first_difference = wrong.first().map(|(pixel, (ours, theirs))| {
            let count = wrong.len();
            format!(
                "{case:?}: refresh {refreshes}: {count} pixels differ, \
                 first {pixel}: {ours:?} for {theirs:?}"
            )
        });
    }
    assert!(refreshes > 0, "the stream asks for no picture");
    Found {
        first_difference,
        lit: cpu.display().picture().iter().any(|p| *p != [0; 3]),
    }
}

/// The first difference of two displays that show something.
fn difference(gpu: &Gpu, case: Case, tables: &Tables, bytes: &[u8]) -> Option<String> {
    let found = compare(gpu, case, tables, bytes);
    assert!(found.lit, "{case:?}: black pictures prove nothing");
    found.first_difference
}

fn check(gpu: &Gpu, case: Case, bytes: &[u8]) {
    let found = difference(gpu, case, &Tables::new(&case.config), bytes);
    assert_eq!(found, None, "{}", gpu.describe());
}

/// Four refreshes 20 ms apart, each after a share of `samples`, view, poses and tiles changing.
fn four_refreshes(size: (u16, u16), layout: Layout, samples: usize, start: u32) -> Vec<u8> {
    let mut stream = Stream::new(size, layout, u64::from(start) ^ samples as u64);
    for index in 0..4u32 {
        let time = start.wrapping_add(index * 20_000);
        let phase = f64::from(index) * 0.1;
        stream.view(time, phase);
        stream.poses(time, phase);
        stream.tiles(time, 60);
        stream.samples(samples / 4, time, 19_000);
        stream.refresh(time.wrapping_add(20_000), index);
    }
    stream.bytes
}

const ADAPTIVE: Config = Config::ADAPTIVE;

/// Every option of the configuration, alone and in the combinations that share a stage.
fn variants() -> Vec<(&'static str, Config)> {
    let gradient = Config {
        extents: Extents::Gradient,
        ..ADAPTIVE
    };
    let constant = Extents::Constant(-100);
    let lifetime = Lifetime::Constant(-900);
    vec![
        ("adaptive", ADAPTIVE),
        ("newest", Config::NEWEST),
        ("uniform", Config::UNIFORM),
        ("paper", Config::PAPER),
        (
            "not reprojected",
            Config {
                reproject: false,
                ..ADAPTIVE
            },
        ),
        (
            "newest, not reprojected",
            Config {
                reproject: false,
                ..Config::NEWEST
            },
        ),
        (
            "hidden off",
            Config {
                hidden: false,
                ..ADAPTIVE
            },
        ),
        (
            "fill off",
            Config {
                fill: false,
                ..ADAPTIVE
            },
        ),
        (
            "fit constant",
            Config {
                fit: Fit::Constant,
                ..ADAPTIVE
            },
        ),
        (
            "encoded",
            Config {
                light: Light::Encoded,
                ..ADAPTIVE
            },
        ),
        (
            "gaussian",
            Config {
                kernel: TimeKernel::Gaussian,
                ..ADAPTIVE
            },
        ),
        (
            "exponential",
            Config {
                kernel: TimeKernel::Exponential,
                ..ADAPTIVE
            },
        ),
        ("gradient extents", gradient),
        (
            "gradient extents and lifetime",
            Config {
                lifetime: Lifetime::Gradient,
                ..gradient
            },
        ),
        (
            "gradient lifetime",
            Config {
                lifetime: Lifetime::Gradient,
                ..ADAPTIVE
            },
        ),
        (
            "constant extents",
            Config {
                extents: constant,
                ..ADAPTIVE
            },
        ),
        (
            "wide",
            Config {
                extents: Extents::Constant(i16::MAX),
                ..ADAPTIVE
            },
        ),
        (
            "narrow",
            Config {
                extents: Extents::Constant(i16::MIN),
                ..ADAPTIVE
            },
        ),
        (
            "pixels",
            Config {
                extents: Extents::Pixel,
                ..ADAPTIVE
            },
        ),
        (
            "means of pixels, nothing hidden",
            Config {
                extents: Extents::Pixel,
                fit: Fit::Constant,
                hidden: false,
                ..ADAPTIVE
            },
        ),
        (
            "constant lifetime",
            Config {
                lifetime,
                ..ADAPTIVE
            },
        ),
    ]
}

#[test]
fn every_configuration_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of the display's twin") else {
        return;
    };
    let size = (64, 64);
    let stream = |layout| four_refreshes(size, layout, 12_000, 5);
    let (world, screen) = (stream(Layout::World), stream(Layout::Screen));
    for (name, config) in variants() {
        // Fewer than are sent: the ring wraps.
        let case = Case {
            config,
            size,
            samples: 8_000,
        };
        println!("{name}");
        check(&gpu, case, &world);
        check(&gpu, case, &screen);
    }
}

/// Each stage's buffer at the last refresh; the first stage that differs, with its first wrong word.
fn stage_difference(gpu: &Gpu, case: Case, bytes: &[u8]) -> Option<String> {
    let (width, height) = case.size;
    let mut twin = GpuPlayer::new(gpu, case.config, width, height, case.samples)
        .expect("the adapter has room");
    let mut input = bytes;
    while twin.push(&mut input).expect("the device answers").is_some() {}
    assert!(twin.counts().refreshes > 0);
    for (probe, expected) in Stages::new(&case.config, case.size, bytes).expected {
        let mut got = twin.probe(probe).expect("the device answers");
        if probe == Probe::Widths {
            // The second word of each is not kept by Rust.
            got = got.chunks_exact(2).map(|w| w[0]).collect();
        }
        if probe == Probe::Masses {
            // Rust saturates at 64 samples at once.
            let saturated = |w: &[u32]| {
                if w[1] > 0 {
                    64 << 15
                } else {
                    w[0].min(64 << 15)
                }
            };
            got = got.chunks_exact(2).map(saturated).collect();
        }
        got.truncate(expected.len());
        assert_eq!(got.len(), expected.len(), "{probe:?}");
        let wrong = got.iter().zip(&expected).position(|(a, b)| a != b);
        if let Some(at) = wrong {
            let (got, expected) = (got[at], expected[at]);
            return Some(format!(
                "{probe:?}: word {at} is {got:#x}, not {expected:#x}; {case:?}"
            ));
        }
    }
    None
}

#[test]
fn every_stage_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of the display's stages") else {
        return;
    };
    let size = (64, 64);
    let samples = 12_000;
    let bytes = four_refreshes(size, Layout::World, samples, 5);
    for (name, config) in variants() {
        if config.mode == Mode::Newest || !config.reproject {
            continue;
        }
        println!("{name}");
        let case = Case {
            config,
            size,
            samples,
        };
        assert_eq!(stage_difference(&gpu, case, &bytes), None);
    }
}
