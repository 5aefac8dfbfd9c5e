//! Effects against closed forms and their convergence; [`ledger`]: what is not called for.

use glam::{Affine3A, Vec2, Vec3};

use super::area::Surface;
use super::medium::Source;
use crate::scene::builtin::{EFFECTS, builtin};
use crate::scene::model::{Medium, Primitive, Scene};
use crate::trace::{Rays, World};

mod convergence;
mod ledger;

const SIZE: [u32; 2] = [32, 32];

/// All rays of a small image, and its colours.
fn image(scene: Scene) -> (Rays, Vec<Vec3>) {
    let world = World::new(scene, SIZE).expect("a sound scene");
    let moment = world.moment(0.0);
    let mut rays = Rays::default();
    let colours = (0..SIZE[0] * SIZE[1])
        .map(|i| {
            let pixel = Vec2::new((i % SIZE[0]) as f32, (i / SIZE[0]) as f32) + 0.5;
            let hit = moment.look(pixel, i);
            rays += hit.rays;
            hit.colour
        })
        .collect();
    (rays, colours)
}

/// The Cornell box without its lamp's glow, so that it calls for no effect at all.
fn plain() -> Scene {
    let mut scene = builtin("cornell").expect("built in");
    scene.indirect = false;
    scene
        .materials
        .iter_mut()
        .for_each(|m| m.emissive = Vec3::ZERO);
    scene
}

const MIST: Medium = Medium {
    min: Vec3::new(-1.0, 0.0, -1.0),
    max: Vec3::new(1.0, 2.0, 1.0),
    sigma_s: 0.3,
    sigma_a: 0.1,
    g: 0.2,
};

#[test]
fn a_medium_of_no_density_is_no_medium() {
    for name in EFFECTS {
        let mut scene = builtin(name).expect("built in");
        scene.medium = None;
        let without = image(scene.clone());
        scene.medium = Some(Medium {
            sigma_s: 0.0,
            sigma_a: 0.0,
            ..MIST
        });
        assert_eq!(image(scene.clone()), without, "{name}");
        // The arithmetic says so too, not only the test that leaves it out.
        let none = scene.medium.expect("set above");
        let through = none.between(Vec3::ZERO, Vec3::X, 5.0);
        assert_eq!(through.to_bits(), 1.0f32.to_bits());
        assert_eq!(none.distance(2.0, 0.25), (0.5, 2.0));
        scene.medium = Some(MIST);
        assert_ne!(image(scene).1, without.1, "{name}: a medium shows");
    }
}

#[test]
fn a_medium_is_met_where_its_box_is_and_weakens_by_the_law() {
    let inside = MIST.stretch(Vec3::new(0.0, 1.0, 5.0), Vec3::NEG_Z, 100.0);
    assert_eq!(inside.map(|s| (s.from, s.to)), Some((4.0, 6.0)));
    // It ends at a surface, and starts at once for an eye within.
    let inside = MIST.stretch(Vec3::new(0.0, 1.0, 0.5), Vec3::NEG_Z, 1.0);
    assert_eq!(inside.map(|s| (s.from, s.to)), Some((0.0, 1.0)));
    assert_eq!(
        MIST.stretch(Vec3::new(0.0, 3.0, 5.0), Vec3::NEG_Z, 9.0),
        None
    );
    assert_eq!(
        MIST.stretch(Vec3::new(0.0, 1.0, 5.0), Vec3::NEG_Z, 3.0),
        None
    );
    let passes = MIST.between(Vec3::new(0.0, 1.0, 5.0), Vec3::NEG_Z, 100.0);
    assert!((passes - (-0.4f32 * 2.0).exp()).abs() < 1e-6);
    // The phase function integrates to one over the sphere.
    let n = 20_000;
    let sum: f32 = (0..n)
        .map(|i| MIST.phase((i as f32 + 0.5) / n as f32 * 2.0 - 1.0))
        .sum();
    let integral = sum / n as f32 * 4.0 * std::f32::consts::PI;
    assert!((integral - 1.0).abs() < 1e-3, "{integral}");
    // Distances follow the density, and the weight is its integral: the mean of s is known.
    let (length, extinction) = (3.0f32, 0.4f32);
    let mean: f32 = (0..n)
        .map(|i| MIST.distance(length, (i as f32 + 0.5) / n as f32).0)
        .sum::<f32>()
        / n as f32;
    let passing = (-extinction * length).exp();
    let expected = 1.0 / extinction - length * passing / (1.0 - passing);
    assert!((mean - expected).abs() < 1e-3, "{mean} {expected}");
    let weight = MIST.distance(length, 0.5).1;
    assert!((weight - (1.0 - passing) / extinction).abs() < 1e-5);
}

/// Mean of a place's red after `n` looks.
fn pixel(scene: &Scene, at: Vec2, n: u32, first: u32) -> f32 {
    let world = World::new(scene.clone(), SIZE).expect("a sound scene");
    let moment = world.moment(0.0);
    let sum: f32 = (0..n).map(|i| moment.look(at, first + i).colour.x).sum();
    sum / n as f32
}

