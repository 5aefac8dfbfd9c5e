//! Scenes made of others, to ask one question each: does a still picture converge, and how fast is
//! a cut forgotten?

use serde::Serialize;
use unframed_host::scene::animate::Animation;
use unframed_host::scene::model::{Channel, Interpolation, Scene, Track};

use super::cell::Cell;

/// How long a still scene is watched, seconds.
pub const STILL_SECONDS: f64 = 5.0;
/// What a still scene's RMSE must fall below in that time.
pub const STILL_LIMIT: f64 = 1.5;
/// When the cut is, seconds: between two refreshes.
pub const CUT_AT: f64 = 1.0 + 1.0 / 120.0;
/// How long is watched after it, seconds.
pub const CUT_WATCHED: f64 = 1.0;
/// A cut is over when the RMSE is this many times the steady one, or less.
pub const RECOVERED: f64 = 1.2;
/// How long that may take, milliseconds.
pub const RECOVERY_LIMIT_MS: f64 = 200.0;
/// Refreshes in a row that must have recovered.
const IN_A_ROW: usize = 3;
/// Keys a second of a baked animation.
const BAKED_HZ: f64 = 240.0;
/// A jump takes this long, seconds: the least that 32-bit key times tell apart for sure.
const JUMP: f64 = 1e-5;

/// The scene as it stands at `time` seconds, for ever.
#[must_use]
pub fn still(scene: &Scene, time: f64) -> Scene {
    let animation = Animation::new(scene);
    let mut frozen = scene.clone();
    for (index, node) in frozen.nodes.iter_mut().enumerate() {
        if animation.moves(index) {
            let local = animation.local(scene, index, time);
            let (scale, rotation, translation) = local.to_scale_rotation_translation();
            (node.scale, node.rotation, node.translation) = (scale, rotation, translation);
        }
    }
    frozen.channels.clear();
    frozen.duration = 0.0;
    frozen
}

/// The scene's animation over `seconds`, baked into keys. With `cut`, all before that instant is
/// of half a loop later: at the cut, everything is elsewhere at once.
#[must_use]
pub fn baked(scene: &Scene, seconds: f64, cut: Option<f64>) -> Scene {
    let animation = Animation::new(scene);
    let shift = 0.5 * scene.duration;
    let cut = cut.unwrap_or(0.0);
    // When a key is, and which instant of the animation it shows.
    let mut keys: Vec<(f64, f64)> = Vec::new();
    for step in 0..=(seconds * BAKED_HZ).ceil() as u32 {
        let time = f64::from(step) / BAKED_HZ;
        if time < cut - JUMP {
            keys.push((time, time + shift));
        } else if time > cut {
            keys.push((time, time));
        }
    }
    if cut > 0.0 {
        let before = keys.partition_point(|key| key.0 < cut);
        keys.splice(
            before..before,
            [(cut - JUMP, cut - JUMP + shift), (cut, cut)],
        );
    } else {
        keys.insert(0, (0.0, 0.0));
    }
    let times: Vec<f32> = keys.iter().map(|key| key.0 as f32).collect();
    let mut result = scene.clone();
    result.channels.clear();
    for node in (0..scene.nodes.len()).filter(|node| animation.moves(*node)) {
        let poses = keys.iter().map(|key| {
            let local = animation.local(scene, node, key.1);
            local.to_scale_rotation_translation()
        });
        let (mut scales, mut rotations, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (scale, rotation, place) in poses {
            scales.push(scale);
            rotations.push(rotation);
            places.push(place);
        }
        for track in [
            Track::Scale(scales),
            Track::Rotation(rotations),
            Track::Translation(places),
        ] {
            result.channels.push(Channel {
                node,
                track,
                times: times.clone(),
                interpolation: Interpolation::Linear,
                period: seconds as f32 + 1.0,
            });
        }
    }
    result.duration = seconds + 1.0;
    result
}

/// The golden thread: what became of a still picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// The still scene.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// Camera samples a second.
    pub rate: u32,
    /// RMSE of the last refresh.
    pub last_rmse: f64,
    /// The instant from which on the RMSE stays below the limit, seconds.
    pub below_limit_from: Option<f64>,
    /// The most by which the mean RMSE of half a second exceeds that of the half second before it,
    /// as a ratio: at most 1 falls all the time.
    pub worst_rise: f64,
    /// What it must fall below.
    pub limit: f64,
    /// Whether it does, and does not rise by more than a twentieth on the way.
    pub holds: bool,
}

