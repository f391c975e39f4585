//! The program as a process of its own.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The program, with `cache` as its folder for caches. Mesa keeps compiled shaders where it keeps those of this process,
/// so that no shader is compiled twice.
pub fn program(cache: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage-under-test"));
    command.env("XDG_CACHE_HOME", cache);
    if let Some(folder) = shader_cache() {
        command.env("MESA_SHADER_CACHE_DIR", folder);
    }
    command
}

/// The folder in which Mesa makes a folder for the shaders of this process.
fn shader_cache() -> Option<PathBuf> {
    let of = |name| std::env::var_os(name).map(PathBuf::from);
    of("MESA_SHADER_CACHE_DIR").or_else(|| of("XDG_CACHE_HOME")).or_else(|| Some(of("HOME")?.join(".cache")))
}
