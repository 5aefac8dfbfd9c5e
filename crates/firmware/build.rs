//! Hands the linker the memory layout of the target's board.

use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let arch = env::var("CARGO_CFG_TARGET_ARCH")?;
    let layout = match arch.as_str() {
        "arm" => "memory/cortex-m.x",
        "riscv32" => "memory/riscv.x",
        other => {
            let remedy = "build with `unframed firmware build`";
            return Err(format!("no board has a {other}: {remedy}").into());
        }
    };
    fs::copy(layout, out.join("memory.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed={layout}");
    println!("cargo:rerun-if-changed=build.rs");
    // cortex-m-rt's script includes memory.x by itself; riscv-rt wants it before its own.
    let scripts: &[&str] = match arch.as_str() {
        "riscv32" => &["-Tmemory.x", "-Tlink.x"],
        _ => &["-Tlink.x"],
    };
    for argument in ["--nmagic", "--gc-sections"].iter().chain(scripts) {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    Ok(())
}
