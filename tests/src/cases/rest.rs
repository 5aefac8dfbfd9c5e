//! When nothing moves, and when it ends.

use super::{BETWEEN, BRIGHT, Case, DARK, Expected, checker};
use crate::stream::{PIXEL, Rng, Stream, flat, sample, tile};
use unframed_wire::WorldSample;

const SIZE: (u16, u16) = (20, 20);
/// Between refreshes, microseconds: a rest settles after six.
const STEP: u32 = 200_000;
/// The code of a lifetime without end.
const RESTS: u8 = 255;

pub(super) fn cases() -> Vec<Case> {
    vec![turns(), light_goes_out()]
}

fn tiles(stream: &mut Stream, time: u32, lifetime: u8) {
    stream.tiles(time, 64, |rect| tile(rect, [90, 90, 90, lifetime]));
}

/// `count` refreshes from `from` on, each after the samples of `take`; when the last one was.
fn refreshes(
    stream: &mut Stream,
    from: u32,
    count: u32,
    mut take: impl FnMut() -> Vec<WorldSample>,
) -> u32 {
    for k in 0..count {
        stream.world(from.wrapping_add(k * STEP), &take());
        stream.refresh(from.wrapping_add((k + 1) * STEP));
    }
    from.wrapping_add(count * STEP)
}

/// Rests until it settles while the clock wraps; the eye moves; rests; is cut; rests.
fn turns() -> Case {
    let mut rng = Rng(30);
    let mut take = move || checker(&mut rng, SIZE, 150);
    let mut stream = Stream::of_the_plane(SIZE);
    let mut time = 0u32.wrapping_sub(3 * STEP);
    tiles(&mut stream, time, RESTS);
    time = refreshes(&mut stream, time, 9, &mut take);
    let mut view = flat(time, SIZE);
    view.eye[0] += i32::from(PIXEL) / 2;
    stream.look(&view);
    time = refreshes(&mut stream, time, 9, &mut take);
    stream.cut(time);
    refreshes(&mut stream, time, 9, &mut take);
    Case::new("rests that settle and end", SIZE, stream.bytes, BETWEEN).method("adaptive-constant")
}

/// All is bright and averaged for long; then it is dark, and the tiles say that light changes.
fn light_goes_out() -> Case {
    let mut rng = Rng(31);
    let mut take = |rgb: [u8; 3]| {
        let mut along = |side: u16| {
            let half = i64::from(side) * i64::from(PIXEL) / 2;
            rng.range(-half, half) as i16
        };
        (0..400)
            .map(|_| sample([along(SIZE.0), along(SIZE.1), 0], rgb))
            .collect::<Vec<_>>()
    };
    let mut stream = Stream::of_the_plane(SIZE);
    tiles(&mut stream, 0, RESTS);
    let time = refreshes(&mut stream, 0, 12, || take(BRIGHT));
    tiles(&mut stream, time, 60);
    let time = refreshes(&mut stream, time, 2, || take(DARK));
    tiles(&mut stream, time, RESTS);
    // What was stored before is still younger than infinity: as the stream says, it counts again.
    stream.cut(time);
    refreshes(&mut stream, time, 8, || take(DARK));
    Case::new(
        "light that goes out at rest",
        SIZE,
        stream.bytes,
        Expected::Colour(DARK, 0),
    )
}