impl Convergence {
    /// Of a cell of a still scene.
    #[must_use]
    pub fn of(cell: &Cell) -> Self {
        let rmses: Vec<f64> = cell.refreshes.iter().map(|r| r.rmse).collect();
        let last_rmse = rmses.last().copied().unwrap_or(f64::NAN);
        let above = cell.refreshes.iter().rposition(|r| r.rmse >= STILL_LIMIT);
        let below = match above {
            None => cell.refreshes.first(),
            Some(above) => cell.refreshes.get(above + 1),
        };
        let halves: Vec<f64> = rmses
            .chunks_exact(30)
            .map(|half| half.iter().sum::<f64>() / half.len() as f64)
            .collect();
        let rises = halves.windows(2).map(|pair| pair[1] / pair[0]);
        let worst_rise = rises.fold(0.0, f64::max);
        Self {
            scene: cell.scene.clone(),
            method: cell.method.clone(),
            rate: cell.rate,
            last_rmse,
            below_limit_from: below.map(|r| r.time),
            worst_rise,
            limit: STILL_LIMIT,
            holds: last_rmse < STILL_LIMIT && worst_rise <= 1.05,
        }
    }
}

/// How fast a cut was forgotten.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recovery {
    /// The scene with the cut.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// Camera samples a second.
    pub rate: u32,
    /// RMSE of the first refresh after the cut.
    pub first_rmse: f64,
    /// RMSE of the whole animation, if that was measured too.
    pub animation_rmse: Option<f64>,
    /// Milliseconds from the cut to the first of three refreshes in a row whose RMSE is at most
    /// 1.2 times that of the animation; none if that never comes. Squared errors are averaged over the
    /// seeds, here and below: one seed's refresh may be half as bad again for no reason but chance.
    pub of_animation: Option<f64>,
    /// RMSE without the cut, over all that was watched.
    pub steady_rmse: f64,
    /// As `of_animation`, with 1.2 times that.
    pub of_steady: Option<f64>,
    /// As `of_animation`, with 1.2 times what *the same refresh* has without a cut.
    pub of_same: Option<f64>,
    /// That for each seed alone.
    pub of_same_each: Vec<Option<f64>>,
    /// The most that it may take, milliseconds.
    pub limit: f64,
    /// Whether it takes no longer until the animation's RMSE is reached; none if that is not known.
    pub holds: Option<bool>,
}

impl Recovery {
    /// Of cells with a cut at [`CUT_AT`], which differ in their seeds, of the same without, and of the whole
    /// animation, if there are any of that. None where a side has no cell.
    #[must_use]
    pub fn of(cut: &[&Cell], steady: &[&Cell], animation: &[&Cell]) -> Option<Self> {
        let (first, _) = (cut.first()?, steady.first()?);
        let curve = over_seeds(cut);
        let alone = |(a, b): (&&Cell, &&Cell)| back(&over_seeds(&[a]), &over_seeds(&[b]));
        let level = |rmse: f64| {
            let level: Vec<(f64, f64)> = curve.iter().map(|point| (point.0, rmse)).collect();
            back(&curve, &level)
        };
        let root_mean = |values: &dyn Fn(&Cell) -> f64, cells: &[&Cell]| {
            let sum: f64 = cells.iter().map(|cell| values(cell).powi(2)).sum();
            (sum / cells.len() as f64).sqrt()
        };
        let steady_rmse = root_mean(&|c| c.rmse, steady);
        let animation_rmse = (!animation.is_empty()).then(|| root_mean(&|c| c.rmse, animation));
        let of_animation = animation_rmse.and_then(level);
        let within = |ms: Option<f64>| ms.is_some_and(|ms| ms <= RECOVERY_LIMIT_MS);
        Some(Self {
            scene: first.scene.clone(),
            method: first.method.clone(),
            rate: first.rate,
            first_rmse: root_mean(&|c| c.refreshes.first().map_or(f64::NAN, |r| r.rmse), cut),
            animation_rmse,
            of_animation,
            steady_rmse,
            of_steady: level(steady_rmse),
            of_same: back(&curve, &over_seeds(steady)),
            of_same_each: cut.iter().zip(steady).map(alone).collect(),
            limit: RECOVERY_LIMIT_MS,
            holds: animation_rmse.map(|_| within(of_animation)),
        })
    }
}