#[test]
fn places_in_a_medium_give_its_integral_whatever_they_are_drawn_to() {
    // ∫ exp(−σt·s)·f(s) ds for light that is strongest near a lamp, by the midpoint rule and by
    // places; thin and thick, a lamp beside the stretch, before it and far away.
    let (length, n) = (4.0f32, 20_000);
    let midpoints = || (0..n).map(|i| (i as f32 + 0.5) / n as f32);
    for density in [0.05f32, 1.0, 6.0] {
        let medium = Medium {
            sigma_s: density,
            sigma_a: 0.0,
            ..MIST
        };
        for (foot, reach) in [(3.0f32, 0.05f32), (-1.0, 0.5), (40.0, 9.0)] {
            let light = |s: f32| 1.0 / (reach * reach + (s - foot).powi(2));
            let expected: f32 = midpoints()
                .map(|at| light(at * length) * medium.transmittance(at * length))
                .sum::<f32>()
                / n as f32
                * length;
            for source in [Source::Near { foot, reach }, Source::Far] {
                let found: Vec<f32> = midpoints()
                    .map(|at| medium.place(length, source, at))
                    .map(|(s, metres)| light(s) * metres)
                    .collect();
                let mean = found.iter().sum::<f32>() / n as f32;
                let off = (mean / expected - 1.0).abs();
                assert!(off < 0.01, "{density} {source:?}: {mean} {expected}");
                // What is drawn to the lamp is bounded, however near the ray passes.
                let most = found.iter().fold(0.0, |a: f32, &b| a.max(b));
                if source != Source::Far && density < 6.0 {
                    assert!(most < 8.0 * mean, "{density} {source:?}: {most} {mean}");
                }
            }
        }
    }
}

#[test]
fn an_area_light_is_as_bright_from_near_by_as_its_form_factor() {
    // The irradiance under the middle of a square of side 2a at height h (as below), by points of
    // the area from afar and by directions from near by, where no point stands for more than
    // the whole sky.
    let square = Primitive {
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, z]| Vec3::new(x, 0.0, z))
            .into(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Primitive::default()
    };
    let surface = Surface::new(&square, false).expect("not empty");
    for h in [8.0f32, 1.0, 0.1, 0.003] {
        let from = Vec3::new(0.0, -h, 0.0);
        let (mut sum, mut most, n) = (0.0, 0.0f32, 256);
        for i in 0..n * n {
            let at = [i % n, i / n].map(|k| (k as f32 + 0.5) / n as f32);
            let (offset, stands_for) = surface
                .seen(at, &Affine3A::IDENTITY, surface.total, from)
                .expect("from the front");
            assert!(
                (offset.y - h).abs() < 1e-3 * offset.length(),
                "on the square"
            );
            sum += stands_for * offset.normalize().y;
            most = most.max(stands_for);
        }
        let c = (1.0 + h * h).sqrt();
        let (found, expected) = (sum / (n * n) as f32, 4.0 / c * (1.0 / c).atan());
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{h}: {found} {expected}"
        );
        // Each half of the square is chosen half of the time.
        assert!(most < 4.0 * std::f32::consts::PI, "{h}: {most}");
    }
}

#[test]
fn an_unblocked_lamp_lights_as_its_form_factor() {
    // The floor under the middle of a square lamp of side 2a at height h gets
    // E = 4·L·a/√(a²+h²)·atan(a/√(a²+h²)) (Howell, catalogue of view factors, B-4, four times).
    let mut scene = builtin("cornell").expect("built in");
    scene
        .nodes
        .retain(|n| n.name != "tall" && n.name != "short");
    scene.channels.clear();
    scene.sky = Default::default();
    scene.indirect = false;
    scene.materials[3].emissive = Vec3::splat(4.0);
    let (a, h) = (0.25f32, 1.98f32);
    let c = (a * a + h * h).sqrt();
    let irradiance = 4.0 * 4.0 * (a / c) * (a / c).atan();
    let expected = 0.73 * irradiance / std::f32::consts::PI;
    let world = World::new(scene.clone(), SIZE).expect("a sound scene");
    let (at, _) = world.camera(0.0).project(Vec3::ZERO).expect("in view");
    let found = pixel(&scene, at, 4000, 0);
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

/// The mean over an image.
fn mean(light: &[Vec3]) -> Vec3 {
    light.iter().sum::<Vec3>() / light.len() as f32
}

/// Root of the mean squared difference of displayed values, 0..255.
fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    let code = |v: &Vec3| Vec3::from(crate::trace::srgb::encode8(*v).map(f32::from));
    let squares = a
        .iter()
        .zip(b)
        .map(|(a, b)| (code(a) - code(b)).length_squared());
    (squares.sum::<f32>() / (3 * a.len()) as f32).sqrt()
}

