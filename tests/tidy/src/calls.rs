//! Calls for which the house has another one: names of files as they are in messages, and threads that end the program
//! where the system has none.

use std::path::{Path, PathBuf};

use crate::workspace::{Workspace, read};

/// A call, the folders in which it is refused, and what takes its place.
const REFUSED: [(&str, &[&str], &str); 3] = [
    // Errors of `graph/media` escape when they are made, and the program when it prints.
    (".display()", &["graph/afterimage/src", "graph/lab/src"], "`shown_path` escapes names"),
    ("thread::spawn(", &["graph", "nodes"], "`std::thread::Builder` returns its error"),
    ("scope.spawn(move", &["graph", "nodes"], "`std::thread::Builder` returns its error"),
];
/// Programs of their own: benches, examples, tests.
const PROGRAMS: [&str; 3] = ["benches", "examples", "tests"];

/// Where files of the product have such calls, a sentence each. Tests inside of the files are not counted.
pub fn violations(workspace: &Workspace, files: &[PathBuf]) -> Vec<String> {
    let product = files.iter().map(|file| (workspace.short(file), file)).filter(|(short, _)| !is_program(short));
    product.flat_map(|(short, file)| in_text(short, &read(file))).collect()
}

fn is_program(file: &Path) -> bool {
    file.components().any(|part| PROGRAMS.iter().any(|name| part.as_os_str() == *name))
}

fn in_text(file: &Path, text: &str) -> Vec<String> {
    let product = text.split("#[cfg(test)]").next().unwrap_or_default();
    let mut found = Vec::new();
    for (call, _, instead) in REFUSED.iter().filter(|(_, folders, _)| folders.iter().any(|it| file.starts_with(it))) {
        let lines = product.lines().enumerate().filter(|(_, line)| line.contains(call));
        found.extend(lines.map(|(number, _)| format!("{}:{}: `{call}`: {instead}", file.display(), number + 1)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_call_is_found_in_its_folders_and_outside_of_tests() {
        let text = "fn a() { format!(\"{}\", path.display()) }\n#[cfg(test)]\nmod tests { path.display() }\n";
        let found = ["graph/lab/src/a.rs:1: `.display()`: `shown_path` escapes names"];
        assert_eq!(in_text(Path::new("graph/lab/src/a.rs"), text), found);
        assert_eq!(in_text(Path::new("graph/cli/src/a.rs"), text), [""; 0]);
    }
}
