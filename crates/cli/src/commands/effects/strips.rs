//! Pictures of each effect, off and on, and of where its samples went.

use std::path::Path;

use anyhow::{Context, Result};
use glam::{UVec2, Vec3};
use unframed_host::drive::Host;
use unframed_host::effects::framed::{Refinement, render};
use unframed_host::scene::builtin::builtin;
use unframed_host::scene::{Light, LightKind, Scene};
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{Rays, World};

use super::{codes, heat};
use crate::method::Method;
use crate::report::Picture;

/// Side of a picture, pixels.
const SIDE: u32 = 160;
/// Samples a second of the frameless host, and how long it runs.
const RATE: u32 = 400_000;
const REFRESHES: u32 = 45;
/// White between pictures, pixels.
const GAP: usize = 4;

/// An effect, a scene that calls for it, and the scene without.
struct Subject {
    name: &'static str,
    scene: &'static str,
    off: fn(&mut Scene),
    rays: fn(&Rays) -> u32,
}

const SUBJECTS: [Subject; 3] = [
    Subject {
        name: "soft_shadows",
        scene: "forest",
        // The lamp's light from one point.
        off: |scene| {
            for material in &mut scene.materials {
                material.emissive = Vec3::ZERO;
            }
            let mut node = unframed_host::scene::Node {
                translation: Vec3::new(-0.5, 3.2, -2.1),
                ..Default::default()
            };
            node.light = Some(Light {
                kind: LightKind::Point,
                intensity: Vec3::new(38.0, 34.0, 28.0),
                range: f32::INFINITY,
            });
            scene.nodes.push(node);
        },
        rays: |rays| rays.soft,
    },
    Subject {
        name: "indirect_diffuse",
        scene: "cornell",
        off: |scene| scene.indirect = false,
        rays: |rays| rays.indirect,
    },
    Subject {
        name: "medium",
        scene: "slats",
        off: |scene| scene.medium = None,
        rays: |rays| rays.medium,
    },
];

/// Writes `effect-NAME.png`: off, on, samples a pixel of the frame (blue is one, bright red
/// nine), rays a sample of the frameless host.
///
/// # Errors
/// A file cannot be written.
pub(super) fn strips(out: &Path) -> Result<()> {
    for subject in &SUBJECTS {
        let scene = builtin(subject.scene).context("a built-in scene")?;
        let mut without = scene.clone();
        (subject.off)(&mut without);
        let off = render(&mut World::new(without, [SIDE; 2])?, 1.0, Refinement::All);
        let mut world = World::new(scene, [SIDE; 2])?;
        let on = render(&mut world, 1.0, Refinement::Adaptive);
        let layer = on.layers.iter().find(|layer| layer.name == subject.name);
        let layer = layer.context("a scene that calls for the effect")?;
        let times = SIDE / layer.width;
        let framed = (0..SIDE * SIDE).map(|i| {
            let (x, y) = (i % SIDE / times, i / SIDE / times);
            heat(layer.samples[(y * layer.width + x) as usize])
        });
        let frameless = rays_a_sample(world, subject.rays)?;
        let parts = [
            codes(&off.light),
            codes(&on.light),
            framed.collect(),
            frameless,
        ];
        let picture = beside(&parts)?;
        picture.write_png(&out.join(format!("effect-{}.png", subject.name)))?;
    }
    Ok(())
}

/// Pictures in a row.
fn beside(parts: &[Vec<[u8; 3]>]) -> Result<Picture> {
    let side = SIDE as usize;
    let width = parts.len() * (side + GAP) - GAP;
    let mut pixels = vec![[255; 3]; width * side];
    for (k, part) in parts.iter().enumerate() {
        for (row, line) in part.chunks_exact(side).zip(pixels.chunks_exact_mut(width)) {
            line[k * (side + GAP)..][..side].copy_from_slice(row);
        }
    }
    Ok(Picture::new(width, side, pixels)?)
}

/// How many rays each pixel's samples gave to an effect, of the last third of a run.
fn rays_a_sample(world: World, of: fn(&Rays) -> u32) -> Result<Vec<[u8; 3]>> {
    let promise = Promise {
        layout: Method::Adaptive.layout(),
        tile_fields: Method::Adaptive.tile_fields(),
        rate: RATE,
        refresh_millihertz: 60_000,
    };
    let mut host = Host::new(
        world,
        Method::Adaptive.sampler(UVec2::splat(SIDE), 1),
        promise,
    );
    let mut sums = vec![(0u32, 0u32); (SIDE * SIDE) as usize];
    let mut bytes = Vec::new();
    for index in 0..REFRESHES {
        bytes.clear();
        host.advance(&mut bytes)?;
        for shot in host.shots().iter().filter(|_| 3 * index >= 2 * REFRESHES) {
            let at = shot.pixel.as_uvec2();
            let sum = &mut sums[(at.y * SIDE + at.x) as usize];
            *sum = (sum.0 + of(&shot.hit.rays), sum.1 + 1);
        }
    }
    let shade = |(rays, samples): &(u32, u32)| match samples {
        0 => [0; 3],
        samples => heat((*rays as f32 / *samples as f32).round() as u8),
    };
    Ok(sums.iter().map(shade).collect())
}
