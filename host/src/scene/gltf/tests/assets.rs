//! The real files in `shared/assets`. They are not part of the project: where the folder is
//! missing, their names are printed, and in CI that fails.

use super::*;
use crate::scene::animate::Animation;
use crate::scene::gltf::{dress, load};
use glam::Vec3;
use std::path::PathBuf;

/// What a file must turn out to be.
struct Expected {
    file: &'static str,
    triangles: usize,
    /// Seconds of the longest loop.
    duration: f64,
    /// Size of its box over the animation, metres, ±2 %.
    size: [f32; 3],
    textures: usize,
    /// Parts of warnings, one each.
    warnings: &'static [&'static str],
}

const EXPECTED: [Expected; 4] = [
    Expected {
        file: "kaykit-room/kaykit_room.glb",
        triangles: 10_422,
        duration: 8.0,
        size: [8.0, 4.1, 8.0],
        textures: 2,
        warnings: &["\"Idle\": is left out: animation 0 \"Walking_A\""],
    },
    Expected {
        file: "kenney-character/character.glb",
        triangles: 550,
        duration: 12.0,
        size: [1.185, 1.104, 0.677],
        textures: 1,
        warnings: &["\"walk\": is left out", "\"jump\": is left out"],
    },
    Expected {
        file: "fox/Fox.glb",
        triangles: 576,
        duration: 12.0,
        size: [56.5, 79.5, 154.7],
        textures: 1,
        warnings: &["\"Walk\": is left out", "\"Run\": is left out"],
    },
    Expected {
        file: "cornell-box/cornellBox_clean.gltf",
        triangles: 16_732,
        duration: 0.0,
        size: [10.1, 10.1, 10.05],
        textures: 0,
        warnings: &["shown as transmission"],
    },
];

fn asset(file: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("UNFRAMED_ASSETS").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets"),
        PathBuf::from,
    );
    let path = folder.join(file);
    if path.exists() {
        return Some(path);
    }
    assert!(
        std::env::var_os("CI").is_none(),
        "{} is missing in CI",
        path.display()
    );
    eprintln!("left out: {file} (set UNFRAMED_ASSETS to the folder of real scenes)");
    None
}

#[test]
fn real_files_are_what_they_are() {
    for expected in EXPECTED {
        let Some(path) = asset(expected.file) else {
            continue;
        };
        let Loaded { scene, warnings } = load(&path, None).unwrap_or_else(|e| panic!("{e}"));
        let shown = scene
            .nodes
            .iter()
            .filter_map(|n| n.mesh)
            .flat_map(|m| &scene.meshes[m].primitives);
        assert_eq!(
            shown.map(|p| p.indices.len()).sum::<usize>(),
            expected.triangles
        );
        assert_eq!(scene.duration, expected.duration, "{}", expected.file);
        assert_eq!(scene.textures.len(), expected.textures);
        assert_eq!(warnings.len(), expected.warnings.len(), "{warnings:?}");
        for (warning, part) in warnings.iter().zip(expected.warnings) {
            assert!(warning.to_string().contains(part), "{warning} says {part}");
        }
        let animation = Animation::new(&scene);
        let (low, high) = dress::bounds(&scene, &animation);
        let size = high - low;
        let error = (size - Vec3::from(expected.size)).abs() / size;
        assert!(
            error.max_element() < 0.02,
            "{}: {low} to {high}, size {size}",
            expected.file
        );
        let camera = scene
            .nodes
            .iter()
            .position(|n| n.camera.is_some())
            .expect("a camera");
        for step in 0..40 {
            let t = f64::from(step) * 0.31;
            assert!(animation.world(&scene, camera, t).is_finite());
        }
    }
}

#[test]
fn real_files_survive_a_round_trip() {
    for expected in EXPECTED {
        let Some(path) = asset(expected.file) else {
            continue;
        };
        let scene = load(&path, None).unwrap_or_else(|e| panic!("{e}")).scene;
        let bytes = crate::scene::gltf::export(&scene).unwrap_or_else(|e| panic!("{e}"));
        let again = load_bytes(&bytes, &path, None).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again.warnings, []);
        let again = again.scene;
        let (a, b) = (Animation::new(&scene), Animation::new(&again));
        let ((low, high), (low2, high2)) = (dress::bounds(&scene, &a), dress::bounds(&again, &b));
        let noise = 1e-4 * (high - low).length();
        assert!(low.abs_diff_eq(low2, noise) && high.abs_diff_eq(high2, noise));
        assert_eq!(
            (scene.duration, scene.materials),
            (again.duration, again.materials)
        );
    }
}
