//! Export, load, compare.

use super::*;
use crate::scene::gltf::{ExportError, export};
use crate::scene::*;
use crate::trace::pattern::pattern;
use glam::{Mat4, Quat, Vec2, Vec3, Vec4};

/// A scene with one of everything that the format can carry unchanged.
pub(super) fn small_scene() -> Scene {
    let node = |name: &str, parent| Node {
        name: name.into(),
        parent,
        ..Node::default()
    };
    let quad = Primitive {
        positions: [(-1., 0.), (1., 0.), (1., 2.), (-1., 2.)]
            .map(|(x, y)| Vec3::new(x, y, 0.25))
            .to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        colours: vec![Vec4::new(0.5, 0.25, 1.0, 1.0); 4],
        joints: vec![[0, 1, 0, 0]; 4],
        weights: vec![[0.75, 0.25, 0.0, 0.0]; 4],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        material: 0,
    };
    let bare = Primitive {
        positions: quad.positions.clone(),
        indices: vec![[0, 1, 2]],
        material: 1,
        ..Primitive::default()
    };
    let texture = TextureRef {
        texture: 0,
        scale: Vec2::new(2.0, 0.5),
        offset: Vec2::Y,
    };
    let light = |kind, range| {
        Some(Light {
            kind,
            intensity: Vec3::new(3.0, 1.5, 0.0),
            range,
        })
    };
    let quarter = Quat::from_rotation_y(1.5);
    Scene {
        name: "small".into(),
        nodes: vec![
            Node {
                translation: Vec3::new(1.0, 2.0, 3.0),
                ..node("root", None)
            },
            Node {
                mesh: Some(0),
                skin: Some(0),
                ..node("skinned", Some(0))
            },
            Node {
                rotation: quarter,
                scale: Vec3::splat(0.5),
                mesh: Some(1),
                ..node("b", Some(1))
            },
            Node {
                light: light(LightKind::Point, 5.0),
                ..node("lamp", Some(0))
            },
            Node {
                light: light(
                    LightKind::Spot {
                        inner: 0.1,
                        outer: 0.5,
                    },
                    f32::INFINITY,
                ),
                ..node("spot", None)
            },
            Node {
                light: light(LightKind::Directional, f32::INFINITY),
                ..node("sun", None)
            },
            Node {
                camera: Some(Lens {
                    yfov: 0.8,
                    aperture: 0.02,
                    focus: 2.5,
                }),
                ..node("camera", Some(5))
            },
        ],
        meshes: vec![
            Mesh {
                name: "quad".into(),
                primitives: vec![quad],
            },
            Mesh {
                name: "bare".into(),
                primitives: vec![bare],
            },
        ],
        materials: vec![
            Material {
                name: "painted".into(),
                base_texture: Some(texture),
                emissive_texture: Some(texture),
                emissive: Vec3::new(0.5, 8.0, 0.0),
                metallic: 1.0,
                roughness: 0.0,
                double_sided: false,
                alpha_cutoff: Some(0.5),
                ..Material::default()
            },
            Material {
                name: "glass".into(),
                base_colour: Vec4::new(0.9, 1.0, 0.9, 1.0),
                transmission: 1.0,
                ior: 1.4,
                unlit: true,
                ..Material::default()
            },
        ],
        textures: vec![Texture {
            name: "paint".into(),
            width: 2,
            height: 2,
            rgba: vec![
                [1, 2, 3, 255],
                [250, 0, 0, 0],
                [0, 250, 0, 128],
                [9, 9, 9, 9],
            ],
            repeat_u: true,
            repeat_v: false,
        }],
        skins: vec![Skin {
            joints: vec![2, 0],
            inverse_bind: vec![Mat4::IDENTITY, Mat4::from_translation(Vec3::Y)],
        }],
        channels: vec![
            Channel {
                node: 2,
                track: Track::Rotation(vec![Quat::IDENTITY, quarter]),
                times: vec![0.0, 2.0],
                interpolation: Interpolation::Linear,
                period: 2.0,
            },
            Channel {
                node: 0,
                track: Track::Scale(vec![Vec3::ONE, Vec3::splat(2.0)]),
                times: vec![0.5, 3.0],
                interpolation: Interpolation::Step,
                period: 3.0,
            },
            Channel {
                node: 6,
                track: Track::Translation([0., 0., 1., 2., 5., 0.].map(Vec3::splat).to_vec()),
                times: vec![0.0, 3.0],
                interpolation: Interpolation::CubicSpline,
                period: 3.0,
            },
        ],
        duration: 3.0,
        sky: Sky {
            zenith: Vec3::Z,
            horizon: Vec3::splat(0.5),
            ambient: Vec3::splat(0.1),
        },
        indirect: true,
        medium: Some(Medium {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
            sigma_s: 0.5,
            sigma_a: 0.125,
            g: -0.25,
        }),
    }
}

