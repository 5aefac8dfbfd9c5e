//! A stream from a real host, decoded by code written from `docs/STREAM.md` alone and shown by
//! every display: the same samples, the same bits.

mod independent;

use glam::UVec2;
use independent::{Decoded, decode};
use unframed_host::drive::Host;
use unframed_host::sampler::adaptive::{Adaptive, Config as Knobs};
use unframed_host::scene::builtin::{ANIMATIONS, BUILTIN, builtin};
use unframed_host::stream::sender::Promise;
use unframed_host::trace::World;
use unframed_recon::heap::HeapStorage;
use unframed_recon::{Config, Display, Fixed, Player, frame_hash};
use unframed_sim::gpu::Gpu;
use unframed_sim::twin::GpuPlayer;
use unframed_wire::{Layout, Packet, Receiver, TileFields};

const SIZE: UVec2 = UVec2::new(80, 60);
const REFRESHES: u32 = 6;

/// A short stream of a built-in scene.
fn stream(scene: &str) -> Vec<u8> {
    let scene = builtin(scene).expect("a built-in scene");
    let world = World::new(scene, SIZE.into()).expect("a sound scene");
    let knobs = Knobs {
        seed: 5,
        ..Knobs::default()
    };
    let promise = Promise {
        layout: Layout::World,
        lamps: true,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        rate: 40_000,
        refresh_millihertz: 60_000,
    };
    let mut host = Host::new(world, Box::new(Adaptive::new(SIZE, knobs)), promise);
    let mut bytes = Vec::new();
    for _ in 0..REFRESHES {
        host.advance(&mut bytes).expect("a sound stream");
    }
    host.end(&mut bytes).expect("a sound stream");
    bytes
}

/// What our own receiver finds: time, place, colour, object of each sample, in order.
fn received(bytes: &[u8]) -> Vec<(u32, [i16; 3], [u8; 3], u8)> {
    let mut receiver = Receiver::new();
    let mut input = bytes;
    let mut samples = Vec::new();
    while let Some(packet) = receiver.push(&mut input) {
        if let Packet::World(packed) = packet {
            let time = packed.time().0;
            samples.extend(packed.map(|s| (time, s.place, s.rgb, s.object)));
        }
    }
    samples
}

fn decoded(stream: &Decoded) -> Vec<(u32, [i16; 3], [u8; 3], u8)> {
    stream
        .samples
        .iter()
        .map(|s| (s.time, s.place.map(|v| v as i16), s.rgb, s.object))
        .collect()
}

#[test]
fn an_independent_decoder_gets_the_same_samples() {
    for scene in BUILTIN {
        let bytes = stream(scene);
        let independent = decode(&bytes);
        let ours = received(&bytes);
        assert_eq!(ours.len(), 4000, "{scene}");
        assert!(
            decoded(&independent) == ours,
            "{scene}: the decoders disagree"
        );
        assert_eq!(independent.refreshes.len(), REFRESHES as usize);
        assert_eq!((independent.lost, independent.damaged), (0, 0));
        assert_eq!(independent.end.map(|end| end.1), Some(4000));
    }
}

#[test]
fn a_flipped_bit_makes_the_decoders_miss_the_same_packet() {
    let whole = stream("toycar");
    let mut fewest = usize::MAX;
    for part in 1..8 {
        let mut bytes = whole.clone();
        bytes[whole.len() * part / 8] ^= 4;
        let independent = decode(&bytes);
        assert_eq!(independent.damaged, 1);
        let ours = received(&bytes);
        assert!(decoded(&independent) == ours);
        fewest = fewest.min(ours.len());
    }
    assert!(fewest < 4000, "no flip hit a packet of samples");
}

#[test]
fn the_twin_shows_the_bits_of_the_firmware() {
    let gpu = match Gpu::new() {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(
                std::env::var_os("CI").is_none(),
                "no adapter in CI: {error}"
            );
            eprintln!("left out: the shader twin against the firmware ({error})");
            return;
        }
    };
    let (width, height) = (SIZE.x as u16, SIZE.y as u16);
    for scene in ANIMATIONS {
        let bytes = stream(scene);
        let mut storage = HeapStorage::<Fixed>::new(width, height, 3000);
        let display =
            Display::new(Config::ADAPTIVE, width, height, storage.memory()).expect("it fits");
        let mut cpu = Player::new(display);
        let mut twin =
            GpuPlayer::new(&gpu, Config::ADAPTIVE, width, height, 3000).expect("it fits");
        let (mut a, mut b) = (&bytes[..], &bytes[..]);
        let mut hashes = Vec::new();
        while let Some(refresh) = cpu.push(&mut a) {
            assert_eq!(twin.push(&mut b).expect("the adapter works"), Some(refresh));
            let hash = frame_hash(cpu.display().picture());
            assert_eq!(
                hash,
                frame_hash(twin.picture()),
                "{scene} at refresh {}",
                refresh.index
            );
            hashes.push(hash);
        }
        hashes.dedup();
        assert_eq!(
            hashes.len(),
            REFRESHES as usize,
            "{scene}: the picture stands still"
        );
    }
}
