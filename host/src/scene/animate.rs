//! Where the nodes are at an instant: keyframe evaluation after glTF 2.0 Appendix C.
//!
//! Time is `f64` seconds and never rounded to frames. Each channel loops on its own period.
//! Where two channels drive the same property of a node, the later one wins.

use glam::{Affine3A, Quat, Vec3};

use super::model::{Channel, Interpolation, Scene, Track};

/// A transform in its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parts {
    pub(super) scale: Vec3,
    pub(super) rotation: Quat,
    pub(super) translation: Vec3,
}

impl Parts {
    pub(super) fn transform(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// Which nodes move, and the channels that move them.
///
/// Made for one scene; asking it about another gives meaningless poses (but does not panic as
/// long as that scene has as many nodes and channels).
#[derive(Clone, Debug, Default)]
pub struct Animation {
    /// Per node: the channel of its translation, rotation, scale.
    drivers: Vec<[Option<usize>; 3]>,
    /// Per node: itself or an ancestor varies.
    moving: Vec<bool>,
    /// Per node: the nearest varying node at or above it.
    carrier: Vec<Option<usize>>,
}

impl Animation {
    /// Finds the channels of each node. A channel whose keys are all equal moves nothing, but
    /// still sets its value.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let mut drivers = vec![[None; 3]; scene.nodes.len()];
        let mut varies = vec![false; scene.nodes.len()];
        for (i, channel) in scene.channels.iter().enumerate() {
            let Some(slots) = drivers.get_mut(channel.node) else {
                continue;
            };
            slots[slot(&channel.track)] = Some(i);
        }
        for (node, slots) in drivers.iter().enumerate() {
            varies[node] = slots
                .iter()
                .flatten()
                .any(|&c| channel_varies(&scene.channels[c]));
        }
        let mut carrier: Vec<Option<usize>> = Vec::with_capacity(scene.nodes.len());
        for (i, node) in scene.nodes.iter().enumerate() {
            let above = node.parent.and_then(|p| carrier.get(p).copied().flatten());
            carrier.push(if varies[i] { Some(i) } else { above });
        }
        let moving = carrier.iter().map(Option::is_some).collect();
        Self {
            drivers,
            moving,
            carrier,
        }
    }

    /// Whether the node's place in the world varies with time.
    #[must_use]
    pub fn moves(&self, node: usize) -> bool {
        self.moving[node]
    }

    /// The nearest node, at or above this one, whose own transform varies: both move rigidly
    /// together.
    #[must_use]
    pub fn carrier(&self, node: usize) -> Option<usize> {
        self.carrier[node]
    }

    /// The node's transform relative to its parent at `t` seconds.
    #[must_use]
    pub fn local(&self, scene: &Scene, node: usize, t: f64) -> Affine3A {
        self.parts(scene, node, t).transform()
    }

    /// The same in its parts.
    pub(super) fn parts(&self, scene: &Scene, node: usize, t: f64) -> Parts {
        let rest = &scene.nodes[node];
        let [translation, rotation, scale] = self.drivers[node];
        let channel = |slot: Option<usize>| slot.map(|c| &scene.channels[c]);
        Parts {
            scale: channel(scale)
                .and_then(|c| vector_at(c, t))
                .unwrap_or(rest.scale),
            rotation: channel(rotation)
                .and_then(|c| rotation_at(c, t))
                .unwrap_or(rest.rotation),
            translation: channel(translation)
                .and_then(|c| vector_at(c, t))
                .unwrap_or(rest.translation),
        }
    }

    /// Whether the node's own transform varies.
    pub(super) fn varies(&self, node: usize) -> bool {
        self.carrier[node] == Some(node)
    }

    /// The node's transform to the world at `t` seconds.
    #[must_use]
    pub fn world(&self, scene: &Scene, node: usize, t: f64) -> Affine3A {
        let mut pose = self.local(scene, node, t);
        let mut above = scene.nodes[node].parent;
        while let Some(parent) = above {
            pose = self.local(scene, parent, t) * pose;
            above = scene.nodes[parent].parent;
        }
        pose
    }

    /// All transforms to the world at `t`. With `poses` filled by an earlier call only the nodes
    /// that move are evaluated.
    pub fn world_all(&self, scene: &Scene, t: f64, poses: &mut Vec<Affine3A>) {
        self.compose(scene, |node| self.local(scene, node, t), poses);
    }

    /// All transforms to the world, of local ones; as [`Self::world_all`].
    pub(super) fn compose(
        &self,
        scene: &Scene,
        local: impl Fn(usize) -> Affine3A,
        poses: &mut Vec<Affine3A>,
    ) {
        let fresh = poses.len() != scene.nodes.len();
        poses.resize(scene.nodes.len(), Affine3A::IDENTITY);
        for (i, node) in scene.nodes.iter().enumerate() {
            if fresh || self.moving[i] {
                let local = local(i);
                poses[i] = node.parent.map_or(local, |p| poses[p] * local);
            }
        }
    }

    /// Instants strictly inside `t0..t1` at which some motion has a corner or a jump (keys and
    /// loop ends), ascending. Between them every channel is smooth.
    #[must_use]
    pub fn corners(&self, scene: &Scene, t0: f64, t1: f64) -> Vec<f64> {
        let mut found = Vec::new();
        for channel in self
            .drivers
            .iter()
            .flatten()
            .flatten()
            .map(|&c| &scene.channels[c])
        {
            let period = f64::from(channel.period);
            let loops = period > 0.0;
            let base = if loops {
                (t0 / period).floor() * period
            } else {
                0.0
            };
            let begin = t0 - base;
            let first = channel.times.partition_point(|&k| f64::from(k) <= begin);
            for &key in &channel.times[first..] {
                if base + f64::from(key) >= t1 || (loops && f64::from(key) >= period) {
                    break;
                }
                found.push(base + f64::from(key));
            }
            if loops && base + period > t0 && base + period < t1 {
                found.push(base + period);
            }
        }
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    }
}

fn slot(track: &Track) -> usize {
    match track {
        Track::Translation(_) => 0,
        Track::Rotation(_) => 1,
        Track::Scale(_) => 2,
    }
}

fn channel_varies(channel: &Channel) -> bool {
    // Spline tangents count: equal values with a tangent between them still move.
    let spline = channel.interpolation == Interpolation::CubicSpline;
    match &channel.track {
        Track::Translation(v) | Track::Scale(v) => {
            v.windows(2).any(|w| w[0] != w[1]) && !(spline && still(v, Vec3::ZERO))
        }
        Track::Rotation(v) => {
            v.windows(2).any(|w| w[0] != w[1])
                && !(spline && still(v, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)))
        }
    }
}

