//! What a host lets its sampler see: the world, from where the eye will be when it is shown.
//!
//! Samples of a span appear at its end. Seen from where the eye is at each instant, what the eye uncovers meanwhile
//! has hardly been looked at by then. So the view of the end is predicted at the beginning, from what it did before
//! (as head-mounted displays do; Azuma & Bishop 1995, *A frequency-domain analysis of head-motion
//! prediction*), and all samples of the span look from there. Where the view turns out
//! not to go there, as at a cut, samples look from where it is.

use glam::{Affine3A, Mat3, Quat, Vec2, Vec3};
use unframed_wire::SKY;

use crate::effects::care::{Care, Told};
use crate::sampler::{Eye, SEEN};
use crate::trace::camera::Camera;
use crate::trace::{Hit, Moment, World};

/// A view turns by no more than this between two instants of a span, or it jumps; radians.
const TURN: f32 = 0.35;
/// A view's speed grows by no more than this factor from one span to the next, or it jumps.
const FASTER: f32 = 4.0;
/// A view that is off its prediction by more than this share of the way is not where it was to be.
const OFF: f32 = 0.5;

/// The view at the end of a span, predicted at its beginning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead {
    from: Camera,
    to: Camera,
    t0: f64,
    t1: f64,
}

impl Ahead {
    /// Goes on as from `views[0]` to `views[1]` to `views[2]`, which are as far apart as `t0` and `t1`,
    /// the last of them at `t0`. A view that jumped stays.
    pub(crate) fn predict(views: [&Camera; 3], t0: f64, t1: f64) -> Self {
        let [first, before, now] = views;
        let steps = [first.eye.distance(before.eye), before.eye.distance(now.eye)];
        let turn = turned(before, now);
        let near = (now.eye.length() + 1.0) * 1e-4;
        let jumps = steps[1] > FASTER * steps[0] + near
            || angle(turn) > TURN
            || angle(turn) > FASTER * angle(turned(first, before)) + 1e-3;
        let to = if jumps {
            *now
        } else {
            Camera {
                eye: now.eye + (now.eye - before.eye),
                right: turn * now.right,
                down: turn * now.down,
                forward: turn * now.forward,
                ..*now
            }
        };
        Self {
            from: *now,
            to,
            t0,
            t1,
        }
    }

    /// The view to look from at an instant at which it is `now`.
    fn view(&self, time: f64, now: &Camera) -> Camera {
        let part = ((time - self.t0) / (self.t1 - self.t0)) as f32;
        let due = self.from.eye.lerp(self.to.eye, part);
        let way = self.from.eye.distance(self.to.eye);
        let near = (now.eye.length() + 1.0) * 1e-4;
        let whole = angle(turned(&self.from, &self.to));
        let axis = self.from.forward.lerp(self.to.forward, part);
        let aside = axis.angle_between(now.forward);
        if due.distance(now.eye) > OFF * way + near || aside > OFF * whole + 1e-3 {
            *now
        } else {
            self.to
        }
    }
}

/// The turn from one view to another.
fn turned(a: &Camera, b: &Camera) -> Quat {
    let axes = |c: &Camera| Mat3::from_cols(c.right, c.down, c.forward);
    Quat::from_mat3(&(axes(b) * axes(a).transpose())).normalize()
}

/// The angle of a turn, radians.
fn angle(turn: Quat) -> f32 {
    // Not by the cosine, which tells small turns from none only down to 3e-4.
    2.0 * Vec3::new(turn.x, turn.y, turn.z).length().min(1.0).asin()
}

/// A world as a sampler sees it.
#[derive(Clone, Copy)]
pub(crate) struct Gaze<'a> {
    pub(crate) world: &'a World,
    /// Whether samples tell what they would be without shadows that the display draws.
    pub(crate) open: bool,
    pub(crate) ahead: Option<Ahead>,
}

impl Gaze<'_> {
    fn moment(&self, time: f64) -> Moment<'_> {
        let moment = self.world.moment(time);
        match &self.ahead {
            Some(ahead) => {
                let view = ahead.view(time, moment.camera());
                moment.seen_from(view)
            }
            None => moment,
        }
    }

    fn care(&self, care: Care) -> Care {
        Care {
            open: self.open,
            ..care
        }
    }
}

