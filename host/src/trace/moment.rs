//! Rays at one instant.

use glam::{Affine3A, Vec2, Vec3, Vec3A};
use obvhs::ray::{Ray, RayHit};
use unframed_wire::{SKY, Shares};

use super::camera::Camera;
use super::cone::{Cone, Footprint};
use super::epoch::{blend, blend_cameras, inverse_or_zero};
use super::geometry::{Attributes, Met, Spot};
use super::light::Place;
use super::shade::{Path, Shader, lifted};
use super::world::World;
use super::{Hit, Rays};
use crate::effects::care::{Care, Told};

/// A world at an instant. Making one costs a few nanoseconds: movers are placed when a ray
/// comes near them.
#[derive(Clone)]
pub struct Moment<'a> {
    pub(crate) world: &'a World,
    knot: usize,
    next: usize,
    f: f32,
    camera: Camera,
}

/// What a ray met, in world coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Struck {
    /// Ray parameter.
    pub(crate) t: f32,
    pub(crate) place: Vec3,
    /// In the coordinates of the object.
    pub(crate) local: Vec3,
    /// Unit normal of the triangle, towards where the ray came from.
    pub(crate) flat: Vec3,
    /// Unit interpolated normal, on the same side.
    pub(crate) smooth: Vec3,
    /// Whether the ray met the side from which the corners run counter-clockwise.
    pub(crate) front: bool,
    /// Texture coordinates, colour, material, object; the rest is in local coordinates.
    pub(crate) spot: Spot,
}

impl Struck {
    /// Where rays that leave on the near side start.
    pub(crate) fn clear(&self) -> Vec3 {
        lifted(self.place, self.flat)
    }
}

/// Which hierarchy a triangle is in.
#[derive(Clone, Copy)]
enum Part {
    Fixed,
    Skin,
    Mover(usize),
}

impl<'a> Moment<'a> {
    pub(crate) fn new(world: &'a World, t: f64) -> Self {
        let (knot, f) = world.epoch.locate(t);
        let next = (knot + 1).min(world.epoch.knots.len() - 1);
        let (a, b) = (&world.epoch.knots[knot], &world.epoch.knots[next]);
        let camera = blend_cameras(&a.camera, &b.camera, f);
        Self {
            world,
            knot,
            next,
            f,
            camera,
        }
    }

    /// The camera of the instant.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// A camera sample at pixel coordinates. `seed` decides where on the lens.
    #[must_use]
    pub fn look(&self, pixel: Vec2, seed: u32) -> Hit {
        self.look_with(pixel, seed, Care::default()).0
    }

    /// The same with care for effects, and what these told.
    #[must_use]
    pub fn look_with(&self, pixel: Vec2, seed: u32, care: Care) -> (Hit, Told) {
        clamped(self.look_unclamped(pixel, seed, care))
    }

    /// The same with linear light as it is estimated, which may be brighter than white: what
    /// averages to the truth.
    #[must_use]
    pub fn look_unclamped(&self, pixel: Vec2, seed: u32, care: Care) -> (Hit, Told) {
        let direction = self.camera.direction(pixel);
        if self.camera.aperture > 0.0 {
            self.look_through_lens(direction, seed, care)
        } else {
            self.sample(self.camera.eye, direction, seed, care)
        }
    }

    /// A sample along a ray from the eye (a pinhole, whatever the lens); `direction` need not
    /// have unit length.
    #[must_use]
    pub fn look_along(&self, direction: Vec3, seed: u32) -> Hit {
        self.look_along_with(direction, seed, Care::default()).0
    }

    /// The same with care for effects, and what these told.
    #[must_use]
    pub fn look_along_with(&self, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        clamped(self.sample(self.camera.eye, direction, seed, care))
    }