/// Time, seconds, and RMSE of each refresh: the root of the mean of cells that differ in their
/// seeds.
#[must_use]
pub fn over_seeds(cells: &[&Cell]) -> Vec<(f64, f64)> {
    let times = cells.first().map_or(&[][..], |cell| &cell.refreshes);
    let mean = |index: usize| {
        let values = cells.iter().filter_map(|cell| cell.refreshes.get(index));
        let squares: Vec<f64> = values.map(|r| r.rmse * r.rmse).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let points = times.iter().enumerate();
    points.map(|(index, r)| (r.time, mean(index))).collect()
}

/// Milliseconds from the cut until it is forgotten.
fn back(cut: &[(f64, f64)], steady: &[(f64, f64)]) -> Option<f64> {
    let pairs = cut.iter().zip(steady);
    let recovered: Vec<bool> = pairs.map(|(a, b)| a.1 <= RECOVERED * b.1).collect();
    let index = recovered
        .windows(IN_A_ROW)
        .position(|row| row.iter().all(|ok| *ok))?;
    Some(1000.0 * (cut.get(index)?.0 - CUT_AT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use unframed_host::scene::builtin::builtin;
    use unframed_host::trace::World;

    #[test]
    fn a_still_scene_stands_as_it_stood() {
        let scene = builtin("interactive").unwrap();
        let moving = World::new(scene.clone(), [32, 32]).unwrap();
        let frozen = World::new(still(&scene, 0.7), [32, 32]).unwrap();
        assert!(!frozen.moves().view && !frozen.moves().objects);
        let (a, b) = (moving.camera(0.7), frozen.camera(3.0));
        assert!(a.eye.distance(b.eye) < 1e-4 && a.forward.dot(b.forward) > 0.9999);
        assert!(
            moving.camera(1.5).eye.distance(b.eye) > 0.01,
            "and it did move"
        );
    }

    #[test]
    fn a_cut_is_over_when_three_refreshes_in_a_row_are_back_on_the_mean_of_seeds() {
        let cut = |first: [f64; 6], second: [f64; 6]| {
            let curve: Vec<(f64, f64)> = (0..6)
                .map(|i| {
                    let mean = f64::midpoint(first[i].powi(2), second[i].powi(2)).sqrt();
                    (CUT_AT + 0.01 * (i + 1) as f64, mean)
                })
                .collect();
            back(
                &curve,
                &curve.iter().map(|p| (p.0, 10.0)).collect::<Vec<_>>(),
            )
        };
        let calm = [30.0, 11.0, 11.0, 11.0, 11.0, 11.0];
        assert!((cut(calm, calm).unwrap() - 20.0).abs() < 1e-6);
        // Two are not enough, and what is back on the mean may be late in one.
        let late = [30.0, 11.0, 11.0, 14.0, 11.0, 11.0];
        assert_eq!(cut(late, late), None);
        let early = [30.0, 8.0, 8.0, 8.0, 8.0, 8.0];
        assert!((cut(late, early).unwrap() - 20.0).abs() < 1e-6);
    }

    #[test]
    fn a_cut_is_a_jump_and_without_it_all_is_as_before() {
        let scene = builtin("walkthrough").unwrap();
        let before = World::new(scene.clone(), [32, 32]).unwrap();
        let smooth = World::new(baked(&scene, 2.0, None), [32, 32]).unwrap();
        let cut = World::new(baked(&scene, 2.0, Some(CUT_AT)), [32, 32]).unwrap();
        for t in [0.0, 0.313, 1.0, 1.02, 1.9] {
            let (a, b, c) = (before.camera(t), smooth.camera(t), cut.camera(t));
            assert!(a.eye.distance(b.eye) < 1e-3, "{t}");
            let same = a.eye.distance(c.eye) < 1e-3;
            assert_eq!(same, t > CUT_AT, "{t}");
        }
    }
}
