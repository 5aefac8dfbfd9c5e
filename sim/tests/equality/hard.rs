//! Odd panels, small buffers, streams with turns, old samples, heaps of samples; and that the
//! comparison can fail.

use super::stream::Stream;
use super::{
    ADAPTIVE, Case, adapter_or_skip, check, compare, difference, four_refreshes, stage_difference,
};
use unframed_recon::Config;
use unframed_recon::config::{Extents, Fit, Light, TimeKernel};
use unframed_sim::GpuPlayer;
use unframed_sim::twin::Tables;
use unframed_wire::{Layout, Shares, Tick, View, WorldSample};

/// Panels down to one pixel, of odd sizes, wider than high and higher than wide; one where a
/// coordinate of the guard band's far edge wraps in 16 bits (496 + 16 is a power of two).
#[test]
fn every_panel_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of odd panels") else {
        return;
    };
    let sizes = [(1, 1), (1, 7), (33, 17), (2, 130), (496, 5)];
    let paper = Config {
        hidden: true,
        fit: Fit::Linear,
        ..Config::PAPER
    };
    for size in sizes {
        for config in [ADAPTIVE, paper, Config::NEWEST] {
            let case = Case {
                config,
                size,
                samples: 3000,
            };
            check(&gpu, case, &four_refreshes(size, Layout::World, 4000, 77));
        }
        let still = Config {
            reproject: false,
            ..ADAPTIVE
        };
        let case = Case {
            config: still,
            size,
            samples: 3000,
        };
        check(&gpu, case, &four_refreshes(size, Layout::Screen, 4000, 78));
    }
}

/// The deployed size and rate, once: half of the samples are old when the picture is made.
#[test]
fn a_full_panel_is_equal() {
    let Some(gpu) = adapter_or_skip("equality at 256 x 256 pixels") else {
        return;
    };
    let size = (256, 256);
    let mut stream = Stream::new(size, Layout::World, 9);
    stream.view(0, 0.05);
    stream.poses(0, 0.0);
    stream.tiles(0, 64);
    stream.samples(400_000, 0, 1_000_000);
    stream.refresh(983_333, 0);
    stream.view(1_000_000, 0.15);
    stream.poses(1_000_000, 0.5);
    stream.refresh(1_000_000, 1);
    let case = Case {
        config: ADAPTIVE,
        size,
        samples: 400_000,
    };
    check(&gpu, case, &stream.bytes);
}

/// Deep buffers of no, one and few samples, against packets of 50.
#[test]
fn every_capacity_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of small deep buffers") else {
        return;
    };
    let size = (20, 20);
    let mut stream = Stream::new(size, Layout::World, 3);
    stream.samples(100, 0, 100);
    for index in 0..3 {
        stream.view(index * 1000, 0.0);
        stream.poses(index * 1000, 0.0);
        stream.samples(333, index * 1000, 900);
        stream.refresh(index * 1000 + 1000, index);
    }
    for samples in [0, 1, 7, 332, 333, 334, 100_000] {
        for reproject in [true, false] {
            let config = Config {
                reproject,
                ..ADAPTIVE
            };
            let case = Case {
                config,
                size,
                samples,
            };
            let found = compare(&gpu, case, &Tables::new(&config), &stream.bytes);
            assert_eq!(found.first_difference, None);
            assert_eq!(found.lit, samples > 0, "{case:?}");
        }
    }
}

/// Hello repeated, for another panel, changed; layouts that change; samples before view and poses,
/// unsound views; cuts before and after samples; views and poses in the middle of samples; bytes
/// lost, damaged and in small pieces.
#[test]
fn every_turn_of_a_stream_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of a stream with turns") else {
        return;
    };
    let size = (40, 30);
    let mut stream = Stream::new(size, Layout::World, 4);
    let mut index = 0;
    let mut refresh = |stream: &mut Stream, time| {
        stream.refresh(time, index);
        index += 1;
    };
    stream.samples(500, 0, 100);
    refresh(&mut stream, 100);
    stream.poses(100, 0.0);
    stream.samples(500, 100, 100);
    refresh(&mut stream, 200);
    stream.view(200, 0.1);
    stream.samples(500, 200, 100);
    stream.view(250, 0.2);
    stream.samples(500, 300, 100);
    stream.poses(300, 1.0);
    stream.samples(500, 300, 100);
    stream.tiles(300, 20);
    refresh(&mut stream, 400);
    // Nothing new.
    refresh(&mut stream, 30_000);
    stream.foreign_hello();
    stream.any_view(&View {
        time: Tick(400),
        eye: [i32::MIN; 3],
        rows: [[i32::MAX; 3]; 3],
        frac_bits: 30,
    });
    stream.samples(300, 500, 100);
    refresh(&mut stream, 600);
    stream.cut(600);
    refresh(&mut stream, 700);
    stream.samples(700, 700, 100);
    stream.cut(800);
    stream.samples(200, 800, 100);
    refresh(&mut stream, 900);
    stream.hello(7);
    refresh(&mut stream, 1000);
    stream.samples(100, 1000, 100);
    stream.view(1000, 0.0);
    stream.poses(1000, 0.0);
    stream.samples(900, 1100, 100);
    refresh(&mut stream, 1200);
    stream.layout(Layout::Screen);
    stream.samples(900, 1300, 100);
    refresh(&mut stream, 1400);
    stream.layout(Layout::World);
    stream.samples(900, 1500, 100);
    refresh(&mut stream, 1600);
    let mut damaged = stream.bytes.clone();
    for at in (400..damaged.len()).step_by(1900) {
        damaged[at] ^= 0x10;
    }
    damaged.drain(3000..3500);
    for config in [
        ADAPTIVE,
        Config::NEWEST,
        Config {
            reproject: false,
            ..ADAPTIVE
        },
    ] {
        let case = Case {
            config,
            size,
            samples: 1500,
        };
        check(&gpu, case, &stream.bytes);
        check(&gpu, case, &damaged);
    }
}

