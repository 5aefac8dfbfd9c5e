//! Sums, tiling and queues against recomputation.

use glam::Vec2;

use super::super::Config;
use super::super::buffer::DeepBuffer;
use super::super::crosshair::{Crosshair, Initial};
use super::super::tiling::Tiling;
use super::super::tree::{Entry, NONE, Sums, Tree};
use super::{SIZE, crosshair};
use crate::sampler::noise::Random;

/// What the sums of a block should be: recomputed from the buffer, weights relative to `now`.
fn recomputed<'a>(
    stored: impl Iterator<Item = &'a Crosshair>,
    tree: &Tree,
    node: u32,
    decline: f64,
    now: f64,
) -> (u32, [f64; 7], f64) {
    let (mut count, mut sums, mut times) = (0, [0.0; 7], 0.0);
    for c in stored {
        let mut above = tree.home(c.pixel);
        while above != node && above != NONE {
            above = tree.nodes[above as usize].parent;
        }
        if above != node {
            continue;
        }
        let w = (-decline * (now - c.time)).exp();
        let l = f64::from(c.centre.luminance);
        let g = c.gradients.map(f64::from);
        let terms = [
            1.0,
            l,
            l * l,
            g[0],
            g[1],
            g[2],
            f64::from(u8::from(c.occluded)),
        ];
        sums.iter_mut().zip(terms).for_each(|(s, t)| *s += w * t);
        count += 1;
        times += c.time;
    }
    (count, sums, times)
}

/// Sums as ratios to their weight.
fn ratios(sums: &Sums) -> [f64; 6] {
    let [gx, gy, gt] = sums.gradients;
    [sums.light[0], sums.light[1], gx, gy, gt, sums.occluded].map(|s| s / sums.weight)
}

/// The tiles of every pixel: exactly one each.
fn check_partition(tiling: &Tiling) {
    let mut owners = vec![0; SIZE.element_product() as usize];
    for index in 0..tiling.len() as u32 {
        let tile = tiling.at(index);
        let rect = tiling.tree.nodes[tile as usize].rect;
        for y in rect.y..rect.y + rect.h {
            for x in rect.x..rect.x + rect.w {
                let pixel = u32::from(y) * SIZE.x + u32::from(x);
                owners[pixel as usize] += 1;
                assert_eq!(tiling.of(pixel), tile);
            }
        }
    }
    assert!(owners.iter().all(|&n| n == 1));
}

#[test]
fn tiling_and_sums_hold_under_a_hundred_thousand_operations() {
    let config = Config {
        finest: 2,
        least_tiles: 1,
        ..Config::default()
    };
    let mut random = Random::new(17);
    let tree = Tree::new(SIZE, config.decline);
    let mut tiling = Tiling::new(tree, &config);
    let mut buffer = DeepBuffer::new(SIZE.element_product() as usize, config.depth);
    let (mut now, mut target) = (0.0, 100);
    for step in 0..100_000 {
        // In all 400 s, in which weights are rebased three times.
        now += 0.004;
        match random.below(8) {
            0..4 => {
                let new = crosshair(&mut random, now);
                buffer.push_front(new);
                tiling.update(new.pixel, &buffer);
            }
            4..6 => {
                let pixel = random.below(SIZE.element_product());
                if let Some(old) = buffer.pop_front(pixel) {
                    tiling.update(pixel, &buffer);
                    let moved = Crosshair {
                        pixel: random.below(SIZE.element_product()),
                        ..old
                    };
                    buffer.push_back(moved);
                    tiling.update(moved.pixel, &buffer);
                }
            }
            6 => {
                if random.below(50) == 0 {
                    target = 1 + random.below(400);
                }
                tiling.adjust(target, &config);
            }
            _ => {
                let pixel = random.below(SIZE.element_product());
                let place = Vec2::new((pixel % SIZE.x) as f32, (pixel / SIZE.x) as f32);
                let initial = Initial {
                    place,
                    time: now,
                    luminance: 0.5,
                };
                tiling.set_initial(pixel, initial);
                let tile = tiling.of(pixel);
                assert_eq!(tiling.take_initial(tile), Some(initial));
                tiling.set_initial(pixel, initial);
            }
        }
        if step % 500 == 0 {
            tiling.check();
        }
        if step % 5000 == 4999 {
            check_partition(&tiling);
            for _ in 0..20 {
                let node = random.below(tiling.tree.nodes.len() as u32);
                let (count, exact, times) =
                    recomputed(buffer.iter(), &tiling.tree, node, config.decline, now);
                let sums = tiling.tree.sums(node);
                assert_eq!(sums.count, count);
                if count == 0 {
                    assert_eq!(*sums, Sums::default());
                    continue;
                }
                assert!((sums.times - times).abs() < 1e-9 * times);
                for (got, sum) in ratios(sums).iter().zip(&exact[1..]) {
                    assert!(
                        (got - sum / exact[0]).abs() < 1e-7,
                        "{got} {}",
                        sum / exact[0]
                    );
                }
                let mean = exact[1] / exact[0];
                let variance = exact[2] / exact[0] - mean * mean;
                assert!((sums.variance() - variance).abs() < 1e-9);
            }
        }
    }
    assert!(tiling.moves[0] > 1000 && tiling.moves[1] > 1000);
}

