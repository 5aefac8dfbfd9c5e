//! What is not called for costs nothing: no ray, and not a byte that differs.

use glam::{UVec2, Vec3};

use super::{MIST, SIZE, image, plain};
use crate::drive::Host;
use crate::sampler::adaptive::{Adaptive, Config};
use crate::scene::calls;
use crate::scene::model::{Light, LightKind, Node, Scene};
use crate::stream::sender::Promise;
use crate::trace::{Rays, World};
use unframed_wire::{Layout, TileFields};

/// An effect, and what makes a scene call for it.
type Cause = (&'static str, fn(&mut Scene));

/// All effects that cost rays.
const CAUSES: [Cause; 6] = [
    ("hard_shadows", |s| {
        s.nodes.push(Node {
            translation: Vec3::new(0.3, 1.7, 0.2),
            light: Some(Light {
                kind: LightKind::Point,
                intensity: Vec3::ONE,
                range: f32::INFINITY,
            }),
            ..Node::default()
        });
    }),
    ("soft_shadows", |s| {
        s.materials[3].emissive = Vec3::splat(10.0)
    }),
    ("mirror", |s| {
        (s.materials[1].metallic, s.materials[1].roughness) = (1.0, 0.0);
    }),
    ("refraction", |s| s.materials[2].transmission = 1.0),
    ("medium", |s| s.medium = Some(MIST)),
    ("indirect_diffuse", |s| s.indirect = true),
];

#[test]
fn the_ledger_is_zero_for_what_is_not_called_for() {
    for mask in 0u32..64 {
        let mut scene = plain();
        for (i, (_, cause)) in CAUSES.iter().enumerate() {
            if mask & 1 << i != 0 {
                cause(&mut scene);
            }
        }
        let called = calls::effects(&scene);
        let lit = mask & 3 != 0;
        let (rays, _) = image(scene);
        assert_eq!(rays.primary, SIZE[0] * SIZE[1]);
        for (i, (name, count)) in rays.by_effect().into_iter().enumerate() {
            assert_eq!(name, CAUSES[i].0);
            let call = called.iter().find(|e| e.name == name).expect("an effect");
            assert_eq!(call.called_for, mask & 1 << i != 0, "{name} in {mask:b}");
            // Without a lamp, neither a medium nor a wall throws anything on.
            let expected = call.called_for && (lit || i < 4);
            assert_eq!(count > 0, expected, "{name} in {mask:b}: {count} rays");
        }
    }
}

/// How an author takes the causes away again, in the order of [`CAUSES`]: what carried them stays.
const REMOVALS: [fn(&mut Scene); 6] = [
    |s| {
        s.nodes.iter_mut().for_each(|n| n.light = None);
    },
    |s| s.materials[3].emissive = Vec3::ZERO,
    |s| {
        let plain = plain().materials.swap_remove(1);
        (s.materials[1].metallic, s.materials[1].roughness) = (plain.metallic, plain.roughness);
    },
    |s| s.materials[2].transmission = 0.0,
    |s| {
        // Still there, but of nothing.
        let medium = s.medium.as_mut().expect("put there before");
        (medium.sigma_s, medium.sigma_a) = (0.0, 0.0);
    },
    |s| s.indirect = false,
];

/// The bytes of a short stream, and the rays that it cost.
fn recorded(scene: Scene) -> (Vec<u8>, Rays) {
    let world = World::new(scene, SIZE).expect("a sound scene");
    let sampler = Adaptive::new(UVec2::from(SIZE), Config::default());
    let promise = Promise {
        layout: Layout::World,
        lamps: true,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        rate: 60_000,
        refresh_millihertz: 60_000,
    };
    let mut host = Host::new(world, Box::new(sampler), promise);
    let (mut bytes, mut rays) = (Vec::new(), Rays::default());
    for _ in 0..3 {
        rays += host.advance(&mut bytes).expect("a sound stream").rays;
    }
    host.end(&mut bytes).expect("a sound stream");
    (bytes, rays)
}

#[test]
fn a_cause_that_is_taken_away_leaves_no_byte_behind() {
    let with = |mask: u32| {
        let mut scene = plain();
        for (i, (_, cause)) in CAUSES.iter().enumerate() {
            if mask & 1 << i != 0 {
                cause(&mut scene);
            }
        }
        scene
    };
    let (none, all) = (recorded(with(0)), recorded(with(63)));
    for (i, removal) in REMOVALS.iter().enumerate() {
        let name = CAUSES[i].0;
        // Alone, and among all others; without a lamp a medium and indirect light do nothing.
        let lamp = if i < 4 { 0 } else { 2 };
        for (mask, without) in [(lamp | 1 << i, lamp), (63, 63 & !(1 << i))] {
            let before = match without {
                0 => none.clone(),
                without => recorded(with(without)),
            };
            let mut scene = with(mask);
            let after = match mask {
                63 => all.clone(),
                _ => recorded(scene.clone()),
            };
            assert!(after.0 != before.0, "{name} in {mask:b} changes the stream");
            removal(&mut scene);
            let same = recorded(scene) == before;
            assert!(same, "{name} taken away from {mask:b} leaves a trace");
        }
    }
}
