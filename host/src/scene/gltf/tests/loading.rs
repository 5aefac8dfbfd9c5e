//! Each feature of the format on the smallest file that has it.

use super::*;
use crate::scene::animate::Animation;
use crate::scene::{LightKind, Scene};
use glam::{Quat, Vec2, Vec3, Vec4};

pub(super) fn loaded(root: Value, data: &[u8]) -> Loaded {
    load_json(root, data).unwrap_or_else(|error| panic!("{error}"))
}

pub(super) fn texts(loaded: &Loaded) -> String {
    loaded.warnings.iter().map(|w| format!("{w}\n")).collect()
}

fn triangles(scene: &Scene) -> &[[u32; 3]] {
    &scene.meshes[0].primitives[0].indices
}

#[test]
fn a_bare_mesh_gets_a_camera_a_sky_and_a_key_light() {
    let (root, data) = square(&[]);
    let scene = loaded(root, &data).scene;
    assert_eq!(triangles(&scene), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(scene.duration, 12.0);
    assert!(scene.sky.ambient.min_element() > 0.0 && scene.sky.zenith != scene.sky.horizon);
    let key = scene.nodes.iter().find_map(|n| n.light).expect("a light");
    assert_eq!(key.kind, LightKind::Directional);
    // The orbiting camera keeps the whole square in view, looks down on its centre, and uses
    // the picture: the margin is 1.2, not 3.
    let animation = Animation::new(&scene);
    let camera = scene
        .nodes
        .iter()
        .position(|n| n.camera.is_some())
        .expect("a camera");
    let half = (scene.nodes[camera].camera.expect("a lens").yfov * 0.5).tan();
    for step in 0..12 {
        let world = animation.world(&scene, camera, f64::from(step));
        assert!(world.translation.y > 0.0);
        let seen = world.inverse();
        assert!(
            seen.transform_point3(Vec3::ZERO).truncate().length() < 1e-4,
            "{step}"
        );
        let extent = scene.meshes[0].primitives[0]
            .positions
            .iter()
            .map(|&p| seen.transform_point3(p))
            .map(|p| p.truncate().abs().max_element() / (-p.z * half))
            .fold(0.0, f32::max);
        assert!((0.3..0.9).contains(&extent), "{step}: {extent}");
    }
}

#[test]
fn strips_fans_and_missing_indices_wind_as_the_specification_says() {
    for (mode, expected) in [
        (5, vec![[0, 1, 2], [1, 3, 2]]),
        (6, vec![[1, 2, 0], [2, 3, 0]]),
        (4, vec![[0, 1, 2]]),
    ] {
        let (mut root, data) = square(&[]);
        let primitive = &mut root["meshes"][0]["primitives"][0];
        primitive["mode"] = json!(mode);
        primitive
            .as_object_mut()
            .expect("an object")
            .remove("indices");
        assert_eq!(
            triangles(&loaded(root, &data).scene),
            expected,
            "mode {mode}"
        );
    }
}

#[test]
fn indices_of_all_widths_are_the_same() {
    for (component, bytes) in [
        (5121, [0_u8, 1, 2, 0, 2, 3].to_vec()),
        (
            5125,
            [0_u32, 1, 2, 0, 2, 3]
                .iter()
                .flat_map(|i| i.to_le_bytes())
                .collect(),
        ),
    ] {
        let (mut root, data) = square(&bytes);
        let value =
            json!({ "bufferView": 2, "componentType": component, "type": "SCALAR", "count": 6 });
        let index = accessor(&mut root, value);
        root["meshes"][0]["primitives"][0]["indices"] = json!(index);
        assert_eq!(
            triangles(&loaded(root, &data).scene),
            [[0, 1, 2], [0, 2, 3]]
        );
    }
}

#[test]
fn sparse_accessors_replace_elements_with_and_without_a_base() {
    // Index 3 (u8, padded), then its value.
    let mut more = vec![3, 0, 0, 0];
    more.extend(floats(&[5.0, 6.0, 7.0]));
    for base in [true, false] {
        let (mut root, data) = square(&more);
        let sparse = json!({
            "count": 1,
            "indices": { "bufferView": 2, "componentType": 5121 },
            "values": { "bufferView": 2, "byteOffset": 4 },
        });
        root["accessors"][0]["sparse"] = sparse;
        if !base {
            root["accessors"][0]
                .as_object_mut()
                .expect("an object")
                .remove("bufferView");
        }
        let scene = loaded(root, &data).scene;
        let positions = &scene.meshes[0].primitives[0].positions;
        assert_eq!(positions[3], Vec3::new(5.0, 6.0, 7.0));
        assert_eq!(
            positions[0],
            if base {
                Vec3::new(-1.0, -1.0, 0.0)
            } else {
                Vec3::ZERO
            }
        );
    }
}

#[test]
fn strides_and_normalised_integers_are_decoded() {
    // Four vertices of u8 colours (VEC3 normalised, stride 4) after eight bytes of u16 uvs each.
    let mut more = Vec::new();
    for i in 0..4_u16 {
        more.extend((i * 21_845).to_le_bytes());
        more.extend(0_u16.to_le_bytes());
        more.extend([255, 0, 51, 99]);
    }
    let (mut root, data) = square(&more);
    root["bufferViews"][2]["byteStride"] = json!(8);
    let uv = json!({ "bufferView": 2, "componentType": 5123, "type": "VEC2", "count": 4, "normalized": true });
    let colour = json!({ "bufferView": 2, "byteOffset": 4, "componentType": 5121, "type": "VEC3",
                         "count": 4, "normalized": true });
    let (uv, colour) = (accessor(&mut root, uv), accessor(&mut root, colour));
    root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colour);
    let scene = loaded(root, &data).scene;
    let primitive = &scene.meshes[0].primitives[0];
    assert_eq!(primitive.colours, [Vec4::new(1.0, 0.0, 0.2, 1.0); 4]);
    assert_eq!(primitive.uvs[3], Vec2::new(1.0, 0.0));
    assert!((primitive.uvs[1].x - 1.0 / 3.0).abs() < 1e-6);
}

