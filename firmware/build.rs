//! Gives the linker the memory layout of the board that is built for.

use std::path::PathBuf;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory");
    if env::var_os("CARGO_FEATURE_MPS2").is_none() {
        return Ok(());
    }
    // cargo sets it for every build script
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    fs::copy("memory/mps2.x", out.join("memory.x"))?;
    fs::copy("memory/mps2_device.x", out.join("device.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    Ok(())
}
