//! Licenses and sources of the dependencies: those that `.cargo/deny.toml` allows.
//!
//! These are the dependencies of this machine's target; `tests/deny.sh` looks at those of all targets.

use std::path::Path;

use serde_json::Value;

use crate::workspace::{Workspace, list, metadata, read, string};

/// Where packages may come from.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// The dependencies of a workspace whose license is not allowed, or that come from elsewhere, a sentence each.
pub fn violations(workspace: &Workspace) -> Vec<String> {
    let allowed = allowed(&read(&workspace.root.join(".cargo/deny.toml")));
    let packages = packages(&workspace.root);
    packages.iter().filter_map(|package| fault(package, &allowed)).collect()
}

/// All packages that this machine builds.
fn packages(root: &Path) -> Vec<Value> {
    let target = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let target = if cfg!(target_os = "linux") { vec!["--filter-platform", &target] } else { Vec::new() };
    let found = list(&metadata(root, &target), "packages").to_vec();
    assert!(found.len() > 100, "only {} packages are found", found.len());
    found
}

/// The licenses of a file for cargo-deny.
fn allowed(file: &str) -> Vec<String> {
    let (_, list) = file.split_once("\nallow = [").expect("the file lists the allowed licenses");
    let list = list.split(']').next().unwrap_or_default();
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

fn fault(package: &Value, allowed: &[String]) -> Option<String> {
    let name = string(package, "name");
    let license = package["license"].as_str().unwrap_or_default();
    let source = package["source"].as_str();
    if !is_allowed(license, allowed) {
        return Some(format!("`{name}` has the license `{license}`, which `.cargo/deny.toml` does not allow"));
    }
    source.filter(|source| *source != REGISTRY).map(|source| format!("`{name}` comes from {source}"))
}

/// True if allowed licenses satisfy an SPDX expression. Old packages write `/` for `OR`.
fn is_allowed(expression: &str, allowed: &[String]) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ").replace(" WITH ", "\0");
    let mut words = spaced.split_whitespace();
    any(&mut words, &|license| allowed.iter().any(|one| *one == license.replace('\0', " WITH ")))
}

/// Alternatives up to the end or a closing bracket. `AND` binds more tightly than `OR`.
fn any<'e>(words: &mut impl Iterator<Item = &'e str>, allowed: &dyn Fn(&str) -> bool) -> bool {
    let (mut found, mut all) = (false, true);
    loop {
        all &= match words.next() {
            Some("(") => any(words, allowed),
            Some(license) => allowed(license),
            None => false,
        };
        match words.next() {
            Some("AND") => {}
            Some("OR") => {
                found |= all;
                all = true;
            }
            _ => return found || all,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expression_needs_one_alternative_and_each_part_of_it() {
        let allowed =
            allowed("[licenses]\nallow = [\n    \"MIT\",\n    \"ISC\", \"A WITH B\",\n]\nother = [\"GPL-3.0\"]\n");
        for (expression, expected) in [
            ("MIT", true),
            ("MIT OR GPL-3.0", true),
            ("GPL-3.0/MIT", true),
            ("A WITH B OR C", true),
            ("(GPL-3.0 OR MIT) AND ISC", true),
            ("ISC AND (GPL-3.0 OR MIT)", true),
            ("GPL-3.0 AND MIT OR ISC", true),
            ("MIT AND GPL-3.0", false),
            ("(MIT OR ISC) AND GPL-3.0", false),
            ("GPL-3.0 OR MIT AND GPL-3.0", false),
            ("A", false),
            ("GPL-3.0", false),
            ("MIT AND", false),
            ("", false),
        ] {
            assert_eq!(is_allowed(expression, &allowed), expected, "{expression}");
        }
    }

    #[test]
    fn other_licenses_and_sources_are_found() {
        let package = |license: &str, source: &str| {
            let package = serde_json::json!({ "name": "one", "license": license, "source": source });
            fault(&package, &["MIT".to_owned()])
        };
        assert_eq!(package("MIT", REGISTRY), None);
        let text = "`one` has the license `GPL-3.0`, which `.cargo/deny.toml` does not allow";
        assert_eq!(package("GPL-3.0", REGISTRY).as_deref(), Some(text));
        assert_eq!(package("MIT", "git+https://a.b/c").as_deref(), Some("`one` comes from git+https://a.b/c"));
    }
}
