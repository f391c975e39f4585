//! Lists the WGSL files of this folder, so that a new file needs no line in Rust.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets the folder of the package"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets the folder for generated files"));
    let mut code = table("KINDS", &root);
    code += &table("LIBRARY", &root.join("lib"));
    code += &table("DEMO", &root.join("demo"));
    fs::write(out.join("sources.rs"), code).expect("the folder for generated files can be written");
}

/// A constant with the stem and the text of every WGSL file of a folder.
fn table(name: &str, folder: &Path) -> String {
    println!("cargo::rerun-if-changed={}", folder.display());
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("a folder's entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "wgsl"));
    files.sort();
    let mut code = format!("/// Stem and text of each file, sorted.\npub const {name}: &[(&str, &str)] = &[\n");
    for path in &files {
        let stem = path.file_stem().expect("a file has a name").to_string_lossy();
        let _ = writeln!(code, "    ({stem:?}, include_str!({path:?})),");
    }
    code + "];\n"
}
