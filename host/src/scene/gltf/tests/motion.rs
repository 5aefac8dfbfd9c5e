//! Clips, splines and skins.

use super::loading::{loaded, texts};
use super::*;
use crate::scene::animate::Animation;
use crate::scene::{Interpolation, Track};
use glam::Vec3;

/// Adds a clip that slides node 0 along x from `times`/`values` in the view 2.
fn slide(
    root: &mut Value,
    name: &str,
    offset: usize,
    keys: usize,
    node: usize,
    interpolation: &str,
) {
    let per_key = if interpolation == "CUBICSPLINE" { 3 } else { 1 };
    let input = accessor(
        root,
        json!({ "bufferView": 2, "byteOffset": offset, "componentType": 5126, "type": "SCALAR",
                "count": keys, "min": [0], "max": [9] }),
    );
    let output = accessor(
        root,
        json!({ "bufferView": 2, "byteOffset": offset + 4 * keys, "componentType": 5126,
                "type": "VEC3", "count": keys * per_key }),
    );
    if root["animations"].is_null() {
        root["animations"] = json!([]);
    }
    root["animations"]
        .as_array_mut()
        .expect("a list")
        .push(json!({
            "name": name,
            "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }],
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
        }));
}

#[test]
fn clips_play_together_unless_they_exclude_each_other() {
    let mut more = floats(&[0.0, 2.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    more.extend(floats(&[0.0, 3.0, 7.0, 7.0, 7.0, 7.0, 7.0, 7.0]));
    let (mut root, data) = square(&more);
    root["nodes"] = json!([{ "mesh": 0 }, { "name": "other" }]);
    root["scenes"][0]["nodes"] = json!([0, 1]);
    slide(&mut root, "rest", 32, 2, 0, "LINEAR");
    slide(&mut root, "walk", 0, 2, 0, "LINEAR");
    slide(&mut root, "run", 0, 2, 0, "STEP");
    slide(&mut root, "aside", 0, 2, 1, "STEP");
    let bytes = glb(root, &data);
    let path = Path::new("made.glb");
    let all = load_bytes(&bytes, path, None).expect("loads");
    // "rest" does not move, so it sets the pose and does not shut out "walk"; "run" is shut out.
    let moving: Vec<_> = all
        .scene
        .channels
        .iter()
        .map(|c| (c.node, c.interpolation))
        .collect();
    assert_eq!(
        moving[..2],
        [(0, Interpolation::Linear), (1, Interpolation::Step)]
    );
    assert_eq!(all.scene.nodes[0].translation, Vec3::splat(7.0));
    assert!(
        texts(&all).contains("animation 2 \"run\": is left out"),
        "{}",
        texts(&all)
    );
    let run = load_bytes(&bytes, path, Some("run")).expect("loads").scene;
    assert_eq!(
        (run.channels[0].interpolation, run.channels[0].period),
        (Interpolation::Step, 2.0)
    );
    assert_eq!(run.nodes[0].translation, Vec3::ZERO);
    let error = load_bytes(&bytes, path, Some("fly"))
        .expect_err("no such clip")
        .to_string();
    assert!(
        error.contains("\"fly\"") && error.contains("rest, walk, run, aside"),
        "{error}"
    );
}

#[test]
fn splines_keep_their_tangents() {
    // Two keys of (in-tangent, value, out-tangent).
    let mut keys = floats(&[0.0, 1.0]);
    keys.extend(floats(&[
        0., 0., 0., 1., 0., 0., 6., 0., 0., 5., 0., 0., 2., 0., 0., 0., 0., 0.,
    ]));
    let (mut root, data) = square(&keys);
    slide(&mut root, "spline", 0, 2, 0, "CUBICSPLINE");
    let scene = loaded(root, &data).scene;
    let Track::Translation(values) = &scene.channels[0].track else {
        panic!("a translation")
    };
    assert_eq!((values.len(), values[2].x, values[3].x), (6, 6.0, 5.0));
    // Appendix C at s = ½: p0/2 + p1/2 + (b0 − a1)/8.
    let x = Animation::new(&scene).world(&scene, 0, 0.5).translation.x;
    assert!((x - (0.5 + 1.0 + (6.0 - 5.0) / 8.0)).abs() < 1e-5, "{x}");
}

#[test]
fn skins_are_reordered_with_their_nodes_and_weights_sum_to_one() {
    let mut more = Vec::new();
    for _ in 0..4 {
        more.extend([1, 0, 200, 0, 128, 128, 0, 0]);
    }
    let (mut root, data) = square(&more);
    root["bufferViews"][2]["byteStride"] = json!(8);
    let joints = json!({ "bufferView": 2, "componentType": 5121, "type": "VEC4", "count": 4 });
    let weights = json!({ "bufferView": 2, "byteOffset": 4, "componentType": 5121, "type": "VEC4",
                          "count": 4, "normalized": true });
    let (joints, weights) = (accessor(&mut root, joints), accessor(&mut root, weights));
    root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    root["nodes"] = json!([
        { "name": "hand" },
        { "name": "skinned", "mesh": 0, "skin": 0 },
        { "name": "arm", "children": [0] },
    ]);
    root["scenes"][0]["nodes"] = json!([1, 2]);
    root["skins"] = json!([{ "joints": [2, 0] }]);
    let scene = loaded(root.clone(), &data).scene;
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(
        (primitive.joints[0], primitive.weights[0]),
        ([1, 0, 0, 0], [0.5, 0.5, 0.0, 0.0])
    );
    let names: Vec<_> = scene.skins[0]
        .joints
        .iter()
        .map(|&j| &scene.nodes[j].name)
        .collect();
    assert_eq!(names, ["arm", "hand"]);
    // A joint beyond the skin is a fault, not an index out of bounds later.
    root["skins"] = json!([{ "joints": [2] }]);
    let error = load_json(root, &data)
        .expect_err("joint 1 of 1")
        .to_string();
    assert!(
        error.contains("refers to joint 1 and its skin 0 has 1"),
        "{error}"
    );
}
