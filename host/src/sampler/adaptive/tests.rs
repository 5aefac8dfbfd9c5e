//! The sampler on the analytic stage.

use glam::{DAffine3, DVec3, UVec2, Vec2, Vec3};

use super::cells::NONE;
use super::*;
use crate::sampler::stage::{PANEL, Stage, WALL};

const SIZE: UVec2 = UVec2::new(64, 48);
const LARGE: UVec2 = UVec2::new(128, 96);
const RATE: f64 = 40_000.0;

/// Lets a sampler work for a while; returns its shots.
fn work(sampler: &mut Adaptive, stage: &Stage, from: f64, seconds: f64) -> Vec<Shot> {
    let mut out = Vec::new();
    let epochs = (seconds * 60.0).round() as usize;
    for i in 0..epochs {
        let at = |i: usize| from + i as f64 / 60.0;
        let shots = ((at(i + 1) * RATE).round() - (at(i) * RATE).round()) as usize;
        sampler.epoch(
            Span {
                t0: at(i),
                t1: at(i + 1),
                shots,
            },
            stage,
            &mut out,
        );
    }
    out
}

fn sampler() -> Adaptive {
    Adaptive::new(SIZE, Config::default())
}

/// Whose lifetimes are the time in which light changes by the tolerance.
fn by_tolerance(size: UVec2) -> Adaptive {
    let config = Config {
        balanced: false,
        ..Config::default()
    };
    Adaptive::new(size, config)
}

/// Whether a pixel looks at the panel, `margin` pixels inside its edge.
fn on_panel(p: Vec2, size: UVec2, margin: f32) -> bool {
    let half = PANEL / WALL * size.y as f32 - margin;
    (p - size.as_vec2() * 0.5).abs().max_element() < half
}

#[test]
fn takes_the_shots_it_is_given_in_order_and_within_the_image() {
    let stage = Stage {
        camera_speed: 2.0,
        disc_speed: 1.0,
        ..Stage::new(SIZE)
    };
    let out = work(&mut sampler(), &stage, 0.0, 0.5);
    assert_eq!(out.len(), (RATE * 0.5) as usize);
    for pair in out.windows(2) {
        assert!((pair[1].time - pair[0].time - 1.0 / RATE).abs() < 1e-6);
    }
    assert!(out.iter().all(|s| s.pixel.cmpge(Vec2::ZERO).all()));
    assert!(out.iter().all(|s| s.pixel.cmplt(SIZE.as_vec2()).all()));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let stage = Stage {
        camera_speed: 1.0,
        disc_speed: 1.0,
        panel_rate: 80.0,
        ..Stage::new(SIZE)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| work(&mut sampler(), &stage, 0.0, 0.3))
    };
    let one = with(1);
    assert_eq!(one, with(3));
    let mut other = Adaptive::new(
        SIZE,
        Config {
            seed: 2,
            ..Config::default()
        },
    );
    assert_ne!(one, work(&mut other, &stage, 0.0, 0.3), "the seed matters");
}

#[test]
fn verification_measures_a_known_gradient() {
    // The panel changes by 100 levels a second: after a tenth of a second a sample is 10 levels
    // off, the tolerance. The camera moves, which must not count.
    let stage = Stage {
        panel_rate: 100.0,
        camera_speed: 0.3,
        checker: 0.0,
        ..Stage::new(LARGE)
    };
    let mut sampler = by_tolerance(LARGE);
    work(&mut sampler, &stage, 0.0, 1.0);
    let eye = stage.camera(1.0).eye;
    let (grid, tau) = sampler.lifetimes();
    let centre =
        |i: u32| (UVec2::new(i % grid.x, i / grid.x) * lifetime::TILE * SIDE).as_vec2() + 4.0;
    let shift = Vec2::X * (eye.x / WALL * LARGE.y as f32);
    let panel: Vec<f32> = (0..grid.element_product())
        .filter(|&i| on_panel(centre(i) + shift, LARGE, 16.0))
        .map(|i| tau[i as usize])
        .collect();
    assert!(!panel.is_empty());
    for tau in panel {
        assert!(
            (0.085..0.13).contains(&tau),
            "lifetime {tau} where 0.1 is due"
        );
    }
    assert!(tau[0] > 0.9, "the still corner lives {}", tau[0]);
}

