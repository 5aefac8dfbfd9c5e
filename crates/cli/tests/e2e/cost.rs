//! `unframed cost` as a user runs it: names that scripts rely on, parts that add up, presets that
//! nothing beats, budgets that are answered.

use std::path::Path;

use crate::common::{succeed, unframed};
use serde_json::Value;

fn cost(out: &Path, more: &[&str]) -> Value {
    let json = out.join("numbers.json");
    let (out, file) = (out.to_str().unwrap(), json.to_str().unwrap());
    let always = ["cost", "--seconds", "0.2", "--out", out, "--json", file];
    succeed(always.iter().chain(more));
    serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap()
}

#[test]
fn presets_are_measured_once_and_budgets_answered() {
    let out = tempfile::tempdir().unwrap();
    let words = ["interactive", "--presets-only", "--size", "40x32"];
    let report = cost(out.path(), &words);
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 6);
    for point in points {
        for name in ["knobs", "preset", "on_front", "instructions_per_sample"] {
            assert!(point.get(name).is_some(), "{name}");
        }
        for name in [
            "host_seconds",
            "display_seconds",
            "bytes_per_second",
            "ram_bytes",
        ] {
            assert!(point[name].as_f64().unwrap() > 0.0, "{name}");
        }
        let error = |name: &str| point["error"][name].as_f64().unwrap();
        let parts = ["sampling", "filtering", "arithmetic", "delay"].map(error);
        let sum: f64 = parts.iter().sum();
        assert!((sum - error("total")).abs() <= 0.05 * error("total"));
        assert!(error("filtering") > 0.0);
        assert!(error("arithmetic").abs() < 0.05 * error("total"));
    }
    // A mark that only a finished point's own file can carry on.
    for entry in std::fs::read_dir(out.path().join("points")).unwrap() {
        let path = entry.unwrap().path();
        let mut point: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        point["rmse"] = 77.5.into();
        std::fs::write(&path, point.to_string()).unwrap();
    }
    let budget = ["--budget", "this link=10Mbit/s ram=300kB 40x32@60Hz"];
    let again = cost(out.path(), &[&words[..], &budget].concat());
    assert_eq!(again["points"][0]["rmse"], 77.5);
    let answer = &again["budgets"][0];
    let ram = answer["preset"]["ram_bytes"].as_f64().unwrap();
    assert!(ram <= 300e3 && answer["used"]["ram"].as_f64().unwrap() <= 1.0);
    for file in ["report.html", "report.json", "points.csv"] {
        assert!(out.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn no_preset_is_dominated() {
    let out = tempfile::tempdir().unwrap();
    let report = cost(out.path(), &["interactive", "--size", "64x64"]);
    let points = report["points"].as_array().unwrap();
    let mut presets = 0;
    for point in points.iter().filter(|p| !p["preset"].is_null()) {
        let by = point["dominated_by"].as_f64().unwrap();
        assert!(
            by <= 0.03,
            "{} by {by}: {}",
            point["preset"],
            point["knobs"]
        );
        presets += 1;
    }
    assert!(presets >= 5);
    assert!(
        points
            .iter()
            .any(|p| p["dominated_by"].as_f64().unwrap() > 0.03)
    );
    assert!(out.path().join("front-display-time.svg").is_file());
}

#[test]
fn what_is_not_understood_is_refused() {
    for (words, says) in [
        (["--preset", "huge"], "medium"),
        (["--budget", "z80@4MHz 8x8@60Hz"], "cortex-m7"),
    ] {
        let output = unframed(["cost"].iter().chain(&words));
        assert!(!output.status.success());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(errors.contains(says), "{errors}");
    }
}
