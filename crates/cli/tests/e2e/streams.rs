//! Streams as files: the same bytes every time, the same pictures from them.

use crate::common::{succeed, unframed};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

const SCENE: [&str; 7] = [
    "toycar",
    "--seconds",
    "0.3",
    "--size",
    "96x64",
    "--rate",
    "60k",
];

fn record(path: &Path) {
    let path = path.to_str().expect("a Unicode path");
    succeed(["record"].iter().chain(&SCENE).chain(&["-o", path]));
}

#[test]
fn recordings_repeat_and_do_not_depend_on_threads() {
    let dir = tempfile::tempdir().expect("a directory");
    let [a, b] = ["a.ufs", "b.ufs"].map(|name| dir.path().join(name));
    record(&a);
    let status = Command::new(env!("CARGO_BIN_EXE_unframed"))
        .args(["record"].iter().chain(&SCENE))
        .arg("-o")
        .arg(&b)
        .env("RAYON_NUM_THREADS", "1")
        .status()
        .expect("the command starts");
    assert!(status.success());
    let [a, b] = [a, b].map(|path| fs::read(path).expect("a recording"));
    assert!(a.len() > 50_000);
    assert!(a == b, "two recordings differ");
}

#[test]
fn another_seed_gives_another_stream() {
    let dir = tempfile::tempdir().expect("a directory");
    let [a, b] = ["a.ufs", "b.ufs"].map(|name| dir.path().join(name));
    record(&a);
    let path = b.to_str().expect("a Unicode path");
    succeed(
        ["record"]
            .iter()
            .chain(&SCENE)
            .chain(&["--seed", "2", "-o", path]),
    );
    assert!(fs::read(a).expect("a recording") != fs::read(b).expect("a recording"));
}

#[test]
fn playing_shows_what_running_showed() {
    let dir = tempfile::tempdir().expect("a directory");
    let out = dir.path().join("run");
    let path = out.to_str().expect("a Unicode path");
    succeed(
        ["run"]
            .iter()
            .chain(&SCENE)
            .chain(&["--every", "100", "--out", path]),
    );
    let file = dir.path().join("a.ufs");
    record(&file);
    let file = file.to_str().expect("a Unicode path");
    let played = succeed(["play", file, "--hashes"]);
    let shown = fs::read_to_string(out.join("hashes.txt")).expect("hashes");
    assert_eq!(played.lines().count(), 18);
    assert_eq!(played, shown);
    let distinct: std::collections::BTreeSet<_> = played
        .lines()
        .filter_map(|line| line.split(' ').nth(1))
        .collect();
    assert!(distinct.len() > 15, "the picture hardly changes");
    for name in [
        "report.html",
        "report.json",
        "adaptive-0017.png",
        "ideal-0017.png",
    ] {
        assert!(out.join(name).is_file(), "{name}");
    }
}

#[test]
fn inspecting_counts_what_recording_sent() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("a.ufs");
    let path = path.to_str().expect("a Unicode path");
    let tail = ["--json", "-o", path];
    let words = ["record"].iter().chain(&SCENE).chain(&tail);
    let sent: Value = serde_json::from_str(&succeed(words)).expect("JSON");
    let found: Value = serde_json::from_str(&succeed(["inspect", path, "--json"])).expect("JSON");
    assert_eq!(found["samples"], sent["samples"]);
    assert_eq!(found["bytes"], sent["stream_bytes"]);
    assert_eq!(found["samples"], 18_000);
    assert_eq!(found["packets"]["refresh"], 18);
    assert_eq!(found["packets"]["end"], 1);
    assert_eq!(found["lost"], 0);
    assert_eq!(found["damaged"], 0);
}

#[test]
fn a_damaged_recording_plays_with_losses_counted() {
    let dir = tempfile::tempdir().expect("a directory");
    let path = dir.path().join("a.ufs");
    record(&path);
    let mut bytes = fs::read(&path).expect("a recording");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    bytes.truncate(bytes.len() * 9 / 10);
    let hurt = dir.path().join("hurt.ufs");
    fs::write(&hurt, bytes).expect("written");
    let hurt = hurt.to_str().expect("a Unicode path");
    let output = unframed(["play", hurt, "--json"]);
    assert!(output.status.success());
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["damaged"], 1);
    assert!(
        report["refreshes"]
            .as_u64()
            .is_some_and(|n| (14..18).contains(&n))
    );
    let found: Value = serde_json::from_str(&succeed(["inspect", hurt, "--json"])).expect("JSON");
    assert_eq!(found["ended"], false);
    assert!(found["lost"].as_u64().is_some_and(|n| n >= 1));
}
