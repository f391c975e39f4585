//! Functions: where they are, how long they are, what they name.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, Ident, TokenTree};

use crate::modules::Tree;
use crate::tokens::{each_list, group, ident, is_punct, is_word, product_tokens, word};
use crate::workspace::{Crate, read};

/// The longest median of a crate, in lines.
pub const MAX_MEDIAN: usize = 7;
/// The longest 99th percentile of a crate, in lines.
pub const MAX_PERCENTILE: usize = 40;

/// A function with a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// The type or trait around it.
    pub owner: Option<String>,
    /// Its name.
    pub name: String,
    /// The line of `fn`, from 1.
    pub line: usize,
    /// Lines from `fn` to the closing brace, both included.
    pub lines: usize,
    /// All identifiers in its body.
    pub names: BTreeSet<String>,
}

/// Lengths of the functions of a crate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lengths {
    /// How many functions there are.
    pub count: usize,
    /// Half of the functions are at most this long.
    pub median: usize,
    /// How many functions must become shorter until the median is [`MAX_MEDIAN`].
    pub excess: usize,
    /// 99 of 100 functions are at most this long.
    pub percentile: usize,
    /// The functions that are longer than [`MAX_PERCENTILE`].
    pub long: Vec<(PathBuf, Function)>,
}

/// The functions in a text, nested ones included, tests excluded.
pub fn in_text(text: &str, name: &Path) -> Vec<Function> {
    let mut found = Vec::new();
    collect(&product_tokens(text, name), None, &mut found);
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
    let short = lines.iter().filter(|lines| **lines <= MAX_MEDIAN).count();
    let excess = count.div_ceil(2).saturating_sub(short);
    let long = functions.into_iter().filter(|(_, function)| function.lines > MAX_PERCENTILE).collect();
    Lengths { count, median, excess, percentile, long }
}

/// What breaks the rules of lengths, a sentence each.
pub fn violations(name: &str, lengths: &Lengths) -> Vec<String> {
    let Lengths { median, excess, percentile, .. } = lengths;
    let mut found = Vec::new();
    if *median > MAX_MEDIAN {
        let excess = format!("functions to shorten: {excess}");
        found.push(format!("`{name}`: the median function has {median} lines, not {MAX_MEDIAN}; {excess}"));
    }
    if *percentile > MAX_PERCENTILE {
        found.push(format!("`{name}`: 99 % of the functions need {percentile} lines, not {MAX_PERCENTILE}"));
    }
    found
}

fn collect(tokens: &[TokenTree], owner: Option<&str>, found: &mut Vec<Function>) {
    let mut inner_owner: Option<String> = None;
    for (at, token) in tokens.iter().enumerate() {
        if is_word(Some(token), "impl") || is_word(Some(token), "trait") {
            inner_owner = owner_of(&tokens[at + 1..]).or(inner_owner);
        }
        found.extend(function(&tokens[at..], owner));
        if let TokenTree::Group(group) = token {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            let is_body = group.delimiter() == Delimiter::Brace;
            collect(&inner, inner_owner.as_deref().filter(|_| is_body), found);
            inner_owner = inner_owner.filter(|_| !is_body);
        }
    }
}

/// The function that begins here, if it has a body.
fn function(tokens: &[TokenTree], owner: Option<&str>) -> Option<Function> {
    let name = is_word(tokens.first(), "fn").then(|| word(tokens.get(1))).flatten()?;
    let end = tokens.iter().position(|t| is_punct(Some(t), ';') || group(Some(t), Delimiter::Brace).is_some())?;
    let body = group(tokens.get(end), Delimiter::Brace)?;
    let (first, last) = (tokens[0].span().start().line, body.span_close().end().line);
    let mut names = BTreeSet::new();
    each_list(&[body.clone().into()], &mut |list| names.extend(list.iter().filter_map(ident).map(Ident::to_string)));
    Some(Function { owner: owner.map(str::to_owned), name, line: first, lines: last + 1 - first, names })
}

/// The type of the `impl` or the trait of the `trait` whose tokens follow: the last name outside of generics, behind
/// `for` if there is one.
fn owner_of(tokens: &[TokenTree]) -> Option<String> {
    let mut depth = 0_i32;
    let mut owner = None;
    for (at, token) in tokens.iter().enumerate() {
        let is_arrow = at > 0 && is_punct(tokens.get(at - 1), '-');
        match token {
            TokenTree::Punct(punct) if punct.as_char() == '<' => depth += 1,
            TokenTree::Punct(punct) if punct.as_char() == '>' && !is_arrow => depth -= 1,
            TokenTree::Punct(punct) if punct.as_char() == ';' => return None,
            TokenTree::Punct(punct) if punct.as_char() == ':' && depth == 0 && !touches_path(tokens, at) => break,
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => break,
            TokenTree::Ident(ident) if depth == 0 && ident == "where" => break,
            TokenTree::Ident(ident) if depth == 0 => owner = Some(ident.to_string()),
            _ => {}
        }
    }
    owner
}

/// Whether the colon at this position is part of `::`.
fn touches_path(tokens: &[TokenTree], at: usize) -> bool {
    is_punct(tokens.get(at + 1), ':') || at > 0 && is_punct(tokens.get(at - 1), ':')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<(String, usize)> {
        let name = |f: &Function| f.owner.iter().chain([&f.name]).cloned().collect::<Vec<_>>().join("::");
        in_text(text, Path::new("a.rs")).iter().map(|f| (name(f), f.lines)).collect()
    }

    #[test]
    fn functions_are_measured_from_signature_to_brace() {
        let text =
            "/// Docs.\n#[inline]\npub fn a(\n    b: u32,\n) -> u32 {\n    b\n}\nfn c() {}\ntrait D { fn e(); }\n";
        assert_eq!(found(text), [("a".to_owned(), 5), ("c".to_owned(), 1)]);
    }

    #[test]
    fn owners_are_found() {
        let text = "impl<T: Fn() -> u8> A<T> { fn b() { fn c() {} } }\nimpl fmt::Display for x::D<'_> where E: F { fn g() {} }\ntrait H: I { fn j() {} }";
        let names: Vec<String> = found(text).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["A::b", "c", "D::g", "H::j"]);
    }

    #[test]
    fn functions_of_tests_do_not_count() {
        assert_eq!(found("#[test] fn a() {}\n#[cfg(test)] mod tests { fn b() {} }"), []);
    }

    #[test]
    fn long_functions_are_found() {
        let one = |lines: usize| format!("fn f() {{\n{}}}\n", "a();\n".repeat(lines - 2));
        let measured = |texts: &[String]| {
            let functions = in_text(&texts.concat(), Path::new("a.rs"));
            violations("a", &lengths(functions.into_iter().map(|f| (PathBuf::from("a.rs"), f)).collect()))
        };
        assert_eq!(measured(&[one(7), one(40)]), Vec::<String>::new());
        assert_eq!(measured(&[one(3), one(41)]), ["`a`: 99 % of the functions need 41 lines, not 40"]);
        assert_eq!(
            measured(&[one(8), one(9)]),
            ["`a`: the median function has 8 lines, not 7; functions to shorten: 1"]
        );
    }
}
