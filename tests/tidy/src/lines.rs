//! Lines of code by crate, of the work tree or of a revision.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenTree};

use crate::files;
use crate::modules::Tree;
use crate::tokens::product_tokens;
use crate::workspace::{Crate, Workspace, files_in, read};

/// Lines of a crate or of the shared shaders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// Lines with code, without tests, comments and blank lines.
    pub code: usize,
    /// All lines of all files, tests inside the crate included.
    pub all: usize,
}

/// The lines of each crate of the product, by name.
pub fn by_crate(workspace: &Workspace) -> Vec<(String, Lines)> {
    let folder = workspace.root.join("shaders");
    let mut counts: Vec<(String, Lines)> = workspace.product().map(|one| (one.name.clone(), of_crate(one))).collect();
    // Early revisions have the shared shaders in no crate.
    if !workspace.product().any(|member| member.folder == folder) {
        let shaders = files_in(&folder, &["wgsl"]);
        counts.push(("shaders".to_owned(), Lines { code: wgsl_lines(&shaders), all: all_lines(&shaders) }));
    }
    counts
}

fn of_crate(member: &Crate) -> Lines {
    let trees: Vec<Tree> = member.roots.iter().map(|root| Tree::of(root)).collect();
    let product: BTreeSet<&Path> = trees.iter().flat_map(Tree::files).collect();
    let shaders = member.folders().into_iter().flat_map(|folder| files_in(folder, &["wgsl"])).collect::<Vec<_>>();
    let code = product.iter().map(|file| rust(&read(file), file)).sum::<usize>();
    Lines { code: code + wgsl_lines(&shaders), all: all_lines(&files::of_crate(member)) }
}

fn wgsl_lines(files: &[PathBuf]) -> usize {
    files.iter().map(|file| wgsl(&read(file))).sum()
}

fn all_lines(files: &[PathBuf]) -> usize {
    files.iter().map(|file| read(file).lines().count()).sum()
}

/// Lines of Rust with code outside of tests.
fn rust(text: &str, name: &Path) -> usize {
    let mut lines = BTreeSet::new();
    note_lines(&product_tokens(text, name), &mut lines);
    lines.len()
}

fn note_lines(tokens: &[TokenTree], lines: &mut BTreeSet<usize>) {
    for token in tokens.iter().filter(|token| !is_comment(token)) {
        match token {
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                note_lines(&inner, lines);
                if group.delimiter() != Delimiter::None {
                    lines.extend([group.span_open().start().line, group.span_close().end().line]);
                }
            }
            _ => lines.extend(token.span().start().line..=token.span().end().line),
        }
    }
}

/// True if the token is part of a doc comment, which the compiler reads as an attribute.
fn is_comment(token: &TokenTree) -> bool {
    let may_be = match token {
        TokenTree::Punct(punct) => matches!(punct.as_char(), '#' | '!'),
        TokenTree::Group(group) => group.delimiter() == Delimiter::Bracket,
        _ => false,
    };
    may_be && token.span().source_text().is_some_and(|text| text.starts_with("//") || text.starts_with("/*"))
}

/// Lines of WGSL with code.
fn wgsl(text: &str) -> usize {
    let mut depth = 0_usize;
    text.lines().filter(|line| has_wgsl_code(line, &mut depth)).count()
}

/// True if a line has code; `depth` is the number of block comments that are open, which nest in WGSL.
fn has_wgsl_code(line: &str, depth: &mut usize) -> bool {
    let mut has_code = false;
    let mut rest = line;
    while let Some(first) = rest.chars().next() {
        let length = match rest {
            _ if rest.starts_with("/*") => {
                *depth += 1;
                2
            }
            _ if *depth > 0 && rest.starts_with("*/") => {
                *depth -= 1;
                2
            }
            _ if *depth == 0 && rest.starts_with("//") => break,
            _ => {
                has_code |= *depth == 0 && !first.is_whitespace();
                first.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    has_code
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_blank_lines_and_tests_are_no_code() {
        let text = "//! Docs.\n\n// Why.\nfn a() {\n    /* b */\n    c(\"d\n e\"); // f\n}\n/// G.\n#[inline]\nfn h() {}\n#[cfg(test)]\nmod tests {\n}\n";
        assert_eq!(rust(text, Path::new("a.rs")), 6);
    }

    #[test]
    fn comments_nest_in_shaders() {
        assert_eq!(wgsl("// a\n\nfn b() { /* c /* d */\ne */ }\n/* f\ng */\nconst h = 1; // i\n"), 3);
    }
}
