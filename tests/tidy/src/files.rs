//! Rules of a single file: its header and its width.

use std::path::{Path, PathBuf};

use crate::workspace::{Crate, Workspace, files_in, read};

/// The widest line, in characters; `.rustfmt.toml` has the same number.
pub const MAX_WIDTH: usize = 120;

/// The Rust and WGSL files of a crate, tests inside the crate included.
pub fn of_crate(member: &Crate) -> Vec<PathBuf> {
    let others = ["examples", "benches", "tests"].map(|folder| member.folder.join(folder));
    let folders = member.folders().into_iter().chain(others.iter().map(PathBuf::as_path));
    let mut files: Vec<PathBuf> = folders.flat_map(|folder| files_in(folder, &["rs", "wgsl"])).collect();
    files.extend(member.roots.iter().cloned());
    files.sort();
    files.dedup();
    files
}

/// The Rust and WGSL files of the product: its crates and the shared shaders.
pub fn of_product(workspace: &Workspace) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = workspace.product().flat_map(of_crate).collect();
    files.extend(files_in(&workspace.root.join("shaders"), &["wgsl"]));
    files.sort();
    files.dedup();
    files
}

/// What breaks the rules in these files, a sentence each.
pub fn violations(workspace: &Workspace, files: &[PathBuf]) -> Vec<String> {
    files.iter().flat_map(|file| of_text(workspace.short(file), &read(file))).collect()
}

fn of_text(file: &Path, text: &str) -> Vec<String> {
    let name = file.display();
    let mut found = Vec::new();
    if file.extension().is_some_and(|extension| extension == "rs") && !text.starts_with("//!") {
        found.push(format!("{name}: the first line is no `//!` comment"));
    }
    let wide = text.lines().enumerate().map(|(line, text)| (line + 1, text.chars().count()));
    let wide = wide.filter(|(_, width)| *width > MAX_WIDTH);
    found.extend(wide.map(|(line, width)| format!("{name}:{line}: {width} columns, at most {MAX_WIDTH} are allowed")));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(name: &str, text: &str) -> Vec<String> {
        of_text(Path::new(name), text)
    }

    #[test]
    fn a_missing_header_is_found_in_rust() {
        assert_eq!(found("a.rs", "struct A;\n"), ["a.rs: the first line is no `//!` comment"]);
        assert_eq!(found("a.wgsl", "struct A {}\n"), Vec::<String>::new());
    }

    #[test]
    fn a_wide_line_is_found_by_its_characters() {
        let text = |characters| format!("//! A.\n// {}\n", "ä".repeat(characters));
        assert_eq!(found("a.rs", &text(117)), Vec::<String>::new());
        assert_eq!(found("a.rs", &text(118)), ["a.rs:2: 121 columns, at most 120 are allowed"]);
    }

    #[test]
    fn the_width_is_that_of_the_formatter() {
        let settings = read(&Workspace::this().root.join(".rustfmt.toml"));
        assert!(settings.contains(&format!("max_width = {MAX_WIDTH}\n")), "{settings}");
    }
}
