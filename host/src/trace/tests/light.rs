//! Light, mirrors, glass, masks and the lens against closed forms.

use glam::{Vec2, Vec3, Vec4};
use unframed_wire::SKY;

use super::{SIZE, middle, wall};
use crate::scene::model::{Lens, Light, LightKind, Material, Mesh, Node, Primitive, Scene, Sky};
use crate::trace::World;

#[test]
fn light_arrives_as_the_formulas_say() {
    let lit = |light: Light, at: Vec3| {
        let mut scene = wall();
        scene.nodes.push(Node {
            light: Some(light),
            translation: at,
            ..Node::default()
        });
        middle(scene)
    };
    let light = |kind| Light {
        kind,
        intensity: Vec3::splat(10.0),
        range: f32::INFINITY,
    };
    let albedo = Vec3::new(0.5, 0.25, 1.0);
    // Point: I·cos/d²·albedo/π, once straight and once from the side.
    let hit = lit(light(LightKind::Point), Vec3::ZERO);
    let expected = albedo * 10.0 / 25.0 / std::f32::consts::PI;
    assert!(hit.colour.distance(expected) < 1e-4, "{hit:?} {expected}");
    assert_eq!(
        (hit.rays.primary, hit.rays.shadow, hit.rays.bounce),
        (1, 1, 0)
    );
    let hit = lit(light(LightKind::Point), Vec3::new(5.0, 0.0, 0.0));
    assert!(hit.colour.distance(expected * 0.5 * 0.5f32.sqrt()) < 1e-4);
    // Directional, and a spot that misses.
    let sun = Light {
        intensity: Vec3::splat(2.0),
        ..light(LightKind::Directional)
    };
    let hit = lit(sun, Vec3::ZERO);
    assert!(hit.colour.distance(albedo * 2.0 / std::f32::consts::PI) < 1e-4);
    let spot = light(LightKind::Spot {
        inner: 0.1,
        outer: 0.2,
    });
    assert_eq!(lit(spot, Vec3::new(3.0, 0.0, 0.0)).colour, Vec3::ZERO);
    assert!(lit(spot, Vec3::ZERO).colour.distance(expected) < 1e-4);
    // Behind the wall: dark.
    assert_eq!(
        lit(light(LightKind::Point), Vec3::new(0.0, 0.0, -9.0)).colour,
        Vec3::ZERO
    );
}

#[test]
fn an_emissive_patch_lights_as_its_solid_angle() {
    // 0.1 m × 0.1 m of radiance 100 at the eye, facing the wall: E = L·A/d².
    let mut scene = wall();
    let patch = Primitive {
        positions: [(-0.05, -0.05), (-0.05, 0.05), (0.05, 0.05), (0.05, -0.05)]
            .map(|(x, y)| Vec3::new(x, y, 0.0))
            .to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material: 1,
        ..Primitive::default()
    };
    scene.meshes.push(Mesh {
        name: "patch".into(),
        primitives: vec![patch],
    });
    scene.materials.push(Material {
        emissive: Vec3::splat(100.0),
        ..Material::default()
    });
    let at = Vec3::new(0.0, 0.5, 0.0);
    scene.nodes.push(Node {
        mesh: Some(1),
        translation: at,
        ..Node::default()
    });
    let hit = middle(scene);
    let d2: f32 = 25.25;
    let cos = 5.0 / d2.sqrt();
    let expected = 0.5 * 100.0 * 0.01 * cos * cos / d2 / std::f32::consts::PI;
    assert!(
        (hit.colour.x / expected - 1.0).abs() < 0.01,
        "{} {expected}",
        hit.colour.x
    );
}

#[test]
fn mirrors_and_glass_show_the_sky() {
    let sky = Sky {
        zenith: Vec3::ONE,
        horizon: Vec3::new(0.2, 0.4, 0.6),
        ambient: Vec3::ZERO,
    };
    let mut scene = Scene { sky, ..wall() };
    scene.materials[0].metallic = 1.0;
    scene.materials[0].roughness = 0.0;
    // Seen straight on, Schlick's term is the base colour; the mirrored ray is horizontal.
    let hit = middle(scene.clone());
    assert!(hit.colour.distance(sky.horizon * Vec3::new(0.5, 0.25, 1.0)) < 1e-4);
    assert_eq!(hit.rays.bounce, 1);
    assert_eq!(hit.depth, 5.0);

    scene.materials[0].metallic = 0.0;
    scene.materials[0].transmission = 1.0;
    scene.materials[0].base_colour = Vec4::ONE;
    // Reflected and refracted shares sum to one, and both see the horizon.
    let hit = middle(scene);
    assert!(hit.colour.distance(sky.horizon) < 2e-3, "{hit:?}");
    assert_eq!((hit.rays.bounce, hit.rays.refraction), (0, 2));
}

#[test]
fn masked_texels_are_passed_by_all_rays() {
    let mut scene = wall();
    scene.materials[0].alpha_cutoff = Some(0.5);
    scene.materials[0].base_colour.w = 0.4;
    assert_eq!(middle(scene.clone()).object, SKY);
    let world = World::new(scene, SIZE).unwrap();
    assert!(!world.moment(0.0).blocked(Vec3::ZERO, Vec3::NEG_Z, 9.0));
}

#[test]
fn lens_samples_project_to_their_own_pixel() {
    let mut scene = wall();
    scene.nodes[1].camera = Some(Lens {
        yfov: 1.0,
        aperture: 0.2,
        focus: 3.0,
    });
    let world = World::new(scene, SIZE).unwrap();
    let moment = world.moment(0.0);
    for seed in 0..50 {
        let pixel = Vec2::new(20.0, 30.0);
        let hit = moment.look(pixel, seed);
        assert!((hit.depth - 5.0).abs() < 1e-4);
        let (back, _) = moment.camera().project(hit.local).unwrap();
        assert!(back.distance(pixel) < 1e-3);
    }
}