/// Whether all spline values are equal and all tangents zero.
fn still<T: PartialEq + Copy>(v: &[T], zero: T) -> bool {
    v.chunks_exact(3)
        .all(|k| k[0] == zero && k[2] == zero && k[1] == v[1])
}

/// A place on the time axis of a channel: between keys `from` and `from + 1`.
struct Place {
    from: usize,
    /// 0..1 from key to key.
    s: f32,
    /// Seconds between the keys.
    span: f32,
}

/// `None` without keys. Times before the first and after the last key hold those.
fn place(channel: &Channel, t: f64) -> Option<Place> {
    let period = f64::from(channel.period);
    let t = if period > 0.0 {
        t.rem_euclid(period)
    } else {
        t
    };
    let times = &channel.times;
    let after = times.partition_point(|&k| f64::from(k) <= t);
    if times.is_empty() {
        None
    } else if after == 0 || after == times.len() {
        Some(Place {
            from: after.saturating_sub(1),
            s: 0.0,
            span: 0.0,
        })
    } else {
        let (a, b) = (f64::from(times[after - 1]), f64::from(times[after]));
        Some(Place {
            from: after - 1,
            s: ((t - a) / (b - a)) as f32,
            span: (b - a) as f32,
        })
    }
}

/// Hermite weights (out-tangents scaled by the span): value, out-tangent, next value, next
/// in-tangent.
fn hermite(p: &Place) -> [f32; 4] {
    let (s, s2, s3) = (p.s, p.s * p.s, p.s * p.s * p.s);
    [
        2.0 * s3 - 3.0 * s2 + 1.0,
        p.span * (s3 - 2.0 * s2 + s),
        -2.0 * s3 + 3.0 * s2,
        p.span * (s3 - s2),
    ]
}

fn vector_at(channel: &Channel, t: f64) -> Option<Vec3> {
    let (Track::Translation(v) | Track::Scale(v)) = &channel.track else {
        return None;
    };
    let p = place(channel, t)?;
    let still = p.span <= 0.0;
    match channel.interpolation {
        Interpolation::Step => v.get(p.from).copied(),
        Interpolation::Linear if still => v.get(p.from).copied(),
        Interpolation::Linear => Some(v.get(p.from)?.lerp(*v.get(p.from + 1)?, p.s)),
        Interpolation::CubicSpline if still => v.get(3 * p.from + 1).copied(),
        Interpolation::CubicSpline => {
            let w = hermite(&p);
            let k = v.get(3 * p.from..3 * p.from + 6)?;
            Some(k[1] * w[0] + k[2] * w[1] + k[4] * w[2] + k[3] * w[3])
        }
    }
}

