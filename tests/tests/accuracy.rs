//! Integers against the oracle: how far, and why.

use unframed_host::scene::builtin::BUILTIN;
use unframed_recon::Config;
use unframed_tests::accuracy::{Accuracy, Setting, compare};
use unframed_tests::backends::Show;
use unframed_tests::scenes::{RATE, REFRESHES, SIZE, ideals, record, recorded};
use unframed_tests::stream::Rng;
use unframed_tests::{cases, fuzzed};

/// The deployed display of the boards.
const SETTING: Setting = Setting {
    config: Config::ADAPTIVE,
    size: SIZE,
    samples: 16_384,
};

fn report(name: &str, found: &Accuracy) {
    println!(
        "{name}: equal {:.2} %, at most 1 {:.4} %, worst {}; of {} decisions {:?}, reaching {:.4} % \
         of the pixels, changing {:.4} % by more than 1; {:?}",
        100.0 * found.within(0),
        100.0 * found.within(1),
        found.worst(),
        found.decisions,
        found.flips,
        100.0 * found.reached(),
        100.0 * found.flipped(1),
        found.errors
    );
}

#[test]
fn on_the_recorded_streams_integers_show_what_the_oracle_shows() {
    for (scene, bytes) in recorded() {
        let found = compare(&bytes, &SETTING);
        report(scene, &found);
        assert!(found.decisions > 50_000, "{scene}");
        assert!(found.within(1) >= 0.999 && found.worst() <= 3, "{scene}");
        // Counted apart: what a flipped sample reaches and changes by more than that.
        assert!(found.flipped(1) <= 0.0005, "{scene}");
        assert_eq!(found.flips.unexplained, 0, "{scene}");
        assert!(found.errors.place < 0.51 && found.errors.depth <= 1.25);
        assert!(found.errors.weight < 12.0);
    }
}

/// Few samples a pixel, whose planes enlarge what rounding leaves; long enough that things move
/// before others.
#[test]
fn on_thin_streams_every_flip_is_explained() {
    let mut flips = 0;
    for scene in BUILTIN.iter().take(3) {
        let found = compare(&record(scene, RATE, 40), &SETTING);
        report(scene, &found);
        flips += found.flips.depths;
        assert!(found.within(1) >= 0.998, "{scene}");
        assert!(found.flipped(1) <= 0.005, "{scene}");
        assert_eq!(found.flips.unexplained, 0, "{scene}");
        assert!(found.errors.place < 0.51 && found.errors.depth <= 1.25);
        assert!(found.errors.weight < 12.0);
    }
    assert!(flips > 0, "nothing to explain");
}

/// The hard cases are made to sit on borders: there decisions flip in masses.
#[test]
fn in_the_hard_cases_every_flip_is_explained() {
    for case in cases::all() {
        let found = compare(case.show().bytes, &case.show().setting());
        assert_eq!(found.flips.unexplained, 0, "{}: {found:?}", case.name);
    }
}

/// The body of the fuzz target `oracle` over seeded bytes.
#[test]
fn any_bytes_are_shown_alike() {
    let (mut shown, mut decisions, mut borders, mut depths) = (0, 0, 0, 0);
    for seed in 0..300 {
        let mut rng = Rng(seed);
        let data: Vec<u8> = (0..rng.range(50, 1500)).map(|_| rng.bits() as u8).collect();
        let found = fuzzed::check(&data);
        shown += usize::from(found.decisions > 0);
        decisions += found.decisions;
        borders += found.flips.borders;
        depths += found.flips.depths;
    }
    println!(
        "{shown} show something; {decisions} decisions; flipped: {borders} by borders, {depths} by depths"
    );
    assert!(shown > 150 && decisions > 100_000 && borders > 100 && depths > 10);
}

/// Root of the mean squared difference, levels of 255.
fn rms(pictures: &[Vec<[u8; 3]>], ideals: &[Vec<[u8; 3]>]) -> f64 {
    let pairs = pictures.iter().flatten().zip(ideals.iter().flatten());
    let squares =
        pairs.flat_map(|(a, b)| [0, 1, 2].map(|c| f64::from(a[c].abs_diff(b[c])).powi(2)));
    let count = 3 * pictures.iter().map(Vec::len).sum::<usize>();
    (squares.sum::<f64>() / count as f64).sqrt()
}

#[test]
fn integers_are_as_close_to_what_should_be_seen_as_the_oracle() {
    for (scene, bytes) in recorded() {
        let show = Show {
            bytes: &bytes,
            size: SIZE,
            method: "adaptive",
            samples: SETTING.samples,
        };
        let ideals = ideals(scene, REFRESHES);
        let fixed = rms(&show.fixed().pictures, &ideals);
        let oracle = rms(&show.here::<f64>().pictures, &ideals);
        println!("{scene}: {fixed:.4} in integers, {oracle:.4} in f64");
        assert!(oracle > 1.0 && oracle < 40.0, "{scene}: {oracle}");
        assert!((fixed / oracle - 1.0).abs() < 0.01, "{scene}");
    }
}
