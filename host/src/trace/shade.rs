//! What light a surface sends back: direct light with its shadows, mirrors, glass, and the medium
//! on the way.
//!
//! Diffuse is Lambert's, highlights are GGX with the height-correlated Smith term (Heitz 2014)
//! and Schlick's Fresnel, as glTF 2.0 Appendix B describes. Mirrors and glass follow rays; both
//! choices of a glass surface are followed. Points on area lights and in the medium are random.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use unframed_wire::{LAMPS, Shares};

use super::Rays;
use super::cone::{Cone, Footprint};
use super::moment::{Moment, Struck};
use super::pattern::pattern;
use crate::effects::care::{Care, INDIRECT, MEDIUM, MOST, Points, Purpose, SOFT, Told};
use crate::effects::medium::Stretch;
use crate::scene::model::{MIRROR_ROUGHNESS, Material};

/// Most bounces of a path.
const MAX_BOUNCES: u32 = 4;
/// Contributions below this (linear; half an 8-bit step in the darks) are not worth a ray.
const NEGLIGIBLE: f32 = 1.0 / 2048.0;
/// Paths that carry less than this are cut.
const FAINT: f32 = 1.0 / 256.0;
/// Rougher dielectrics have no visible highlight.
const GLOSSY: f32 = 0.7;

/// Shades one camera sample.
pub(crate) struct Shader<'a> {
    moment: &'a Moment<'a>,
    /// Rays traced so far.
    pub(crate) rays: Rays,
    care: Care,
    /// Where effects that choose take their numbers from.
    points: Points,
    /// What the rays of effects brought so far.
    pub(crate) told: Told,
    /// What the lamps bring whose shadows the display draws, where the path met its first surface.
    brought: [Vec3; LAMPS],
    seed: u32,
}

/// How a ray came to a surface.
#[derive(Clone, Copy)]
pub(crate) struct Path {
    /// Unit direction of the ray.
    pub(crate) direction: Vec3,
    /// What the pixel sees, at the surface.
    pub(crate) cone: Cone,
    /// Mirrors and glass passed so far.
    pub(crate) bounces: u32,
    /// What the path so far lets through.
    pub(crate) weight: Vec3,
}

/// A surface's response to light at a place.
struct Response {
    albedo: Vec3,
    /// Reflectance along the normal.
    f0: Vec3,
    /// GGX α, or `None` without highlight.
    alpha: Option<f32>,
}

impl<'a> Shader<'a> {
    pub(crate) fn new(moment: &'a Moment<'a>, seed: u32, care: Care) -> Self {
        Self {
            moment,
            rays: Rays::default(),
            care,
            points: Points::new(seed, care.pattern),
            told: Told::default(),
            brought: [Vec3::ZERO; LAMPS],
            seed,
        }
    }

    /// What the lamps bring of a colour whose shadows the display draws, as it will be shown: of
    /// light beyond white a lamp may take much before anything is seen.
    pub(crate) fn shares(&self, colour: Vec3) -> Shares {
        if !self.care.open {
            return Shares::default();
        }
        let shown = |light: Vec3| light.clamp(Vec3::ZERO, Vec3::ONE);
        let [chance, _] = super::moment::unit_square(self.seed);
        Shares::new(self.brought.map(|light| {
            let (with, without) = (shown(colour), shown(colour - light));
            if light == Vec3::ZERO || with.max_element() <= 0.0 {
                return 0;
            }
            // Displays take tints into account as against green.
            let left = if with.y > FAINT {
                without.y / with.y
            } else {
                without.max_element() / with.max_element()
            };
            let most = f32::from(Shares::MAX);
            (most * (1.0 - left.clamp(0.0, 1.0).sqrt()) + chance) as u8
        }))
    }

    /// Radiance of the sky.
    pub(crate) fn sky(&self, direction: Vec3) -> Vec3 {
        let sky = &self.moment.world.scene.sky;
        sky.horizon.lerp(sky.zenith, direction.y.clamp(0.0, 1.0))
    }

