//! What the tests of this crate share.

use std::process::Command;

use crate::gpu::{Gpu, GpuError};

/// An adapter, or `None` after a line that names what is left untested. Where `CI` is set the
/// adapter is part of the machine's set-up, and its absence fails the test.
pub(crate) fn adapter_or_skip(left_out: &str) -> Option<Gpu> {
    match Gpu::new() {
        Ok(gpu) => Some(gpu),
        Err(error @ GpuError::NoAdapter { .. }) if std::env::var_os("CI").is_none() => {
            eprintln!("SKIPPED, not tested: {left_out}: {error}");
            None
        }
        Err(error) => panic!("{left_out}: {error}"),
    }
}

/// Runs one ignored test of this binary in a process of its own, with variables set and removed;
/// returns what it printed. A child that panics fails the caller.
pub(crate) fn run_ignored(test: &str, set: &[(&str, &str)], remove: &[&str]) -> String {
    let binary = std::env::current_exe().expect("the test binary has a path");
    let mut command = Command::new(binary);
    command.args([
        "--exact",
        test,
        "--ignored",
        "--nocapture",
        "--test-threads=1",
    ]);
    command.envs(set.iter().copied());
    for name in remove {
        command.env_remove(name);
    }
    let output = command.output().expect("the test binary starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{test}: {text}");
    assert!(text.contains("1 passed"), "{test} did not run: {text}");
    text
}

/// The xorshift64* generator (Vigna 2014): seeded test data.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }
}
