//! Where the nodes will be: motion of the last four milliseconds, continued.
//!
//! Samples are shown some milliseconds after they were taken. A renderer that wants them to be right then
//! has to know the scene of then, and all it has is the past: as head-mounted displays do with the view (Azuma &
//! Bishop 1995, *A frequency-domain analysis of head-motion prediction*), each node's translation,
//! rotation and scale go on at the speed that they had, which goes on to grow as it did. They do so relative to the parent, so that a
//! wheel that spins evenly on a car that drives evenly is foreseen exactly. Nothing after the instant of
//! knowledge is looked at.

use glam::{Affine3A, Quat, Vec3};

use super::animate::{Animation, Parts};
use super::model::Scene;

/// Over how long speed is measured, seconds: as short as f32 allows, for what accelerates is then off
/// by least.
const STEP: f64 = 1e-3;
/// Speed grows by no more than this factor within a step, or it was a jump and nothing is continued.
const FASTER: f32 = 4.0;
/// So much of its distance from the origin (at least 1 m) may a node move in a step out of rest, and so much may it turn, radians.
const START: f32 = 1e-4;
const START_TURN: f32 = 1e-3;

impl Animation {
    /// All transforms to the world at `until`, as foreseen at `now` (seconds). With `poses` filled by an earlier
    /// call only the nodes that move are evaluated.
    pub fn foresee_all(&self, scene: &Scene, now: f64, until: f64, poses: &mut Vec<Affine3A>) {
        let steps = ((until - now) / STEP).max(0.0) as f32;
        let local = |node: usize| {
            let parts =
                [4.0, 3.0, 2.0, 1.0, 0.0].map(|back| self.parts(scene, node, now - back * STEP));
            Parts {
                scale: continued(parts.map(|p| p.scale), steps),
                rotation: turned(parts.map(|p| p.rotation), steps),
                translation: continued(parts.map(|p| p.translation), steps),
            }
            .transform()
        };
        let varying = |node: usize| {
            if self.varies(node) {
                local(node)
            } else {
                self.local(scene, node, now)
            }
        };
        self.compose(scene, varying, poses);
    }
}

/// By how much a value changes in `steps` after its last four steps; `None` after a jump.
///
/// Speed goes on to grow as it did, by the least of the last three of its changes and not at all where they
/// differ in sign: a corner of a motion changes two of them, and is no push that lasts.
fn way(changes: [Vec3; 4], steps: f32, start: f32) -> Option<Vec3> {
    let [.., before, last] = changes;
    if last.length() > FASTER * before.length() + start {
        return None;
    }
    let growths = [0, 1, 2].map(|i| changes[i + 1] - changes[i]);
    let least = |[a, b, c]: [f32; 3]| {
        if a > 0.0 && b > 0.0 && c > 0.0 {
            a.min(b).min(c)
        } else if a < 0.0 && b < 0.0 && c < 0.0 {
            a.max(b).max(c)
        } else {
            0.0
        }
    };
    let growth = Vec3::new(
        least(growths.map(|g| g.x)),
        least(growths.map(|g| g.y)),
        least(growths.map(|g| g.z)),
    );
    Some(last * steps + growth * (0.5 * steps * (steps + 1.0)))
}

/// The last of five values a step apart, `steps` later. What stands still stays to the bit.
fn continued([a, b, c, d, last]: [Vec3; 5], steps: f32) -> Vec3 {
    let start = START * (last.length() + 1.0);
    match way([b - a, c - b, d - c, last - d], steps, start) {
        Some(way) if last != d => last + way,
        _ => last,
    }
}