    /// Radiance that a surface sends back along the path that met it.
    pub(crate) fn radiance(&mut self, struck: &Struck, path: &Path) -> Vec3 {
        let scene = &self.moment.world.scene;
        let material = &scene.materials[struck.spot.material as usize];
        let seen = seen_through(struck, path);
        let base = self.base(struck, material, &seen);
        if material.unlit {
            return base;
        }
        let (light, share) = self.own(struck, path, &seen, base);
        if share * path.weight.max_element() <= NEGLIGIBLE {
            return light;
        }
        let mirror = mirrors(material);
        let metallic = if mirror { 0.0 } else { material.metallic };
        let glossy = !mirror && (metallic > 0.0 || material.roughness < GLOSSY);
        let response = Response {
            albedo: base * (1.0 - metallic),
            f0: Vec3::splat(0.04).lerp(base, metallic),
            alpha: glossy.then(|| material.roughness.max(MIRROR_ROUGHNESS).powi(2)),
        };
        let open = self.care.open && path.bounces == 0;
        let direct = self.direct(struck, path.direction, &response, path.weight * share, open);
        if open {
            self.brought = self.brought.map(|light| light * share);
        }
        let ambient = if self.moment.indirect() {
            self.indirect(struck, path.weight * share * base)
        } else {
            scene.sky.ambient
        };
        light + (base * ambient + direct) * share
    }

    /// Diffuse reflectance at a place, and the light that does not come by it.
    pub(crate) fn split(&mut self, struck: &Struck, path: &Path) -> (Vec3, Vec3) {
        let scene = &self.moment.world.scene;
        let material = &scene.materials[struck.spot.material as usize];
        let seen = seen_through(struck, path);
        let base = self.base(struck, material, &seen);
        if material.unlit {
            return (Vec3::ZERO, base);
        }
        let (light, share) = self.own(struck, path, &seen, base);
        (diffuse(material, base) * share, light)
    }

    /// Diffuse reflectance where a path of diffuse bounces meets a surface.
    pub(crate) fn albedo(&self, struck: &Struck) -> Vec3 {
        let material = &self.moment.world.scene.materials[struck.spot.material as usize];
        if material.unlit {
            return Vec3::ZERO;
        }
        let base = self.base(struck, material, &Footprint::point(struck.spot.uv));
        let share = if mirrors(material) {
            1.0 - material.metallic
        } else {
            1.0 - material.transmission * (1.0 - material.metallic)
        };
        diffuse(material, base) * share
    }

    /// Irradiance/π from few virtual point lights for all.
    #[inline(never)]
    fn indirect(&mut self, struck: &Struck, weight: Vec3) -> Vec3 {
        let rays = self.care.of(INDIRECT);
        let (mut sum, mut brought) = (Vec3::ZERO, [0.0; MOST]);
        for (i, brought) in brought[..rays].iter_mut().enumerate() {
            let point = self.points.next(Purpose::Light, i);
            let vpls = &self.moment.world.vpls;
            let rays = &mut self.rays.indirect;
            let light = self.moment.virtual_light(vpls, struck, point, rays);
            *brought = luminance(light * weight);
            sum += light;
        }
        self.told.add(INDIRECT, &brought[..rays]);
        sum / rays as f32
    }

    /// Light that is not reflected diffusely: emission, mirror and glass; and the share that
    /// these leave for the lamps.
    fn own(&mut self, struck: &Struck, path: &Path, seen: &Footprint, base: Vec3) -> (Vec3, f32) {
        let scene = &self.moment.world.scene;
        let material = &scene.materials[struck.spot.material as usize];
        let mut light = if struck.front || material.double_sided {
            self.emitted(material, seen)
        } else {
            Vec3::ZERO
        };
        let mut share = 1.0;
        if mirrors(material) {
            let cos = -path.direction.dot(struck.smooth);
            let tint = schlick(base, cos) * material.metallic;
            self.rays.bounce += self.worth_following(path, tint);
            light += self.mirrored(struck, path, tint);
            share -= material.metallic;
        } else if material.transmission > 0.0 {
            let part = material.transmission * (1.0 - material.metallic);
            light += self.glass(struck, material, path, base * part);
            share -= part;
        }
        (light, share)
    }

