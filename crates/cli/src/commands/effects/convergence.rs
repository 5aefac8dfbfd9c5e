//! Whether effects converge to the path tracer as samples grow, and how fast.

use std::path::Path;

use anyhow::{Context, Result};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use unframed_host::effects::care::Care;
use unframed_host::effects::framed::indirect_alone;
use unframed_host::effects::reference::reference;
use unframed_host::scene::Scene;
use unframed_host::scene::builtin::builtin;
use unframed_host::trace::World;

use crate::report::{Axis, Plot, Scale};

/// Side of the pictures, pixels.
const SIDE: u32 = 24;
/// Paths a pixel of the reference: its own error lies below all that is plotted.
const PATHS: u32 = 40_000;
/// Samples a pixel, or paths from the lamps.
const STEPS: [u32; 6] = [1, 4, 16, 64, 256, 1024];
/// Paths of virtual lights for each estimate of what they leave out near by.
const PATHS_A_CORRECTION: u32 = 16;

/// An effect of single samples, in a scene without indirect light.
struct Subject {
    name: &'static str,
    scene: &'static str,
    change: fn(&mut Scene),
    /// Whether its points can come from a sequence.
    sequence: bool,
}

const SUBJECTS: [Subject; 4] = [
    Subject {
        name: "soft shadows",
        scene: "forest",
        change: |_| {},
        sequence: true,
    },
    Subject {
        name: "medium",
        scene: "cornell-mist",
        change: |_| {},
        sequence: true,
    },
    Subject {
        name: "depth of field",
        scene: "toycar",
        change: |scene| {
            let cameras = scene.nodes.iter_mut().filter_map(|n| n.camera.as_mut());
            cameras.for_each(|lens| (lens.aperture, lens.focus) = (0.08, 4.0));
        },
        sequence: false,
    },
    Subject {
        name: "soft shadows in mirrors and glass",
        scene: "cornell",
        // White walls reflect half, the green one is of glass.
        change: |scene| {
            (scene.materials[0].metallic, scene.materials[0].roughness) = (0.5, 0.0);
            scene.materials[2].transmission = 0.8;
        },
        sequence: true,
    },
];

/// Errors by number of samples.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
}

impl Curve {
    /// The slope of a straight line through all points, in a double logarithm.
    fn slope(&self) -> f64 {
        let logs = self.points.iter().map(|(n, e)| (n.ln(), e.ln()));
        let n = self.points.len() as f64;
        let (sx, sy) = logs.clone().fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
        let (mx, my) = (sx / n, sy / n);
        let (xy, xx) = logs.fold((0.0, 0.0), |s, (x, y)| {
            (s.0 + (x - mx) * (y - my), s.1 + (x - mx).powi(2))
        });
        xy / xx
    }
}

/// Measures, writes `convergence.svg` and gives the slopes.
///
/// # Errors
/// A file cannot be written.
pub(super) fn convergence(out: &Path) -> Result<Value> {
    let mut curves = Vec::new();
    for subject in SUBJECTS {
        let mut scene = builtin(subject.scene).context("a built-in scene")?;
        scene.indirect = false;
        (subject.change)(&mut scene);
        let truth = reference(&mut world(&scene)?, 0.0, PATHS);
        for (points, pattern) in [("random", false), ("sequence", true)] {
            if pattern && !subject.sequence {
                continue;
            }
            let name = format!("{}, {points}", subject.name);
            curves.push(looks(name, &scene, &truth, pattern)?);
        }
    }
    curves.extend(lights()?);
    let mut plot = Plot::new(
        "Error against the path tracer",
        Axis::new("samples a pixel, or paths from the lamps", Scale::Log),
        Axis::new("relative RMSE", Scale::Log),
    );
    let mut slopes = serde_json::Map::new();
    for curve in curves {
        let slope = curve.slope();
        println!("{}: slope {slope:.2}", curve.name);
        slopes.insert(
            curve.name.clone(),
            json!({"slope": slope, "points": curve.points}),
        );
        plot = plot.line(format!("{} ({slope:.2})", curve.name), curve.points);
    }
    let path = out.join("convergence.svg");
    std::fs::write(&path, plot.svg()?)
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Value::Object(slopes))
}

fn world(scene: &Scene) -> Result<World> {
    Ok(World::new(scene.clone(), [SIDE; 2])?)
}

/// Frameless samples through pixel middles.
fn looks(name: String, scene: &Scene, truth: &[Vec3], pattern: bool) -> Result<Curve> {
    let world = world(scene)?;
    let moment = world.moment(0.0);
    let care = Care {
        pattern,
        ..Care::default()
    };
    let points = STEPS.map(|n| {
        let found: Vec<Vec3> = (0..SIDE * SIDE)
            .map(|i| {
                let pixel = Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5;
                let sum: Vec3 = (0..n)
                    // Each pixel has a sequence of its own.
                    .map(|k| moment.look_unclamped(pixel, i << 16 | k, care).0.colour)
                    .sum();
                sum / n as f32
            })
            .collect();
        (f64::from(n), error(&found, truth))
    });
    Ok(Curve {
        name,
        points: points.to_vec(),
    })
}

/// Indirect light by ever more virtual lights, with and without what these leave out near by.
fn lights() -> Result<Vec<Curve>> {
    let scene = builtin("cornell").context("a built-in scene")?;
    let mut without = scene.clone();
    without.indirect = false;
    without.sky.ambient = Vec3::ZERO;
    let [with, without] = [
        reference(&mut world(&scene)?, 0.0, PATHS),
        reference(&mut world(&without)?, 0.0, PATHS),
    ];
    let truth: Vec<Vec3> = with.iter().zip(&without).map(|(a, b)| *a - *b).collect();
    let mut world = world(&scene)?;
    let curves = [("corrected", true), ("lights alone", false)].map(|(name, corrected)| Curve {
        name: format!("indirect diffuse, {name}"),
        points: STEPS
            .map(|n| {
                let paths = PATHS_A_CORRECTION * n;
                let corrections = if corrected { n } else { 0 };
                let found = indirect_alone(&mut world, 0.0, paths as usize, corrections);
                (f64::from(paths), error(&found, &truth))
            })
            .to_vec(),
    });
    Ok(curves.into())
}

/// Root of the mean squared difference, relative to the truth and its mean: else the few pixels
/// around a lamp would be all that counts.
fn error(found: &[Vec3], truth: &[Vec3]) -> f64 {
    let mean = truth.iter().sum::<Vec3>() / truth.len() as f32;
    let apart = |(a, b): (&Vec3, &Vec3)| ((*a - *b) / (*b + mean)).length_squared();
    let squares: f32 = found.iter().zip(truth).map(apart).sum();
    (f64::from(squares) / (3 * truth.len()) as f64).sqrt()
}
