//! Any bytes into the receiver and the recording tools, twice: as they are, and as payloads of
//! packets with a good CRC, so that the fuzzer reaches what lies behind it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use unframed_wire::{
    ColourEncoding, Hello, LAMPS, Layout, MAX_PACKET, Packet, Receiver, SKY, TileFields, WorldFrame,
    WorldSample, Writer, frame, recording,
};

fn drain(receiver: &mut Receiver, mut input: &[u8]) {
    let before = receiver.counters().bytes;
    let mut lamps = receiver.hello().map_or(0, |h| h.lamps);
    let len = input.len() as u64;
    while let Some(packet) = receiver.push(&mut input) {
        match packet {
            Packet::Hello(hello) => lamps = hello.lamps,
            Packet::World(samples) => {
                let told = |s: &WorldSample| u32::from(s.shares.0) >> (4 * lamps) == 0;
                assert!(samples.inspect(|s| assert!(told(s))).count() <= 256);
            }
            Packet::Screen(samples) => {
                samples.for_each(|s| assert!(s.x < 16 * 64 && s.y < 16 * 48));
            }
            Packet::Tiles(tiles) => tiles.for_each(|t| {
                assert!(t.rect.w > 0 && t.rect.x + t.rect.w <= 64);
                assert!(t.rect.h > 0 && t.rect.y + t.rect.h <= 48);
            }),
            Packet::Poses(poses) => poses.for_each(|p| assert!(p.frac_bits <= 31)),
            Packet::Lamps(found) => {
                assert_eq!(found.inspect(|l| assert!(l.is_valid())).count(), usize::from(lamps));
            }
            Packet::Shape(shape) => {
                assert!((1..SKY).contains(&shape.object()));
                assert!(u16::from(shape.part()) < shape.parts());
                let triangles = shape.len();
                assert_eq!(shape.count(), triangles);
            }
            _ => {}
        }
    }
    assert_eq!(receiver.counters().bytes, before + len);
}

/// COBS, plainly: every block ends before its zero or after 254 bytes.
fn framed(kind: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut packet = vec![kind];
    packet.extend(sequence.to_le_bytes());
    packet.extend(payload.iter().take(MAX_PACKET - 7));
    packet.extend(frame::checksum(&packet).to_le_bytes());
    let mut out = Vec::new();
    for block in packet.split(|&b| b == 0) {
        let mut rest = block;
        while rest.len() >= 254 {
            out.push(255);
            out.extend(&rest[..254]);
            rest = &rest[254..];
        }
        out.push(rest.len() as u8 + 1);
        out.extend(rest);
    }
    out.push(0);
    out
}

fuzz_target!(|data: &[u8]| {
    drain(&mut Receiver::new(), data);
    let _ = recording::Summary::of(data);
    let mut repaired = data.to_vec();
    recording::repair(&mut repaired);
    assert!(recording::read_index(&repaired).is_some());

    let Some((&choice, payload)) = data.split_first() else { return };
    let layout = if choice & 0x80 == 0 { Layout::World } else { Layout::Screen };
    let hello = Hello {
        width: 64,
        height: 48,
        layout,
        objects: layout == Layout::World,
        tile_fields: TileFields { gradients: true, lifetime: true, density: true },
        encoding: ColourEncoding::Srgb8,
        rate: 1,
        refresh_millihertz: 1,
        world: WorldFrame { origin: [0.0; 3], unit: 1.0 },
        lamps: if layout == Layout::World { (choice >> 4) % (LAMPS as u8 + 1) } else { 0 },
    };
    let mut receiver = Receiver::new();
    let mut bytes = Vec::new();
    let written = Writer::new().hello(&hello, &mut |frame| bytes.extend_from_slice(frame));
    assert_eq!(written, Ok(()));
    bytes.extend(framed(choice & 15, 1, payload));
    drain(&mut receiver, &bytes);
    let counters = receiver.counters();
    assert_eq!(counters.received + counters.damaged + counters.unknown, 2);
});
