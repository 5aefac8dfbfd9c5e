//! The whole loop on a small scene.

use glam::{UVec2, Vec2};
use unframed_wire::tiles::TileNode;
use unframed_wire::{LogCode, TileFields};

use super::super::{Config, Paper};
use crate::sampler::stage::{self, Stage};
use crate::sampler::{Eye, Sampler, Shot, Span};
use crate::trace::Rays;

/// Runs `seconds` of a stage at `rate` samples a second; shots of the last epoch.
fn run(sampler: &mut Paper, stage: &Stage, seconds: f64, rate: usize) -> Vec<Shot> {
    let mut out = Vec::new();
    let epochs = (seconds * 60.0).round() as usize;
    for epoch in 0..epochs {
        out.clear();
        let [t0, t1] = [epoch, epoch + 1].map(|k| k as f64 / 60.0);
        let shots = rate / 60;
        sampler.epoch(Span { t0, t1, shots }, stage, &mut out);
        assert!(out.is_sorted_by(|a, b| a.time <= b.time));
        assert!(out.iter().all(|s| s.time >= t0 && s.time < t1));
        let inside = |p: Vec2| p.cmpge(Vec2::ZERO).all() && p.cmplt(stage.size.as_vec2()).all();
        assert!(out.iter().all(|s| inside(s.pixel)));
    }
    out
}

#[test]
fn every_ray_is_paid_for() {
    let stage = Stage {
        camera_speed: 1.0,
        disc_speed: 1.0,
        ..Stage::new(UVec2::new(64, 48))
    };
    for occlusion_cost in [1.0, 0.25] {
        let mut sampler = Paper::new(
            stage.size,
            Config {
                occlusion_cost,
                ..Config::default()
            },
        );
        let (seconds, rate) = (0.5, 60_000);
        run(&mut sampler, &stage, seconds, rate);
        let stats = sampler.stats();
        let spent = stats.samples as f64 + occlusion_cost * stats.tests as f64;
        let budget = seconds * rate as f64;
        assert!(
            spent <= budget && spent > budget - 20.0,
            "{spent} of {budget}"
        );
        assert!(stats.tests > 1000 && stats.occluded > 20, "{stats:?}");
        assert_eq!(sampler.take_rays().shadow as u64, stats.tests);
        assert_eq!(sampler.take_rays(), Rays::default());
    }
}

#[test]
fn samples_go_where_the_picture_changes() {
    // A plain wall with a panel that flickers, 56 % of the picture: the panel gets the samples.
    let stage = Stage {
        panel_rate: 2000.0,
        checker: 0.0,
        disc_speed: 100.0,
        ..Stage::new(UVec2::new(128, 128))
    };
    let share = |config: Config| {
        let mut sampler = Paper::new(stage.size, config);
        let last = run(&mut sampler, &stage, 0.5, 240_000);
        let offset = |s: &Shot| {
            let at = stage.camera(s.time).direction(s.pixel) * stage::WALL;
            at.truncate().abs().max_element()
        };
        let inside = |s: &&Shot| offset(s) < stage::PANEL;
        last.iter().filter(inside).count() as f64 / last.len() as f64
    };
    let fixed = Config {
        gain: false,
        tiles: 256,
        ..Config::default()
    };
    let adaptive = share(fixed.clone());
    let even = share(Config {
        adapt: false,
        ..fixed
    });
    assert!(adaptive > 1.2 * even, "{adaptive} against {even}");
}

#[test]
fn gain_follows_motion_and_side_data_tell_of_it() {
    let still = Stage::new(UVec2::new(128, 128));
    let moving = Stage {
        camera_speed: 6.0,
        ..still
    };
    let fields = TileFields {
        gradients: true,
        lifetime: false,
        density: true,
    };
    let mut seen = Vec::new();
    for stage in [still, moving] {
        let mut sampler = Paper::new(stage.size, Config::default());
        run(&mut sampler, &stage, 0.4, 240_000);
        let mut nodes = Vec::new();
        sampler.tiles(fields, &mut nodes);
        let tiles: Vec<_> = nodes
            .iter()
            .filter_map(|node| match node {
                TileNode::Leaf(tile) => Some(*tile),
                TileNode::Split(_) => None,
            })
            .collect();
        assert_eq!(tiles.len(), sampler.stats().tiles);
        let quantity = |code: LogCode| (f64::from(code.0) - 128.0).exp2().powf(0.125);
        let area = |t: &unframed_wire::Tile| f64::from(t.rect.w) * f64::from(t.rect.h);
        let mean = |of: &dyn Fn(&unframed_wire::Tile) -> f64| {
            tiles.iter().map(|t| area(t) * of(t)).sum::<f64>() / (128.0 * 128.0)
        };
        // Densities add up to the rate: about 240k less what the tests cost.
        let rate = mean(&|t| quantity(t.density)) * 128.0 * 128.0;
        assert!((180_000.0..260_000.0).contains(&rate), "{rate}");
        seen.push((tiles.len(), mean(&|t| quantity(t.gt))));
    }
    assert!(seen[0].0 > 2 * seen[1].0, "{seen:?}");
    assert!(seen[1].1 > 3.0 * seen[0].1, "{seen:?}");
}

#[test]
fn the_same_on_any_number_of_threads() {
    let stage = Stage {
        camera_speed: 1.0,
        ..Stage::new(UVec2::new(64, 48))
    };
    let shots = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut sampler = Paper::new(stage.size, Config::default());
        pool.install(|| run(&mut sampler, &stage, 0.2, 60_000))
    };
    assert_eq!(shots(1), shots(3));
}
