//! `unsafe` blocks and implementations, and the reason that is written beside each.

use std::path::PathBuf;

use proc_macro2::{Delimiter, TokenTree};

use crate::tokens::{all_tokens, each_list, group, ident, is_word, word};
use crate::workspace::{Workspace, files_in, read};

/// The folders of all members.
const FOLDERS: [&str; 4] = ["graph", "nodes", "shaders", "tests"];

/// One `unsafe` block or implementation.
#[derive(Debug, PartialEq, Eq)]
pub struct Unsafe {
    /// The file, relative to the root.
    pub file: PathBuf,
    /// The line of the word `unsafe`.
    pub line: usize,
    /// What the comment above it says after `SAFETY:`.
    pub reason: Option<String>,
}

/// Every `unsafe` block and implementation in the workspace, in the order of files.
pub fn all(workspace: &Workspace) -> Vec<Unsafe> {
    let files: Vec<PathBuf> =
        FOLDERS.iter().flat_map(|folder| files_in(&workspace.root.join(folder), &["rs"])).collect();
    let of_file = |file: &PathBuf| {
        let text = read(file);
        let of_line = |line| Unsafe { file: workspace.short(file).to_owned(), line, reason: reason(&text, line) };
        lines(&text, file).into_iter().map(of_line).collect::<Vec<_>>()
    };
    files.iter().flat_map(of_file).collect()
}

/// Those without a reason, a sentence each.
pub fn violations(found: &[Unsafe]) -> Vec<String> {
    let bare = found.iter().filter(|one| one.reason.is_none());
    bare.map(|one| format!("{}:{}: `unsafe` without a `SAFETY:` comment", one.file.display(), one.line)).collect()
}

/// Lines of `unsafe {` and `unsafe impl`. An `unsafe fn` states what its caller promises in its documentation.
fn lines(text: &str, file: &std::path::Path) -> Vec<usize> {
    let mut found = Vec::new();
    let tokens: Vec<TokenTree> = all_tokens(text, file).into_iter().collect();
    each_list(&tokens, &mut |tokens| {
        for at in (0..tokens.len()).filter(|at| is_word(tokens.get(*at), "unsafe")) {
            let next = tokens.get(at + 1);
            if group(next, Delimiter::Brace).is_some() || word(next).as_deref() == Some("impl") {
                found.extend(ident(&tokens[at]).map(|word| word.span().start().line));
            }
        }
    });
    found.sort_unstable();
    found
}

/// The text after `SAFETY:` in the comment above a line. Attributes, and the start of the statement, may lie between.
fn reason(text: &str, line: usize) -> Option<String> {
    let mut above = text.lines().take(line - 1).map(str::trim).collect::<Vec<_>>();
    let is_comment = |text: &str| text.starts_with("//") && !text.starts_with("///");
    let ends_statement = |text: &str| text.ends_with([';', '}']) || text.is_empty();
    while above.last().is_some_and(|text| !is_comment(text) && !ends_statement(text)) {
        above.pop();
    }
    let begin = above.iter().rposition(|text| !is_comment(text)).map_or(0, |at| at + 1);
    let words = above[begin..].iter().map(|text| text.trim_start_matches('/').trim()).collect::<Vec<_>>().join(" ");
    words.split_once("SAFETY:").map(|(_, reason)| reason.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_unsafe_block_has_the_comment_above_it() {
        let text = "fn a() {\n    // SAFETY: it is\n    // good.\n    unsafe { b() };\n    unsafe { c() };\n}\n\
                    // SAFETY: it counts.\nunsafe impl D for E {\n    unsafe fn f() {}\n}\n\
                    /// # Safety\nunsafe fn g() {}\n// SAFETY: read only.\n#[allow(h)]\nstatic I: J =\n    unsafe { k() };\n\
                    // About l.\nfn l() { unsafe { m() } }\n";
        let found: Vec<_> = lines(text, "a.rs".as_ref()).into_iter().map(|line| (line, reason(text, line))).collect();
        let expected =
            [(4, Some("it is good.")), (5, None), (8, Some("it counts.")), (16, Some("read only.")), (18, None)];
        assert_eq!(found, expected.map(|(line, reason)| (line, reason.map(str::to_owned))));
    }
}