#[test]
fn second_looks_reach_back_a_lifetime() {
    // Lifetimes of a tenth of a second, and 50 new samples a cell and second.
    let stage = Stage {
        panel_rate: 100.0,
        checker: 0.0,
        ..Stage::new(SIZE)
    };
    let mut sampler = by_tolerance(SIZE);
    work(&mut sampler, &stage, 0.0, 1.0);
    let now = (1.0 - sampler.projection.time()) as f32;
    let (mut ages, mut lives, mut count) = (0.0, 0.0, 0.0);
    for (pixel, spot) in sampler.cells.plane.iter().enumerate() {
        let pixel = pixel as u32;
        let width = sampler.grid.size.x;
        let at = (UVec2::new(pixel % width, pixel / width) * SIDE).as_vec2() + 1.0;
        if let Some(cell) = sampler.cells.pool.get(spot.front as usize)
            && on_panel(at, SIZE, 4.0)
        {
            ages += now - cell.born;
            lives += sampler.lifetimes.tau[sampler.lifetime_tiles[sampler.grid.of(pixel)] as usize];
            count += 1.0;
        }
    }
    assert!(count > 50.0, "{count} cells");
    // Evenly from none to one, and a second look in between begins anew.
    let share = ages / lives;
    assert!((0.35..0.75).contains(&share), "{share} of a lifetime old");
}

#[test]
fn what_is_kept_for_a_second_look_is_of_the_cell() {
    let mut cells = cells::Cells::new(UVec2::splat(8));
    let fresh = |object, born, level| cells::Fresh {
        local: Vec3::splat(born),
        object,
        colour: Vec3::splat(level),
        born,
        points: guidance::Points::new(0, crate::effects::care::Care::default()),
    };
    let at = Vec2::splat(3.5);
    let index = cells.deposit(&fresh(1, 0.0, 10.0), at, 2.0, 0.1);
    let kept = |cells: &cells::Cells| {
        let cell = cells.pool[index as usize];
        (cell.object, cell.born, cell.kept().x, cell.local.x)
    };
    assert_eq!(cells.deposit(&fresh(1, 0.05, 30.0), at, 2.0, 0.1), index);
    assert_eq!(kept(&cells), (1, 0.0, 10.0, 0.0), "young enough");
    assert_eq!(cells.pool[index as usize].mean.x, 20.0, "but it counts");
    cells.deposit(&fresh(1, 0.11, 50.0), at, 2.0, 0.1);
    assert_eq!(kept(&cells), (1, 0.11, 50.0, 0.11), "a lifetime later");
    cells.deposit(&fresh(2, 0.12, 70.0), at, 2.0, 0.1);
    assert_eq!(kept(&cells), (2, 0.12, 70.0, 0.12), "another object");
}

/// Which lifetime tiles the display is told to average for as long as it likes.
fn told_to_rest(sampler: &Adaptive) -> Vec<bool> {
    let tiles = sampler.lifetimes().0.element_product() as usize;
    (0..tiles)
        .map(|tile| sampler.lifetimes.told(tile) == f32::INFINITY)
        .collect()
}

#[test]
fn a_still_scene_rests_without_a_break() {
    // Edges everywhere: rays that graze them must wake nobody.
    let stage = Stage {
        checker: 0.11,
        ..Stage::new(LARGE)
    };
    let mut sampler = Adaptive::new(LARGE, Config::default());
    work(&mut sampler, &stage, 0.0, 0.5);
    for step in 0..30 {
        let from = 0.5 + f64::from(step) / 30.0;
        work(&mut sampler, &stage, from, 1.0 / 30.0);
        let awake = told_to_rest(&sampler).iter().filter(|told| !**told).count();
        assert_eq!(awake, 0, "tiles awake after {from} s");
        assert!(sampler.still);
    }
    // A fortieth of the shots looks again, so that the others teach the means.
    let before = sampler.stats();
    work(&mut sampler, &stage, 1.5, 0.5);
    let after = sampler.stats();
    let looks = after.verifications - before.verifications;
    let share = looks as f64 / (after.shots - before.shots) as f64;
    assert!((0.02..0.03).contains(&share), "{share}");
}

#[test]
fn light_that_changes_slowly_wakes_its_tiles_alone() {
    // 20 levels a second: a fiftieth of a second for the change that the eye can see.
    let stage = Stage {
        panel_rate: 20.0,
        ..Stage::new(LARGE)
    };
    let mut sampler = Adaptive::new(LARGE, Config::default());
    work(&mut sampler, &stage, 0.0, 1.0);
    let (grid, _) = sampler.lifetimes();
    let centre = |i: usize| {
        let i = i as u32;
        (UVec2::new(i % grid.x, i / grid.x) * lifetime::TILE * SIDE).as_vec2() + 4.0
    };
    let told = told_to_rest(&sampler);
    let changing: Vec<bool> = (0..told.len())
        .filter(|&i| on_panel(centre(i), LARGE, 0.0))
        .map(|i| told[i])
        .collect();
    let resting = changing.iter().filter(|told| **told).count();
    assert!(!changing.is_empty());
    assert_eq!(resting, 0, "of {} tiles", changing.len());
    assert!(told[0], "the still corner rests");
}

