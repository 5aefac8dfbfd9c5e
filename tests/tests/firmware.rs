//! The images: the same bits as everywhere, nothing in them that must not be, a panel that shows it.

use embedded_graphics_core::pixelcolor::raw::RawU16;
use embedded_graphics_core::pixelcolor::{Rgb565, Rgb888};
use embedded_graphics_core::prelude::RawData;
use unframed_host::scene::builtin::BUILTIN;
use unframed_sim::Gpu;
use unframed_sim::boards::elf::Contents;
use unframed_sim::boards::{Board, BoardError, Image, Report, Target};
use unframed_tests::backends::{Show, adapter_or_skip, boards_or_skip, firmware};
use unframed_tests::controller::Controller;
use unframed_tests::scenes::{RATE, REFRESHES, SIZE, record, recorded};
use unframed_tests::stream::{PIXEL, Rng, Stream, sample, tile};
use unframed_wire::WorldSample;

/// Bytes of stack that the reconstructor may use, of the 16 KiB that the boards have.
const STACK: u64 = 12 * 1024;

fn show(bytes: &[u8]) -> Show<'_> {
    Show {
        bytes,
        size: SIZE,
        method: "adaptive",
        samples: 16_384,
    }
}

/// Shows a stream on the adapter and, if wanted, on all boards, with the bits of the desktop; what the
/// boards reported.
fn shown_alike(
    scene: &str,
    show: &Show<'_>,
    gpu: Option<&Gpu>,
    boards: bool,
) -> Vec<(Board, Report)> {
    let hashes = show.fixed().hashes();
    if let Some(gpu) = gpu {
        let twin = show.twin(gpu).expect("the adapter has room");
        assert_eq!(twin.hashes(), hashes, "{scene} on the adapter");
    }
    let boards = Board::ALL.iter().filter(|_| boards);
    let reports = boards.map(|board| {
        let report = show.board(*board, Image::Play).expect("the board works");
        let shown: Vec<_> = report.shown.iter().map(|shown| shown.hash).collect();
        assert_eq!(shown, hashes, "{scene} on {}", board.name());
        (*board, report)
    });
    reports.collect()
}

#[test]
fn every_back_end_shows_the_same_bits_of_the_scenes() {
    let gpu = adapter_or_skip("the scenes on the adapter");
    let boards = boards_or_skip(Image::Play, "the scenes on the boards");
    for (scene, bytes) in recorded() {
        let show = show(&bytes);
        let hashes = show.fixed().hashes();
        assert_eq!(hashes.len(), REFRESHES as usize);
        let mut distinct = hashes.clone();
        distinct.dedup();
        assert_eq!(
            distinct.len(),
            hashes.len(),
            "{scene}: the picture stands still"
        );
        for (_, report) in shown_alike(scene, &show, gpu.as_ref(), boards) {
            assert!(report.stack < STACK, "{} bytes of stack", report.stack);
        }
    }
}

#[test]
fn a_board_counts_the_same_every_time() {
    if !boards_or_skip(Image::Play, "instructions counted twice") {
        return;
    }
    let bytes = record(BUILTIN[0], RATE, 2);
    for board in Board::ALL {
        let runs = [(); 2].map(|()| show(&bytes).board(board, Image::Play).expect("it works"));
        assert_eq!(runs[0], runs[1], "{}", board.name());
        assert!(runs[0].shown.iter().all(|shown| shown.show > 100_000));
    }
}

/// Samples all over a plane that fills 64 × 64 pixels.
fn samples_of_the_plane(rng: &mut Rng, count: usize) -> Vec<WorldSample> {
    let half = i64::from(PIXEL) * 32;
    (0..count)
        .map(|_| {
            let [x, y] = [(); 2].map(|()| rng.range(-half, half) as i16);
            sample([x, y, 0], [(x as u8) ^ (y as u8), 90, y as u8])
        })
        .collect()
}

