//! Pictures of each effect, off and on, and of where its samples went.

use std::path::Path;

use anyhow::{Context, Result};
use glam::{UVec2, Vec3};
use unframed_host::drive::Host;
use unframed_host::effects::framed::{Refinement, render};
use unframed_host::scene::builtin::builtin;
use unframed_host::scene::{Light, LightKind, MIRROR_ROUGHNESS, Material, Scene};
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{Rays, World, ideal};

use super::{codes, heat};
use crate::measure::IDEAL_GRID;
use crate::method::Method;
use crate::report::Picture;

/// Side of a picture, pixels.
const SIDE: u32 = 160;
/// The instant that is shown, seconds.
const SHOWN: f64 = 1.0;
/// Samples a second of the frameless host, and the refreshes over which they are counted: around
/// that instant.
const RATE: u32 = 400_000;
const COUNTED: std::ops::Range<u32> = 45..75;
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

/// An effect that is traced, not interleaved: what calls for it, and its rays if it has any.
struct Traced {
    name: &'static str,
    scene: &'static str,
    on: fn(&mut Scene),
    off: fn(&mut Scene),
    rays: Option<fn(&Rays) -> u32>,
}

const TRACED: [Traced; 4] = [
    Traced {
        name: "mirror",
        scene: "toycar",
        on: |_| {},
        off: |scene| {
            let smooth = |m: &&mut Material| m.roughness <= MIRROR_ROUGHNESS;
            let mirrors = scene.materials.iter_mut().filter(smooth);
            mirrors.for_each(|m| m.metallic = 0.0);
        },
        rays: Some(|rays| rays.bounce),
    },
    Traced {
        name: "refraction",
        scene: "cornell",
        on: |scene| {
            // Both blocks of glass.
            let glass = Material {
                name: "glass".into(),
                base_colour: Vec3::new(0.9, 0.97, 0.95).extend(1.0),
                transmission: 1.0,
                ior: 1.5,
                ..Material::default()
            };
            scene.materials.push(glass);
            let glass = scene.materials.len() - 1;
            for name in ["tall", "short"] {
                let block = scene.nodes.iter().find(|node| node.name == name);
                let mesh = block.and_then(|node| node.mesh);
                let parts = mesh.map_or(&mut [][..], |mesh| &mut scene.meshes[mesh].primitives);
                parts.iter_mut().for_each(|part| part.material = glass);
            }
        },
        off: |scene| {
            scene
                .materials
                .iter_mut()
                .for_each(|m| m.transmission = 0.0)
        },
        rays: Some(|rays| rays.refraction),
    },
    Traced {
        name: "depth_of_field",
        scene: "toycar",
        on: |scene| {
            let cameras = scene
                .nodes
                .iter_mut()
                .filter_map(|node| node.camera.as_mut());
            cameras.for_each(|lens| (lens.aperture, lens.focus) = (0.08, 4.0));
        },
        off: |scene| {
            let cameras = scene
                .nodes
                .iter_mut()
                .filter_map(|node| node.camera.as_mut());
            cameras.for_each(|lens| lens.aperture = 0.0);
        },
        rays: None,
    },
    Traced {
        name: "textures",
        scene: "interactive",
        on: |_| {},
        off: |scene| {
            for material in &mut scene.materials {
                (material.base_texture, material.procedural) = (None, None);
            }
        },
        rays: None,
    },
];

/// Writes `effect-NAME.png` for each effect: off, on, and where refinement went.
///
/// Of what is interleaved: samples a pixel of the frame and rays a sample of the frameless host (blue
/// is one or none, bright red nine or more). Of what is traced: samples a pixel of the frameless host
/// with the effect (white is four times the mean or more) and, if it has rays, rays a sample
/// (black is none, white three or more).
///
/// # Errors
/// A file cannot be written.
pub(super) fn strips(out: &Path) -> Result<()> {
    let write = |name: &str, parts: &[Vec<[u8; 3]>]| {
        let picture = beside(parts)?;
        anyhow::Ok(picture.write_png(&out.join(format!("effect-{name}.png")))?)
    };
    for subject in &SUBJECTS {
        let scene = builtin(subject.scene).context("a built-in scene")?;
        let mut without = scene.clone();
        (subject.off)(&mut without);
        let mut without = World::new(without, [SIDE; 2])?;
        let off = render(&mut without, SHOWN, Refinement::All);
        let mut world = World::new(scene, [SIDE; 2])?;
        let on = render(&mut world, SHOWN, Refinement::Adaptive);
        let layer = on.layers.iter().find(|layer| layer.name == subject.name);
        let layer = layer.context("a scene that calls for the effect")?;
        let times = SIDE / layer.width;
        let framed = (0..SIDE * SIDE).map(|i| {
            let (x, y) = (i % SIDE / times, i / SIDE / times);
            heat(layer.samples[(y * layer.width + x) as usize])
        });
        let counts = count(world, subject.rays)?;
        let parts = [
            codes(&off.light),
            codes(&on.light),
            framed.collect(),
            (counts.iter().map(|c| heat(c.rays_a_sample().round() as u8))).collect(),
        ];
        write(subject.name, &parts)?;
    }
    for subject in &TRACED {
        let mut with = builtin(subject.scene).context("a built-in scene")?;
        (subject.on)(&mut with);
        let mut without = with.clone();
        (subject.off)(&mut without);
        let mut world = World::new(with, [SIDE; 2])?;
        let off = ideal(&mut World::new(without, [SIDE; 2])?, SHOWN, IDEAL_GRID);
        let on = ideal(&mut world, SHOWN, IDEAL_GRID);
        let counts = count(world, subject.rays.unwrap_or(|_| 0))?;
        let mean = counts.iter().map(|c| c.samples).sum::<u32>() as f32 / counts.len() as f32;
        let share = |c: &Count| [(c.samples as f32 / mean * 64.0).min(255.0) as u8; 3];
        let mut parts = vec![off, on, counts.iter().map(share).collect()];
        if subject.rays.is_some() {
            let rays = |c: &Count| [(85.0 * c.rays_a_sample()).min(255.0) as u8; 3];
            parts.push(counts.iter().map(rays).collect());
        }
        write(subject.name, &parts)?;
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

/// What the frameless host spent on a pixel.
#[derive(Clone, Copy, Default)]
struct Count {
    /// Rays of the effect.
    rays: u32,
    samples: u32,
}

impl Count {
    fn rays_a_sample(&self) -> f32 {
        self.rays as f32 / self.samples.max(1) as f32
    }
}

/// Pixel by pixel, with the rays of an effect.
fn count(world: World, of: fn(&Rays) -> u32) -> Result<Vec<Count>> {
    let promise = Promise {
        layout: Method::Adaptive.layout(),
        lamps: true,
        tile_fields: Method::Adaptive.tile_fields(),
        rate: RATE,
        refresh_millihertz: 60_000,
    };
    let mut host = Host::new(
        world,
        Method::Adaptive.sampler(UVec2::splat(SIDE), 1),
        promise,
    );
    let mut counts = vec![Count::default(); (SIDE * SIDE) as usize];
    let mut bytes = Vec::new();
    for index in 0..COUNTED.end {
        bytes.clear();
        host.advance(&mut bytes)?;
        for shot in host.shots().iter().filter(|_| COUNTED.contains(&index)) {
            let at = shot.pixel.as_uvec2();
            let count = &mut counts[(at.y * SIDE + at.x) as usize];
            count.rays += of(&shot.hit.rays);
            count.samples += 1;
        }
    }
    Ok(counts)
}
