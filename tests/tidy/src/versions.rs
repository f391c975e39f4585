//! Versions that documents name, and the features that crates document.

use serde_json::Value;

use crate::workspace::{Workspace, list, metadata, read, string};

/// Places with another version than the manifests have, a sentence each.
pub fn violations(workspace: &Workspace) -> Vec<String> {
    let text = |name: &str| read(&workspace.root.join(name));
    let manifest = text("Cargo.toml");
    let oldest = quoted(&manifest, "\nrust-version = ");
    let wgpu = leading(quoted(&manifest, "\nwgpu = { version = "), 1);
    let bevy_manifest = text("graph/bevy/Cargo.toml");
    let bevy = leading(quoted(&bevy_manifest, "\nbevy = { version = "), 2);
    let packages = metadata(&workspace.root, &["--no-deps"]);
    let others = list(&packages, "packages").iter().filter(|package| package["rust_version"] != oldest);
    let mut found: Vec<String> =
        others.map(|package| format!("`{}` has not the oldest Rust, {oldest}", string(package, "name"))).collect();
    for (file, stated) in [
        ("graph/bevy/Cargo.toml", format!("rust-version = \"{oldest}\"")),
        ("graph/python/Cargo.toml", format!("rust-version = \"{oldest}\"")),
        ("README.md", format!("wgpu {wgpu}, Bevy {bevy}, Rust from {oldest} on")),
        (".github/CONTRIBUTING.md", format!("`rust-version` is {oldest}")),
        ("graph/docs/hosts.md", format!("Rust {oldest} is the oldest")),
        ("graph/docs/recipes.md", format!("with wgpu {wgpu}.")),
        ("graph/bevy/README.md", format!("Bevy {bevy}")),
    ] {
        found.extend((!text(file).contains(&stated)).then(|| format!("{file} does not state `{stated}`")));
    }
    found
}

/// Crates that are published and do not say which features they have, or with which they are documented.
pub fn undocumented_features(workspace: &Workspace) -> Vec<String> {
    let packages = metadata(&workspace.root, &["--no-deps"]);
    let published = list(&packages, "packages").iter().filter(|package| package["publish"].is_null());
    published.flat_map(undocumented_in).collect()
}

fn undocumented_in(package: &Value) -> Vec<String> {
    let features = package["features"].as_object().into_iter().flat_map(|features| features.keys());
    let features: Vec<&String> = features.filter(|feature| *feature != "default").collect();
    let name = string(package, "name");
    let is_built = ["features", "all-features"].iter().any(|key| !package["metadata"]["docs"]["rs"][key].is_null());
    let mut found = Vec::new();
    if !features.is_empty() && !is_built {
        found.push(format!("`{name}` does not state the features of its documentation"));
    }
    let is_library = |target: &&Value| list(target, "kind").iter().any(|kind| kind == "lib");
    let library = list(package, "targets").iter().find(is_library);
    let library = library.map(|target| read(string(target, "src_path").as_ref()));
    let head: String = library.iter().flat_map(|text| text.lines()).filter(|line| line.starts_with("//!")).collect();
    let is_missing = |feature: &&&String| !head.contains(&format!("`{feature}`"));
    found.extend(features.iter().filter(is_missing).map(|feature| format!("`{name}` does not document `{feature}`")));
    found
}

/// The text in quotes after `key`.
fn quoted<'a>(text: &'a str, key: &str) -> &'a str {
    let after = text.split_once(key).unwrap_or_else(|| panic!("a manifest has `{key}`")).1;
    after.split('"').nth(1).expect("a value is in quotes")
}

/// The first numbers of a version.
fn leading(version: &str, count: usize) -> String {
    version.split('.').take(count).collect::<Vec<_>>().join(".")
}