#[test]
fn children_before_parents_in_the_file_come_after_them_here() {
    let (mut root, data) = square(&[]);
    root["nodes"] = json!([
        { "name": "leaf", "mesh": 0, "translation": [1, 0, 0] },
        { "name": "outside", "children": [3] },
        { "name": "trunk", "children": [0], "matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1] },
        { "name": "hidden", "mesh": 0 },
    ]);
    root["scenes"][0]["nodes"] = json!([2]);
    let scene = loaded(root, &data).scene;
    assert!(
        scene
            .nodes
            .iter()
            .enumerate()
            .all(|(i, n)| n.parent.is_none_or(|p| p < i))
    );
    let leaf = scene
        .nodes
        .iter()
        .position(|n| n.name == "leaf")
        .expect("the leaf");
    // The trunk turns x to y, doubles it and shifts it by 5.
    let at = Animation::new(&scene)
        .world(&scene, leaf, 0.0)
        .transform_point3(Vec3::ZERO);
    assert!(at.abs_diff_eq(Vec3::new(5.0, 2.0, 0.0), 1e-5), "{at}");
    let hidden = scene
        .nodes
        .iter()
        .find(|n| n.name == "hidden")
        .expect("the hidden node");
    assert_eq!(hidden.mesh, None, "nodes outside the scene are not shown");
}

#[test]
fn materials_lights_cameras_and_extras_are_read() {
    let (mut root, data) = square(&[]);
    root["materials"] = json!([{
        "name": "glow", "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.2, 0.3, 1], "metallicFactor": 0.25, "roughnessFactor": 0.75 },
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 4 },
            "KHR_materials_transmission": { "transmissionFactor": 0.5 },
            "KHR_materials_ior": { "ior": 1.25 }, "KHR_materials_unlit": {},
        },
    }]);
    root["meshes"][0]["primitives"][0]["material"] = json!(0);
    root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "color": [1, 0.5, 0.25], "intensity": 2, "range": 9,
          "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
    ] } });
    root["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 },
                               "extras": { "aperture": 0.01 } }]);
    root["nodes"] = json!([
        { "mesh": 0 },
        { "camera": 0, "translation": [0, 0, 7] },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [0, 0, 2] },
    ]);
    root["scenes"][0]["nodes"] = json!([0, 1, 2]);
    root["extras"] = json!({ "medium": { "aabb": [[-1, 0, -1], [1, 2, 1]], "sigma_s": 0.5, "sigma_a": 0.25, "g": 0.3 } });
    let loaded = loaded(root, &data);
    let scene = &loaded.scene;
    let m = &scene.materials[0];
    assert_eq!(m.emissive, Vec3::new(4.0, 2.0, 0.0));
    assert_eq!(m.base_colour, Vec4::new(0.1, 0.2, 0.3, 1.0));
    assert_eq!(
        (m.metallic, m.roughness, m.transmission, m.ior),
        (0.25, 0.75, 0.5, 1.25)
    );
    assert_eq!(
        (m.alpha_cutoff, m.double_sided, m.unlit),
        (Some(0.25), true, true)
    );
    let light = scene.nodes[2].light.expect("a light");
    assert_eq!(
        light.kind,
        LightKind::Spot {
            inner: 0.1,
            outer: 0.2
        }
    );
    assert_eq!(
        (light.intensity, light.range),
        (Vec3::new(2.0, 1.0, 0.5), 9.0)
    );
    let lens = scene.nodes[1].camera.expect("a camera");
    assert_eq!((lens.yfov, lens.aperture), (0.5, 0.01));
    assert!(
        (lens.focus - 7.0).abs() < 1e-5,
        "focus rests on the scene: {}",
        lens.focus
    );
    let medium = scene.medium.expect("a medium");
    assert_eq!((medium.sigma_s, medium.sigma_a, medium.g), (0.5, 0.25, 0.3));
    assert_eq!((medium.min.y, medium.max.y), (0.0, 2.0));
    assert_eq!(scene.duration, 0.0);
    assert_eq!(loaded.warnings, []);
}

