//! Integers against the oracle on the recorded streams: how far, and why.

use unframed_host::scene::builtin::BUILTIN;
use unframed_tests::accuracy::compare;
use unframed_tests::backends::Show;
use unframed_tests::scenes::{RATE, SIZE, record};

#[test]
fn integers_follow_the_oracle() {
    for (rate, refreshes) in [(8 * RATE, 6), (RATE, 40)] {
        for scene in BUILTIN.iter().take(3) {
            let bytes = record(scene, rate, refreshes);
            let show = Show {
                bytes: &bytes,
                size: SIZE,
                method: "adaptive",
                samples: 16_384,
            };
            let found = compare(&show);
            let cut = |h: &[usize]| h.iter().rposition(|n| *n > 0).map_or(vec![], |l| h[..=l].to_vec());
            println!("{scene} {rate} {:?} of {}: others {:?} flipped {:?}", found.flips, found.decisions, cut(&found.others), cut(&found.flipped));
        }
    }
}