/// Everything moves, so nothing lives long: samples that are too old for the longest lifetime cost
/// next to nothing. 64 × 64 pixels, 16,384 samples of a second.
#[test]
fn what_moves_costs_what_is_young() {
    if !boards_or_skip(Image::Play, "instructions in motion") {
        return;
    }
    let size = (64, 64);
    for method in ["pixels", "adaptive-constant", "adaptive"] {
        // Lifetimes of 1/16, 1/4 and 1 s.
        let costs = [96, 112, 128].map(|lifetime| {
            let mut rng = Rng(40);
            let mut stream = Stream::of_the_plane(size);
            stream.tiles(0, 64, |rect| tile(rect, [90, 90, 90, lifetime]));
            for time in 0..64 {
                stream.world(time * 15_625, &samples_of_the_plane(&mut rng, 256));
            }
            stream.refresh(1_000_000);
            let show = Show {
                bytes: &stream.bytes,
                size,
                method,
                samples: 16_384,
            };
            let report = show.board(Board::CortexM7, Image::Play);
            report.expect("the board works").shown[0].show
        });
        println!("{method}: {costs:?} instructions a refresh");
        let [short, middle, _] = costs;
        // Fewer samples are filtered more widely; not asking where the old ones are saves a third.
        assert!(3 * short < 2 * middle, "{method}: {costs:?}");
    }
}

/// 64 × 64 pixels, 16,384 samples remembered, everything moving, each sample counting for its own
/// pixel: within four million instructions a refresh, 240 million a second, and with the bits that the
/// desktop finds by its filters.
#[test]
fn pixels_alone_move_within_four_million_instructions() {
    let boards = boards_or_skip(Image::Play, "pixels alone");
    let gpu = adapter_or_skip("pixels alone on the adapter");
    for (scene, bytes) in recorded() {
        let show = Show {
            method: "pixels",
            ..show(&bytes)
        };
        for (board, report) in shown_alike(scene, &show, gpu.as_ref(), boards) {
            let most = report.shown.iter().map(|shown| shown.show).max();
            println!("{scene} on {}: {most:?} instructions", board.name());
            if board == Board::CortexM7 {
                assert!(
                    most.is_some_and(|most| most <= 4_000_000),
                    "{scene}: {most:?}"
                );
            }
        }
    }
}

/// 64 × 64 pixels that remember 16,384 samples and get as many a second: at rest a refresh looks at
/// 273 of them.
#[test]
fn at_rest_a_refresh_costs_what_is_new() {
    if !boards_or_skip(Image::Play, "instructions at rest") {
        return;
    }
    let size = (64, 64);
    let mut rng = Rng(40);
    let mut take = |count| samples_of_the_plane(&mut rng, count);
    let mut stream = Stream::of_the_plane(size);
    stream.tiles(0, 64, |rect| tile(rect, [90, 90, 90, 255]));
    stream.world(0, &take(16_384));
    // A second at 8 Hz until it settles, then at 60 Hz.
    let mut time = 0;
    for step in [[125_000; 10], [16_667; 10]].concat() {
        time += step;
        stream.world(time, &take(273));
        stream.refresh(time);
    }
    for board in Board::ALL {
        let show = Show {
            size,
            ..show(&stream.bytes)
        };
        let report = show.board(board, Image::Play).expect("the board works");
        let (moving, resting) = (&report.shown[0], &report.shown[15..]);
        let most = resting.iter().map(|shown| shown.show).max().unwrap_or(0);
        println!(
            "{}: filtering {}, at rest at most {most} instructions a refresh",
            board.name(),
            moving.show
        );
        assert!(most > 1000 && most <= 400_000, "{}: {most}", board.name());
        assert!(moving.show > 10 * most);
    }
}

#[test]
fn the_deployed_image_cannot_panic_allocate_or_compute_with_floats() {
    if !boards_or_skip(Image::Play, "the image's contents") {
        return;
    }
    for target in Target::ALL {
        let elf = firmware().and_then(|source| source.build(Image::Play, target));
        let contents = Contents::of(&elf.expect("it builds")).expect("an ELF file");
        assert!(contents.code > 10_000 && contents.constants > 10_000);
        assert_eq!(contents.panics, [""; 0]);
        assert_eq!(contents.allocators, [""; 0]);
        assert_eq!(contents.floats, [""; 0]);
    }
}

/// The checks above can fail: floats are found where there are floats, and an image that can panic
/// does not link unless it is allowed to.
#[test]
fn what_must_not_be_there_is_found() {
    if !boards_or_skip(Image::Panel, "must-fail checks of the images") {
        return;
    }
    let source = firmware().expect("the source");
    for target in Target::ALL {
        let elf = source.build(Image::PlayF32, target).expect("it builds");
        let contents = Contents::of(&elf).expect("an ELF file");
        assert!(!contents.floats.is_empty(), "{}", target.triple());
        let elf = source.build(Image::Panel, target).expect("it builds");
        let contents = Contents::of(&elf).expect("an ELF file");
        assert!(!contents.panics.is_empty(), "{}", target.triple());
        match source.build_with(Image::Panel, target, "panel") {
            Err(BoardError::Build { output, .. }) => {
                assert!(output.contains("this_image_can_panic"), "{output}");
            }
            other => panic!("linked: {other:?}"),
        }
    }
}

