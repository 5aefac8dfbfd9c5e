//! Broken files: each an error that says what and where, never a panic.

use super::*;
use crate::scene::gltf::{export, load};

/// Loads the square after a change to its document; the error it must give.
fn broken(change: impl Fn(&mut Value)) -> String {
    let (mut root, data) = square(&[0; 64]);
    assert!(
        load_json(root.clone(), &data).is_ok(),
        "the square itself loads"
    );
    change(&mut root);
    match load_json(root, &data) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("was loaded"),
    }
}

#[track_caller]
fn assert_says(error: &str, parts: &[&str]) {
    for part in parts {
        assert!(error.contains(part), "{error:?} says {part:?}");
    }
}

#[test]
fn what_is_not_there_or_not_gltf() {
    let error = load(Path::new("no/such/file.glb"), None)
        .expect_err("missing")
        .to_string();
    assert_says(&error, &["no/such/file.glb", "check the path"]);
    for (bytes, says) in [
        (&b""[..], "it is empty"),
        (b"glTF", "too few for a GLB header"),
        (b"glTF\x02\0\0\0\x01\0\0\0", "declares 1 bytes"),
        (b"{ \"asset\": ", "EOF"),
        (b"\x89PNG", "expected value"),
        (b"{}", "asset"),
    ] {
        let error = load_bytes(bytes, Path::new("x.glb"), None)
            .expect_err("broken")
            .to_string();
        assert_says(&error, &["x.glb", says]);
    }
}

#[test]
fn truncation_at_every_length_is_an_error() {
    let (root, data) = square(&[]);
    let whole = glb(root, &data);
    for length in 0..whole.len() {
        assert!(
            load_bytes(&whole[..length], Path::new("cut.glb"), None).is_err(),
            "{length}"
        );
    }
}

#[test]
fn unsupported_required_extensions_are_named() {
    let error = broken(|root| {
        root["extensionsRequired"] = json!([
            "KHR_lights_punctual",
            "KHR_draco_mesh_compression",
            "EXT_meshopt_compression"
        ]);
    });
    assert_says(
        &error,
        &[
            "KHR_draco_mesh_compression, EXT_meshopt_compression",
            "without them",
        ],
    );
    assert!(!error.contains("KHR_lights_punctual"));
}