impl Eye for Gaze<'_> {
    fn camera(&self, time: f64) -> Camera {
        let now = self.world.camera(time);
        self.ahead.map_or(now, |ahead| ahead.view(time, &now))
    }

    fn pose(&self, object: u8, time: f64) -> Affine3A {
        if object == SKY {
            return Affine3A::from_translation(self.camera(time).eye);
        }
        self.world.pose(object, time)
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        self.look_with(time, pixel, seed, Care::default()).0
    }

    fn look_along(&self, time: f64, direction: Vec3, seed: u32) -> Hit {
        self.look_along_with(time, direction, seed, Care::default())
            .0
    }

    fn look_with(&self, time: f64, pixel: Vec2, seed: u32, care: Care) -> (Hit, Told) {
        self.moment(time).look_with(pixel, seed, self.care(care))
    }

    fn look_along_with(&self, time: f64, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        let care = self.care(care);
        self.moment(time).look_along_with(direction, seed, care)
    }

    fn sees(&self, time: f64, object: u8, local: Vec3) -> bool {
        let moment = self.moment(time);
        let camera = moment.camera();
        let offset = self.pose(object, time).transform_point3(local) - camera.eye;
        let end = if object == SKY { f32::INFINITY } else { SEEN };
        camera.project_direction(offset).is_some() && moment.is_clear(offset, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A view that turns and flies evenly, at an instant; it jumps at 1 s.
    fn view(t: f64) -> Camera {
        let far = if t >= 1.0 { 5.0 } else { 0.0 };
        let turn = Quat::from_rotation_y(0.8 * t as f32 + far) * Quat::from_rotation_x(0.2);
        Camera {
            eye: Vec3::new(1.2 * t as f32 + far, 1.0, -0.5 * t as f32),
            right: turn * Vec3::X,
            down: turn * Vec3::NEG_Y,
            forward: turn * Vec3::NEG_Z,
            focal: 200.0,
            centre: Vec2::splat(128.0),
            aperture: 0.0,
            focus: 1.0,
        }
    }

    const SPAN: f64 = 1.0 / 60.0;

    fn ahead(t0: f64) -> Ahead {
        let views = [2.0, 1.0, 0.0].map(|spans| view(t0 - spans * SPAN));
        Ahead::predict([&views[0], &views[1], &views[2]], t0, t0 + SPAN)
    }

    fn off(a: &Camera, b: &Camera) -> f32 {
        a.eye.distance(b.eye) + a.forward.distance(b.forward) + a.right.distance(b.right)
    }

    #[test]
    fn an_even_motion_is_predicted() {
        let ahead = ahead(0.5);
        for part in [0.0, 0.3, 0.7, 1.0] {
            let t = 0.5 + part * SPAN;
            let seen = ahead.view(t, &view(t));
            assert!(off(&seen, &view(0.5 + SPAN)) < 1e-4, "at {part}");
        }
        assert!(off(&view(0.5), &view(0.5 + SPAN)) > 0.02, "it moves");
    }

    #[test]
    fn a_view_that_jumped_is_where_it_is() {
        // Before the beginning, between the views that are known.
        let t0 = 1.0 + 0.5 * SPAN;
        assert!(off(&ahead(t0).view(t0, &view(t0)), &view(t0)) < 1e-4);
        // Within the span.
        let t0 = 1.0 - 0.5 * SPAN;
        let ahead = ahead(t0);
        let before = t0 + 0.2 * SPAN;
        assert!(off(&ahead.view(before, &view(before)), &ahead.to) < 1e-6);
        let after = t0 + 0.7 * SPAN;
        assert!(off(&ahead.view(after, &view(after)), &view(after)) < 1e-6);
    }

    #[test]
    fn a_view_at_rest_stays() {
        let now = view(0.3);
        let ahead = Ahead::predict([&now, &now, &now], 0.3, 0.3 + SPAN);
        assert!(off(&ahead.view(0.31, &now), &now) < 1e-6);
    }
}
