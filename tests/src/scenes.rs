//! Streams of the built-in scenes, recorded by a real host.

use glam::UVec2;
use unframed_host::drive::Host;
use unframed_host::sampler::adaptive::{Adaptive, Config};
use unframed_host::scene::builtin::{BUILTIN, builtin};
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{World, ideal};
use unframed_wire::{Layout, TileFields};

/// The panel of the boards.
pub const SIZE: (u16, u16) = (64, 64);
/// Samples a second, and samples remembered: 6.1 a pixel, as 400,000 are at 256 × 256.
pub const RATE: u32 = 25_000;

/// Refreshes of a [`recorded`] stream.
pub const REFRESHES: u32 = 6;

/// Names and streams of three built-in scenes at eight times the rate, so that the boards' memory
/// is full in a tenth of a second.
pub fn recorded() -> impl Iterator<Item = (&'static str, Vec<u8>)> {
    let scenes = BUILTIN.iter().take(3);
    scenes.map(|scene| (*scene, record(scene, 8 * RATE, REFRESHES)))
}

/// The first `refreshes` refreshes of a built-in scene at 60 Hz.
///
/// # Panics
/// When the scene is unknown or the host fails.
#[must_use]
pub fn record(scene: &str, rate: u32, refreshes: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut host = host(scene, rate);
    for _ in 0..refreshes {
        host.advance(&mut bytes).expect("a sound stream");
    }
    host.end(&mut bytes).expect("a sound stream");
    bytes
}

/// What those refreshes should show: 16 rays a pixel.
///
/// # Panics
/// When the scene is unknown.
#[must_use]
pub fn ideals(scene: &str, refreshes: u32) -> Vec<Vec<[u8; 3]>> {
    let host = host(scene, RATE);
    let mut world = host.world().clone();
    let instants = (0..refreshes).map(|index| host.instant(index));
    instants.map(|t| ideal(&mut world, t, 4)).collect()
}

fn host(scene: &str, rate: u32) -> Host {
    let size = UVec2::new(SIZE.0.into(), SIZE.1.into());
    let world = World::new(builtin(scene).expect("a built-in scene"), size.into());
    let promise = Promise {
        layout: Layout::World,
        lamps: true,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        rate,
        refresh_millihertz: 60_000,
    };
    let sampler = Adaptive::new(size, Config::default());
    Host::new(world.expect("a sound scene"), Box::new(sampler), promise)
}
