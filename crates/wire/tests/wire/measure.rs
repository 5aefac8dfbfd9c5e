//! Bytes a sample on realistic data: the goals of the format, and where the bits go
//! (`cargo test -p unframed-wire measure -- --nocapture` prints the table).

use crate::common::*;
use crate::room::{Rng, samples, shoot};
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
    let overhead =
        8 * ledger.total_bytes() - b.place - b.colour - b.object - b.parameters - b.shares;
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

/// Bits a share of `lamps` lamps in packets of `n` samples, where light changes smoothly.
fn bits_per_share(lamps: u8, n: usize) -> f64 {
    let mut rng = Rng(1);
    let mut w = Writer::new();
    let mut sink = |_: &[u8]| {};
    w.hello(&lit(lamps), &mut sink).unwrap();
    for packet in 0..200u32 {
        let (mut world, _) = samples(&mut rng, n, 0.01 * f64::from(packet), 0.4, false);
        world
            .iter_mut()
            .for_each(|s| s.shares = smooth(s.place, lamps));
        w.world_samples(Tick(packet * 320), &world, &mut sink)
            .unwrap();
    }
    let ledger = w.ledger();
    ledger.sample_bits.shares as f64 / (ledger.samples as f64 * f64::from(lamps))
}

#[test]
fn measure_shares() {
    for lamps in [1, 2] {
        let bits = bits_per_share(lamps, 128);
        println!("shares of {lamps} lamps: {bits:.2} bits each");
        assert!(bits <= 2.0, "{bits:.2} bits a share");
    }
}

/// A k-d cut of the room: halves the longer edge while the luminance inside varies.
fn cut(rng: &mut Rng, rect: Rect, time: f64, out: &mut Vec<TileNode>) {
    let (x, y) = (f64::from(rect.x), f64::from(rect.y));
    let (w, h) = (f64::from(rect.w), f64::from(rect.h));
    let luminance = |x: f64, y: f64, time: f64| {
        let [r, g, b] = shoot(x, y, time, 0.0).0.rgb.map(f64::from);
        (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.0
    };
    let (mut gx, mut gy, mut gt, mut low, mut high) = (0.0, 0.0, 0.0, 1.0f64, 0.0f64);
    let n = 12.0;
    for _ in 0..12 {
        let (px, py) = (x + rng.unit() * w, y + rng.unit() * h);
        let l = luminance(px, py, time);
        gx += (luminance(px + 1.0, py, time) - l).abs() / n;
        gy += (luminance(px, py + 1.0, time) - l).abs() / n;
        gt += (luminance(px, py, time + 0.01) - l).abs() / (n * 0.01);
        (low, high) = (low.min(l), high.max(l));
    }
    let axis = if rect.w >= rect.h { Axis::X } else { Axis::Y };
    let area = w * h;
    if (high - low) * area.sqrt() > 1.6
        && let Some((a, b)) = tiles::split(rect, axis)
    {
        out.push(TileNode::Split(axis));
        cut(rng, a, time, out);
        cut(rng, b, time, out);
        return;
    }
    let code = |v: f64| LogCode((128.0 + 8.0 * v.max(1e-9).log2()).clamp(0.0, 255.0) as u8);
    let lifetime = code((0.05 / gt.max(1e-3)).min(1.0));
    let density = code(6.1 * 180.0 / area * (0.7 + 0.6 * rng.unit()));
    out.push(TileNode::Leaf(Tile {
        rect,
        gx: code(gx),
        gy: code(gy),
        gt: code(gt),
        lifetime,
        density,
    }));
}

/// Bits of the same codes by frame of reference: a minimum and a width for each field.
fn frame_of_reference(tiles: &[Tile]) -> u64 {
    let fields = [
        |t: &Tile| t.gx,
        |t: &Tile| t.gy,
        |t: &Tile| t.gt,
        |t: &Tile| t.lifetime,
        |t: &Tile| t.density,
    ];
    let bits = fields.map(|field| {
        let low = tiles.iter().map(|t| field(t).0).min().unwrap();
        let high = tiles.iter().map(|t| field(t).0).max().unwrap();
        12 + u64::from(8 - (high - low).leading_zeros()) * tiles.len() as u64
    });
    bits.iter().sum()
}

#[test]
fn measure_tiles() {
    let mut rng = Rng(9);
    let mut w = Writer::new();
    let mut sink = |_: &[u8]| {};
    w.hello(&hello(Layout::World, true), &mut sink).unwrap();
    let mut reference = 0;
    for i in 0..20u32 {
        let mut nodes = Vec::new();
        let whole = Rect {
            x: 0,
            y: 0,
            w: 256,
            h: 256,
        };
        cut(&mut rng, whole, 0.1 * f64::from(i), &mut nodes);
        let leaf = |n: &TileNode| match n {
            TileNode::Leaf(tile) => Some(*tile),
            TileNode::Split(_) => None,
        };
        let leaves: Vec<Tile> = nodes.iter().filter_map(leaf).collect();
        reference += leaves.chunks(256).map(frame_of_reference).sum::<u64>();
        w.tiles(Tick(i), whole, &nodes, &mut sink).unwrap();
    }
    let l = w.ledger();
    let n = l.tile_bits.leaves as f64;
    let bytes = l.bytes_of(Kind::Tiles) as f64 / n;
    println!(
        "tiles: {:.0} leaves a cut, {:.1} packets; {bytes:.2} bytes a leaf; bits: codes {:.1} tree {:.1}; \
         codes by frame of reference {:.1}",
        n / 20.0,
        l.packets_of(Kind::Tiles) as f64 / 20.0,
        l.tile_bits.codes as f64 / n,
        l.tile_bits.tree as f64 / n,
        reference as f64 / n
    );
    assert!(bytes <= 4.5, "{bytes:.2} bytes a leaf");
    assert!(
        l.tile_bits.codes < reference,
        "the simpler code would be shorter"
    );
}
