//! `unframed eval` as a user runs it: names that scripts rely on, and that nothing is done twice.

use std::path::Path;

use crate::common::{succeed, unframed};
use serde_json::Value;

fn eval(out: &Path, more: &[&str]) -> Value {
    let json = out.join("numbers.json");
    let (out, file) = (out.to_str().unwrap(), json.to_str().unwrap());
    let words = ["eval", "toycar", "--size", "32x32", "--rates", "5k,10k"];
    let always = [
        "--samples",
        "2k",
        "--flip-every",
        "0",
        "--no-cvvdp",
        "--out",
        out,
        "--json",
        file,
    ];
    succeed(words.iter().chain(&always).chain(more));
    serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap()
}

fn rmse(report: &Value, method: &str) -> Vec<f64> {
    let cells = report["cells"].as_array().unwrap();
    let of = cells.iter().filter(|cell| cell["method"] == method);
    of.map(|cell| cell["rmse"].as_f64().unwrap()).collect()
}

#[test]
fn what_is_finished_is_not_done_again() {
    let out = tempfile::tempdir().unwrap();
    let some = ["--seconds", "0.1", "--methods", "uniform,framed60-10x"];
    let report = eval(out.path(), &some);
    let cells = report["cells"].as_array().unwrap();
    // The tenfold renderer does not know of rates.
    assert_eq!(cells.len(), 3);
    for cell in cells {
        for name in [
            "scene",
            "method",
            "rate",
            "rmse",
            "psnr",
            "flip",
            "cvvdp",
            "worst_rmse",
            "p95_rmse",
            "samples",
            "seconds_host",
            "seconds_display",
        ] {
            assert!(cell.get(name).is_some(), "{name}");
        }
    }
    assert_eq!(rmse(&report, "uniform").len(), 2);
    for file in [
        "report.html",
        "report.json",
        "cells.csv",
        "rmse-toycar-5k.svg",
    ] {
        assert!(out.path().join(file).is_file(), "{file}");
    }

    // A mark on each finished cell that only its own file can carry on.
    let dir = out.path().join("cells");
    for entry in std::fs::read_dir(&dir).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") {
            let mut cell: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
            cell["rmse"] = 77.5.into();
            std::fs::write(&path, cell.to_string()).unwrap();
        }
    }
    // One is half written, as if power had failed; one method is new.
    let torn = std::fs::read_dir(&dir)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| {
            let name = path.to_string_lossy();
            name.contains("uniform-5000-1") && name.ends_with(".json")
        })
        .unwrap();
    std::fs::write(&torn, "{\"scene\": \"toy").unwrap();
    let more = ["--seconds", "0.1", "--methods", "uniform,framed60-10x,taau"];
    let again = eval(out.path(), &more);
    assert_eq!(rmse(&again, "framed60-10x"), [77.5]);
    assert_eq!(
        rmse(&again, "uniform")[0],
        rmse(&report, "uniform")[0],
        "made again"
    );
    assert_eq!(rmse(&again, "uniform")[1], 77.5);
    assert!(rmse(&again, "taau").iter().all(|rmse| *rmse < 77.0));

    // Other parameters are other cells, and --fresh believes nothing.
    let longer = eval(out.path(), &["--seconds", "0.15", "--methods", "uniform"]);
    assert!(rmse(&longer, "uniform").iter().all(|rmse| *rmse < 77.0));
    let fresh = [
        "--seconds",
        "0.1",
        "--methods",
        "uniform,framed60-10x",
        "--fresh",
    ];
    let fresh = eval(out.path(), &fresh);
    for method in ["uniform", "framed60-10x"] {
        assert_eq!(rmse(&fresh, method), rmse(&report, method));
    }
}

#[test]
fn unknown_methods_are_refused_by_name() {
    let output = unframed(["eval", "--methods", "papr"]);
    assert!(!output.status.success());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        errors.contains("framed60-lowres") && errors.contains("papr"),
        "{errors}"
    );
}
