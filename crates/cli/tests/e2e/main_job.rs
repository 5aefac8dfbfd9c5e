//! The main job on every built-in scene and on real files.

use crate::common::{assets, succeed};
use serde_json::Value;

fn run(words: &[&str]) -> Value {
    let words = ["run"].iter().chain(words).chain(&["--json"]).copied();
    serde_json::from_str(&succeed(words)).expect("one JSON object")
}

/// At the same rate, the error of `adaptive` is at most `share` of traditional frameless
/// rendering, and a sample costs at most 10 bytes, all packets counted.
fn check(scene: &str, report: &Value, share: f64) {
    let rmse = |method: &str| {
        report["methods"][method]["rmse"]
            .as_f64()
            .expect("a number")
    };
    let (adaptive, frameless) = (rmse("adaptive"), rmse("frameless"));
    assert!(
        adaptive <= share * frameless,
        "{scene}: {adaptive} against {frameless}"
    );
    let bytes = report["bytes_per_sample"].as_f64().expect("a number");
    assert!(
        (3.0..=10.0).contains(&bytes),
        "{scene}: {bytes} bytes a sample"
    );
}

#[test]
fn built_in_scenes() {
    for scene in unframed_host::scene::builtin::ANIMATIONS {
        let report = run(&[scene, "--seconds", "1", "--every", "15"]);
        check(scene, &report, 0.6);
        assert_eq!(report["samples"], 400_000);
        assert_eq!(report["refreshes"], 60);
    }
}

#[test]
fn real_files() {
    let Some(assets) = assets("runs on kaykit-room and fox") else {
        return;
    };
    for file in ["kaykit-room/kaykit_room.glb", "fox/Fox.glb"] {
        let path = assets.join(file);
        let path = path.to_str().expect("a Unicode path");
        let report = run(&[path, "--seconds", "0.5", "--every", "15"]);
        // A small thing on a plain sky leaves little to win.
        check(file, &report, 1.0);
        let effects = report["effects"].as_array().expect("names");
        assert!(
            effects.iter().any(|name| name == "skinning"),
            "{file}: {effects:?}"
        );
    }
}