    fn base(&self, struck: &Struck, material: &Material, seen: &Footprint) -> Vec3 {
        let world = self.moment.world;
        let mut base = material.base_colour.truncate() * struck.spot.colour.truncate();
        if let Some(texture) = &material.base_texture {
            base *= world
                .sampler
                .sample(&world.scene.textures, texture, seen)
                .truncate();
        }
        if let Some(procedural) = &material.procedural {
            base *= pattern(procedural, seen.uv, seen.extent());
        }
        base
    }

    fn emitted(&self, material: &Material, seen: &Footprint) -> Vec3 {
        let world = self.moment.world;
        match &material.emissive_texture {
            Some(texture) if material.emissive != Vec3::ZERO => {
                let texel = world.sampler.sample(&world.scene.textures, texture, seen);
                material.emissive * texel.truncate()
            }
            _ => material.emissive,
        }
    }

    /// Light that comes straight from the lamps; `open`: without shadows that the display draws.
    fn direct(
        &mut self,
        s: &Struck,
        direction: Vec3,
        response: &Response,
        weight: Vec3,
        open: bool,
    ) -> Vec3 {
        let world = self.moment.world;
        let (hard, soft) = world.lamps.split_at(world.first_area);
        let mut rays = 0;
        let mut sum = Vec3::ZERO;
        for i in 0..hard.len() {
            let left = if open {
                world.casters.position(i)
            } else {
                None
            };
            let open = left.is_some();
            let light =
                self.lamp_light(i, [0.5; 2], s, direction, response, weight, open, &mut rays);
            if let Some(lamp) = left {
                self.brought[lamp] = light;
            }
            sum += light;
        }
        self.rays.shadow += rays;
        if !soft.is_empty() {
            sum += self.area_light(s, direction, response, weight);
        }
        sum
    }

    /// Light from area lights. Apart from the rest, so that scenes without them keep their path
    /// short; as is all that only some scenes call for.
    #[inline(never)]
    fn area_light(
        &mut self,
        s: &Struck,
        direction: Vec3,
        response: &Response,
        weight: Vec3,
    ) -> Vec3 {
        let world = self.moment.world;
        let count = self.care.of(SOFT);
        let (mut sum, mut brought) = (Vec3::ZERO, [0.0; MOST]);
        let mut rays = 0;
        for lamp in world.first_area..world.lamps.len() {
            for (i, brought) in brought[..count].iter_mut().enumerate() {
                let point = self.points.next(Purpose::Lamp(lamp), i);
                let light = self.lamp_light(
                    lamp, point, s, direction, response, weight, false, &mut rays,
                );
                *brought += luminance(light * weight);
                sum += light;
            }
        }
        self.rays.soft += rays;
        self.told.add(SOFT, &brought[..count]);
        sum / count as f32
    }

