//! Clocks, order, rates.

use super::{BETWEEN, BRIGHT, Case, Expected, checker};
use crate::stream::{Rng, Stream, flat, pose, sample};
use unframed_wire::{Layout, SKY};

const SIZE: (u16, u16) = (24, 24);

pub(super) fn cases() -> Vec<Case> {
    vec![
        wrap(),
        aged(
            1 << 31,
            "samples half the clock's range old",
            Expected::Black,
        ),
        aged(
            (1 << 31) + 5_000_000,
            "samples older than half the range",
            Expected::Black,
        ),
        aged(
            1 << 30,
            "samples of the age that is forgotten",
            Expected::Black,
        ),
        aged(
            50_000u32.wrapping_neg(),
            "samples from the future",
            Expected::Colour(BRIGHT, 0),
        ),
        out_of_order(),
        repeated(),
        slow(),
        fast(),
        month(),
    ]
}

/// Ten refreshes of the checker from `start` on.
fn running(start: u32) -> Vec<u8> {
    let mut rng = Rng(20);
    let mut stream = Stream::of_the_plane(SIZE);
    for index in 0..10u32 {
        let time = start.wrapping_add(index * 16_000);
        for k in 0..8 {
            let samples = checker(&mut rng, SIZE, 30);
            stream.world(time.wrapping_add(k * 2000), &samples);
        }
        let mut view = flat(time, SIZE);
        view.eye[0] += 40 * index as i32;
        stream.look(&view);
        stream.refresh(time.wrapping_add(16_000));
    }
    stream.bytes
}

fn wrap() -> Case {
    let expected = Expected::SameAs("the stream at time 0", running(0));
    let bytes = running(u32::MAX - 70_000);
    Case::new("the clock wraps at 2^32", SIZE, bytes, expected)
}

fn aged(age: u32, name: &'static str, expected: Expected) -> Case {
    let mut stream = Stream::of_the_plane(SIZE);
    let now = 1_000_000u32;
    let samples: Vec<_> = (-4..4)
        .map(|x| sample([x * 16, x * 8, 0], BRIGHT))
        .collect();
    stream.world(now.wrapping_sub(age), &samples);
    stream.refresh(now);
    Case::new(name, SIZE, stream.bytes, expected)
}

/// Packets of the same samples in two orders.
fn out_of_order() -> Case {
    let stream = |back: bool| {
        let mut rng = Rng(21);
        let mut packets: Vec<_> = (0..40u32)
            .map(|k| (k * 400, checker(&mut rng, SIZE, 40)))
            .collect();
        if back {
            packets.reverse();
            packets
                .iter_mut()
                .for_each(|(_, samples)| samples.reverse());
        }
        let mut stream = Stream::of_the_plane(SIZE);
        for (time, samples) in packets {
            stream.world(time, &samples);
        }
        stream.refresh(16_000);
        stream.bytes
    };
    let expected = Expected::SameAs("the stream in order", stream(false));
    Case::new("samples out of order", SIZE, stream(true), expected)
}

/// Every frame arrives twice: a packet is taken once.
fn repeated() -> Case {
    let once = running(0);
    let twice = once
        .split_inclusive(|byte| *byte == 0)
        .flat_map(|frame| [frame, frame].concat())
        .collect();
    let expected = Expected::SameAs("the stream without repeats", once);
    Case::new("every packet twice", SIZE, twice, expected)
}

fn slow() -> Case {
    let mut rng = Rng(22);
    let mut stream = Stream::new(SIZE, Layout::World, 1);
    stream.look(&flat(0, SIZE));
    stream.poses(0, &[pose(0, 1.0, [0; 3]), pose(SKY, 1.0, [0; 3])]);
    for second in 0..40u32 {
        stream.world(second * 1_000_000, &checker(&mut rng, SIZE, 1));
        stream.refresh(second * 1_000_000 + 500_000);
    }
    Case::new("one sample a second", SIZE, stream.bytes, BETWEEN).method("adaptive-constant")
}

/// 10^8 samples a second: 1.2 ms of them, several packets in the same microsecond.
fn fast() -> Case {
    let mut rng = Rng(23);
    let mut stream = Stream::new(SIZE, Layout::World, 100_000_000);
    stream.look(&flat(0, SIZE));
    stream.poses(0, &[pose(0, 1.0, [0; 3]), pose(SKY, 1.0, [0; 3])]);
    for k in 0..600u32 {
        stream.world(2 * k, &checker(&mut rng, SIZE, 200));
        if k % 200 == 199 {
            stream.refresh(2 * k + 1);
        }
    }
    Case::new("10^8 samples a second", SIZE, stream.bytes, BETWEEN)
        .method("adaptive-constant")
        .samples(65_536)
}

/// 30 days in steps of an hour (the clock wraps 603 times): a few samples and two refreshes each.
/// What is shown at the end is what the last hour alone shows.
fn month() -> Case {
    let size = (8, 8);
    let hour = |stream: &mut Stream, hour: u64| {
        let mut rng = Rng(hour);
        let start = (hour * 3_600_000_000) as u32;
        let samples = checker(&mut rng, size, 60);
        stream.world(start, &samples);
        stream.refresh(start.wrapping_add(5000));
        stream.refresh(start.wrapping_add(21_667));
    };
    let mut stream = Stream::of_the_plane(size);
    (0..720).for_each(|k| hour(&mut stream, k));
    Case::new("30 days", size, stream.bytes, BETWEEN)
        .method("adaptive-constant")
        .samples(256)
}