fn rotation_at(channel: &Channel, t: f64) -> Option<Quat> {
    let Track::Rotation(v) = &channel.track else {
        return None;
    };
    let p = place(channel, t)?;
    let still = p.span <= 0.0;
    match channel.interpolation {
        Interpolation::Step => v.get(p.from).copied(),
        Interpolation::Linear if still => v.get(p.from).copied(),
        Interpolation::Linear => Some(v.get(p.from)?.slerp(*v.get(p.from + 1)?, p.s)),
        Interpolation::CubicSpline if still => v.get(3 * p.from + 1).copied(),
        Interpolation::CubicSpline => {
            let w = hermite(&p);
            let k = v.get(3 * p.from..3 * p.from + 6)?;
            let q = k[1] * w[0] + k[2] * w[1] + k[4] * w[2] + k[3] * w[3];
            Some(if q.length_squared() > 1e-12 {
                q.normalize()
            } else {
                Quat::IDENTITY
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::model::Node;
    use std::f32::consts::TAU;

    fn one(track: Track, times: Vec<f32>, interpolation: Interpolation, period: f32) -> Scene {
        Scene {
            nodes: vec![
                Node::default(),
                Node {
                    parent: Some(0),
                    translation: Vec3::X,
                    ..Node::default()
                },
            ],
            channels: vec![Channel {
                node: 0,
                track,
                times,
                interpolation,
                period,
            }],
            ..Scene::default()
        }
    }

    #[test]
    fn a_wheel_turns_as_its_closed_form() {
        let keys = 9;
        let times: Vec<f32> = (0..keys).map(|i| i as f32 * 0.25).collect();
        let turns = (0..keys)
            .map(|i| Quat::from_rotation_y(TAU * i as f32 / (keys - 1) as f32))
            .collect();
        let scene = one(Track::Rotation(turns), times, Interpolation::Linear, 2.0);
        let animation = Animation::new(&scene);
        assert!(animation.moves(1) && animation.carrier(1) == Some(0));
        for i in 0..500 {
            let t = i as f64 * 0.0173 - 1.0;
            let angle = (t.rem_euclid(2.0) / 2.0) as f32 * TAU;
            let at = animation.world(&scene, 1, t).translation;
            let expected = Vec3::new(angle.cos(), 0.0, -angle.sin());
            assert!(
                (Vec3::from(at) - expected).length() < 1e-5,
                "{t}: {at} {expected}"
            );
        }
    }

    #[test]
    fn splines_follow_a_cubic_exactly() {
        // x(t) = t³ − 2t has these values and tangents at its keys.
        let f = |t: f32| Vec3::new(t * t * t - 2.0 * t, t, 1.0);
        let d = |t: f32| Vec3::new(3.0 * t * t - 2.0, 1.0, 0.0);
        let times = vec![0.0, 0.5, 2.0];
        let keys = times.iter().flat_map(|&t| [d(t), f(t), d(t)]).collect();
        let scene = one(
            Track::Translation(keys),
            times,
            Interpolation::CubicSpline,
            3.0,
        );
        let animation = Animation::new(&scene);
        for i in 0..=200 {
            let t = i as f32 * 0.01;
            let at = animation.world(&scene, 0, f64::from(t)).translation;
            assert!((Vec3::from(at) - f(t)).length() < 1e-5, "{t}");
        }
        // Held after the last key until the loop ends.
        let held = animation.world(&scene, 0, 2.9).translation;
        assert!((Vec3::from(held) - f(2.0)).length() < 1e-6);
    }

    #[test]
    fn steps_hold_and_linear_scales() {
        let v = vec![Vec3::ONE, Vec3::splat(3.0)];
        let scene = one(Track::Scale(v), vec![0.0, 1.0], Interpolation::Step, 2.0);
        let a = Animation::new(&scene);
        assert_eq!(a.world(&scene, 1, 0.999).translation.x, 1.0);
        assert_eq!(a.world(&scene, 1, 1.001).translation.x, 3.0);
        assert_eq!(a.world(&scene, 1, 2.001).translation.x, 1.0);
        assert_eq!(a.corners(&scene, 0.5, 2.5), [1.0, 2.0]);
        assert_eq!(a.corners(&scene, 1.0, 1.5), [] as [f64; 0]);
    }

    #[test]
    fn keys_that_are_equal_do_not_move() {
        let v = vec![Vec3::Y; 2];
        let scene = one(
            Track::Translation(v),
            vec![0.0, 1.0],
            Interpolation::Linear,
            1.0,
        );
        let a = Animation::new(&scene);
        assert!(!a.moves(0) && !a.moves(1));
        assert_eq!(
            a.world(&scene, 1, 0.3).translation,
            Vec3::new(1.0, 1.0, 0.0).into()
        );
    }

    #[test]
    fn evaluating_all_equals_one_by_one() {
        let v = vec![Vec3::ZERO, Vec3::splat(3.0)];
        let scene = one(
            Track::Translation(v),
            vec![0.0, 1.0],
            Interpolation::Linear,
            1.0,
        );
        let a = Animation::new(&scene);
        let mut all = Vec::new();
        for t in [0.0, 0.25, 0.7] {
            a.world_all(&scene, t, &mut all);
            for (n, pose) in all.iter().enumerate() {
                assert!(pose.abs_diff_eq(a.world(&scene, n, t), 1e-6));
            }
        }
    }
}
