//! What a scene calls for: which effects exist in it, and why.
//!
//! An effect that is not called for costs nothing: no ray, no byte on the wire, no RAM at the
//! display. Only what nodes refer to counts: an unused mirror material calls for no mirror.

use super::animate::Animation;
use super::{LightKind, MIRROR_ROUGHNESS, Material, Node, Scene};

/// An effect, and whether a scene calls for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Effect {
    /// Stable name, as in reports.
    pub name: &'static str,
    /// Whether the scene has it.
    pub called_for: bool,
    /// The node or material that calls for it, or what is missing.
    pub because: String,
}

/// All effects there are, in a fixed order, each with the scene's call for it.
///
/// Light between matt surfaces is the ambient term of the sky unless the scene says
/// `indirect`.
#[must_use]
pub fn effects(scene: &Scene) -> Vec<Effect> {
    let animation = Animation::new(scene);
    let light = |wanted: fn(&LightKind) -> bool| {
        let shines = |n: &&Node| {
            n.light
                .is_some_and(|l| l.intensity.max_element() > 0.0 && wanted(&l.kind))
        };
        scene
            .nodes
            .iter()
            .find(shines)
            .map(|n| format!("light on node {:?}", n.name))
    };
    let material = |wanted: fn(&Material) -> bool, what: &str| {
        let found = used(scene).find(|(_, m)| wanted(m));
        found.map(|(node, m)| format!("{what} material {:?} on node {:?}", m.name, node.name))
    };
    let area = material(|m| m.emissive.max_element() > 0.0, "emissive");
    let punctual = light(|_| true);
    let camera = scene.nodes.iter().position(|node| node.camera.is_some());
    let lens = camera.and_then(|c| scene.nodes[c].camera.map(|lens| (c, lens)));
    let mover = scene.nodes.iter().enumerate().find_map(|(i, node)| {
        node.mesh.filter(|&m| {
            scene
                .meshes
                .get(m)
                .is_some_and(|m| !m.primitives.is_empty())
        })?;
        let joints = node
            .skin
            .and_then(|skin| scene.skins.get(skin))
            .map(|skin| &skin.joints);
        match joints {
            Some(joints) => joints
                .iter()
                .find(|&&joint| joint < scene.nodes.len() && animation.moves(joint))
                .map(|&joint| {
                    format!(
                        "joint {:?} moves node {:?}",
                        scene.nodes[joint].name, node.name
                    )
                }),
            None => animation
                .moves(i)
                .then(|| format!("node {:?} moves", node.name)),
        }
    });
    let entry = |name, call: Option<String>, otherwise: &str| Effect {
        name,
        called_for: call.is_some(),
        because: call.unwrap_or_else(|| otherwise.to_owned()),
    };
    vec![
        entry(
            "direct_light",
            punctual.clone().or(area.clone()),
            "no light and nothing emissive",
        ),
        entry(
            "hard_shadows",
            punctual,
            "no point, spot or directional light",
        ),
        entry("soft_shadows", area, "no emissive mesh"),
        entry(
            "mirror",
            material(
                |m| m.metallic > 0.0 && m.roughness <= MIRROR_ROUGHNESS,
                "smooth metal",
            ),
            "no metal is smooth enough to mirror",
        ),
        entry(
            "refraction",
            material(|m| m.transmission > 0.0, "transmitting"),
            "no material transmits light",
        ),
        entry(
            "indirect_diffuse",
            scene
                .indirect
                .then(|| "extras.indirect of the scene".to_owned()),
            "the ambient term of the sky stands for it",
        ),
        entry(
            "medium",
            scene.medium.map(|m| {
                let extinction = m.sigma_s + m.sigma_a;
                format!(
                    "a medium of {extinction} per metre between {} and {}",
                    m.min, m.max
                )
            }),
            "no medium",
        ),
        entry(
            "depth_of_field",
            lens.filter(|(_, lens)| lens.aperture > 0.0)
                .map(|(c, lens)| {
                    format!(
                        "aperture of {} m on camera {:?}",
                        lens.aperture, scene.nodes[c].name
                    )
                }),
            "the camera is a pinhole",
        ),
        entry(
            "textures",
            material(
                |m| {
                    m.base_texture.is_some()
                        || m.emissive_texture.is_some()
                        || m.procedural.is_some()
                },
                "textured",
            ),
            "no texture and no pattern",
        ),
        entry(
            "skinning",
            scene
                .nodes
                .iter()
                .find(|n| n.mesh.is_some() && n.skin.is_some())
                .map(|n| format!("skin on node {:?}", n.name)),
            "no skin",
        ),
        entry(
            "view_motion",
            camera
                .filter(|&c| animation.moves(c))
                .map(|c| format!("camera {:?} moves", scene.nodes[c].name)),
            "the camera is at rest",
        ),
        entry("object_motion", mover, "no mesh moves"),
    ]
}

