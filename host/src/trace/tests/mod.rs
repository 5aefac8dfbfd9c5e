//! The tracer against slow and obvious twins, and against closed forms.

mod light;
mod movers;
mod twins;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use unframed_wire::SKY;

use super::{Hit, World, WorldError, ideal};
use crate::scene::builtin::builtin;
use crate::scene::model::{
    Channel, Interpolation, Lens, Material, Mesh, Node, Primitive, Scene, Track,
};

const SIZE: [u32; 2] = [64, 48];

fn world(name: &str) -> World {
    World::new(builtin(name).unwrap(), SIZE).unwrap()
}

/// Numbers in 0..1 that are the same in every run.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        crate::trace::moment::unit_square(self.0)[0]
    }

    fn pixel(&mut self) -> Vec2 {
        Vec2::new(self.next() * SIZE[0] as f32, self.next() * SIZE[1] as f32)
    }
}

/// Nearest triangle by trying all of them at their places of the instant, in f64 and by another
/// method (volumes of tetrahedra): ray parameter and material.
fn brute_force(scene: &Scene, t: f64, origin: Vec3, direction: Vec3) -> Option<(f64, usize)> {
    let animation = crate::scene::animate::Animation::new(scene);
    let mut best: Option<(f64, usize)> = None;
    let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
    for (i, node) in scene.nodes.iter().enumerate() {
        let Some(mesh) = node.mesh else { continue };
        let pose = animation.world(scene, i, t);
        for p in &scene.meshes[mesh].primitives {
            for triangle in &p.indices {
                let v =
                    triangle.map(|k| pose.transform_point3(p.positions[k as usize]).as_dvec3() - o);
                let volumes = [
                    d.dot(v[1].cross(v[2])),
                    d.dot(v[2].cross(v[0])),
                    d.dot(v[0].cross(v[1])),
                ];
                let inside = volumes.iter().all(|&s| s >= 0.0) || volumes.iter().all(|&s| s <= 0.0);
                let normal = (v[1] - v[0]).cross(v[2] - v[0]);
                let s = normal.dot(v[0]) / normal.dot(d);
                if inside && s > 1e-9 && best.is_none_or(|b| s < b.0) {
                    best = Some((s, p.material));
                }
            }
        }
    }
    best
}

/// One triangle pair 10 m wide at z = −5, lit from the eye's side.
fn wall() -> Scene {
    let primitive = Primitive {
        positions: [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)]
            .map(|(x, y)| Vec3::new(x, y, -5.0))
            .to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Primitive::default()
    };
    Scene {
        name: "wall".into(),
        nodes: vec![
            Node {
                mesh: Some(0),
                ..Node::default()
            },
            Node {
                camera: Some(Lens {
                    yfov: 1.0,
                    aperture: 0.0,
                    focus: 1.0,
                }),
                ..Node::default()
            },
        ],
        meshes: vec![Mesh {
            name: "wall".into(),
            primitives: vec![primitive],
        }],
        materials: vec![Material {
            base_colour: Vec4::new(0.5, 0.25, 1.0, 1.0),
            ..Material::default()
        }],
        ..Scene::default()
    }
}

fn middle(scene: Scene) -> Hit {
    let world = World::new(scene, SIZE).unwrap();
    world.moment(0.0).look(Vec2::new(32.0, 24.0), 0)
}

#[test]
fn the_ideal_image_does_not_depend_on_threads() {
    let mut world = world("interactive");
    let on = |threads: usize, world: &mut World| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| ideal(world, 0.7, 2))
    };
    let one = on(1, &mut world);
    assert_eq!(one, on(3, &mut world));
    let distinct: std::collections::BTreeSet<_> = one.iter().collect();
    assert!(distinct.len() > 200, "a picture, not a flat colour");
    assert_ne!(one, ideal(&mut world, 2.2, 2));
}

#[test]
fn directions_and_projections_are_inverse() {
    let world = world("walkthrough");
    let camera = world.camera(1.7);
    for i in 0..100 {
        let pixel = Vec2::new(0.64 * i as f32, 48.0 - 0.48 * i as f32);
        let (back, depth) = camera
            .project(camera.eye + camera.direction(pixel) * 3.0)
            .unwrap();
        assert!(back.distance(pixel) < 1e-3 && (depth - 3.0).abs() < 1e-4);
    }
    assert!(camera.project(camera.eye - camera.forward).is_none());
}

#[test]
fn nothing_at_all_is_sky() {
    let mut world = World::new(Scene::default(), [3, 2]).unwrap();
    assert_eq!(world.object_count(), 1);
    world.prepare(0.0, 0.01);
    let hit = world.moment(0.005).look(Vec2::ONE, 0);
    assert_eq!((hit.object, hit.colour), (SKY, Vec3::ZERO));
    assert_eq!(world.pose(9, 0.0), Affine3A::IDENTITY);
    assert_eq!(ideal(&mut world, 0.0, 0), [[0; 3]; 6]);
}

#[test]
fn impossible_scenes_are_refused() {
    assert_eq!(
        World::new(wall(), [0, 5]).err(),
        Some(WorldError::Size(0, 5))
    );
    let broken: [fn(&mut Scene); 8] = [
        |s| s.nodes[0].mesh = Some(7),
        |s| s.nodes[0].parent = Some(0),
        |s| s.meshes[0].primitives[0].indices[0][1] = 4,
        |s| s.meshes[0].primitives[0].material = 1,
        |s| s.meshes[0].primitives[0].positions[0].x = f32::NAN,
        |s| s.meshes[0].primitives[0].uvs = vec![Vec2::ZERO],
        |s| s.nodes[0].rotation = Quat::from_xyzw(f32::INFINITY, 0.0, 0.0, 0.0),
        |s| {
            s.channels.push(Channel {
                node: 0,
                track: Track::Scale(vec![Vec3::ONE]),
                times: vec![0.0, 1.0],
                interpolation: Interpolation::Linear,
                period: 1.0,
            });
        },
    ];
    for (i, breaks) in broken.iter().enumerate() {
        let mut scene = wall();
        breaks(&mut scene);
        let error = World::new(scene, SIZE).err().map(|e| e.to_string());
        assert!(
            error.is_some_and(|e| e.starts_with("scene 'wall', ")),
            "case {i}"
        );
    }
}