fn back(scene: &Scene) -> Loaded {
    let bytes = export(scene).unwrap_or_else(|error| panic!("{error}"));
    load_bytes(&bytes, Path::new("small.glb"), None).unwrap_or_else(|error| panic!("{error}"))
}

/// Nodes come back in depth-first order: compare each by its name.
#[track_caller]
fn assert_same_nodes(a: &Scene, b: &Scene) {
    assert_eq!(a.nodes.len(), b.nodes.len());
    let name = |scene: &Scene, n: Option<usize>| n.map(|n| scene.nodes[n].name.clone());
    for node in &a.nodes {
        let other = b
            .nodes
            .iter()
            .find(|n| n.name == node.name)
            .expect("the same name");
        assert_eq!(name(a, node.parent), name(b, other.parent));
        assert_eq!(
            (node.translation, node.scale),
            (other.translation, other.scale)
        );
        assert!(node.rotation.abs_diff_eq(other.rotation, 1e-6));
        assert_eq!(
            (node.mesh, node.skin, node.camera),
            (other.mesh, other.skin, other.camera)
        );
        assert_eq!(node.light, other.light);
    }
}

#[test]
fn a_scene_comes_back_as_it_was() {
    let scene = small_scene();
    let Loaded {
        scene: other,
        warnings,
    } = back(&scene);
    assert_eq!(warnings, []);
    assert_eq!((&other.name, other.duration), (&scene.name, scene.duration));
    assert_same_nodes(&scene, &other);
    assert_eq!(other.materials, scene.materials);
    assert_eq!((other.sky, other.medium), (scene.sky, scene.medium));
    assert!(other.indirect && scene.indirect);
    for (a, b) in scene.meshes.iter().zip(&other.meshes) {
        assert_eq!(
            (&a.name, format!("{:?}", a.primitives)),
            (&b.name, format!("{:?}", b.primitives))
        );
    }
    let (a, b) = (&scene.textures[0], &other.textures[0]);
    assert_eq!(
        (a.width, &a.rgba, a.repeat_u, a.repeat_v),
        (b.width, &b.rgba, b.repeat_u, b.repeat_v)
    );
    assert_eq!(other.skins[0].inverse_bind, scene.skins[0].inverse_bind);
    assert_eq!(other.channels.len(), 3);
    for (a, b) in scene.channels.iter().zip(&other.channels) {
        assert_eq!(scene.nodes[a.node].name, other.nodes[b.node].name);
        assert_eq!(
            (&a.times, a.period, a.interpolation),
            (&b.times, b.period, b.interpolation)
        );
        assert_eq!(format!("{:?}", a.track), format!("{:?}", b.track));
    }
}

#[test]
fn periods_longer_than_the_keys_are_padded_and_kept() {
    let mut scene = small_scene();
    for channel in &mut scene.channels {
        channel.period = 4.0;
    }
    let other = back(&scene).scene;
    let (before, after) = (
        animate::Animation::new(&scene),
        animate::Animation::new(&other),
    );
    assert_eq!(other.duration, 4.0);
    for step in 0..80 {
        let t = f64::from(step) * 0.1;
        for (n, node) in scene.nodes.iter().enumerate() {
            let m = other
                .nodes
                .iter()
                .position(|o| o.name == node.name)
                .expect("the node");
            let (a, b) = (before.world(&scene, n, t), after.world(&other, m, t));
            assert!(a.abs_diff_eq(b, 1e-4), "{t} {}: {a:?} {b:?}", node.name);
        }
    }
    assert!(other.channels.iter().all(|c| c.times.last() == Some(&4.0)));
}

