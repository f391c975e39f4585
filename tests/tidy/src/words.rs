//! Words that the glossary replaces.

use std::path::{Path, PathBuf};

use crate::files;
use crate::workspace::{Workspace, files_in, read};

/// The words of `tests/tidy/words.txt` that must not occur, with what replaces them.
pub fn replaced() -> Vec<(String, String)> {
    parse(&read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("words.txt")))
}

fn parse(text: &str) -> Vec<(String, String)> {
    let mut words = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (old, new) = line.split_once(" -> ").unwrap_or_else(|| panic!("`{line}` is no `OLD -> NEW`"));
        words.push((old.to_owned(), new.to_owned()));
    }
    words
}

/// Where the words of a list occur: `file:line: word, replacement`.
pub fn violations(workspace: &Workspace, words: &[(String, String)]) -> Vec<String> {
    let files = searched(workspace);
    files.iter().flat_map(|file| in_text(workspace.short(file), &read(file), words)).collect()
}

/// The files that are searched: code of the product and of its tests, shaders, pipelines and documents. The changelog
/// and the list itself state old names.
fn searched(workspace: &Workspace) -> Vec<PathBuf> {
    let mut files = files::of_product(workspace);
    files.push(workspace.root.join("README.md"));
    for folder in ["graph", "nodes", "pipelines", "shaders"] {
        files.extend(files_in(&workspace.root.join(folder), &["md", "ron"]));
    }
    files.extend(files_in(&workspace.root.join("tests"), &["rs", "wgsl", "md", "ron"]));
    files.retain(|file| !file.ends_with("CHANGELOG.md") && !file.starts_with(workspace.root.join("tests/tidy")));
    files
}

fn in_text(file: &Path, text: &str, words: &[(String, String)]) -> Vec<String> {
    let in_line = |(number, line): (usize, &str)| {
        let found = words.iter().filter(|(old, _)| occurs(line, old));
        found.map(|(old, new)| format!("{}:{}: `{old}`, now {new}", file.display(), number + 1)).collect::<Vec<_>>()
    };
    text.lines().enumerate().flat_map(in_line).collect()
}

/// Whether a line holds the word, with no character of an identifier that touches an identifier in the word.
fn occurs(line: &str, word: &str) -> bool {
    let is_exact = word.contains(|character: char| character.is_uppercase() || character == '_');
    let line = if is_exact { line.to_owned() } else { line.to_lowercase() };
    line.match_indices(word).any(|(at, _)| {
        let ends = [line[..at].chars().next_back(), word.chars().next()];
        let begins = [word.chars().next_back(), line[at + word.len()..].chars().next()];
        ![ends, begins].iter().any(|pair| pair.iter().all(|character| character.is_some_and(is_identifier)))
    })
}

fn is_identifier(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_words_are_found_whole() {
        let words = parse("# Comment\nOldName -> NewName\ntake turns -> share\nOld:: -> New\n");
        let text = "let x = OldName::None;\n// Images TAKE TURNS in\nlet OldNames = oldname(Unold::A, Old);\nOld::B\n";
        let expected =
            ["a.rs:1: `OldName`, now NewName", "a.rs:2: `take turns`, now share", "a.rs:4: `Old::`, now New"];
        assert_eq!(in_text(Path::new("a.rs"), text, &words), expected);
    }
}