    /// Light that comes straight from a lamp, of which `point` says where.
    #[inline]
    #[expect(
        clippy::too_many_arguments,
        reason = "a place, a lamp and what joins them"
    )]
    fn lamp_light(
        &self,
        lamp: usize,
        point: [f32; 2],
        s: &Struck,
        direction: Vec3,
        response: &Response,
        weight: Vec3,
        open: bool,
        rays: &mut u32,
    ) -> Vec3 {
        let moment = self.moment;
        let place = || (point, moment.lamp_pose(lamp));
        let incoming = moment.world.lamps[lamp].incoming(&moment.lamp(lamp), s.place, place);
        let Some(mut light) = incoming else {
            return Vec3::ZERO;
        };
        let cos = s.smooth.dot(light.towards);
        if cos <= 0.0 || s.flat.dot(light.towards) <= 0.0 {
            return Vec3::ZERO;
        }
        let reflected = response.towards(s.smooth, -direction, light.towards);
        if let Some(medium) = moment.medium() {
            light.irradiance *= medium.between(s.place, light.towards, light.distance);
        }
        let arriving = reflected * light.irradiance * cos;
        if (arriving * weight).max_element() < NEGLIGIBLE {
            return Vec3::ZERO;
        }
        *rays += 1;
        let origin = lifted(s.place, s.flat);
        let end = light.distance * 0.9999;
        let blocked = if open {
            moment.blocked_for_good(origin, light.towards, end, s.spot.object)
        } else {
            moment.blocked(origin, light.towards, end)
        };
        if blocked {
            return Vec3::ZERO;
        }
        arriving
    }

    fn mirrored(&mut self, s: &Struck, path: &Path, tint: Vec3) -> Vec3 {
        let direction = path.direction;
        let mut reflected = direction - s.smooth * (2.0 * direction.dot(s.smooth));
        let below = reflected.dot(s.flat);
        if below < 1e-3 {
            // An interpolated normal can send the ray into the surface: bend it out.
            reflected += s.flat * (1e-3 - below);
        }
        let bulge = if s.front {
            s.spot.curvature
        } else {
            -s.spot.curvature
        };
        let next = Path {
            direction: reflected,
            cone: path.cone.reflected(bulge),
            bounces: path.bounces,
            weight: path.weight * tint,
        };
        tint * self.follow(lifted(s.place, s.flat), next)
    }

    /// Smooth glass: reflected and refracted light, weighted by the Fresnel equations.
    fn glass(&mut self, s: &Struck, material: &Material, path: &Path, tint: Vec3) -> Vec3 {
        let direction = path.direction;
        let eta = if s.front {
            1.0 / material.ior.max(1.0)
        } else {
            material.ior.max(1.0)
        };
        let cos = (-direction.dot(s.smooth)).max(0.0);
        let sin2 = eta * eta * (1.0 - cos * cos);
        let mut light = Vec3::ZERO;
        let mut fresnel = 1.0;
        if sin2 < 1.0 {
            let cos_in = (1.0 - sin2).sqrt();
            let parallel = (cos - eta * cos_in) / (cos + eta * cos_in);
            let across = (eta * cos - cos_in) / (eta * cos + cos_in);
            fresnel = 0.5 * (parallel * parallel + across * across);
            let refracted = direction * eta + s.smooth * (eta * cos - cos_in);
            let through = tint * (1.0 - fresnel);
            let origin = lifted(s.place, -s.flat);
            let next = Path {
                direction: refracted,
                weight: path.weight * through,
                ..*path
            };
            self.rays.refraction += self.worth_following(path, through);
            light += through * self.follow(origin, next);
        }
        let whole = Vec3::splat(fresnel * material.transmission);
        self.rays.refraction += self.worth_following(path, whole);
        light + self.mirrored(s, path, whole)
    }

    /// Radiance along a bounced ray, whose cone is that at its origin.
    fn follow(&mut self, origin: Vec3, path: Path) -> Vec3 {
        if !goes_on(&path) {
            // What is not followed any more is taken to be the ambient light.
            return self.moment.world.scene.sky.ambient;
        }
        let direction = path.direction.normalize_or(Vec3::Y);
        let weight = path.weight;
        let (end, light) = match self.moment.closest(origin, direction) {
            Some(struck) => {
                let path = Path {
                    direction,
                    cone: path.cone.after(struck.t),
                    bounces: path.bounces + 1,
                    ..path
                };
                (struck.t, self.radiance(&struck, &path))
            }
            None => (f32::INFINITY, self.sky(direction)),
        };
        self.through_medium(origin, direction, end, light, weight)
    }

    /// Whether a path goes on after `tint`, as a number of rays.
    fn worth_following(&self, path: &Path, tint: Vec3) -> u32 {
        let weight = path.weight * tint;
        u32::from(goes_on(&Path { weight, ..*path }))
    }

    /// What arrives at `origin` of `light` from `end` metres along the unit `direction`, with
    /// what the medium adds on the way: for each lamp, from few places in it.
    pub(crate) fn through_medium(
        &mut self,
        origin: Vec3,
        direction: Vec3,
        end: f32,
        light: Vec3,
        weight: Vec3,
    ) -> Vec3 {
        let moment = self.moment;
        let Some(medium) = moment.medium() else {
            return light;
        };
        let Some(inside) = medium.stretch(origin, direction, end) else {
            return light;
        };
        light * medium.transmittance(inside.length())
            + self.scattered(origin, direction, inside, weight)
    }

    /// Light that the medium throws towards `origin` from a stretch of a ray.
    #[inline(never)]
    fn scattered(&mut self, origin: Vec3, direction: Vec3, inside: Stretch, weight: Vec3) -> Vec3 {
        let moment = self.moment;
        let Some(medium) = moment.medium() else {
            return Vec3::ZERO;
        };
        let count = self.care.of(MEDIUM);
        let (mut sum, mut brought) = (Vec3::ZERO, [0.0; MOST]);
        let start = origin + direction * inside.from;
        for lamp in 0..moment.lamp_count() {
            let source = moment.source(lamp, start, direction);
            for (i, brought) in brought[..count].iter_mut().enumerate() {
                let [at, _] = self.points.next(Purpose::Place(lamp), i);
                let (s, metres) = medium.place(inside.length(), source, at);
                let point = self.points.next(Purpose::Glow(lamp), i);
                let place = start + direction * s;
                let rays = &mut self.rays.medium;
                if let Some(thrown) = moment.thrown(lamp, place, direction, point, rays) {
                    *brought += luminance(thrown.light * metres * weight);
                    sum += thrown.light * metres;
                }
            }
        }
        self.told.add(MEDIUM, &brought[..count]);
        sum / count as f32
    }
}

