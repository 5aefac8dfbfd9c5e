//! Each effect against the path tracer as samples grow: a slope of −1/2 in a double logarithm.

use glam::{Vec2, Vec3};

use crate::effects::care::Care;
use crate::effects::framed::indirect_alone;
use crate::effects::reference::reference;
use crate::scene::builtin::builtin;
use crate::scene::model::Scene;
use crate::trace::World;

/// Side of the pictures, pixels.
const SIDE: u32 = 16;
/// Paths a pixel of the reference: a fifth of the error of the most samples that are tested.
const PATHS: u32 = 25 * STEPS[2];
/// Samples a pixel.
const STEPS: [u32; 3] = [4, 32, 256];

fn world(scene: &Scene) -> World {
    World::new(scene.clone(), [SIDE; 2]).expect("a sound scene")
}

/// Root of the mean squared difference, relative to the truth and its mean: else the few pixels
/// around a lamp would be all that counts.
fn error(found: &[Vec3], truth: &[Vec3]) -> f32 {
    let mean = truth.iter().sum::<Vec3>() / truth.len() as f32;
    let apart = |(a, b): (&Vec3, &Vec3)| ((*a - *b) / (*b + mean)).length_squared();
    let squares: f32 = found.iter().zip(truth).map(apart).sum();
    (squares / (3 * truth.len()) as f32).sqrt()
}

/// Between the first and the last of [`STEPS`].
fn slope(errors: [f32; 3]) -> f32 {
    (errors[2] / errors[0]).log2() / (STEPS[2] as f32 / STEPS[0] as f32).log2()
}

/// Errors of frameless samples through pixel middles.
fn looks(scene: &Scene, care: Care, truth: &[Vec3]) -> [f32; 3] {
    let world = world(scene);
    let moment = world.moment(0.0);
    STEPS.map(|n| {
        let found: Vec<Vec3> = (0..SIDE * SIDE)
            .map(|i| {
                let pixel = Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5;
                let one = |k| moment.look_unclamped(pixel, i << 16 | k, care).0.colour;
                (0..n).map(one).sum::<Vec3>() / n as f32
            })
            .collect();
        error(&found, truth)
    })
}

/// What is done to a built-in scene.
type Change = fn(&mut Scene);

fn through_a_lens(scene: &mut Scene) {
    let lens = scene.nodes.iter_mut().find_map(|node| node.camera.as_mut());
    let lens = lens.expect("a camera");
    (lens.aperture, lens.focus) = (0.08, 4.0);
}

/// White walls reflect half, the green one is of glass.
fn of_mirrors_and_glass(scene: &mut Scene) {
    (scene.materials[0].metallic, scene.materials[0].roughness) = (0.5, 0.0);
    scene.materials[2].transmission = 0.8;
}

#[test]
fn samples_converge_to_the_path_tracer() {
    let random = Care::default();
    let sequence = Care {
        pattern: true,
        ..random
    };
    // Lamps, a medium around a lamp, shafts of light, a lens, a mirror and glass; without indirect
    // light, whose virtual lights are as many as there are. Places on a lens are always random.
    let subjects: [(&str, Change, bool); 5] = [
        ("forest", |_| {}, true),
        ("cornell-mist", |_| {}, true),
        ("slats", |_| {}, true),
        ("toycar", through_a_lens, false),
        ("cornell", of_mirrors_and_glass, true),
    ];
    for (name, change, has_sequence) in subjects {
        let mut scene = builtin(name).expect("built in");
        scene.indirect = false;
        change(&mut scene);
        let truth = reference(&mut world(&scene), 0.0, PATHS);
        let errors = looks(&scene, random, &truth);
        let found = slope(errors);
        assert!(
            (found + 0.5).abs() < 0.1,
            "{name}: {errors:?}, slope {found}"
        );
        if has_sequence {
            let errors = looks(&scene, sequence, &truth);
            let found = slope(errors);
            // What is left of a sequence at last is the reference's own noise.
            assert!(found < -0.45, "{name}, sequence: {errors:?}, slope {found}");
        }
    }
}

#[test]
fn virtual_lights_converge_to_the_path_tracer_with_what_they_leave_out() {
    let scene = builtin("cornell").expect("built in");
    let mut without = scene.clone();
    without.indirect = false;
    without.sky.ambient = Vec3::ZERO;
    let [all, direct] = [&scene, &without].map(|scene| reference(&mut world(scene), 0.0, PATHS));
    let truth: Vec<Vec3> = all.iter().zip(&direct).map(|(a, b)| *a - *b).collect();
    let mut world = world(&scene);
    let mut errors = |corrected: bool| {
        STEPS.map(|n| {
            let corrections = if corrected { n } else { 0 };
            error(
                &indirect_alone(&mut world, 0.0, 16 * n as usize, corrections),
                &truth,
            )
        })
    };
    let corrected = errors(true);
    let found = slope(corrected);
    assert!((found + 0.5).abs() < 0.15, "{corrected:?}, slope {found}");
    // Without, corners stay dark however many lights there are.
    let dark = errors(false);
    assert!(slope(dark) > -0.2, "{dark:?}");
    assert!(dark[2] > 2.0 * corrected[2], "{dark:?} {corrected:?}");
}
