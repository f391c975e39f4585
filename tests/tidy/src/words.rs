//! Words that the glossary replaces.

use std::path::{Path, PathBuf};

use crate::files;
use crate::workspace::{Workspace, files_in, read};

/// Words that must not occur, with what replaces them.
///
/// A word with a capital letter or an underscore matches in this case only, any other in every case. A word matches
/// whole: no part of an identifier may touch it.
pub const REPLACED: &[(&str, &str)] = &[];

/// Words of the old vocabulary that still occur. A line moves up to [`REPLACED`] as soon as its word is gone.
pub const PENDING: &[(&str, &str)] = &[
    // Identifiers.
    ("FALLBACK", "FALLBACK"),
    ("ShaderFeatures", "ShaderFeatures"),
    ("features", "shader features"),
    ("Draft", "PlanBuilder, NodeDraft, UncompiledDispatch"),
    ("OutputState::", "OutputState"),
    ("AliasingBarrier", "aliasing barrier"),
    ("hand_over", "aliasing barrier"),
    ("Holding::", "residency"),
    ("Skipped", "Skipped"),
    ("skipped", "skipped"),
    ("launch", "command"),
    ("launches", "commands"),
    ("Moment::", "FrameConstants"),
    ("SharedRead", "SharedRead"),
    ("shared_reads", "shared reads"),
    ("SampleMode::", "SampleMode"),
    ("PlanRequest<", "PlanRequest"),
    ("PlanRequest {", "PlanRequest, Override"),
    ("Fallback", "Fallback"),
    ("fallback", "fallback"),
    ("Told::", "BuiltinArg"),
    ("can_tell", "supported"),
    (".accepts(", "accepts"),
    ("specialize", "specialize"),
    ("BatchBarriers", "BatchBarriers"),
    ("batch", "batch"),
    ("batches", "batches"),
    ("Workshop", "PlanCompiler"),
    // Phrases.
    ("are told", "are reported"),
    ("unchecked", "unchecked"),
    ("hand-over", "aliasing barrier"),
    ("hands over", "passes"),
    ("is told", "is reported"),
    ("newborn", "uninitialized"),
    ("of so many", "of N"),
    ("peer", "baseline"),
    ("pitfall", "lint"),
    ("lints", "lints"),
    ("resident", "alias owner"),
    ("so manyth", "stride"),
    ("stand-in", "fallback"),
    ("stands in for", "is the fallback of"),
    ("take turns", "share"),
    ("takes turns", "shares"),
    ("the rooms", "the layout"),
    ("the truth", "the reference"),
    ("twin", "CPU reference"),
    ("twins", "CPU references"),
    ("what becomes of", "the result of"),
];

/// Where the words of a list occur: `file:line: word, replacement`.
pub fn violations(workspace: &Workspace, words: &[(&str, &str)]) -> Vec<String> {
    let files = searched(workspace);
    files.iter().flat_map(|file| in_text(workspace.short(file), &read(file), words)).collect()
}

/// The files that are searched: code of the product, shaders, pipelines and documents.
fn searched(workspace: &Workspace) -> Vec<PathBuf> {
    let mut files = files::of_product(workspace);
    files.push(workspace.root.join("README.md"));
    for folder in ["graph", "nodes", "pipelines", "shaders"] {
        files.extend(files_in(&workspace.root.join(folder), &["md", "ron"]));
    }
    files
}

fn in_text(file: &Path, text: &str, words: &[(&str, &str)]) -> Vec<String> {
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
        let words = [("Fallback", "Fallback"), ("take turns", "share"), ("Told::", "BuiltinArg")];
        let text =
            "let x = Fallback::None;\n// Images TAKE TURNS in\nlet StandIns = standin(Untold::A, Told);\nTold::B\n";
        let expected =
            ["a.rs:1: `Fallback`, now Fallback", "a.rs:2: `take turns`, now share", "a.rs:4: `Told::`, now BuiltinArg"];
        assert_eq!(in_text(Path::new("a.rs"), text, &words), expected);
    }

    #[test]
    fn no_word_is_on_both_lists() {
        let both = PENDING.iter().filter(|(old, _)| REPLACED.iter().any(|(word, _)| word == old));
        assert_eq!(both.count(), 0);
    }
}
