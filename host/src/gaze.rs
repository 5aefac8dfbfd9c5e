//! What a host lets its sampler see: the world as it is, or as it will be when it is shown.
//!
//! Samples of a span appear at its end. Seen from where the eye is at each instant, what the eye or a thing that
//! moves uncovers meanwhile has hardly been looked at by then, and light has moved on. So for a sampler that looks ahead the
//! world stands all the span as it is foreseen at the beginning to stand at the end
//! ([`World::foresee`]), and samples bear the time of the end, of which they tell.

use glam::{Affine3A, Vec2, Vec3};
use unframed_wire::SKY;

use crate::effects::care::{Care, Told};
use crate::sampler::{Eye, SEEN};
use crate::trace::camera::Camera;
use crate::trace::{Hit, World};

/// A world as a sampler sees it; it has been prepared accordingly.
#[derive(Clone, Copy)]
pub(crate) struct Gaze<'a> {
    pub(crate) world: &'a World,
    /// Whether samples tell what they would be without shadows that the display draws.
    pub(crate) open: bool,
    /// The end of the span, seconds, if it is foreseen.
    pub(crate) ahead: Option<f64>,
}

impl Gaze<'_> {
    fn care(&self, care: Care) -> Care {
        Care {
            open: self.open,
            ..care
        }
    }
}

impl Eye for Gaze<'_> {
    fn camera(&self, time: f64) -> Camera {
        match self.ahead {
            Some(_) => *self.world.moment(time).camera(),
            None => self.world.camera(time),
        }
    }

    fn pose(&self, object: u8, time: f64) -> Affine3A {
        match self.ahead {
            Some(_) => self.world.moment(time).pose(object),
            None => self.world.pose(object, time),
        }
    }

    fn as_of(&self, time: f64) -> f64 {
        self.ahead.unwrap_or(time)
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        self.look_with(time, pixel, seed, Care::default()).0
    }

    fn look_along(&self, time: f64, direction: Vec3, seed: u32) -> Hit {
        self.look_along_with(time, direction, seed, Care::default())
            .0
    }

    fn look_with(&self, time: f64, pixel: Vec2, seed: u32, care: Care) -> (Hit, Told) {
        self.world
            .moment(time)
            .look_with(pixel, seed, self.care(care))
    }

    fn look_along_with(&self, time: f64, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        let care = self.care(care);
        self.world
            .moment(time)
            .look_along_with(direction, seed, care)
    }

    fn sees(&self, time: f64, object: u8, local: Vec3) -> bool {
        let moment = self.world.moment(time);
        let camera = moment.camera();
        let offset = self.pose(object, time).transform_point3(local) - camera.eye;
        let end = if object == SKY { f32::INFINITY } else { SEEN };
        camera.project_direction(offset).is_some() && moment.is_clear(offset, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::builtin;

    const SPAN: f64 = 1.0 / 60.0;

    /// How far from where they were seen hits lie at the end of a span, pixels, sorted: what moves,
    /// what stands still.
    fn astray(name: &str, foreseen: bool) -> [Vec<f32>; 2] {
        let scene = builtin(name).expect("a built-in scene");
        let mut world = World::new(scene, [64, 64]).expect("a sound scene");
        let mut found = [Vec::new(), Vec::new()];
        for k in 0..12 {
            let t0 = 0.31 + 0.4 * f64::from(k);
            let t1 = t0 + SPAN;
            if foreseen {
                world.foresee(t0, t1);
            } else {
                world.prepare(t0, t1);
            }
            let gaze = Gaze {
                world: &world,
                open: false,
                ahead: foreseen.then_some(t1),
            };
            let time = t0 + 0.3 * SPAN;
            assert_eq!(gaze.as_of(time), if foreseen { t1 } else { time });
            for i in 0..64 * 64 {
                let pixel = Vec2::new((i % 64) as f32, (i / 64) as f32) + 0.5;
                let hit = gaze.look(time, pixel, i);
                let then = world.pose(hit.object, t1).transform_point3(hit.local);
                let camera = world.camera(t1);
                if let Some((at, _)) = camera.project_direction(then - camera.eye) {
                    let moves = hit.object != 0 && hit.object != SKY;
                    found[usize::from(!moves)].push(at.distance(pixel));
                }
            }
        }
        found.iter_mut().for_each(|all| all.sort_by(f32::total_cmp));
        found
    }

    fn most(sorted: &[f32]) -> f32 {
        sorted[sorted.len() * 99 / 100]
    }

    #[test]
    fn samples_are_right_at_the_end_of_their_span() {
        for name in ["interactive", "walkthrough", "toycar"] {
            let foreseen = astray(name, true).map(|all| most(&all));
            let present = astray(name, false).map(|all| most(&all));
            println!("{name}: {foreseen:?} px, as they are {present:?} px");
            let moved = present[0].max(present[1]);
            assert!(moved > 0.2, "{name}: {moved} px");
            assert!(
                foreseen.iter().all(|off| *off < 0.3 * moved),
                "{name}: {foreseen:?} px of {moved}"
            );
        }
    }

    #[test]
    fn what_is_foreseen_is_where_it_is_said_to_be() {
        let scene = builtin("toycar").expect("a built-in scene");
        let mut world = World::new(scene, [64, 64]).expect("a sound scene");
        world.foresee(1.0, 1.0 + SPAN);
        let gaze = Gaze {
            world: &world,
            open: false,
            ahead: Some(1.0 + SPAN),
        };
        let mut movers = 0;
        for i in 0..64 * 64 {
            let pixel = Vec2::new((i % 64) as f32, (i / 64) as f32) + 0.5;
            let hit = gaze.look(1.0, pixel, i);
            let camera = gaze.camera(1.0);
            let place = gaze.pose(hit.object, 1.0).transform_point3(hit.local);
            let (at, _) = camera
                .project_direction(place - camera.eye)
                .expect("before the eye");
            assert!(at.distance(pixel) < 0.02, "{at} {pixel}");
            movers += usize::from(hit.object != 0 && hit.object != SKY);
        }
        assert!(movers > 30);
    }
}
