//! What the tests of this machine can run on, so that a test that cannot run is reported as ignored and never as passed.

use std::path::Path;

/// Where Debian's Chromium keeps the driver file of SwiftShader.
const SWIFTSHADER: &str = "/usr/lib/chromium/vk_swiftshader_icd.json";

fn main() {
    println!("cargo::rustc-check-cfg=cfg(no_gpu)");
    println!("cargo::rustc-check-cfg=cfg(no_swiftshader)");
    println!("cargo::rustc-check-cfg=cfg(no_ffmpeg)");
    println!("cargo::rerun-if-env-changed=AFTERIMAGE_NO_GPU");
    println!("cargo::rerun-if-env-changed=PATH");
    println!("cargo::rerun-if-changed={SWIFTSHADER}");
    if std::env::var("AFTERIMAGE_NO_GPU").is_ok_and(|value| value == "1") {
        println!("cargo::rustc-cfg=no_gpu");
    }
    if Path::new(SWIFTSHADER).exists() {
        println!("cargo::rustc-env=SWIFTSHADER={SWIFTSHADER}");
    } else {
        println!("cargo::rustc-cfg=no_swiftshader");
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let is_there = |program: &str| std::env::split_paths(&path).any(|folder| folder.join(program).is_file());
    if !is_there("ffmpeg") || !is_there("ffprobe") {
        println!("cargo::rustc-cfg=no_ffmpeg");
    }
}