#[test]
fn indices_and_ranges_are_checked_with_their_place() {
    let says = |change: &dyn Fn(&mut Value), parts: &[&str]| assert_says(&broken(change), parts);
    says(
        &|r| r["accessors"][1]["count"] = json!(7),
        &[
            "mesh 0 \"square\", primitive 0, indices",
            "accessor 1",
            "7 elements",
        ],
    );
    says(
        &|r| r["accessors"][0]["count"] = json!(3),
        &["index 5 is vertex 3 of 3"],
    );
    says(
        &|r| r["accessors"][0]["count"] = json!(u64::MAX),
        &["mesh 0", "accessor 0"],
    );
    says(
        &|r| r["accessors"][0]["byteOffset"] = json!(u64::MAX - 8),
        &["exceed buffer view 0"],
    );
    says(
        &|r| r["bufferViews"][0]["byteLength"] = json!(u64::MAX),
        &["buffer view 0 covers"],
    );
    says(
        &|r| r["accessors"][0]["bufferView"] = json!(9),
        &["accessors[0].bufferView", "out of bounds"],
    );
    says(
        &|r| r["accessors"][0]["type"] = json!("VEC2"),
        &["POSITION", "3 components expected"],
    );
    says(
        &|r| r["accessors"][1]["componentType"] = json!(5126),
        &["unsigned integers expected"],
    );
    says(
        &|r| r["meshes"][0]["primitives"][0]["material"] = json!(0),
        &["material", "out of bounds"],
    );
    says(
        &|r| r["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(1),
        &["NORMAL", "6 elements for 4"],
    );
    says(&|r| r["nodes"][0]["mesh"] = json!(4), &["nodes[0].mesh"]);
    says(
        &|r| r["nodes"][0]["children"] = json!([0]),
        &["node 0", "ancestor"],
    );
    says(
        &|r| r["nodes"][0]["translation"] = json!([1e39, 0, 0]),
        &["node 0 \"plate\"", "not finite"],
    );
    says(&|r| r["nodes"][0]["mesh"] = Value::Null, &["shows nothing"]);
    says(
        &|r| r["nodes"][0]["scale"] = json!([3e38, 1, 1]),
        &["scene", "check the scales"],
    );
    says(
        &|r| r["scenes"][0]["nodes"] = json!([0, 0]),
        &["two parents"],
    );
    says(
        &|r| {
            r["accessors"][0]
                .as_object_mut()
                .expect("an object")
                .remove("bufferView");
            r["accessors"][0]["count"] = json!(1_u64 << 40);
            r["accessors"][0]["sparse"] = json!({ "count": 1,
                "indices": { "bufferView": 2, "componentType": 5121 }, "values": { "bufferView": 2 } });
        },
        &["elements without data"],
    );
    says(
        &|r| {
            r["accessors"][0]["sparse"] = json!({ "count": 1,
                "indices": { "bufferView": 0, "componentType": 5123, "byteOffset": 2 },
                "values": { "bufferView": 2 } });
        },
        &["sparse index 49024 of 4"],
    );
    says(
        &|r| {
            r["animations"] = json!([{ "name": "spin", "samplers": [{ "input": 0, "output": 0 }],
                "channels": [{ "sampler": 1, "target": { "node": 0, "path": "rotation" } }] }]);
        },
        &["animations[0].channels[0].sampler", "out of bounds"],
    );
    says(
        &|r| r["extras"] = json!({ "medium": { "sigma_s": 1 } }),
        &["extras.medium", "aabb"],
    );
}

#[test]
fn positions_that_are_not_numbers_are_named() {
    let (root, mut data) = square(&[]);
    data[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = load_json(root, &data).expect_err("NaN").to_string();
    assert_says(
        &error,
        &[
            "mesh 0 \"square\", primitive 0, POSITION",
            "element 1 is not a finite",
        ],
    );
}

#[test]
fn missing_and_broken_resources_are_named() {
    let textured = |r: &mut Value| {
        r["textures"] = json!([{ "source": 0 }]);
        r["materials"] =
            json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    };
    let image = |value: Value| {
        broken(|r| {
            textured(r);
            r["images"] = json!([value]);
        })
    };
    assert_says(&broken(textured), &["textures[0].source", "out of bounds"]);
    assert_says(
        &image(json!({ "uri": "gone.png", "name": "bark" })),
        &["image 0 \"bark\"", "gone.png", "put the file there"],
    );
    assert_says(
        &image(json!({})),
        &["image 0", "neither a bufferView nor a uri"],
    );
    assert_says(
        &image(json!({ "uri": "data:image/png;base64,!!" })),
        &["image 0", "base64"],
    );
    assert_says(
        &image(json!({ "bufferView": 2 })),
        &["image 0", "PNG and JPEG"],
    );
    assert_says(&image(json!({ "uri": "bad%FF.png" })), &["not UTF-8"]);
    assert_says(
        &image(json!({ "uri": "https://example.org/a.png" })),
        &["neither relative nor data:"],
    );
    let text = br#"{ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 8, "uri": "gone.bin" }] }"#;
    let error = load_bytes(text, Path::new("some/x.gltf"), None)
        .expect_err("missing")
        .to_string();
    assert_says(&error, &["some/x.gltf", "buffer 0", "gone.bin", "\"some\""]);
}

/// Flips bytes of a small file with every kind of content: nothing may panic.
#[test]
fn two_thousand_mutants_do_not_panic() {
    let scene = round_trip::small_scene();
    let whole = export(&scene).expect("exports");
    let json_end = 20 + u32::from_le_bytes([whole[12], whole[13], whole[14], whole[15]]) as usize;
    let digits: Vec<usize> = (20..json_end)
        .filter(|&i| whole[i].is_ascii_digit())
        .collect();
    let mut state = 0x1234_5678_9ABC_DEF0_u64;
    let mut random = |below: usize| {
        // xorshift64*, Vigna 2016.
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % below
    };
    let (mut loads, mut errors) = (0, 0);
    for round in 0..2000 {
        let mut mutant = whole.clone();
        for _ in 0..=random(3) {
            // A third anywhere, a third in the JSON (it decides what the rest means), a third
            // from digit to digit in the JSON, which gets past the parser.
            let (at, byte) = match round % 3 {
                0 => (random(mutant.len()), random(256) as u8),
                1 => (random(json_end), random(256) as u8),
                _ => (digits[random(digits.len())], b'0' + random(10) as u8),
            };
            mutant[at] = byte;
        }
        match load_bytes(&mutant, Path::new("mutant.glb"), None) {
            Ok(_) => loads += 1,
            Err(_) => errors += 1,
        }
    }
    assert!(
        loads > 200 && errors > 200,
        "the mutants reach both ends: {loads} and {errors}"
    );
}