#[test]
fn shots_go_where_the_residual_is() {
    let stage = Stage {
        panel_rate: 300.0,
        checker: 0.0,
        ..Stage::new(SIZE)
    };
    let density = |config: Config| {
        let mut sampler = Adaptive::new(SIZE, config);
        let out = work(&mut sampler, &stage, 0.0, 1.0);
        let late: Vec<_> = out.iter().filter(|s| s.time > 0.4).collect();
        let area = (0..SIZE.element_product())
            .filter(|i| {
                on_panel(
                    UVec2::new(i % SIZE.x, i / SIZE.x).as_vec2() + 0.5,
                    SIZE,
                    0.0,
                )
            })
            .count();
        let hits = late.iter().filter(|s| on_panel(s.pixel, SIZE, 0.0)).count();
        let rest = (late.len() - hits) as f32 / (SIZE.element_product() as usize - area) as f32;
        hits as f32 / area as f32 / rest
    };
    let adaptive = density(Config::default());
    let blind = density(Config {
        residuals: false,
        water_filling: false,
        ..Config::default()
    });
    assert!(
        adaptive > 1.6,
        "{adaptive} times as dense on the changing panel"
    );
    assert!((0.9..1.1).contains(&blind), "{blind} without residuals");
}

#[test]
fn what_comes_into_view_is_served_first() {
    // At 30 m/s the first epoch after one of rest finds nine new columns at the right.
    let dash = Stage {
        camera_speed: 30.0,
        checker: 0.0,
        ..Stage::new(SIZE)
    };
    let mut sampler = sampler();
    work(
        &mut sampler,
        &Stage {
            camera_speed: 0.0,
            ..dash
        },
        -0.5,
        0.5,
    );
    let out = work(&mut sampler, &dash, 1.0 / 60.0, 1.0 / 60.0);
    let right = out.iter().filter(|s| s.pixel.x >= 55.0).count() as f32 / 9.0;
    let left = out.iter().filter(|s| s.pixel.x < 55.0).count() as f32 / 55.0;
    assert!(right > 4.0 * left, "{right} to {left} a column");
}

#[test]
fn the_memory_is_warped_where_something_moves() {
    let warps = |camera_speed: f32| {
        let stage = Stage {
            camera_speed,
            ..Stage::new(SIZE)
        };
        let mut sampler = sampler();
        work(&mut sampler, &stage, 0.0, 0.15);
        sampler.stats().warps
    };
    // 9 epochs: each fourth at rest; the wall moves by 4.4 pixels an epoch, by 2.4.
    assert_eq!(warps(0.0), 3);
    assert_eq!(warps(22.0), 9);
    assert_eq!(warps(12.0), 5);
}

#[test]
fn a_change_shortens_lifetimes_before_the_next_warp() {
    let mut sampler = sampler();
    // Of each fourth epoch one warps, the first of all and the 33rd.
    work(&mut sampler, &Stage::new(SIZE), 0.0, 33.0 / 60.0);
    let (warps, from) = (sampler.stats().warps, 33.0 / 60.0);
    assert_eq!(warps, 9);
    let mean = |sampler: &Adaptive| {
        let (grid, tau) = sampler.lifetimes();
        let centre =
            |i: u32| (UVec2::new(i % grid.x, i / grid.x) * lifetime::TILE * SIDE).as_vec2();
        let panel: Vec<f32> = (0..grid.element_product())
            .filter(|&i| on_panel(centre(i) + 4.0, SIZE, 4.0))
            .map(|i| tau[i as usize])
            .collect();
        panel.iter().sum::<f32>() / panel.len() as f32
    };
    assert!(mean(&sampler) > 0.9, "{}", mean(&sampler));
    // The panel is 50 levels brighter at once.
    let changed = Stage {
        panel_rate: (50.0 / from) as f32,
        ..Stage::new(SIZE)
    };
    work(&mut sampler, &changed, from, 3.0 / 60.0);
    assert_eq!(sampler.stats().warps, warps);
    assert_eq!(sampler.stats().cuts, 0);
    assert!(mean(&sampler) < 0.3, "{}", mean(&sampler));
}

#[test]
fn errors_that_are_kept_are_those_of_the_tiles() {
    let stage = Stage {
        disc_speed: 1.0,
        swap: 0.25,
        ..Stage::new(LARGE)
    };
    let mut sampler = Adaptive::new(LARGE, Config::default());
    for epoch in 0..30 {
        work(&mut sampler, &stage, f64::from(epoch) / 60.0, 1.0 / 60.0);
        sampler.allocate(1);
        for (i, tile) in sampler.tiles.iter().enumerate() {
            let error = tile.merit(&sampler.config) * sampler.grid.areas[i];
            assert_eq!(sampler.errors[i], error, "tile {i} after epoch {epoch}");
            assert_eq!(sampler.filled[i], tile.samples, "tile {i} after {epoch}");
        }
    }
    assert_eq!(sampler.stats().cuts, 1);
}