#[test]
fn photometric_lights_are_scaled_together() {
    let (mut root, data) = square(&[]);
    root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "intensity": 100_000 }, { "type": "point", "intensity": 50_000 },
    ] } });
    root["nodes"] = json!([
        { "mesh": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "extensions": { "KHR_lights_punctual": { "light": 1 } }, "translation": [0, 0, 3] },
    ]);
    root["scenes"][0]["nodes"] = json!([0, 1]);
    let loaded = loaded(root, &data);
    let intensity = |n: usize| loaded.scene.nodes[n].light.expect("a light").intensity.x;
    assert!(
        (intensity(0) - std::f32::consts::PI).abs() < 1e-4,
        "sunlit white shows as white"
    );
    assert!((intensity(0) / intensity(1) - 2.0).abs() < 1e-5);
    assert!(texts(&loaded).contains("lights: their intensities"));
}

#[test]
fn blending_becomes_glass_or_a_mask() {
    let (mut root, data) = square(&[]);
    root["materials"] = json!([{ "alphaMode": "BLEND", "pbrMetallicRoughness": {
        "baseColorFactor": [1, 1, 1, 0.25], "roughnessFactor": 0 } }]);
    root["meshes"][0]["primitives"][0]["material"] = json!(0);
    let loaded = loaded(root, &data);
    let m = &loaded.scene.materials[0];
    assert_eq!(
        (m.transmission, m.metallic, m.ior, m.alpha_cutoff),
        (0.75, 0.0, 1.5, None)
    );
    assert!(texts(&loaded).contains("shown as transmission"));
}

