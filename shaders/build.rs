//! Lists the WGSL files of this folder, so that a new file needs no line in Rust.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets the folder of the package"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets the folder for generated files"));
    let code = [table("KINDS", &root), table("LIBRARY", &root.join("lib")), table("DEMO", &root.join("demo"))].concat();
    fs::write(out.join("sources.rs"), code).expect("the folder for generated files can be written");
}

/// A constant with the stem and the text of every WGSL file of a folder.
fn table(name: &str, folder: &Path) -> String {
    println!("cargo::rerun-if-changed={}", folder.display());
    let rows: String = wgsl_files(folder).iter().map(|path| row(path)).collect();
    format!("/// Stem and text of each file, sorted.\npub const {name}: &[(&str, &str)] = &[\n{rows}];\n")
}

fn wgsl_files(folder: &Path) -> BTreeSet<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = entries.map(|entry| entry.expect("a folder's entry").path());
    paths.filter(|path| path.extension().is_some_and(|extension| extension == "wgsl")).collect()
}

fn row(path: &Path) -> String {
    let stem = path.file_stem().expect("a file has a name").to_string_lossy();
    format!("    ({stem:?}, include_str!({path:?})),\n")
}