#[test]
fn a_cut_is_noticed_within_a_refresh_or_two() {
    let stage = Stage {
        swap: 0.5,
        disc_speed: 1.0,
        ..Stage::new(LARGE)
    };
    // Three samples a pixel and second. With four times as many, on a panel as small as `SIZE`, half
    // of the memory is new before there are enough second looks to judge by: one seed in five
    // takes longer.
    let mut sampler = Adaptive::new(LARGE, Config::default());
    work(&mut sampler, &stage, 0.0, 0.5);
    assert_eq!(sampler.take_cut(), None);
    work(&mut sampler, &stage, 0.5, 2.0 / 60.0);
    let cut = sampler.take_cut().expect("a cut");
    assert!((cut - 0.5).abs() < 0.02, "noticed as of {cut}");
    assert_eq!(sampler.take_cut(), None);
    work(&mut sampler, &stage, 0.5 + 2.0 / 60.0, 0.2);
    assert_eq!(sampler.take_cut(), None, "once");
    assert!(sampler.stats().coverage > 0.8);
}

#[test]
fn projection_agrees_with_f64() {
    let stage = Stage {
        camera_speed: 1.3,
        disc_speed: -0.7,
        ..Stage::new(SIZE)
    };
    let time = 0.37;
    let mut projection = Projection::new(time);
    let mut random = Random::new(4);
    for _ in 0..10_000 {
        let object = (random.next() & 1) as u8;
        projection.prepare(object, &stage);
        let mut unit = || random.unit() * 2.0 - 1.0;
        let local = Vec3::new(unit() * 3.0, unit() * 3.0, unit() * 4.0 + 4.1);
        let camera = stage.camera(time);
        let pose = stage.pose(object, time);
        let pose = DAffine3::from_translation(glam::Vec3::from(pose.translation).as_dvec3());
        let d = pose.transform_point3(local.as_dvec3()) - camera.eye.as_dvec3();
        let z = d.dot(DVec3::from(camera.forward));
        if z < 0.05 {
            continue;
        }
        let x = d.dot(camera.right.as_dvec3()) / z * f64::from(camera.focal);
        let y = d.dot(camera.down.as_dvec3()) / z * f64::from(camera.focal);
        let (at, depth) = projection.project(object, local).expect("in front");
        let error = (at.as_dvec2() - camera.centre.as_dvec2() - glam::DVec2::new(x, y)).length();
        assert!(error < 1e-4 * x.hypot(y).max(1.0), "{error} px at {x}, {y}");
        assert!((f64::from(depth) - z).abs() < 1e-5);
    }
}

#[test]
fn the_plane_agrees_with_the_pool() {
    let stage = Stage {
        camera_speed: 2.0,
        disc_speed: -3.0,
        ..Stage::new(SIZE)
    };
    let mut sampler = sampler();
    let mut worst = 0;
    for epoch in 0..40 {
        work(&mut sampler, &stage, f64::from(epoch) / 60.0, 1.0 / 60.0);
        let cells = &sampler.cells;
        for (pixel, spot) in cells.plane.iter().enumerate() {
            let front = spot.front;
            let Some(cell) = cells.pool.get(front as usize) else {
                assert_eq!(front, NONE);
                continue;
            };
            assert_eq!(cell.pixel as usize, pixel);
            assert!(cell.weight > 0.0, "a dead cell in front");
        }
        worst = worst.max(cells.pool.len());
    }
    assert!(worst < 2 * pixels(&sampler), "{worst} cells");
    // Who lives after a warp has a pixel of its own, and the tiles sum all of them up.
    sampler.warp(40.0 / 60.0, &stage);
    let living = |cell: &&cells::Cell| cell.weight > 0.0;
    let alive = sampler.cells.pool.iter().filter(living).count();
    let fronts = sampler.cells.plane.iter().filter(|s| s.front != NONE);
    assert_eq!(alive, fronts.count());
    let before: f32 = sampler.tiles.iter().map(|t| t.samples).sum();
    let direct: f32 = sampler
        .cells
        .plane
        .iter()
        .filter_map(|spot| sampler.cells.pool.get(spot.front as usize))
        .map(|cell| cell.weight)
        .sum();
    assert!(
        (before / direct - 1.0).abs() < 1e-4,
        "{before} summed, {direct} there"
    );
}

/// Pixels of the map.
fn pixels(sampler: &Adaptive) -> usize {
    sampler.cells.plane.len()
}