#[test]
fn queues_hold_four_and_forget_the_oldest() {
    let mut buffer = DeepBuffer::new(2, 4);
    let at = |time: f64| Crosshair {
        time,
        pixel: 1,
        ..crosshair(&mut Random::new(1), 0.0)
    };
    let times = |buffer: &DeepBuffer| -> Vec<f64> { buffer.queue(1).map(|c| c.time).collect() };
    for time in 1..=4 {
        assert_eq!(buffer.push_front(at(f64::from(time))), None);
    }
    assert_eq!(buffer.push_front(at(9.0)), Some(at(1.0)));
    assert_eq!(times(&buffer), [9.0, 4.0, 3.0, 2.0]);
    assert_eq!(
        buffer.push_back(at(0.5)),
        Some(at(0.5)),
        "older than the back"
    );
    assert_eq!(buffer.push_back(at(2.5)), Some(at(2.0)));
    assert_eq!(buffer.pop_front(1), Some(at(9.0)));
    assert_eq!(buffer.push_back(at(9.0)), None);
    assert_eq!(times(&buffer), [4.0, 3.0, 2.5, 9.0]);
    assert_eq!(buffer.newest(1), Some(&at(9.0)));
    assert_eq!(buffer.remove(&at(3.0)), Some(at(3.0)));
    assert_eq!(buffer.remove(&at(3.0)), None);
    assert_eq!((times(&buffer), buffer.len()), (vec![4.0, 2.5, 9.0], 3));
    assert_eq!(buffer.queue(0).count(), 0);
}

#[test]
fn a_queue_is_as_deep_as_it_is_told_to_be() {
    let at = |time: f64, pixel| Crosshair {
        time,
        pixel,
        ..crosshair(&mut Random::new(1), 0.0)
    };
    for depth in [0, 1, 3, 8] {
        let places = usize::from(depth.max(1));
        let mut buffer = DeepBuffer::new(3, depth);
        for time in 0..20 {
            for pixel in 0..3 {
                let out = buffer.push_front(at(f64::from(time), pixel));
                assert_eq!(out.is_some(), time as usize >= places, "{depth}");
            }
        }
        assert_eq!(buffer.len(), 3 * places);
        for pixel in 0..3 {
            let times: Vec<f64> = buffer.queue(pixel).map(|c| c.time).collect();
            let newest: Vec<f64> = (0..20).rev().take(places).map(f64::from).collect();
            assert_eq!(times, newest, "{depth}");
        }
        assert_eq!(buffer.push_back(at(0.5, 1)), Some(at(0.5, 1)));
        assert!(buffer.pop_front(1).is_some());
        assert_eq!(buffer.push_back(at(0.5, 1)), None);
        assert_eq!(buffer.queue(0).chain(buffer.queue(2)).count(), 2 * places);
    }
}

#[test]
fn a_tile_with_under_two_crosshairs_inherits() {
    let config = Config::default();
    let mut tree = Tree::new(SIZE, config.decline);
    let entry = |luminance, gt| Entry {
        time: 1.0,
        luminance,
        gradients: [0.1, 0.2, gt],
        occluded: false,
    };
    // The tile of the first pixel and its neighbour.
    let tile = tree.nodes[tree.home(0) as usize].parent;
    tree.set(0, [entry(0.2, 1.0)].into_iter());
    assert_eq!(tree.known(tile), None, "one in all the image");
    // Far away: only the root holds both.
    let far = SIZE.element_product() - 1;
    tree.set(far, [entry(0.6, 3.0)].into_iter());
    let known = tree.known(tile).expect("two");
    assert!((known.variance() - 0.04).abs() < 1e-7);
    assert!((known.mean_gradients()[2] - 2.0).abs() < 1e-6);
    tree.set(0, [entry(0.2, 1.0), entry(0.2, 1.0)].into_iter());
    assert!(tree.known(tile).expect("two").variance() < 1e-9);
}

#[test]
fn what_is_old_is_not_eaten_by_what_was_new() {
    // Ten seconds make weights differ by 10^15: taking the new ones out of a sum would leave
    // nothing but rounding.
    let mut tree = Tree::new(SIZE, Config::default().decline);
    let entry = |time, luminance| Entry {
        time,
        luminance,
        gradients: [0.0; 3],
        occluded: false,
    };
    let old = [entry(1.0, 0.25), entry(1.0, 0.75)];
    tree.set(0, old.into_iter());
    tree.set(1, [entry(11.0, 0.3)].into_iter());
    tree.set(0, [entry(11.0, 0.9)].into_iter().chain(old));
    tree.set(0, old.into_iter());
    tree.set(1, std::iter::empty());
    assert!((tree.sums(0).variance() - 0.0625).abs() < 1e-12);
    assert_eq!(tree.sums(0).count, 2);
}