#[test]
fn a_furnace_glows_evenly() {
    // Closed, diffuse, every wall shining L: all of it has radiance L/(1 − albedo).
    let mut scene = plain();
    scene.indirect = true;
    scene.sky = Default::default();
    scene.channels.clear();
    let room = scene
        .nodes
        .iter()
        .position(|n| n.name == "room")
        .expect("a room");
    let mesh = scene.nodes[room].mesh.expect("with walls");
    scene
        .nodes
        .retain(|n| n.name != "tall" && n.name != "short");
    let mut walls = scene.meshes[mesh].primitives[0].clone();
    walls.positions = [-1.0f32, 1.0]
        .into_iter()
        .flat_map(|x| [0.0, 2.0].map(|y| (x, y)))
        .flat_map(|(x, y)| [-4.0, 4.0].map(|z| Vec3::new(x, y, z)))
        .collect();
    (walls.normals, walls.uvs) = (Vec::new(), Vec::new());
    // Counter-clockwise from inside: corners are numbered 4·x + 2·y + z.
    walls.indices = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ]
    .into_iter()
    .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
    .collect();
    let (albedo, shines) = (0.5, 0.25);
    let material = &mut scene.materials[walls.material];
    material.base_colour = Vec3::splat(albedo).extend(1.0);
    material.emissive = Vec3::splat(shines);
    scene.meshes[mesh].primitives = vec![walls];
    let mut world = World::new(scene, [24, 24]).expect("a sound scene");
    let light = super::reference::reference(&mut world, 0.0, 600);
    let (found, expected) = (mean(&light).x, shines / (1.0 - albedo));
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

#[test]
fn a_larger_pattern_shares_indirect_light_among_more_pixels() {
    use super::framed::{Refinement, render, render_with};
    let scene = builtin("cornell").expect("built in");
    let mut world = World::new(scene, [48, 48]).expect("a sound scene");
    let truth = super::reference::reference(&mut world, 0.0, 600);
    let mut frame = |side| render_with(&mut world, 0.0, Refinement::Plain([1; 3]), side);
    // An even side counts as one more.
    let [one, two, three, five] = [1, 2, 3, 5].map(&mut frame);
    assert_eq!(two.light, three.light);
    let usual = render(&mut world, 0.0, Refinement::Plain([1; 3]));
    assert_eq!(usual.light, three.light);
    // With n² pixels each looks at every n²-th light: so many fewer rays, but for those of the
    // correction near by; and the filter brings the others' share.
    let rays = [&one, &three, &five].map(|f| f.rays.indirect as f32);
    let errors = [&one, &three, &five].map(|f| apart(&f.light, &truth));
    assert!(
        rays[0] > 4.0 * rays[1] && rays[1] > 1.5 * rays[2],
        "{rays:?}"
    );
    // Without neighbours all pixels see the lamp from one point; with many the box is too wide.
    assert!(
        errors[1] < errors[0] && errors[1] < errors[2] && errors[0] < 14.0,
        "{errors:?}"
    );
}

#[test]
fn interleaving_comes_close_to_the_reference_and_refines_where_it_must() {
    use super::framed::{MOST, Refinement, render};
    for name in ["cornell", "forest", "cornell-mist"] {
        let scene = builtin(name).expect("built in");
        let mut world = World::new(scene, [48, 48]).expect("a sound scene");
        let truth = super::reference::reference(&mut world, 0.0, 600);
        let plain = render(&mut world, 0.0, Refinement::Plain([1; 3]));
        let adaptive = render(&mut world, 0.0, Refinement::Adaptive);
        let all = render(&mut world, 0.0, Refinement::All);
        let [p, a, m] = [&plain, &adaptive, &all].map(|f| apart(&f.light, &truth));
        assert!(
            m < p && a < p && m < 9.0,
            "{name}: plain {p} adaptive {a} all {m}"
        );
        let rays = [&plain, &adaptive, &all].map(|f| f.rays.total());
        assert!(rays[0] < rays[1] && rays[1] < rays[2], "{name}: {rays:?}");
        for layer in &adaptive.layers {
            let (least, most) = (layer.samples.iter().min(), layer.samples.iter().max());
            assert_eq!(least, Some(&1), "{name} {}", layer.name);
            assert!(most > Some(&3), "{name} {}: {most:?}", layer.name);
        }
        assert!(all.layers.iter().all(|l| l.mean() == f64::from(MOST)));
        for (effect, rays) in adaptive.rays.by_effect() {
            let shown = adaptive.layers.iter().any(|l| l.name == effect);
            assert_eq!(rays > 0, shown, "{name} {effect}");
        }
    }
}

#[test]
fn sets_are_disjoint_and_each_is_well_spread() {
    let sets = super::sets::Sets::new(9, 9);
    let mut all = Vec::new();
    for set in 0..9 {
        let of_set: Vec<[f32; 2]> = (0..9).map(|p| sets.point(p, set)).collect();
        // Nine points: three in a third of either axis, give or take two.
        for axis in 0..2 {
            for third in 0..3 {
                let n = of_set
                    .iter()
                    .filter(|p| (p[axis] * 3.0) as i32 == third)
                    .count();
                assert!((1..=5).contains(&n), "set {set}, axis {axis}: {n}");
            }
        }
        all.extend(of_set.iter().map(|p| p.map(f32::to_bits)));
    }
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), 81);
}
