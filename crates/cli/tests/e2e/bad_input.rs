//! Bad input: a clear message, exit status not 0, never a panic.

use crate::common::unframed;
use std::fs;

/// Demands failure without a panic, and that the message names `needle`.
fn fails(words: &[&str], needle: &str) {
    let output = unframed(words);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{words:?} succeeded");
    assert!(
        output.status.code().is_some_and(|code| code != 101),
        "{words:?}: {errors}"
    );
    assert!(!errors.contains("panicked"), "{words:?}: {errors}");
    assert!(
        errors.contains(needle),
        "{words:?} does not say {needle:?}: {errors}"
    );
}

#[test]
fn arguments() {
    fails(&["run", "--rate", "0"], "out of range");
    fails(&["run", "--rate", "many"], "400k");
    fails(&["run", "--size", "0x0"], "1x1");
    fails(&["run", "--size", "100000x100000"], "4080");
    fails(&["run", "--seconds=-1"], "seconds");
    fails(&["run", "--every", "0"], "every");
    fails(&["run", "no-such-scene"], "no-such-scene");
    fails(&["run", "toycar", "--clip", "walk"], "clips");
    fails(&["frobnicate"], "frobnicate");
}

#[test]
fn files() {
    let dir = tempfile::tempdir().expect("a directory");
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("written");
        path.to_str().expect("a Unicode path").to_owned()
    };
    fails(&["run", "missing.glb"], "missing.glb");
    fails(
        &["run", &write("broken.gltf", b"{ \"asset\": ")],
        "broken.gltf",
    );
    fails(
        &[
            "run",
            &write("broken.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff"),
        ],
        "broken.glb",
    );
    fails(&["scenes", &write("empty.glb", b"")], "empty.glb");
    fails(&["play", "missing.ufs"], "missing.ufs");
    fails(&["play", &write("noise.ufs", &[7; 1000])], "no Hello");
    fails(&["inspect", &write("empty.ufs", b"")], "empty.ufs");
    let file = write("file", b"");
    fails(
        &[
            "run",
            "toycar",
            "--seconds",
            "0.1",
            "--out",
            &format!("{file}/below"),
        ],
        "--out",
    );
    fails(
        &["record", "toycar", "-o", &format!("{file}/below.ufs")],
        "below.ufs",
    );
}

#[test]
fn tiny_and_odd_panels_work() {
    for size in ["1x1", "1x9", "33x7"] {
        let words = [
            "run",
            "toycar",
            "--seconds",
            "0.1",
            "--rate",
            "3k",
            "--size",
            size,
            "--json",
        ];
        let output = unframed(words);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{size}: {errors}");
    }
}

#[test]
fn one_sample_a_second_works() {
    let words = [
        "run",
        "toycar",
        "--seconds",
        "2",
        "--rate",
        "1",
        "--size",
        "16x16",
        "--json",
    ];
    let output = unframed(words);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