/// Ages across the clock's wrap, from the future, and so old that a sample is forgotten: it must
/// stay forgotten when the clock comes round.
#[test]
fn every_age_is_equal() {
    let Some(gpu) = adapter_or_skip("equality across the clock's wrap") else {
        return;
    };
    let size = (24, 24);
    let mut stream = Stream::new(size, Layout::World, 5);
    let start = u32::MAX - 30_000;
    stream.view(start, 0.0);
    stream.poses(start, 0.0);
    let step = 1 << 29;
    for index in 0..10u32 {
        let time = start.wrapping_add(index.wrapping_mul(step));
        stream.samples(400, time, 60_000);
        stream.refresh(time.wrapping_add(40_000), index);
    }
    // Exactly at the limits of what is remembered, one of them on either side.
    let now = 1_000_000;
    for (k, age) in [1 << 30, (1 << 30) - 1, -(1 << 30), 1 - (1 << 30)]
        .into_iter()
        .enumerate()
    {
        let sample = WorldSample {
            place: [2000 * k as i16 - 3000, 0, 20_000],
            rgb: [60 * k as u8, 200, 50],
            object: 0,
            shares: Shares::default(),
        };
        stream.cut(now);
        stream.same_sample(3, now.wrapping_sub_signed(age), sample);
        stream.refresh(now, 10 + k as u32);
    }
    let case = Case {
        config: ADAPTIVE,
        size,
        samples: 3000,
    };
    check(&gpu, case, &stream.bytes);
    check(
        &gpu,
        case,
        &four_refreshes(size, Layout::World, 2000, start),
    );
}

/// All samples on one pixel: every sum at its largest.
#[test]
fn a_heap_of_samples_on_one_pixel_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of large sums") else {
        return;
    };
    let size = (3, 3);
    // A little more than 2^32 in weights of 2^15: a lost carry would leave a small mass.
    let samples = 131_080;
    let mut stream = Stream::new(size, Layout::World, 6);
    stream.view(0, 0.0);
    stream.poses(0, 0.0);
    let sample = WorldSample {
        place: [300, -200, 20_000],
        rgb: [255, 254, 1],
        object: 0,
        shares: Shares::default(),
    };
    stream.same_sample(samples, 1000, sample);
    stream.refresh(1000, 0);
    let wide = Extents::Constant(512);
    for extents in [Extents::Density, wide] {
        let config = Config {
            extents,
            ..ADAPTIVE
        };
        let case = Case {
            config,
            size,
            samples,
        };
        assert_eq!(stage_difference(&gpu, case, &stream.bytes), None);
        check(&gpu, case, &stream.bytes);
    }
}

/// Changes a table.
type Flip = fn(&mut Tables);

/// The comparison must be able to fail: the lowest bits of each table's entries show.
#[test]
fn a_flipped_bit_in_any_table_is_found() {
    let Some(gpu) = adapter_or_skip("the check of equality") else {
        return;
    };
    let size = (64, 64);
    let bytes = four_refreshes(size, Layout::World, 12_000, 5);
    let kernel = |kernel| Config { kernel, ..ADAPTIVE };
    let encoded = Config {
        light: Light::Encoded,
        ..ADAPTIVE
    };
    let time: Flip = |t| t.time.iter_mut().for_each(|v| *v ^= 1);
    let light: Flip = |t| t.light.iter_mut().for_each(|v| *v ^= 1);
    let flips: [(&str, Config, Flip); 11] = [
        ("log2_q11", ADAPTIVE, |t| {
            t.log2_q11.iter_mut().for_each(|v| *v ^= 1);
        }),
        // Widths beyond the table of taps.
        ("exp2_q15", Config::PAPER, |t| {
            t.exp2_q15.iter_mut().for_each(|v| *v ^= 1);
        }),
        ("time, rational", kernel(TimeKernel::Rational), time),
        ("time, Gaussian", kernel(TimeKernel::Gaussian), time),
        ("time, exponential", kernel(TimeKernel::Exponential), time),
        ("light, linear", ADAPTIVE, light),
        ("light, encoded", encoded, light),
        ("linear", ADAPTIVE, |t| {
            t.linear.iter_mut().for_each(|v| *v ^= 1);
        }),
        ("srgb_from", ADAPTIVE, |t| {
            t.srgb_from.iter_mut().for_each(|v| *v ^= 1);
        }),
        ("srgb_guess", ADAPTIVE, |t| {
            t.srgb_guess.iter_mut().for_each(|v| *v ^= 1);
        }),
        ("taps", ADAPTIVE, |t| {
            t.taps.iter_mut().for_each(|v| *v ^= 1)
        }),
    ];
    for (name, config, flip) in flips {
        let case = Case {
            config,
            size,
            samples: 12_000,
        };
        let mut tables = Tables::new(&config);
        assert_eq!(difference(&gpu, case, &tables, &bytes), None, "{name}");
        flip(&mut tables);
        let found = difference(&gpu, case, &tables, &bytes);
        assert!(found.is_some(), "{name}: not found");
    }
}

#[test]
fn a_display_that_cannot_be_is_refused() {
    let Some(gpu) = adapter_or_skip("refusal of impossible displays") else {
        return;
    };
    for (width, height, samples) in [(0, 1, 1), (1, 4081, 1), (4, 4, usize::MAX)] {
        let error = GpuPlayer::new(&gpu, ADAPTIVE, width, height, samples);
        let text = error.expect_err("out of range").to_string();
        assert!(text.starts_with("graphics: the display's twin: "), "{text}");
    }
}
