//! Streams of the built-in scenes, recorded by a real host.

use glam::UVec2;
use unframed_host::drive::Host;
use unframed_host::sampler::adaptive::{Adaptive, Config};
use unframed_host::scene::builtin::builtin;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::World;
use unframed_wire::{Layout, TileFields};

/// The panel of the boards.
pub const SIZE: (u16, u16) = (64, 64);
/// Samples a second, and samples remembered: 6.1 a pixel, as 400,000 are at 256 × 256.
pub const RATE: u32 = 25_000;

/// The first `refreshes` refreshes of a built-in scene at 60 Hz.
///
/// # Panics
/// When the scene is unknown or the host fails.
#[must_use]
pub fn record(scene: &str, rate: u32, refreshes: u32) -> Vec<u8> {
    let size = UVec2::new(SIZE.0.into(), SIZE.1.into());
    let world = World::new(builtin(scene).expect("a built-in scene"), size.into());
    let promise = Promise {
        layout: Layout::World,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        rate,
        refresh_millihertz: 60_000,
    };
    let sampler = Adaptive::new(size, Config::default());
    let mut host = Host::new(world.expect("a sound scene"), Box::new(sampler), promise);
    let mut bytes = Vec::new();
    for _ in 0..refreshes {
        host.advance(&mut bytes).expect("a sound stream");
    }
    host.end(&mut bytes).expect("a sound stream");
    bytes
}