/// Whether a material reflects rays.
pub(crate) fn mirrors(material: &Material) -> bool {
    material.metallic > 0.0 && material.roughness <= MIRROR_ROUGHNESS
}

/// Diffuse reflectance, apart from the share of mirror and glass.
fn diffuse(material: &Material, base: Vec3) -> Vec3 {
    if mirrors(material) {
        base
    } else {
        base * (1.0 - material.metallic)
    }
}

/// Whether a bounced path is followed.
fn goes_on(path: &Path) -> bool {
    path.weight.max_element() >= FAINT && path.bounces < MAX_BOUNCES
}

/// Luminance of linear light (ITU-R BT.709).
fn luminance(light: Vec3) -> f32 {
    light.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

impl Response {
    /// Reflected radiance for unit irradiance: the BRDF. All vectors point away from the surface.
    fn towards(&self, n: Vec3, view: Vec3, light: Vec3) -> Vec3 {
        let diffuse = self.albedo * FRAC_1_PI;
        let Some(alpha) = self.alpha else {
            return diffuse;
        };
        let half = (view + light).normalize_or(n);
        let (nv, nl) = (n.dot(view).max(1e-4), n.dot(light).max(1e-4));
        let (nh, vh) = (n.dot(half).max(0.0), view.dot(half).max(0.0));
        let a2 = alpha * alpha;
        let spread = nh * nh * (a2 - 1.0) + 1.0;
        let d = a2 / (PI * spread * spread).max(1e-9);
        let smith =
            nl * (nv * nv * (1.0 - a2) + a2).sqrt() + nv * (nl * nl * (1.0 - a2) + a2).sqrt();
        diffuse + schlick(self.f0, vh) * (d * 0.5 / smith.max(1e-6))
    }
}

fn schlick(f0: Vec3, cos: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * (1.0 - cos.clamp(0.0, 1.0)).powi(5)
}

/// A ray origin clear of the surface that it starts from, on the side of `normal`. The lift
/// grows with the coordinates, as their rounding does.
pub(crate) fn lifted(place: Vec3, normal: Vec3) -> Vec3 {
    place + normal * (3e-5 * place.abs().max_element().max(1.0))
}

/// What of a texture a path sees where it struck.
fn seen_through(struck: &Struck, path: &Path) -> Footprint {
    let spot = &struck.spot;
    path.cone
        .footprint(spot.uv, spot.gradients, struck.flat, path.direction)
}
