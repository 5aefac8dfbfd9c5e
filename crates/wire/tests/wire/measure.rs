//! Bytes a sample on realistic data: the goals of the format, and where the bits go
//! (`cargo test -p unframed-wire measure -- --nocapture` prints the table).

use crate::common::*;
use crate::room::{Rng, samples};
use unframed_wire::*;

/// Mean bytes a sample of 200 packets of `n` samples, all framing counted.
fn bytes_per_sample(layout: Layout, n: usize, tilt: f64, crosshairs: bool) -> f64 {
    let mut rng = Rng(1);
    let mut w = Writer::new();
    let mut sink = |_: &[u8]| {};
    w.hello(&hello(layout, layout == Layout::World), &mut sink)
        .unwrap();
    for packet in 0..200u32 {
        let (world, screen) = samples(&mut rng, n, 0.01 * f64::from(packet), tilt, crosshairs);
        let time = Tick(packet * 320);
        match layout {
            Layout::World => w.world_samples(time, &world, &mut sink).unwrap(),
            Layout::Screen => w.screen_samples(time, &screen, &mut sink).unwrap(),
        }
    }
    let ledger = w.ledger();
    let total = ledger.total_bytes() as f64;
    let per = |bits: u64| bits as f64 / ledger.samples as f64;
    let b = ledger.sample_bits;
    let overhead = 8 * ledger.total_bytes() - b.place - b.colour - b.object - b.parameters;
    println!(
        "{layout:?} n {n:3} tilt {tilt:.1} crosshairs {crosshairs:5}: {:.2} bytes; bits: place {:.2} \
         colour {:.2} object {:.2} parameters {:.2} overhead {:.2}",
        total / ledger.samples as f64,
        per(b.place),
        per(b.colour),
        per(b.object),
        per(b.parameters),
        per(overhead)
    );
    total / ledger.samples as f64
}

#[test]
fn measure_samples() {
    for tilt in [0.0, 0.4] {
        for crosshairs in [false, true] {
            for n in [32, 64, 128, 256] {
                let world = bytes_per_sample(Layout::World, n, tilt, crosshairs);
                let screen = bytes_per_sample(Layout::Screen, n, tilt, crosshairs);
                if n >= 128 {
                    assert!(world <= 8.0, "world layout: {world:.2} bytes a sample");
                    assert!(screen <= 5.0, "screen layout: {screen:.2} bytes a sample");
                }
            }
        }
    }
}
