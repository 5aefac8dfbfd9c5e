//! Framed renderers against the ideal renderer.

use glam::{UVec2, Vec2};
use unframed_wire::SKY;

use super::taau::carry_for_tests;
use super::{Framed, Frames, Taau, Tuning, Upscale, resolution};
use crate::scene::builtin::builtin;
use crate::scene::model::Scene;
use crate::trace::{World, ideal};

const SIZE: [u32; 2] = [64, 48];

fn world(scene: Scene) -> World {
    World::new(scene, SIZE).unwrap()
}

fn moving(name: &str) -> World {
    world(builtin(name).unwrap())
}

/// The scene as it is at time 0.
fn still(name: &str) -> World {
    let mut scene = builtin(name).unwrap();
    scene.channels.clear();
    world(scene)
}

fn rmse(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let square = |(a, b): (&u8, &u8)| (f64::from(*a) - f64::from(*b)).powi(2);
    let sum: f64 = a
        .as_flattened()
        .iter()
        .zip(b.as_flattened())
        .map(square)
        .sum();
    (sum / (3 * a.len()) as f64).sqrt()
}

#[test]
fn a_frame_of_a_still_scene_is_the_ideal_image_at_pixel_centres() {
    let mut world = still("toycar");
    let centres = ideal(&mut world, 0.0, 1);
    assert!(
        rmse(&centres, &ideal(&mut world, 0.0, 4)) > 1.0,
        "there is something to see"
    );
    let mut frames = [
        Frames::every_refresh(world.clone(), true),
        Frames::every_refresh(world.clone(), false),
        Frames::full_resolution(world.clone(), 64 * 48 * 7),
        Frames::low_resolution(world.clone(), 64 * 48 * 60, Upscale::Linear),
    ];
    for frames in &mut frames {
        for time in [1.0 / 60.0, 0.5] {
            frames.show(time);
            assert!(frames.picture() == centres, "at {time}");
        }
    }
    let mut coarse = Frames::low_resolution(world, 64 * 48 * 15, Upscale::Linear);
    coarse.show(0.5);
    assert!(coarse.picture() != centres);
}

#[test]
fn what_is_shown_is_exactly_as_old_as_stated() {
    // 10 frames a second: not a divisor of the refreshes' 60 in every phase.
    let rate = 64 * 48 * 25 / 2;
    let interval = 2.0 / 25.0;
    let mut twin = moving("interactive");
    let mut full = Frames::full_resolution(twin.clone(), rate);
    let mut tenfold = Frames::every_refresh(twin.clone(), true);
    let mut ahead = Frames::every_refresh(twin.clone(), false);
    for refresh in 1..40 {
        let time = f64::from(refresh) / 60.0;
        let content = full.show(time);
        let age = time - content;
        // Two intervals are over only after the first two.
        assert!(age < 2.0 * interval + 1e-9, "{age} at {time}");
        assert!(age >= interval - 1e-9 || content == 0.0, "{age} at {time}");
        let whole = content / interval;
        assert!(
            (whole - whole.round()).abs() < 1e-6,
            "a frame begins at {content}"
        );
        assert!((tenfold.show(time) - (time - 1.0 / 60.0)).abs() < 1e-9);
        assert_eq!(ahead.show(time), time);
        if refresh % 7 == 0 {
            assert!(full.picture() == ideal(&mut twin, content, 1));
            assert!(tenfold.picture() == ideal(&mut twin, time - 1.0 / 60.0, 1));
            assert!(ahead.picture() == ideal(&mut twin, time, 1));
            assert!(ahead.picture() != tenfold.picture(), "the scene moves");
        }
    }
    assert_eq!(tenfold.samples(), 39 * 64 * 48);
    let finished = (39.0 / 60.0 / interval).floor() as u64;
    assert_eq!(full.samples(), finished * 64 * 48);
}