#[test]
fn a_controller_shows_what_the_display_computed() {
    if !boards_or_skip(Image::Panel, "the panel's driver") {
        return;
    }
    let bytes = record("toycar", RATE, REFRESHES);
    let hashes = show(&bytes).fixed().hashes();
    for board in [Board::CortexM4F, Board::RiscV] {
        let report = show(&bytes)
            .board(board, Image::Panel)
            .expect("the board works");
        let shown: Vec<_> = report.shown.iter().map(|shown| shown.hash).collect();
        assert_eq!(shown, hashes, "{}", board.name());
        let mut controller = Controller::default();
        let mut refreshes = 0;
        controller
            .replay(&report.bus, |_, windows, pixels| {
                assert!(windows > 0 && pixels >= 64 * windows);
                refreshes += 1;
            })
            .expect("what a controller understands");
        assert_eq!(refreshes, REFRESHES);
        let expected: Vec<u16> = report
            .picture
            .iter()
            .map(|[r, g, b]| RawU16::from(Rgb565::from(Rgb888::new(*r, *g, *b))).into_inner())
            .collect();
        assert!(controller.shown(SIZE).expect("it is on") == expected);
    }
}

/// A second refresh of the same instant changes nothing, and nothing is sent; a few new samples in
/// a corner change a corner.
#[test]
fn only_windows_that_changed_are_sent() {
    if !boards_or_skip(Image::Panel, "the panel's windows") {
        return;
    }
    use unframed_tests::stream::{Stream, sample};
    let mut stream = Stream::of_the_plane(SIZE);
    let fill: Vec<_> = (0..64 * 64)
        .map(|i| {
            sample(
                [8 * (i % 64 - 32) + 4, 8 * (i / 64 - 32) + 4, 0],
                [30, 60, 90],
            )
        })
        .collect();
    stream.world(0, &fill);
    stream.refresh(1000);
    stream.refresh(1000);
    stream.world(1000, &[sample([-200, -200, 0], [250, 250, 250]); 40]);
    stream.refresh(1000);
    let report = show(&stream.bytes)
        .board(Board::CortexM4F, Image::Panel)
        .expect("it works");
    let mut sent = Vec::new();
    let mut controller = Controller::default();
    controller
        .replay(&report.bus, |_, windows, pixels| {
            sent.push((windows, pixels))
        })
        .expect("what a controller understands");
    // The first refresh follows the driver's own clearing of the panel: a window more.
    assert_eq!(sent[0], (1 + 8, 2 * 64 * 64));
    assert_eq!(sent[1], (0, 0));
    assert!(
        (1..=3).contains(&sent[2].0) && sent[2].1 <= 9 * 64,
        "{:?}",
        sent[2]
    );
}

/// The model refuses what the chip leaves undefined.
#[test]
fn a_controller_is_strict() {
    let refused: [&[u8]; 6] = [
        // An unknown command; a window of five columns filled with one pixel; a pixel beyond a
        // window; a window beyond the memory; a record cut off; arguments where none belong.
        &[0, 1, 0, 0x99],
        &[
            0, 1, 0, 0x2a, 1, 4, 0, 0, 0, 0, 4, 0, 1, 0, 0x2c, 1, 2, 0, 0, 0, 0, 1, 0, 0x13,
        ],
        &[0, 1, 0, 0x2c, 1, 4, 0, 0, 0, 0, 0],
        &[0, 1, 0, 0x2a, 1, 4, 0, 0, 0, 0, 240, 0, 1, 0, 0x13],
        &[0, 9, 0, 0x2c],
        &[0, 1, 0, 0x29, 1, 1, 0, 7, 0, 1, 0, 0x13],
    ];
    for bus in refused {
        let outcome = Controller::default().replay(bus, |_, _, _| {});
        assert!(outcome.is_err(), "{bus:x?}");
    }
    assert!(Controller::default().shown((1, 1)).is_err(), "it is asleep");
}
