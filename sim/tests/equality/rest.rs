//! Averaging at rest: equal through all turns of a stream that rests, and while it is at it.

use super::stream::Stream;
use super::{ADAPTIVE, Case, adapter_or_skip, check};
use unframed_recon::config::{Fit, Light};
use unframed_recon::heap::HeapStorage;
use unframed_recon::rest::SETTLED;
use unframed_recon::{Config, Display, Fixed, Player};
use unframed_sim::GpuPlayer;
use unframed_sim::twin::Tables;
use unframed_wire::{Layout, LogCode, Tile};

const SIZE: (u16, u16) = (70, 45);
/// Between refreshes, microseconds: the rest settles after six.
const STEP: u32 = 200_000;
const _: () = assert!(SETTLED < 6 * STEP as i32);

fn rests(tile: &mut Tile) {
    tile.lifetime = LogCode(255);
}

/// `count` refreshes of one view, each with new samples.
fn refreshes(stream: &mut Stream, time: &mut u32, count: u32) {
    for _ in 0..count {
        stream.samples(700, *time, STEP - 1000);
        *time = time.wrapping_add(STEP);
        stream.refresh(*time, *time / STEP);
    }
}

/// Moves, rests till it settles, changes in a corner, settles, moves an object, settles, is cut,
/// lets its clock run back.
fn turns(layout: Layout) -> Vec<u8> {
    let mut stream = Stream::new(SIZE, layout, 5);
    // The clock wraps on the way.
    let mut time = 0u32.wrapping_sub(4 * STEP);
    for turn in [0.0, 0.1] {
        stream.view(time, turn);
        stream.poses(time, turn);
        stream.tiles_but(time, 60, rests);
        refreshes(&mut stream, &mut time, 1);
    }
    refreshes(&mut stream, &mut time, 9);
    stream.tiles_but(time, 60, |tile| {
        if tile.rect.x > 30 {
            rests(tile);
        }
    });
    refreshes(&mut stream, &mut time, 2);
    stream.tiles_but(time, 60, rests);
    refreshes(&mut stream, &mut time, 8);
    stream.poses(time, 0.5);
    refreshes(&mut stream, &mut time, 8);
    stream.cut(time);
    refreshes(&mut stream, &mut time, 8);
    time = time.wrapping_sub(5 * STEP);
    refreshes(&mut stream, &mut time, 8);
    stream.bytes
}

#[test]
fn every_turn_of_a_rest_is_equal() {
    let Some(gpu) = adapter_or_skip("equality at rest") else {
        return;
    };
    let encoded = Config {
        light: Light::Encoded,
        fit: Fit::Constant,
        ..ADAPTIVE
    };
    for (config, layout, samples) in [
        (ADAPTIVE, Layout::World, 2000),
        // Fewer than arrive between two refreshes.
        (ADAPTIVE, Layout::World, 500),
        (encoded, Layout::World, 2000),
        (ADAPTIVE, Layout::Screen, 2000),
    ] {
        let case = Case {
            config,
            size: SIZE,
            samples,
        };
        check(&gpu, case, &turns(layout));
    }
}

/// One pixel, so that its mean fills up and is halved.
#[test]
fn a_full_mean_is_equal() {
    let Some(gpu) = adapter_or_skip("equality of full means") else {
        return;
    };
    let case = Case {
        config: ADAPTIVE,
        size: (1, 1),
        samples: 50_000,
    };
    let mut stream = Stream::new(case.size, Layout::Screen, 6);
    stream.view(0, 0.0);
    stream.tiles_but(0, 60, rests);
    for refresh in 1..5 {
        stream.samples(40_000, refresh * STEP - STEP, STEP);
        stream.refresh(refresh * STEP, refresh);
    }
    check(&gpu, case, &stream.bytes);
}

/// The averages are in the pictures that are compared: a twin that does not average differs.
#[test]
fn a_twin_that_does_not_average_is_found() {
    let Some(gpu) = adapter_or_skip("whether the comparison at rest can fail") else {
        return;
    };
    let case = Case {
        config: ADAPTIVE,
        size: SIZE,
        samples: 2000,
    };
    let without = Config {
        rest: false,
        ..ADAPTIVE
    };
    let tables = Tables::new(&case.config);
    let bytes = turns(Layout::World);
    let mut twin = GpuPlayer::with_tables(&gpu, without, SIZE.0, SIZE.1, 2000, &tables)
        .expect("the adapter has room");
    let mut storage = HeapStorage::new(SIZE.0, SIZE.1, case.samples);
    let display = Display::<Fixed>::new(case.config, SIZE.0, SIZE.1, storage.memory());
    let mut cpu = Player::new(display.expect("it fits"));
    let (mut left, mut right) = (&bytes[..], &bytes[..]);
    let mut differing = 0;
    while twin.push(&mut left).expect("the device answers").is_some() {
        cpu.push(&mut right);
        differing += u32::from(twin.picture() != cpu.display().picture());
    }
    assert!(differing > 20, "{differing} refreshes show averages");
}
