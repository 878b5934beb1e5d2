//! Gives the linker the memory layout of the board that is built for, and of core alone.

use std::path::PathBuf;
use std::{env, fs, io};

/// The programs of the MPS2 boards.
const MPS2: [&str; 6] =
    ["mps2-camera", "mps2-figures", "mps2-hand", "mps2-probes", "mps2-slave", "mps2-streamed"];

fn main() -> io::Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory");
    // cargo sets it for every build script
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    fs::copy("memory/core_alone.x", out.join("core_alone.x"))?;
    println!("cargo:rustc-link-arg-bin=core-alone=-Tcore_alone.x");
    let programs: &[&str] = if env::var_os("CARGO_FEATURE_MPS2").is_some() {
        fs::copy("memory/mps2.x", out.join("memory.x"))?;
        fs::copy("memory/mps2_device.x", out.join("device.x"))?;
        &MPS2
    } else if env::var_os("CARGO_FEATURE_STM32H743").is_some() {
        // (its device.x comes with the crate of its registers)
        fs::copy("memory/stm32h743.x", out.join("memory.x"))?;
        &["stm32h743-camera", "stm32h743-streamed"]
    } else {
        &[]
    };
    let logs = env::var_os("CARGO_FEATURE_DEFMT").is_some();
    for program in programs {
        println!("cargo:rustc-link-arg-bin={program}=-Tlink.x");
        if logs {
            println!("cargo:rustc-link-arg-bin={program}=-Tdefmt.x");
        }
    }
    Ok(())
}