    /// Thin lens (Cook, Porter and Carpenter 1984, §4.1). The hit is reported on the ray through
    /// the centre, at the depth found, so that it projects to its own pixel.
    fn look_through_lens(&self, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        let [u, v] = unit_square(seed);
        let (r, angle) = (self.camera.aperture * u.sqrt(), std::f32::consts::TAU * v);
        let offset = self.camera.right * (r * angle.cos()) + self.camera.down * (r * angle.sin());
        let (mut hit, told) = self.sample(
            self.camera.eye + offset,
            direction - offset / self.camera.focus.max(1e-3),
            seed,
            care,
        );
        if hit.object == SKY {
            hit.local = direction.normalize();
        } else {
            let at = self.camera.eye + direction * hit.depth;
            hit.local = match usize::from(hit.object).checked_sub(1) {
                Some(i) => self
                    .inverse(self.world.object_frames[i])
                    .transform_point3(at),
                None => at,
            };
        }
        (hit, told)
    }

    fn sample(&self, origin: Vec3, direction: Vec3, seed: u32, care: Care) -> (Hit, Told) {
        // The seeds of a pattern are meant as they are.
        let scrambled = if care.pattern {
            seed
        } else {
            seed ^ scramble(direction)
        };
        let mut shader = Shader::new(self, scrambled, care);
        shader.rays = Rays {
            primary: 1,
            ..Rays::default()
        };
        let along = self.camera.forward.dot(direction);
        let hit = match self.closest(origin, direction) {
            Some(struck) => {
                let length = direction.length();
                let path = Path {
                    direction: direction / length,
                    cone: Cone::of_pixel(&self.camera, along / length).after(struck.t * length),
                    bounces: 0,
                    weight: Vec3::ONE,
                };
                let colour = shader.radiance(&struck, &path);
                let shares = shader.shares(colour);
                let end = struck.t * length;
                let colour = shader.through_medium(origin, path.direction, end, colour, Vec3::ONE);
                Hit {
                    colour,
                    object: struck.spot.object,
                    local: struck.local,
                    depth: struck.t * along,
                    rays: shader.rays,
                    shares,
                }
            }
            None => {
                let direction = direction.normalize();
                let sky = shader.sky(direction);
                let end = f32::INFINITY;
                let colour = shader.through_medium(origin, direction, end, sky, Vec3::ONE);
                Hit {
                    colour,
                    object: SKY,
                    local: direction,
                    depth: f32::INFINITY,
                    rays: shader.rays,
                    shares: Shares::default(),
                }
            }
        };
        (hit, shader.told)
    }

    /// From an object's own coordinates to the world; identity for the static world, a translation to the
    /// eye for the sky.
    pub(crate) fn pose(&self, object: u8) -> Affine3A {
        if object == SKY {
            return Affine3A::from_translation(self.camera.eye);
        }
        usize::from(object)
            .checked_sub(1)
            .and_then(|i| self.world.object_frames.get(i))
            .map_or(Affine3A::IDENTITY, |&frame| {
                inverse_or_zero(&self.inverse(frame))
            })
    }

    /// Place of a lamp.
    pub(crate) fn lamp(&self, i: usize) -> Place {
        let knots = &self.world.epoch.knots;
        knots[self.knot].lamps[i].lerp(&knots[self.next].lamps[i], self.f)
    }

    /// Pose of an area light's node.
    pub(crate) fn lamp_pose(&self, i: usize) -> Affine3A {
        let knots = &self.world.epoch.knots;
        blend(
            &knots[self.knot].lamp_poses[i],
            &knots[self.next].lamp_poses[i],
            self.f,
        )
    }

    /// World to frame.
    fn inverse(&self, frame: usize) -> Affine3A {
        let knots = &self.world.epoch.knots;
        blend(
            &knots[self.knot].inverses[frame],
            &knots[self.next].inverses[frame],
            self.f,
        )
    }

    /// The nearest surface that stops light.
    pub(crate) fn closest(&self, origin: Vec3, direction: Vec3) -> Option<Struck> {
        self.closest_within(origin, direction, f32::INFINITY)
    }

