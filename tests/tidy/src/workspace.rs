//! The crates of a workspace, as `cargo metadata` lists them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The members of a workspace.
pub struct Workspace {
    /// The folder of the root manifest.
    pub root: PathBuf,
    /// The members, in the order of `cargo metadata`.
    pub crates: Vec<Crate>,
}

/// A member of the workspace.
#[derive(Clone, Debug)]
pub struct Crate {
    /// The package's name.
    pub name: String,
    /// The folder of its manifest.
    pub folder: PathBuf,
    /// The root files of its library, its programs and its build script.
    pub roots: Vec<PathBuf>,
    /// What it depends on.
    pub dependencies: Vec<Dependency>,
    /// True if it may be published.
    pub is_published: bool,
}

/// A dependency that a manifest names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependency {
    /// The package's name.
    pub name: String,
    /// True if it is for tests, benches and examples only.
    pub dev: bool,
    /// True if it is a crate of this workspace.
    pub is_local: bool,
    /// True if the manifest says which version it needs.
    pub has_version: bool,
}

impl Workspace {
    /// The workspace that this crate belongs to.
    pub fn this() -> Self {
        Self::at(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
    }

    /// The workspace whose root manifest lies in `root`.
    ///
    /// # Panics
    ///
    /// Panics if `cargo metadata` fails there.
    pub fn at(root: &Path) -> Self {
        let root = root.canonicalize().expect("the folder of the workspace exists");
        let crates = list(&metadata(&root, &["--no-deps"]), "packages").iter().map(Crate::read).collect();
        Self { root, crates }
    }

    /// The crates of the product: all members outside of `tests/`.
    pub fn product(&self) -> impl Iterator<Item = &Crate> {
        self.crates.iter().filter(|member| !member.folder.starts_with(self.root.join("tests")))
    }

    /// A path as the reader of a message wants it: relative to the root.
    pub fn short<'a>(&self, path: &'a Path) -> &'a Path {
        path.strip_prefix(&self.root).unwrap_or(path)
    }
}

impl Crate {
    /// The folders of its code: where the root files lie. The manifest's folder counts if a library lies there.
    pub fn folders(&self) -> BTreeSet<&Path> {
        let roots = self.roots.iter().filter(|root| !root.ends_with("build.rs"));
        roots.map(|root| root.parent().expect("a file lies in a folder")).collect()
    }

    fn read(package: &Value) -> Self {
        let manifest = PathBuf::from(string(package, "manifest_path"));
        let is_root = |target: &&Value| {
            let kinds = ["lib", "cdylib", "bin", "custom-build"];
            list(target, "kind").iter().any(|kind| kinds.iter().any(|known| kind == known))
        };
        Self {
            name: string(package, "name"),
            folder: manifest.parent().expect("a manifest lies in a folder").to_owned(),
            roots: list(package, "targets").iter().filter(is_root).map(|t| string(t, "src_path").into()).collect(),
            dependencies: list(package, "dependencies").iter().map(Dependency::read).collect(),
            is_published: package["publish"].is_null(),
        }
    }
}

impl Dependency {
    fn read(dependency: &Value) -> Self {
        Self {
            name: string(dependency, "name"),
            dev: dependency["kind"] == "dev",
            is_local: dependency["path"].is_string(),
            has_version: dependency["req"] != "*",
        }
    }
}

/// What `cargo metadata` prints about the workspace at `root`.
pub(crate) fn metadata(root: &Path, options: &[&str]) -> Value {
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["metadata", "--format-version", "1", "--offline"])
        .args(options)
        .arg("--manifest-path")
        .arg(root.join("Cargo.toml"))
        .output()
        .expect("cargo starts");
    assert!(output.status.success(), "cargo metadata fails: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON")
}

pub(crate) fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

pub(crate) fn string(value: &Value, key: &str) -> String {
    value[key].as_str().unwrap_or_else(|| panic!("cargo metadata has no text `{key}`")).to_owned()
}

/// All files of these extensions in a folder and its subfolders, sorted; none if the folder is missing.
pub fn files_in(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let Ok(entries) = std::fs::read_dir(folder) else { return found };
    for entry in entries.map(|entry| entry.expect("a folder can be listed").path()) {
        if entry.is_dir() {
            found.extend(files_in(&entry, extensions));
        } else if entry.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted)) {
            found.push(entry);
        }
    }
    found.sort();
    found
}

/// The text of a file.
///
/// # Panics
///
/// Panics if it cannot be read as UTF-8.
pub fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{} cannot be read: {error}", path.display()))
}
