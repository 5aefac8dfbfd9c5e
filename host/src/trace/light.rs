//! Where light comes from: punctual lights (KHR_lights_punctual) and emissive meshes.
//!
//! An emissive primitive without emissive texture is an area light, of which each sample sees one
//! point ([`crate::effects::area`]). Primitives with an emissive texture and skinned ones are seen
//! but light nothing.

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec3A};

use super::shade::lifted;
use crate::effects::BUILT_IN;
use crate::effects::area::Surface;
use crate::effects::vpl::cosine;
use crate::scene::animate::Animation;
use crate::scene::model::{Light, LightKind, Node, Primitive, Scene};

/// Most emissive primitives that light others; beyond, the most powerful are kept.
const MAX_EMITTERS: usize = 16;

/// A light of the scene, apart from where it is.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    node: usize,
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    Punctual(Light),
    Emitter {
        surface: Arc<Surface>,
        radiance: Vec3,
    },
}

/// Where a lamp is at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    position: Vec3,
    /// Where it shines (unit); zero for an emitter.
    axis: Vec3,
    /// Area of an emitter, m².
    total: f32,
}

impl Place {
    /// Straight-line blend, for instants between two that are known.
    pub(crate) fn lerp(&self, other: &Self, f: f32) -> Self {
        Self {
            position: self.position.lerp(other.position, f),
            axis: self.axis.lerp(other.axis, f),
            total: self.total + (other.total - self.total) * f,
        }
    }
}

/// Where light comes from that casts hard shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// A place, metres.
    At(Vec3),
    /// A unit direction towards it.
    Towards(Vec3),
}

/// Light that would arrive at a place if nothing stood in between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Incoming {
    /// Unit vector towards the light.
    pub(crate) towards: Vec3,
    /// Metres; infinite for directional light.
    pub(crate) distance: f32,
    /// Irradiance on a surface that faces the light, W/m².
    pub(crate) irradiance: Vec3,
}

impl Lamp {
    /// All lights of a scene, area lights last.
    pub(crate) fn all(scene: &Scene) -> Vec<Self> {
        let mut lamps: Vec<Self> = Vec::new();
        let mut emitters: Vec<(f32, Self)> = Vec::new();
        for (i, node) in scene.nodes.iter().enumerate() {
            if let Some(light) = node.light
                && light.intensity.max_element() > 0.0
            {
                lamps.push(Self {
                    node: i,
                    shape: Shape::Punctual(light),
                });
            }
            for primitive in primitives(scene, node) {
                if lights_others(scene, primitive.material) {
                    emitters.extend(emitter(scene, i, primitive));
                }
            }
        }
        emitters.sort_by(|a, b| b.0.total_cmp(&a.0));
        emitters.truncate(MAX_EMITTERS);
        lamps.extend(emitters.into_iter().map(|(_, lamp)| lamp));
        lamps
    }

    /// Whether the lamp's place varies.
    pub(crate) fn moves(&self, animation: &Animation) -> bool {
        animation.moves(self.node)
    }

    /// Its place when the nodes stand at `poses`.
    pub(crate) fn place(&self, poses: &[Affine3A]) -> Place {
        let pose = &poses[self.node];
        match &self.shape {
            Shape::Punctual(_) => Place {
                position: pose.translation.into(),
                axis: (pose.matrix3 * Vec3A::NEG_Z)
                    .normalize_or(Vec3A::NEG_Y)
                    .into(),
                total: 0.0,
            },
            Shape::Emitter { surface, .. } => Place {
                position: pose.transform_point3(surface.centroid),
                axis: Vec3::ZERO,
                // As if the scale were the same in all directions.
                total: surface.total * pose.matrix3.determinant().abs().powf(2.0 / 3.0),
            },
        }
    }

    /// A path that leaves the lamp: origin, unit direction, and flux, W, such that its mean over
    /// numbers in 0..1 is all the lamp's light. `ball` is what directional light shines on.
    pub(crate) fn emit(
        &self,
        place: &Place,
        pose: impl FnOnce() -> Affine3A,
        where_on: [f32; 2],
        whither: [f32; 2],
        ball: (Vec3, f32),
    ) -> Option<(Vec3, Vec3, Vec3)> {
        match &self.shape {
            Shape::Punctual(light) => {
                let around = |axis: Vec3, radius: f32, angle: f32| {
                    let (a, b) = axis.any_orthonormal_pair();
                    let angle = std::f32::consts::TAU * angle;
                    (a * angle.cos() + b * angle.sin()) * radius
                };
                if light.kind == LightKind::Directional {
                    let (centre, radius) = ball;
                    let aside = around(place.axis, radius * where_on[0].sqrt(), where_on[1]);
                    let flux = light.intensity * (std::f32::consts::PI * radius * radius);
                    return Some((centre - place.axis * radius + aside, place.axis, flux));
                }
                // Uniform over the sphere, or over a spot's cone.
                let least = match light.kind {
                    LightKind::Spot { outer, .. } => outer.cos(),
                    _ => -1.0,
                };
                let cos = 1.0 - whither[0] * (1.0 - least);
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                let direction = place.axis * cos + around(place.axis, sin, whither[1]);
                let nowhere = || ([0.5; 2], Affine3A::IDENTITY);
                let lit = self.incoming(place, place.position + direction, nowhere)?;
                let solid = std::f32::consts::TAU * (1.0 - least);
                Some((place.position, direction, lit.irradiance * solid))
            }
            Shape::Emitter { surface, radiance } => {
                let (at, mut normal) = surface.point(where_on, &pose());
                let mut whither = whither;
                let mut sides = 1.0;
                if !surface.one_sided {
                    sides = 2.0;
                    if whither[1] < 0.5 {
                        normal = -normal;
                    }
                    whither[1] = (whither[1] * 2.0).fract();
                }
                let flux = *radiance * (std::f32::consts::PI * place.total * sides);
                Some((lifted(at, normal), cosine(normal, whither), flux))
            }
        }
    }