#[test]
fn budgets_are_kept_and_used() {
    for (size, rate) in [
        (UVec2::new(256, 256), 100_000.0),
        (UVec2::new(256, 256), 400_000.0),
        (UVec2::new(640, 360), 800_000.0),
        (UVec2::new(64, 64), 800_000.0),
    ] {
        let budget = rate / 60.0;
        let frame = resolution(size, budget);
        let used = f64::from(frame.x * frame.y);
        assert!(
            used <= budget && used > 0.96 * budget,
            "{frame} of {budget}"
        );
        let shape = |v: UVec2| f64::from(v.x) / f64::from(v.y);
        assert!(
            (shape(frame) / shape(size) - 1.0).abs() < 0.06,
            "{frame} for {size}"
        );
    }
    assert_eq!(resolution(UVec2::new(256, 256), 0.2), UVec2::ONE);
}

#[test]
fn upscaling_over_time_converges_on_a_still_scene() {
    let mut world = still("toycar");
    let exact = ideal(&mut world, 0.0, 8);
    let rate = 64 * 48 * 6;
    let mut coarse = Frames::low_resolution(world.clone(), rate, Upscale::Linear);
    let mut full = Frames::every_refresh(world.clone(), false);
    let twin = world.clone();
    let mut taau = Taau::new(world, rate, Tuning::SHARP, 1);
    for refresh in 1..=150 {
        taau.show(f64::from(refresh) / 60.0);
    }
    let mut blocks = Frames::low_resolution(twin, rate, Upscale::Nearest);
    blocks.show(2.5);
    coarse.show(2.5);
    full.show(2.5);
    let [blocks, coarse, full, taau] =
        [&blocks as &dyn Framed, &coarse, &full, &taau].map(|f| rmse(f.picture(), &exact));
    assert!(coarse < blocks, "{coarse} interpolated, {blocks} in blocks");
    assert!(
        taau < 0.6 * coarse,
        "{taau} against {coarse} at low resolution"
    );
    assert!(taau < full, "{taau} against {full} without antialiasing");
}

#[test]
fn the_late_warp_makes_up_for_the_frame_of_delay() {
    let mut world = moving("interactive");
    let rate = 64 * 48 * 60;
    let mut late = Frames::every_refresh(world.clone(), true);
    let mut taau = Taau::new(world.clone(), rate, Tuning::QUICK, 1);
    let (mut warped, mut delayed) = (0.0, 0.0);
    for refresh in 1..=60 {
        let time = f64::from(refresh) / 60.0;
        late.show(time);
        taau.show(time);
        let exact = ideal(&mut world, time, 2);
        warped += rmse(taau.picture(), &exact).powi(2);
        delayed += rmse(late.picture(), &exact).powi(2);
    }
    assert!(warped < 0.5 * delayed, "{warped} against {delayed}");
}

#[test]
fn surfaces_are_carried_where_their_hits_go() {
    for name in ["interactive", "toycar", "walkthrough"] {
        let mut world = moving(name);
        let (now, then) = (0.7, 0.75);
        world.prepare(now, now);
        let camera = world.camera(then);
        let mut movers = 0;
        for i in 0..SIZE[0] * SIZE[1] {
            let pixel = Vec2::new((i % SIZE[0]) as f32, (i / SIZE[0]) as f32) + 0.5;
            let hit = world.moment(now).look(pixel, i);
            let exact = if hit.object == SKY {
                camera.project_direction(hit.local)
            } else {
                let place = world.pose(hit.object, then).transform_point3(hit.local);
                camera.project(place)
            };
            let carried = carry_for_tests(&world, now, then, pixel, &hit);
            let Some((exact, depth)) = exact else {
                continue;
            };
            if !(-200.0..400.0).contains(&exact.x) || !(-200.0..400.0).contains(&exact.y) {
                continue;
            }
            movers += u32::from(hit.object != 0 && hit.object != SKY);
            let (carried, inverse_depth) = carried.expect("it is in front");
            assert!(
                (carried - exact).length() < 0.02,
                "{name}: object {} at {pixel}: {carried} for {exact}",
                hit.object
            );
            if hit.object != SKY {
                assert!((inverse_depth * depth - 1.0).abs() < 1e-3);
            }
        }
        assert!(name != "toycar" || movers > 20, "{name} has movers in view");
    }
}