/// A PNG of one texel and a JPEG, as `data:` URIs and files with escaped names.
#[test]
fn images_come_from_views_uris_and_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let red = image::RgbaImage::from_pixel(2, 1, image::Rgba([250, 10, 20, 128]));
    let jpeg = image::RgbImage::from_pixel(16, 16, image::Rgb([0, 200, 0]));
    red.save(folder.path().join("a b.png")).expect("saved");
    jpeg.save(folder.path().join("c.jpg")).expect("saved");
    let png = std::fs::read(folder.path().join("a b.png")).expect("read");
    let (mut root, data) = square(&png);
    root["bufferViews"][2]["byteLength"] = json!(png.len());
    root["images"] = json!([
        { "uri": "a%20b.png" },
        { "uri": "../".to_owned() + &folder.path().file_name().expect("a name").to_string_lossy() + "/c.jpg" },
        { "bufferView": 2, "mimeType": "image/png", "name": "inside" },
        { "uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==" },
    ]);
    root["samplers"] = json!([{}, { "wrapS": 33071 }]);
    root["textures"] = json!([
        { "source": 0 }, { "source": 1, "sampler": 1 }, { "source": 2 }, { "source": 3 },
        { "source": 0, "sampler": 1 }, { "source": 0, "sampler": 0 },
    ]);
    let uses: Vec<Value> = (0..6)
        .map(|i| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } }))
        .collect();
    root["materials"] = json!(uses);
    let scene = load_bytes(&glb(root, &data), &folder.path().join("made.glb"), None)
        .unwrap_or_else(|error| panic!("{error}"))
        .scene;
    let used =
        |m: usize| &scene.textures[scene.materials[m].base_texture.expect("a texture").texture];
    assert_eq!(
        (used(0).width, used(0).height, used(0).rgba[1]),
        (2, 1, [250, 10, 20, 128])
    );
    assert_eq!(
        (used(0).repeat_u, used(1).repeat_u, used(1).repeat_v),
        (true, false, true)
    );
    let [r, g, b, a] = used(1).rgba[100];
    assert!(
        r < 8 && g.abs_diff(200) < 8 && b < 8 && a == 255,
        "{:?}",
        used(1).rgba[100]
    );
    assert_eq!(used(2).rgba, used(0).rgba);
    assert_eq!(used(2).name, "inside");
    assert_eq!(used(3).rgba, [[255, 0, 0, 127]]);
    // The same image and wrapping is one texture, another wrapping another.
    assert_eq!(scene.textures.len(), 5);
    assert!(std::ptr::eq(used(0), used(5)) && !used(4).repeat_u);
}

#[test]
fn texture_transforms_scale_and_turn_coordinates() {
    let uvs = floats(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    let png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg==";
    for turned in [false, true] {
        let (mut root, data) = square(&uvs);
        let uv = accessor(
            &mut root,
            json!({ "bufferView": 2, "componentType": 5126, "type": "VEC2", "count": 4 }),
        );
        let primitive = &mut root["meshes"][0]["primitives"][0];
        primitive["attributes"]["TEXCOORD_1"] = json!(uv);
        primitive["material"] = json!(0);
        root["images"] = json!([{ "uri": png }]);
        root["textures"] = json!([{ "source": 0 }]);
        let rotation = if turned {
            std::f32::consts::FRAC_PI_2
        } else {
            0.0
        };
        root["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": {
            "index": 0, "extensions": { "KHR_texture_transform": {
                "scale": [2, 3], "offset": [0.5, 0.25], "rotation": rotation, "texCoord": 1 } } } } }]);
        let scene = loaded(root, &data).scene;
        let used = scene.materials[0].base_texture.expect("a texture");
        let at = |i: usize| scene.meshes[0].primitives[0].uvs[i] * used.scale + used.offset;
        assert_eq!(at(0), Vec2::new(0.5, 0.25));
        // The extension's own example: a rotation of 90° takes u to −v.
        let expected = if turned {
            Vec2::new(0.5, -1.75)
        } else {
            Vec2::new(2.5, 0.25)
        };
        assert!(at(1).abs_diff_eq(expected, 1e-6), "{turned}: {}", at(1));
    }
}

#[test]
fn an_orthographic_camera_is_approximated() {
    let (mut root, data) = square(&[]);
    root["cameras"] = json!([{ "type": "orthographic",
        "orthographic": { "xmag": 2, "ymag": 1.5, "znear": 0.1, "zfar": 10 } }]);
    root["nodes"] = json!([{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, 5] }]);
    root["scenes"][0]["nodes"] = json!([0, 1]);
    let loaded = loaded(root, &data);
    let lens = loaded.scene.nodes[1].camera.expect("a camera");
    // At the scene's distance the view is as high as the orthographic one.
    assert!(((lens.yfov * 0.5).tan() * 5.0 - 1.5).abs() < 1e-5);
    assert!(texts(&loaded).contains("shown in perspective"));
}

#[test]
fn rotations_are_unit_even_if_the_file_is_not() {
    let (mut root, data) = square(&[]);
    root["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    assert_eq!(loaded(root, &data).scene.nodes[0].rotation, Quat::IDENTITY);
}