    /// The middle and the radius of a disc of its area, metres; `None` for directional light.
    pub(crate) fn ball(&self, place: &Place) -> Option<(Vec3, f32)> {
        if let Shape::Punctual(light) = &self.shape
            && light.kind == LightKind::Directional
        {
            return None;
        }
        let radius = (place.total * std::f32::consts::FRAC_1_PI).sqrt();
        Some((place.position, radius))
    }

    /// Where a punctual lamp's light comes from when its node stands at `pose`; `None` of others.
    pub(crate) fn source(&self, pose: &Affine3A) -> Option<Source> {
        match &self.shape {
            Shape::Punctual(light) if light.kind == LightKind::Directional => {
                let axis = (pose.matrix3 * Vec3A::NEG_Z).normalize_or(Vec3A::NEG_Y);
                Some(Source::Towards((-axis).into()))
            }
            Shape::Punctual(_) => Some(Source::At(pose.translation.into())),
            Shape::Emitter { .. } => None,
        }
    }

    /// Its colour times intensity.
    pub(crate) fn light(&self) -> Vec3 {
        match &self.shape {
            Shape::Punctual(light) => light.intensity,
            Shape::Emitter { radiance, .. } => *radiance,
        }
    }

    /// Its node.
    pub(crate) fn node(&self) -> usize {
        self.node
    }

    /// Whether it is an area light.
    pub(crate) fn is_area(&self) -> bool {
        BUILT_IN && matches!(self.shape, Shape::Emitter { .. })
    }

    /// What arrives at `at` from the lamp at `place`; `None` where that is nothing. An area
    /// light asks `point` for two numbers in 0..1 and its pose.
    #[inline]
    pub(crate) fn incoming(
        &self,
        place: &Place,
        at: Vec3,
        point: impl FnOnce() -> ([f32; 2], Affine3A),
    ) -> Option<Incoming> {
        let offset = place.position - at;
        let d2 = offset.length_squared().max(1e-8);
        let distance = d2.sqrt();
        let towards = offset / distance;
        match &self.shape {
            Shape::Punctual(light) => match light.kind {
                LightKind::Directional => Some(Incoming {
                    towards: -place.axis,
                    distance: f32::INFINITY,
                    irradiance: light.intensity,
                }),
                LightKind::Point => {
                    let fall = falloff(d2, light.range)?;
                    Some(Incoming {
                        towards,
                        distance,
                        irradiance: light.intensity * fall,
                    })
                }
                LightKind::Spot { inner, outer } => {
                    let (full, none) = (inner.cos(), outer.cos());
                    let within = (-towards.dot(place.axis) - none) / (full - none).max(1e-3);
                    if within <= 0.0 {
                        return None;
                    }
                    let cone = within.min(1.0).powi(2);
                    let fall = falloff(d2, light.range)? * cone;
                    Some(Incoming {
                        towards,
                        distance,
                        irradiance: light.intensity * fall,
                    })
                }
            },
            Shape::Emitter { surface, radiance } => {
                if !BUILT_IN {
                    return None;
                }
                let (random, pose) = point();
                let (offset, solid) = surface.seen(random, &pose, place.total, at)?;
                let distance = offset.length().max(1e-4);
                Some(Incoming {
                    towards: offset / distance,
                    distance,
                    irradiance: *radiance * solid,
                })
            }
        }
    }
}

/// Whether surfaces of this material are area lights; these cast no shadow themselves.
pub(crate) fn lights_others(scene: &Scene, material: usize) -> bool {
    let m = &scene.materials[material];
    m.emissive.max_element() > 0.0 && m.emissive_texture.is_none() && !m.unlit
}

/// 1/d² with the window that KHR_lights_punctual recommends; `None` beyond the range.
fn falloff(d2: f32, range: f32) -> Option<f32> {
    let window = if range.is_finite() {
        1.0 - (d2 / (range * range).max(1e-12)).powi(2)
    } else {
        1.0
    };
    (window > 0.0).then(|| window.min(1.0) / d2)
}

fn primitives<'a>(scene: &'a Scene, node: &Node) -> &'a [Primitive] {
    match (node.mesh, node.skin) {
        (Some(mesh), None) => &scene.meshes[mesh].primitives,
        _ => &[],
    }
}

/// Power (up to a factor) and lamp of an emissive primitive.
fn emitter(scene: &Scene, node: usize, primitive: &Primitive) -> Option<(f32, Lamp)> {
    let material = &scene.materials[primitive.material];
    let surface = Surface::new(primitive, material.double_sided)?;
    let radiance = material.emissive;
    let power = radiance.max_element() * surface.total;
    let shape = Shape::Emitter {
        surface: Arc::new(surface),
        radiance,
    };
    Some((power, Lamp { node, shape }))
}
