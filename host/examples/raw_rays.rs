//! What a sample costs beside the bare rays in it, in the same run, on one thread:
//! `cargo run --release -p unframed-host --example raw_rays -- [SCENE…]`.
//!
//! Bare rays go through one obvhs BVH2 of all triangles as they stand at one instant: closest hits of
//! random pixels, and any hits from there towards a point above the scene. Shaded samples are of
//! the same pixels at the same instant, with movers, shadows, mirrors and textures. Last, the whole
//! host at 400,000 samples a second: samplers, stream and all. Of each, the least of several rounds
//! in turn.

use std::error::Error;
use std::time::{Duration, Instant};

use glam::{UVec2, Vec2, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use unframed_host::drive::Host;
use unframed_host::sampler::adaptive::{Adaptive, Config};
use unframed_host::scene::animate::Animation;
use unframed_host::scene::builtin::{ANIMATIONS, builtin};
use unframed_host::scene::model::Scene;
use unframed_host::stream::sender::Promise;
use unframed_host::trace::{Rays, World};
use unframed_wire::{Layout, TileFields};

const SIZE: u32 = 256;
const SAMPLES: u32 = 50_000;
const ROUNDS: u32 = 7;
const RATE: u32 = 400_000;
/// Refreshes of the host, of which the first half warms up.
const REFRESHES: u32 = 40;

/// All triangles at `time`, but for those that skins bend: as they were modelled.
fn triangles(scene: &Scene, time: f64) -> Vec<Triangle> {
    let mut poses = Vec::new();
    Animation::new(scene).world_all(scene, time, &mut poses);
    let mut all = Vec::new();
    for (node, pose) in scene.nodes.iter().zip(&poses) {
        let Some(mesh) = node.mesh.and_then(|mesh| scene.meshes.get(mesh)) else {
            continue;
        };
        for primitive in &mesh.primitives {
            let corner =
                |i: u32| Vec3A::from(pose.transform_point3(primitive.positions[i as usize]));
            all.extend(primitive.indices.iter().map(|t| {
                let [v0, v1, v2] = t.map(corner);
                Triangle { v0, v1, v2 }
            }));
        }
    }
    all
}

/// obvhs alone.
struct Bare {
    bvh: Bvh2,
    /// In leaf order.
    triangles: Vec<Triangle>,
}

impl Bare {
    fn new(triangles: &[Triangle]) -> Self {
        let params = BvhBuildParams::medium_build();
        let bvh = build_bvh2_from_tris(triangles, params, &mut Duration::default());
        let order = bvh.primitive_indices.iter();
        let triangles = order.map(|i| triangles[*i as usize]).collect();
        Self { bvh, triangles }
    }

    fn closest(&self, ray: Ray) -> f32 {
        let mut hit = RayHit::none();
        self.bvh
            .ray_traverse(ray, &mut hit, |ray, i| self.triangles[i].intersect(ray));
        hit.t
    }

    fn misses(&self, ray: Ray) -> bool {
        self.bvh
            .ray_traverse_miss(ray, |ray, i| self.triangles[i].intersect(ray))
    }
}

/// The least seconds that a job took.
fn keep(least: &mut f64, job: impl FnOnce()) {
    let start = Instant::now();
    job();
    *least = least.min(start.elapsed().as_secs_f64());
}

/// Seconds for a sample of the whole host, and the share of it in rays and shading.
fn host(world: &World) -> Result<(f64, f64), Box<dyn Error>> {
    let promise = Promise {
        layout: Layout::World,
        lamps: true,
        tile_fields: TileFields {
            gradients: false,
            lifetime: true,
            density: false,
        },
        rate: RATE,
        refresh_millihertz: 60_000,
    };
    let sampler = Box::new(Adaptive::new(UVec2::splat(SIZE), Config::default()));
    let mut host = Host::new(world.clone(), sampler, promise);
    let mut samples = 0;
    let mut before = host.spent();
    for refresh in 0..REFRESHES {
        if refresh == REFRESHES / 2 {
            (before, samples) = (host.spent(), 0);
        }
        samples += host.advance(&mut Vec::new())?.samples;
    }
    let total = host.spent().total() - before.total();
    let tracing = host.spent().tracing + host.spent().scene - before.tracing - before.scene;
    Ok((total / samples as f64, tracing / total))
}

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()?;
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = ANIMATIONS.map(String::from).to_vec();
    }
    println!(
        "scene         closest  any hit  Mray/s | samples  M/s, with rays | of bare rays/s | bare rays' share of a sample | whole host: M/s, in rays and shading"
    );
    for name in names {
        let scene = builtin(&name).ok_or_else(|| format!("no scene {name}"))?;
        let time = 0.5 * scene.duration;
        let bare = Bare::new(&triangles(&scene, time));
        let mut world = World::new(scene, [SIZE; 2])?;
        world.prepare(time, time);
        let camera = world.camera(time);
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 * SIZE as f32
        };
        let pixels: Vec<Vec2> = (0..SAMPLES).map(|_| Vec2::new(next(), next())).collect();
        let rays: Vec<Ray> = pixels
            .iter()
            .map(|pixel| Ray::new_inf(camera.eye.into(), camera.direction(*pixel).into()))
            .collect();
        let root = bare
            .bvh
            .nodes
            .first()
            .ok_or("a scene without triangles")?
            .aabb();
        let above = Vec3::from(root.center()).with_y(root.max.y + 1.0);
        let shadows: Vec<Ray> = rays
            .iter()
            .filter_map(|ray| {
                let t = bare.closest(*ray);
                let place = Vec3::from(ray.origin + ray.direction * t * 0.999);
                let way = (above - place).normalize();
                let end = (above - place).length();
                t.is_finite()
                    .then(|| Ray::new(place.into(), way.into(), 1e-3, end))
            })
            .collect();
        let moment = world.moment(time);
        let [mut closest, mut any, mut shaded] = [f64::INFINITY; 3];
        let mut counted = Rays::default();
        let mut hits = 0;
        for _ in 0..ROUNDS {
            keep(&mut closest, || {
                hits = rays
                    .iter()
                    .filter(|ray| bare.closest(**ray).is_finite())
                    .count();
            });
            keep(&mut any, || {
                std::hint::black_box(shadows.iter().filter(|ray| bare.misses(**ray)).count());
            });
            counted = Rays::default();
            keep(&mut shaded, || {
                for (seed, pixel) in (0..).zip(&pixels) {
                    counted += moment.look(*pixel, seed).rays;
                }
            });
        }
        let n = f64::from(SAMPLES);
        let (closest, any) = (closest / n, any / shadows.len() as f64);
        let shaded = shaded / n;
        let shadow = f64::from(counted.shadow + counted.soft) / n;
        let other = f64::from(counted.total()) / n - shadow;
        let bare_rays = other * closest + shadow * any;
        let (whole, tracing) = host(&world)?;
        println!(
            "{name:12} {:8.2} {:8.2}         | {:7.2}  {:.2} + {:.2}      | {:10.1} %   | {:10.1} %                 | {:8.2} {:6.1} %   ({hits} of {SAMPLES} hit)",
            1e-6 / closest,
            1e-6 / any,
            1e-6 / shaded,
            other,
            shadow,
            100.0 * closest / shaded,
            100.0 * bare_rays / shaded,
            1e-6 / whole,
            100.0 * tracing,
        );
    }
    Ok(())
}
