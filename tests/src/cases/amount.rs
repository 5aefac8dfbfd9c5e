//! None, one, millions; panels; damage.

use super::{BETWEEN, Case, Expected, Room, checker};
use crate::stream::{Rng, Stream, sample, tile};
use unframed_wire::{Layout, ScreenSample, WorldSample};

const SIZE: (u16, u16) = (24, 24);

pub(super) fn cases() -> Vec<Case> {
    vec![
        none(),
        one(),
        fireflies(),
        black(),
        heap(
            "two million samples on one spot, the last 65,536 kept",
            65_536,
            Room::Boards,
        ),
        heap(
            "two million samples on one spot, all kept",
            1 << 21,
            Room::Desktop,
        ),
        panel("a panel of 1 × 1", (1, 1), 300),
        panel("a panel of 1 × 300", (1, 300), 2000),
        panel("a panel of 4080 × 1, the widest", (4080, 1), 4000),
        panel("a panel of 1 × 4080, the highest", (1, 4080), 4000),
        panel("a panel of 4080 × 4080, the largest", (4080, 4080), 4000)
            .method("frameless")
            .room(Room::Desktop),
        panel(
            "a panel of 2040 × 1020, reconstructed",
            (2040, 1020),
            100_000,
        )
        .method("adaptive-constant")
        .samples(100_000)
        .room(Room::Desktop),
        frameless(),
        damaged(),
    ]
}

fn none() -> Case {
    let mut stream = Stream::of_the_plane(SIZE);
    stream.tiles(0, 64, |rect| tile(rect, [96, 96, 96, 128]));
    (1..4).for_each(|k| stream.refresh(k * 16_000));
    Case::new("no samples", SIZE, stream.bytes, Expected::Black)
}

fn one() -> Case {
    let rgb = [250, 7, 99];
    let mut stream = Stream::of_the_plane(SIZE);
    stream.world(0, &[sample([3, -5, 0], rgb)]);
    stream.refresh(16_000);
    Case::new("one sample", SIZE, stream.bytes, Expected::Colour(rgb, 0))
}

/// One sample in a hundred as bright as it gets, the others black.
fn fireflies() -> Case {
    let mut rng = Rng(40);
    let mut stream = Stream::of_the_plane(SIZE);
    for k in 0..20u32 {
        let mut samples = checker(&mut rng, SIZE, 100);
        for (i, sample) in samples.iter_mut().enumerate() {
            sample.rgb = if i % 100 == 0 { [255; 3] } else { [0; 3] };
        }
        stream.world(k * 800, &samples);
    }
    stream.refresh(16_000);
    Case::new("fireflies in the dark", SIZE, stream.bytes, Expected::Lit)
}

fn black() -> Case {
    let mut rng = Rng(41);
    let mut stream = Stream::of_the_plane(SIZE);
    let mut samples = checker(&mut rng, SIZE, 2000);
    samples.iter_mut().for_each(|sample| sample.rgb = [0; 3]);
    stream.world(0, &samples);
    stream.refresh(16_000);
    Case::new("black samples", SIZE, stream.bytes, Expected::Black)
}

/// Two million (2^21) samples on one spot: every sum of the pixels around at its largest.
fn heap(name: &'static str, kept: usize, room: Room) -> Case {
    let rgb = [255, 254, 1];
    let mut stream = Stream::of_the_plane(SIZE);
    let packet: Vec<WorldSample> = vec![sample([5, 3, 0], rgb); 256];
    (0..8192).for_each(|k| stream.world(k, &packet));
    stream.refresh(8192);
    Case::new(name, SIZE, stream.bytes, Expected::Colour(rgb, 0))
        .samples(kept)
        .room(room)
}

fn panel(name: &'static str, size: (u16, u16), count: usize) -> Case {
    let mut rng = Rng(42);
    // The lattice reaches over 8192 pixels: coarser steps are not needed.
    let mut stream = Stream::of_the_plane(size);
    for k in 0..4u32 {
        stream.world(k * 4000, &checker(&mut rng, size, count / 4));
    }
    stream.refresh(16_000);
    let expected = Expected::Between([0; 3], super::BRIGHT);
    Case::new(name, size, stream.bytes, expected).method("adaptive-constant")
}

/// Samples on the screen, the newest shows: up to the last row and column.
fn frameless() -> Case {
    let mut rng = Rng(43);
    let mut stream = Stream::new(SIZE, Layout::Screen, 400_000);
    for y in 0..SIZE.1 {
        let row: Vec<_> = (0..SIZE.0)
            .map(|x| ScreenSample {
                x: 16 * x + rng.range(0, 16) as u16,
                y: 16 * y + 15,
                rgb: [9, 99, 199],
            })
            .collect();
        stream.screen(u32::from(y), &row);
    }
    stream.refresh(16_000);
    let expected = Expected::Colour([9, 99, 199], 0);
    Case::new(
        "the newest sample, up to the borders",
        SIZE,
        stream.bytes,
        expected,
    )
    .method("frameless")
}

/// Bytes flipped, lost and invented: what is good still shows.
fn damaged() -> Case {
    let mut rng = Rng(44);
    let mut stream = Stream::of_the_plane(SIZE);
    for round in 0..4u32 {
        for k in 0..20 {
            let samples = checker(&mut rng, SIZE, 50);
            stream.world(round * 16_000 + k * 800, &samples);
        }
        stream.refresh((round + 1) * 16_000);
    }
    let mut bytes = stream.bytes;
    for at in (700..bytes.len()).step_by(1300) {
        bytes[at] ^= 0x10;
    }
    bytes.drain(2000..2500);
    let noise: Vec<u8> = (0..3000).map(|_| rng.bits() as u8).collect();
    bytes.splice(4000..4000, noise);
    Case::new("bytes flipped, lost and invented", SIZE, bytes, BETWEEN).method("adaptive-constant")
}