#[test]
fn patterns_become_images_that_look_the_same() {
    let other = Vec3::new(0.1, 0.2, 0.8);
    for procedural in [
        Procedural::Checker { size: 0.3, other },
        Procedural::Brick {
            size: Vec2::new(0.5, 0.2),
            joint: 0.04,
            mortar: other,
        },
        Procedural::Stripes { period: 0.7, other },
    ] {
        let mut scene = small_scene();
        let colour = Vec3::new(0.9, 0.5, 0.4);
        scene.materials[1] = Material {
            name: "pattern".into(),
            procedural: Some(procedural),
            base_colour: colour.extend(1.0),
            ..Material::default()
        };
        let loaded = back(&scene).scene;
        let material = &loaded.materials[1];
        let used = material.base_texture.expect("baked");
        let texture = &loaded.textures[used.texture];
        assert!(texture.repeat_u && texture.repeat_v && material.base_colour == Vec4::ONE);
        let (mut same, mut points) = (0, 0);
        for i in 0..2000 {
            let uv = Vec2::new(i as f32 * 0.0137 - 9.0, (i as f32 * 0.0071).sin() * 3.0);
            let at = uv * used.scale + used.offset;
            let texel = (at - at.floor()) * Vec2::new(texture.width as f32, texture.height as f32);
            let [r, g, b, _] =
                texture.rgba[texel.y as usize * texture.width as usize + texel.x as usize];
            let expected =
                crate::trace::srgb::encode8(pattern(&procedural, uv, Vec2::ZERO) * colour);
            points += 1;
            same += usize::from(
                [r, g, b]
                    .iter()
                    .zip(expected)
                    .all(|(&a, b)| a.abs_diff(b) <= 1),
            );
        }
        // All but the points on an edge texel.
        assert!(
            same * 100 >= points * 97,
            "{procedural:?}: {same} of {points}"
        );
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    assert_eq!(
        export(&small_scene()).expect("exports"),
        export(&small_scene()).expect("exports")
    );
}

#[test]
fn scenes_that_contradict_themselves_are_refused() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = small_scene();
        change(&mut scene);
        export(&scene).expect_err("refused")
    };
    assert!(matches!(
        refused(&|s| s.nodes[1].mesh = Some(9)),
        ExportError::Index { index: 9, .. }
    ));
    assert!(matches!(
        refused(&|s| s.nodes[0].parent = Some(0)),
        ExportError::Index { .. }
    ));
    assert!(matches!(
        refused(&|s| s.textures[0].width = 3),
        ExportError::Texture { .. }
    ));
    let pattern = Procedural::Stripes {
        period: 1.0,
        other: Vec3::X,
    };
    assert!(matches!(
        refused(&|s| s.materials[0].procedural = Some(pattern)),
        ExportError::TwoTextures(_)
    ));
}

/// Every built-in scene looks the same after a round trip: the same triangles in the same places
/// at the same times, under the same lights.
#[test]
fn built_in_scenes_come_back() {
    for name in builtin::BUILTIN {
        let scene = builtin::builtin(name).expect("built in");
        let Loaded {
            scene: other,
            warnings,
        } = back(&scene);
        assert_eq!(warnings, [], "{name}");
        let (a, b) = (
            animate::Animation::new(&scene),
            animate::Animation::new(&other),
        );
        assert_eq!(
            scene.nodes.len(),
            other.nodes.len(),
            "{name}: nothing had to be added"
        );
        assert_eq!((scene.sky, scene.medium), (other.sky, other.medium));
        let lights = |s: &Scene| -> Vec<_> { s.nodes.iter().filter_map(|n| n.light).collect() };
        assert_eq!(lights(&scene).len(), lights(&other).len());
        for t in [0.0, 0.37, 1.91, 5.3] {
            assert_eq!(
                places(&scene, &a, t),
                places(&other, &b, t),
                "{name} at {t}"
            );
        }
        let called = |s: &Scene| -> Vec<_> {
            calls::effects(s)
                .into_iter()
                .map(|e| (e.name, e.called_for))
                .collect()
        };
        assert_eq!(called(&scene), called(&other), "{name}");
    }
}

/// World positions (millimetres) of the first vertex of everything that is shown, sorted.
fn places(scene: &Scene, animation: &animate::Animation, t: f64) -> Vec<[i32; 3]> {
    let mut places: Vec<[i32; 3]> = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let world = animation.world(scene, index, t);
        let primitives = node
            .mesh
            .into_iter()
            .flat_map(|m| &scene.meshes[m].primitives);
        let first = primitives
            .map(|p| p.positions[0])
            .chain(node.camera.map(|_| Vec3::ZERO));
        places.extend(first.map(|p| {
            (world.transform_point3(p) * 1000.0)
                .round()
                .to_array()
                .map(|x| x as i32)
        }));
    }
    places.sort_unstable();
    places
}