/// Each material that a node shows, with that node, in the order of nodes.
fn used(scene: &Scene) -> impl Iterator<Item = (&Node, &Material)> {
    scene.nodes.iter().flat_map(move |node| {
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh));
        mesh.into_iter()
            .flat_map(|mesh| &mesh.primitives)
            .filter_map(move |p| scene.materials.get(p.material))
            .map(move |material| (node, material))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Channel, Interpolation, Lens, Light, Medium, Mesh, Primitive, Skin, Track};
    use glam::{Mat4, Vec3};

    fn plain() -> Scene {
        let mesh = Mesh {
            primitives: vec![Primitive::default()],
            ..Mesh::default()
        };
        let lens = Lens {
            yfov: 1.0,
            aperture: 0.0,
            focus: 1.0,
        };
        Scene {
            nodes: vec![
                Node {
                    name: "root".into(),
                    ..Node::default()
                },
                Node {
                    name: "thing".into(),
                    mesh: Some(0),
                    ..Node::default()
                },
                Node {
                    name: "eye".into(),
                    parent: Some(0),
                    camera: Some(lens),
                    ..Node::default()
                },
            ],
            meshes: vec![mesh],
            // The second is not used and calls for nothing.
            materials: vec![
                Material::default(),
                Material {
                    transmission: 1.0,
                    emissive: Vec3::ONE,
                    metallic: 1.0,
                    roughness: 0.0,
                    ..Material::default()
                },
            ],
            ..Scene::default()
        }
    }

    fn called(scene: &Scene) -> Vec<&'static str> {
        effects(scene)
            .iter()
            .filter(|e| e.called_for)
            .map(|e| e.name)
            .collect()
    }

    fn slide(node: usize) -> Channel {
        Channel {
            node,
            track: Track::Translation(vec![Vec3::ZERO, Vec3::X]),
            times: vec![0.0, 1.0],
            interpolation: Interpolation::Linear,
            period: 1.0,
        }
    }

    #[test]
    fn a_plain_scene_calls_for_nothing() {
        assert_eq!(called(&plain()), [""; 0]);
        assert_eq!(effects(&plain()).len(), 12);
    }

    #[test]
    fn each_cause_calls_for_its_effect_alone() {
        let light = |kind| Light {
            kind,
            intensity: Vec3::ONE,
            range: f32::INFINITY,
        };
        // What is done to the scene, the effects that it then calls for, whom the last one names.
        type Case<'a> = (&'a dyn Fn(&mut Scene), &'a [&'a str], &'a str);
        let cases: [Case<'_>; 12] = [
            (
                &|s| s.nodes[0].light = Some(light(LightKind::Point)),
                &["direct_light", "hard_shadows"],
                "root",
            ),
            (
                &|s| s.materials[0].emissive = Vec3::X,
                &["direct_light", "soft_shadows"],
                "thing",
            ),
            (
                &|s| {
                    s.materials[0].metallic = 1.0;
                    s.materials[0].roughness = MIRROR_ROUGHNESS;
                },
                &["mirror"],
                "thing",
            ),
            (
                &|s| s.materials[0].transmission = 0.5,
                &["refraction"],
                "thing",
            ),
            (
                &|s| {
                    s.medium = Some(Medium {
                        min: Vec3::ZERO,
                        max: Vec3::ONE,
                        sigma_s: 0.25,
                        sigma_a: 0.5,
                        g: 0.0,
                    });
                },
                &["medium"],
                "0.75",
            ),
            (&|s| s.indirect = true, &["indirect_diffuse"], "extras"),
            (
                &|s| {
                    s.nodes[2].camera = Some(Lens {
                        yfov: 1.0,
                        aperture: 0.1,
                        focus: 1.0,
                    })
                },
                &["depth_of_field"],
                "eye",
            ),
            (
                &|s| {
                    s.materials[0].procedural = Some(crate::scene::Procedural::Stripes {
                        period: 1.0,
                        other: Vec3::X,
                    });
                },
                &["textures"],
                "thing",
            ),
            (
                &|s| {
                    s.skins.push(Skin {
                        joints: vec![0],
                        inverse_bind: vec![Mat4::IDENTITY],
                    });
                    s.nodes[1].skin = Some(0);
                },
                &["skinning"],
                "thing",
            ),
            (&|s| s.channels.push(slide(0)), &["view_motion"], "eye"),
            (&|s| s.channels.push(slide(1)), &["object_motion"], "thing"),
            (
                &|s| {
                    s.skins.push(Skin {
                        joints: vec![0],
                        inverse_bind: vec![Mat4::IDENTITY],
                    });
                    s.nodes[1].skin = Some(0);
                    s.channels.push(slide(0));
                },
                &["skinning", "view_motion", "object_motion"],
                "root",
            ),
        ];
        for (cause, expected, named) in cases {
            let mut scene = plain();
            cause(&mut scene);
            assert_eq!(called(&scene), expected);
            let because = effects(&scene);
            let because = because.iter().rfind(|e| e.called_for).map(|e| &e.because);
            assert!(
                because.is_some_and(|b| b.contains(named)),
                "{because:?} names {named}"
            );
        }
    }

    #[test]
    fn keys_that_are_equal_and_dark_lights_call_for_nothing() {
        let mut scene = plain();
        scene.channels.push(Channel {
            track: Track::Scale(vec![Vec3::ONE; 2]),
            ..slide(1)
        });
        scene.nodes[0].light = Some(Light {
            kind: LightKind::Point,
            intensity: Vec3::ZERO,
            range: f32::INFINITY,
        });
        assert_eq!(called(&scene), [""; 0]);
    }
}