    /// The same before `origin + direction·tmax`.
    pub(crate) fn closest_within(
        &self,
        origin: Vec3,
        direction: Vec3,
        tmax: f32,
    ) -> Option<Struck> {
        let world = self.world;
        let mut ray = Ray::new(origin.into(), direction.into(), 0.0, tmax);
        let stops = |a: &Attributes, uv: Vec2| self.opaque(a, uv);
        let mut best: Option<(Part, Met)> = None;
        if let Some(met) = world.fixed.closest(ray, stops) {
            ray.tmax = met.t;
            best = Some((Part::Fixed, met));
        }
        if let Some(met) = world.skin.closest(ray, stops) {
            ray.tmax = met.t;
            best = Some((Part::Skin, met));
        }
        self.near_movers(ray, |ray, mover| {
            let met = world.movers[mover].closest(self.to_frame(mover, ray), stops);
            met.map_or(f32::INFINITY, |met| {
                best = Some((Part::Mover(mover), met));
                met.t
            })
        });
        let (part, met) = best?;
        ray.tmax = f32::INFINITY;
        Some(match part {
            Part::Fixed => self.struck(world.fixed.surface(&ray, met), met.t, direction, None),
            Part::Skin => self.struck(world.skin.surface(&ray, met), met.t, direction, None),
            Part::Mover(m) => {
                let spot = world.movers[m].surface(&self.to_frame(m, &ray), met);
                self.struck(spot, met.t, direction, Some(self.inverse(m)))
            }
        })
    }

