//! Lengths of functions.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenTree};

use crate::modules::Tree;
use crate::tokens::{group, is_punct, is_word, product_tokens, word};
use crate::workspace::{Crate, read};

/// A function with more lines is listed.
const LONG: usize = 40;

/// A function with a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// The line of `fn`, from 1.
    pub line: usize,
    /// Lines from `fn` to the closing brace, both included.
    pub lines: usize,
}

/// Lengths of the functions of a crate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lengths {
    /// The number of functions.
    pub count: usize,
    /// Half of the functions are at most this long.
    pub median: usize,
    /// 99 of 100 functions are at most this long.
    pub percentile: usize,
    /// The functions of more than 40 lines.
    pub long: Vec<(PathBuf, Function)>,
}

/// The functions in a text, nested ones included, tests excluded.
fn in_text(text: &str, name: &Path) -> Vec<Function> {
    let mut found = Vec::new();
    collect(&product_tokens(text, name), &mut found);
    found.sort_by_key(|function| function.line);
    found
}

/// The lengths of the functions of a crate, without tests.
pub fn of_crate(member: &Crate) -> Lengths {
    let mut files = BTreeSet::new();
    for root in &member.roots {
        files.extend(Tree::of(root).files().into_iter().map(Path::to_owned));
    }
    let in_file = |file: PathBuf| in_text(&read(&file), &file).into_iter().map(move |f| (file.clone(), f));
    lengths(files.into_iter().flat_map(in_file).collect())
}

fn lengths(functions: Vec<(PathBuf, Function)>) -> Lengths {
    let mut lines: Vec<usize> = functions.iter().map(|(_, function)| function.lines).collect();
    lines.sort_unstable();
    let rank = |share: f64| (share * lines.len() as f64).ceil() as usize;
    let at = |share| lines.get(rank(share).saturating_sub(1)).copied().unwrap_or(0);
    let (count, median, percentile) = (lines.len(), at(0.5), at(0.99));
    let long = functions.into_iter().filter(|(_, function)| function.lines > LONG).collect();
    Lengths { count, median, percentile, long }
}

fn collect(tokens: &[TokenTree], found: &mut Vec<Function>) {
    for (at, token) in tokens.iter().enumerate() {
        found.extend(function(&tokens[at..]));
        if let TokenTree::Group(group) = token {
            collect(&group.stream().into_iter().collect::<Vec<_>>(), found);
        }
    }
}

/// The function that begins here, if it has a body.
fn function(tokens: &[TokenTree]) -> Option<Function> {
    let name = is_word(tokens.first(), "fn").then(|| word(tokens.get(1))).flatten()?;
    let end = tokens.iter().position(|t| is_punct(Some(t), ';') || group(Some(t), Delimiter::Brace).is_some())?;
    let body = group(tokens.get(end), Delimiter::Brace)?;
    let (first, last) = (tokens[0].span().start().line, body.span_close().end().line);
    Some(Function { name, line: first, lines: last + 1 - first })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<(String, usize)> {
        in_text(text, Path::new("a.rs")).into_iter().map(|function| (function.name, function.lines)).collect()
    }

    #[test]
    fn functions_are_measured_from_signature_to_brace() {
        let text =
            "/// Docs.\n#[inline]\npub fn a(\n    b: u32,\n) -> u32 {\n    b\n}\nfn c() {}\ntrait D { fn e(); }\n";
        assert_eq!(found(text), [("a".to_owned(), 5), ("c".to_owned(), 1)]);
    }

    #[test]
    fn functions_of_tests_do_not_count() {
        assert_eq!(found("#[test] fn a() {}\n#[cfg(test)] mod tests { fn b() {} }"), []);
    }

    #[test]
    fn median_percentile_and_long_functions_are_found() {
        let one = |lines: usize| format!("fn f{lines}() {{\n{}}}\n", "a();\n".repeat(lines - 2));
        let functions = in_text(&[one(3), one(41), one(8)].concat(), Path::new("a.rs"));
        let Lengths { count, median, percentile, long } =
            lengths(functions.into_iter().map(|function| (PathBuf::from("a.rs"), function)).collect());
        assert_eq!([count, median, percentile], [3, 8, 41]);
        let names: Vec<&str> = long.iter().map(|(_, function)| function.name.as_str()).collect();
        assert_eq!(names, ["f41"]);
    }
}