/// The same for rotations.
fn turned([a, b, c, d, last]: [Quat; 5], steps: f32) -> Quat {
    if last == d {
        return last;
    }
    let turn = |from: Quat, to: Quat| {
        // The shorter way around.
        let to = if from.dot(to) < 0.0 { -to } else { to };
        (to * from.inverse()).to_scaled_axis()
    };
    let turns = [turn(a, b), turn(b, c), turn(c, d), turn(d, last)];
    match way(turns, steps, START_TURN) {
        Some(way) => (Quat::from_scaled_axis(way) * last).normalize(),
        None => last,
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use super::*;
    use crate::scene::builtin::builtin;

    /// How far the corners of a cube of 0.4 m go astray between two transforms, metres.
    fn astray(a: &Affine3A, b: &Affine3A) -> f32 {
        let corner = |i: i32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 0.4;
        (0..8)
            .map(|i| {
                let p = corner(i) - 0.2;
                a.transform_point3(p).distance(b.transform_point3(p))
            })
            .fold(0.0, f32::max)
    }

    /// Mean and greatest distance over a loop from what comes, of all nodes that move: foreseen,
    /// and as they are now.
    fn errors(name: &str, ahead: f64) -> [[f32; 2]; 2] {
        let scene = builtin(name).expect("a built-in scene");
        let animation = Animation::new(&scene);
        let (mut foreseen, mut now, mut then) = (Vec::new(), Vec::new(), Vec::new());
        let mut errors = [[0.0f32; 2]; 2];
        let mut count = 0.0;
        for i in 0..200 {
            let t = f64::from(i) * scene.duration / 200.0 + 0.0037;
            animation.foresee_all(&scene, t, t + ahead, &mut foreseen);
            animation.world_all(&scene, t, &mut now);
            animation.world_all(&scene, t + ahead, &mut then);
            for node in (0..scene.nodes.len()).filter(|&n| animation.moves(n)) {
                for (sums, poses) in errors.iter_mut().zip([&foreseen, &now]) {
                    let off = astray(&poses[node], &then[node]);
                    sums[0] += off;
                    sums[1] = sums[1].max(off);
                }
                count += 1.0;
            }
        }
        errors.map(|[sum, most]| [sum / count, most])
    }

    #[test]
    fn built_in_scenes_are_foreseen() {
        for name in ["interactive", "walkthrough", "toycar", "atelier"] {
            let [foreseen, now] = errors(name, 1.0 / 60.0);
            println!("{name}: {foreseen:?} m, as they were {now:?}");
            assert!(now[0] > 3e-3, "{name}: something moves");
            assert!(foreseen[0] < 0.1 * now[0], "{name}: {foreseen:?} {now:?}");
        }
    }

    #[test]
    fn the_present_is_what_it_is() {
        for name in ["interactive", "toycar"] {
            let [foreseen, _] = errors(name, 0.0);
            assert!(foreseen[1] < 1e-6, "{name}: {foreseen:?}");
        }
    }

    #[test]
    fn even_motion_goes_on_and_rest_rests() {
        let at = |t: f32| Vec3::new(3.0 - 2.0 * t, 1.0, 0.5 * t);
        let steps = [-0.004, -0.003, -0.002, -0.001, 0.0].map(at);
        assert!(continued(steps, 16.0).distance(at(0.016)) < 1e-5);
        let spin = |t: f32| Quat::from_rotation_x(10.0 * TAU * t);
        let steps = [-0.004, -0.003, -0.002, -0.001, 0.0].map(spin);
        assert!(turned(steps, 16.0).angle_between(spin(0.016)) < 1e-3);
        // The same rotation with the other sign is no turn by 360°.
        let steps = [steps[0], steps[1], steps[2], -steps[3], steps[4]];
        assert!(turned(steps, 16.0).angle_between(spin(0.016)) < 1e-3);
        let place = at(0.3);
        assert_eq!(continued([place; 5], 16.0), place);
        let turn = spin(0.123);
        assert_eq!(turned([turn; 5], 16.0), turn);
    }

    #[test]
    fn a_jump_is_not_continued() {
        let far = Vec3::new(4.0, 0.0, 0.0);
        let slow = [0.0, 1e-3, 2e-3, 3e-3].map(|x| Vec3::X * x);
        let [a, b, c, d] = slow;
        assert_eq!(continued([a, b, c, d, far], 16.0), far, "a place");
        let round = Quat::from_rotation_y(2.0);
        let [a, b, c, d] = [0.0, 0.01, 0.02, 0.03].map(Quat::from_rotation_y);
        assert_eq!(turned([a, b, c, d, round], 16.0), round, "a turn");
    }

    #[test]
    fn what_falls_falls_faster_and_what_bounces_does_not_fly() {
        let fall = |t: f32| Vec3::new(0.0, 1.0 - 4.9 * t * t, 2.0 * t);
        let steps = [0.196, 0.197, 0.198, 0.199, 0.2].map(fall);
        assert!(continued(steps, 16.0).distance(fall(0.216)) < 2e-4);
        // It has just bounced: its speed has changed once, by a lot.
        let bounced = |t: f32| Vec3::Y * if t < 0.0 { -3.0 * t } else { 3.0 * t };
        for at in [0.0, 0.0004, 0.001, 0.0014, 0.002, 0.003] {
            let steps = [-0.004, -0.003, -0.002, -0.001, 0.0].map(|back| bounced(at + back));
            let off = continued(steps, 16.0).distance(bounced(at + 0.016));
            assert!(off < 0.1, "{off} m after {at} s");
        }
    }
}