    /// Whether anything that casts a shadow lies between `origin` and `origin + direction·tmax`.
    pub(crate) fn blocked(&self, origin: Vec3, direction: Vec3, tmax: f32) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, tmax);
        self.stopped(ray, |a, uv| self.shadows(a, uv), |_| false)
    }

    /// The same but for movers whose shadows are left to the display; those of `object` are its own.
    pub(crate) fn blocked_for_good(
        &self,
        origin: Vec3,
        direction: Vec3,
        tmax: f32,
        object: u8,
    ) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, tmax);
        let frames = &self.world.object_frames;
        let own = usize::from(object)
            .checked_sub(1)
            .and_then(|i| frames.get(i));
        let casters = &self.world.casters;
        let left = |mover| casters.contains(mover) && own != Some(&mover);
        self.stopped(ray, |a, uv| self.shadows(a, uv), left)
    }

    /// Whether nothing that could be seen lies between the eye and `end` times `way` from it
    /// (`end` may be infinite).
    #[must_use]
    pub fn is_clear(&self, way: Vec3, end: f32) -> bool {
        let ray = Ray::new(self.camera.eye.into(), way.into(), 0.0, end);
        !self.stopped(ray, |a, uv| self.opaque(a, uv), |_| false)
    }

    /// Whether a ray meets anything that `stops` it, of movers only those that are not `left` out.
    #[inline]
    fn stopped(
        &self,
        ray: Ray,
        stops: impl Fn(&Attributes, Vec2) -> bool,
        left: impl Fn(usize) -> bool,
    ) -> bool {
        let world = self.world;
        if world.fixed.blocked(ray, &stops) || world.skin.blocked(ray, &stops) {
            return true;
        }
        let mut blocked = false;
        self.near_movers(ray, |ray, mover| {
            blocked = blocked
                || !left(mover) && world.movers[mover].blocked(self.to_frame(mover, ray), &stops);
            // Nothing beyond matters once something is in the way.
            if blocked { ray.tmin } else { f32::INFINITY }
        });
        blocked
    }

    /// Calls `visit` for each mover whose swept box the ray crosses before its end, which is
    /// drawn in to what `visit` returns.
    fn near_movers(&self, mut ray: Ray, mut visit: impl FnMut(&Ray, usize) -> f32) {
        let epoch = &self.world.epoch;
        if let Some(tree) = &epoch.tree {
            tree.ray_traverse(ray, &mut RayHit::none(), |ray, i| {
                visit(
                    ray,
                    epoch.swept[tree.primitive_indices[i] as usize].0 as usize,
                )
            });
        } else {
            for (mover, swept) in &epoch.swept {
                if swept.intersect_ray(&ray) < ray.tmax {
                    ray.tmax = ray.tmax.min(visit(&ray, *mover as usize));
                }
            }
        }
    }

    /// The ray in a frame; ray parameters stay the same.
    #[inline]
    fn to_frame(&self, frame: usize, ray: &Ray) -> Ray {
        let inverse = self.inverse(frame);
        Ray::new(
            inverse.transform_point3a(ray.origin),
            inverse.matrix3 * ray.direction,
            ray.tmin,
            ray.tmax,
        )
    }

    fn struck(&self, spot: Spot, t: f32, direction: Vec3, inverse: Option<Affine3A>) -> Struck {
        let (place, local, to_world) = match inverse {
            Some(inverse) => (
                inverse.inverse().transform_point3(spot.place),
                spot.place,
                inverse.matrix3,
            ),
            None => {
                let frame = usize::from(spot.object).checked_sub(1);
                let local = frame.map_or(spot.place, |i| {
                    self.inverse(self.world.object_frames[i])
                        .transform_point3(spot.place)
                });
                (spot.place, local, glam::Mat3A::IDENTITY)
            }
        };
        // Normals go by the transposed inverse.
        let normals = to_world.transpose();
        let mut spot = spot;
        spot.gradients = spot.gradients.map(|g| (normals * Vec3A::from(g)).into());
        if spot.curvature != 0.0 {
            spot.curvature *= to_world.determinant().abs().cbrt();
        }
        let flat: Vec3 = (normals * Vec3A::from(spot.flat))
            .normalize_or(Vec3A::Y)
            .into();
        let smooth: Vec3 = (normals * Vec3A::from(spot.smooth))
            .normalize_or(flat.into())
            .into();
        let front = flat.dot(direction) < 0.0;
        let flat = if front { flat } else { -flat };
        let smooth = if smooth.dot(flat) < 0.0 {
            -smooth
        } else {
            smooth
        };
        Struck {
            t,
            place,
            local,
            flat,
            smooth,
            front,
            spot,
        }
    }

    fn opaque(&self, a: &Attributes, uv: Vec2) -> bool {
        let material = &self.world.scene.materials[a.material as usize];
        let Some(cutoff) = material.alpha_cutoff else {
            return true;
        };
        let texture = material.base_texture.as_ref();
        let textures = &self.world.scene.textures;
        let opacity = texture.map_or(1.0, |t| {
            self.world
                .sampler
                .sample(textures, t, &Footprint::point(uv))
                .w
        });
        opacity * material.base_colour.w >= cutoff
    }

    fn shadows(&self, a: &Attributes, uv: Vec2) -> bool {
        let material = &self.world.scene.materials[a.material as usize];
        material.transmission < 0.5
            && !self.world.glowing[a.material as usize]
            && self.opaque(a, uv)
    }
}

/// A hit as it can be displayed.
fn clamped((mut hit, told): (Hit, Told)) -> (Hit, Told) {
    hit.colour = hit.colour.clamp(Vec3::ZERO, Vec3::ONE);
    (hit, told)
}

/// Bits of a direction, so that rays with the same seed differ.
pub(crate) fn scramble(direction: Vec3) -> u32 {
    let [x, y, z] = direction.to_array().map(f32::to_bits);
    x ^ y.rotate_left(11).wrapping_mul(0x9e37_79b1) ^ z.rotate_left(21).wrapping_mul(0x85eb_ca77)
}

/// Two independent numbers in 0..1 (PCG output permutation, O'Neill 2014).
pub(crate) fn unit_square(seed: u32) -> [f32; 2] {
    let hash = |x: u32| {
        let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    let first = hash(seed);
    [first, hash(first ^ 0x9e37_79b9)].map(|h| (h >> 8) as f32 / 16_777_216.0)
}
