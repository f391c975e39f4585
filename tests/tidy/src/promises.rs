//! Invariants of a document, each with the tests that hold it, compared with the tests of the workspace.

use std::collections::BTreeSet;

use crate::workspace::{Workspace, files_in, read};

/// The names of all tests.
pub fn tests(workspace: &Workspace) -> BTreeSet<String> {
    let folders = ["graph", "nodes", "pipelines", "shaders", "tests"];
    let files = folders.iter().flat_map(|folder| files_in(&workspace.root.join(folder), &["rs"]));
    files.flat_map(|file| tests_in(&read(&file))).collect()
}

/// The functions under `#[test]` in a text.
fn tests_in(text: &str) -> Vec<String> {
    let marked = text.split("#[test]\n").skip(1);
    let function = |rest: &str| {
        let line = rest.lines().map(str::trim).find(|line| !line.starts_with("#["))?;
        Some(line.strip_prefix("fn ")?.split('(').next()?.to_owned())
    };
    marked.filter_map(function).collect()
}

/// Rows of the tables under the heading `tests` whose last cell names no test, or one that does not exist.
pub fn violations(text: &str, tests: &BTreeSet<String>) -> Vec<String> {
    let mut found = Vec::new();
    let mut names_tests = false;
    for line in text.lines() {
        let Some(last) = line.strip_suffix(" |").and_then(|row| row.rsplit_once("| ")).map(|(_, last)| last) else {
            // The rule under a heading is part of its table.
            names_tests &= line.starts_with("|-");
            continue;
        };
        if last == "tests" {
            names_tests = true;
        } else if names_tests {
            let names: Vec<&str> = last.split('`').skip(1).step_by(2).collect();
            if names.is_empty() {
                found.push(format!("no test holds `{line}`"));
            }
            found
                .extend(names.iter().filter(|name| !tests.contains(**name)).map(|name| format!("no test is `{name}`")));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_row_needs_tests_that_exist() {
        let known = tests_in("#[test]\n#[ignore]\n    fn it_holds() {}\nfn helper() {}\n").into_iter().collect();
        let text = "| what | tests |\n|---|---|\n| a | `it_holds` |\n| b | `helper` |\n| c | none |\n\n| d | e |\n";
        assert_eq!(violations(text, &known), ["no test is `helper`", "no test holds `| c | none |`"]);
    }
}
