//! A small analytic scene for the tests of the samplers: a wall with a checker, a panel in it
//! whose brightness changes at a known rate, a moving disc before it, and the sky around.

use glam::{Affine3A, UVec2, Vec2, Vec3};
use unframed_wire::SKY;

use super::Eye;
use crate::trace::camera::Camera;
use crate::trace::{Hit, Rays};

/// Depth of the wall, metres.
pub(super) const WALL: f32 = 4.0;
/// Depth of the disc (object 1), metres.
pub(super) const DISC: f32 = 2.0;
/// The panel's side half, metres.
pub(super) const PANEL: f32 = 1.5;

/// The scene and its knobs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    pub(super) size: UVec2,
    /// Metres a second, to the right.
    pub(super) camera_speed: f32,
    /// Metres a second, to the right; the disc stands at x = −1 at time 0.
    pub(super) disc_speed: f32,
    /// Change of the panel's displayed colour, levels (of 255) a second, a triangle wave.
    pub(super) panel_rate: f32,
    /// Side of a checker square, metres; 0 is a plain wall.
    pub(super) checker: f32,
    /// From this instant on the wall and the disc stand at half their depth and are red.
    pub(super) swap: f64,
}

impl Stage {
    pub(super) fn new(size: UVec2) -> Self {
        Self {
            size,
            camera_speed: 0.0,
            disc_speed: 0.0,
            panel_rate: 0.0,
            checker: 0.5,
            swap: f64::INFINITY,
        }
    }

    fn disc_x(&self, time: f64) -> f32 {
        -1.0 + self.disc_speed * time as f32
    }

    /// The displayed level of the panel.
    pub(super) fn panel_level(&self, time: f64) -> f32 {
        let phase = (f64::from(self.panel_rate) * time).rem_euclid(400.0) as f32;
        30.0 + if phase < 200.0 { phase } else { 400.0 - phase }
    }

    fn linear(level: f32) -> f32 {
        let x = level / 255.0;
        if x <= 0.040_45 {
            x / 12.92
        } else {
            ((x + 0.055) / 1.055).powf(2.4)
        }
    }

    fn hit(&self, time: f64, eye: Vec3, direction: Vec3) -> Hit {
        let swapped = time >= self.swap;
        let near = if swapped { 0.5 } else { 1.0 };
        let rays = Rays {
            primary: 1,
            ..Rays::default()
        };
        let tint = |level: f32| {
            let c = Vec3::splat(Self::linear(level));
            if swapped { c * Vec3::X } else { c }
        };
        let disc = eye + direction * DISC * near - Vec3::X * self.disc_x(time);
        if disc.truncate().length() < 0.4 {
            let level = if disc.x * disc.y > 0.0 { 200.0 } else { 60.0 };
            let depth = DISC * near;
            return Hit {
                colour: tint(level),
                object: 1,
                local: disc,
                depth,
                rays,
                shares: unframed_wire::Shares::default(),
            };
        }
        let wall = eye + direction * WALL * near;
        if wall.truncate().abs().max_element() < 3.0 {
            let odd = |x: f32| (x / self.checker).floor() as i32 & 1;
            let level = if wall.truncate().abs().max_element() < PANEL {
                self.panel_level(time)
            } else if self.checker > 0.0 && odd(wall.x) ^ odd(wall.y) == 1 {
                220.0
            } else {
                120.0
            };
            return Hit {
                colour: tint(level),
                object: 0,
                local: wall,
                depth: WALL * near,
                rays,
                shares: unframed_wire::Shares::default(),
            };
        }
        let local = direction.normalize();
        Hit {
            colour: tint(20.0),
            object: SKY,
            local,
            depth: f32::INFINITY,
            rays,
            shares: unframed_wire::Shares::default(),
        }
    }
}

impl Eye for Stage {
    fn camera(&self, time: f64) -> Camera {
        Camera {
            eye: Vec3::X * (self.camera_speed * time as f32),
            right: Vec3::X,
            down: Vec3::Y,
            forward: Vec3::Z,
            focal: self.size.y as f32,
            centre: self.size.as_vec2() * 0.5,
            aperture: 0.0,
            focus: 1.0,
        }
    }

    fn pose(&self, object: u8, time: f64) -> Affine3A {
        match object {
            0 => Affine3A::IDENTITY,
            SKY => Affine3A::from_translation(self.camera(time).eye),
            _ => Affine3A::from_translation(Vec3::X * self.disc_x(time)),
        }
    }

    fn look(&self, time: f64, pixel: Vec2, seed: u32) -> Hit {
        self.look_along(time, self.camera(time).direction(pixel), seed)
    }

    fn look_along(&self, time: f64, direction: Vec3, _seed: u32) -> Hit {
        self.hit(time, self.camera(time).eye, direction)
    }
}
