//! Paths in tokens: what a module imports, and what it names in its code.

use proc_macro2::{Delimiter, TokenTree};

use crate::tokens::{group, is_path_separator, is_punct, is_word, word};

/// A name that a `use` brings into a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Import {
    /// The path, with `crate`, `self` and `super` as they are written.
    pub(crate) path: Vec<String>,
    /// The name in the module; `None` for `*`.
    pub(crate) name: Option<String>,
    /// True if other modules see the name: a re-export.
    pub(crate) public: bool,
}

/// What the tokens of a module name.
#[derive(Debug, Default)]
pub(crate) struct Found {
    pub(crate) imports: Vec<Import>,
    /// Paths outside of `use`. A single lower-case name counts only where it is called, since it may be a variable.
    pub(crate) paths: Vec<Vec<String>>,
}

impl Found {
    pub(crate) fn scan(&mut self, tokens: &[TokenTree]) {
        let mut at = 0;
        while at < tokens.len() {
            at = match &tokens[at] {
                TokenTree::Group(group) => {
                    self.scan(&group.stream().into_iter().collect::<Vec<_>>());
                    at + 1
                }
                TokenTree::Ident(ident) if ident == "use" && !is_punct(tokens.get(at + 1), '<') => {
                    self.import(tokens, at)
                }
                TokenTree::Ident(_) => self.path(tokens, at),
                _ => at + 1,
            }
        }
    }

    /// Reads the `use` at this position; returns the position after it.
    fn import(&mut self, tokens: &[TokenTree], at: usize) -> usize {
        let end = (at..tokens.len()).find(|i| is_punct(tokens.get(*i), ';')).unwrap_or(tokens.len());
        let before = |distance| at.checked_sub(distance).and_then(|i| tokens.get(i));
        let restricted = group(before(1), Delimiter::Parenthesis).is_some() && is_word(before(2), "pub");
        let public = is_word(before(1), "pub") || restricted;
        let global = is_path_separator(tokens, at + 1);
        if !global {
            self.tree(&tokens[at + 1..end], &[], public);
        }
        end + 1
    }

    /// Reads a tree of imports below a prefix.
    fn tree(&mut self, tokens: &[TokenTree], prefix: &[String], public: bool) {
        let mut path = prefix.to_vec();
        let mut name = None;
        let mut at = 0;
        while at < tokens.len() {
            if let Some(list) = group(tokens.get(at), Delimiter::Brace) {
                let list: Vec<TokenTree> = list.stream().into_iter().collect();
                let branches = list.split(|token| is_punct(Some(token), ','));
                branches.filter(|branch| !branch.is_empty()).for_each(|branch| self.tree(branch, &path, public));
                return;
            }
            if is_punct(tokens.get(at), '*') {
                self.imports.push(Import { path, name: None, public });
                return;
            }
            match word(tokens.get(at)).as_deref() {
                Some("as") => name = Some(word(tokens.get(at + 1)).unwrap_or_else(|| "_".to_owned())),
                Some("self") if !path.is_empty() => {}
                Some(segment) if name.is_none() => path.push(segment.to_owned()),
                _ => {}
            }
            at += 1;
        }
        let name = name.or_else(|| path.last().cloned());
        self.imports.push(Import { path, name, public });
    }

    /// Reads the path at this position; returns the position after it.
    fn path(&mut self, tokens: &[TokenTree], at: usize) -> usize {
        let mut path = vec![word(tokens.get(at)).expect("a path begins with an identifier")];
        let mut end = at + 1;
        while let Some(segment) = is_path_separator(tokens, end).then(|| word(tokens.get(end + 2))).flatten() {
            path.push(segment);
            end += 3;
        }
        if begins_path(tokens, at) && (path.len() > 1 || is_item_name(&path[0], &tokens[end..])) {
            self.paths.push(path);
        }
        end
    }
}

/// True if the identifier at this position can be the first segment of a path: no field, method, lifetime or
/// definition.
fn begins_path(tokens: &[TokenTree], at: usize) -> bool {
    let before = |distance| at.checked_sub(distance).and_then(|i| tokens.get(i));
    let is_member = is_punct(before(1), '.') && !is_punct(before(2), '.');
    let is_continued = is_punct(before(1), ':') && is_punct(before(2), ':');
    !is_member && !is_continued && !is_punct(before(1), '\'') && !is_word(before(1), "fn")
}

fn is_item_name(name: &str, after: &[TokenTree]) -> bool {
    let is_macro = is_punct(after.first(), '!') && !is_punct(after.get(1), '=');
    name.starts_with(char::is_uppercase) || group(after.first(), Delimiter::Parenthesis).is_some() || is_macro
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tokens::product_tokens;

    fn found(text: &str) -> Found {
        let mut found = Found::default();
        found.scan(&product_tokens(text, "a.rs".as_ref()));
        found
    }

    fn written(import: &Import) -> String {
        let public = if import.public { "pub " } else { "" };
        format!("{public}{} as {}", import.path.join("::"), import.name.as_deref().unwrap_or("*"))
    }

    #[test]
    fn trees_of_imports_are_read() {
        let found =
            found("use a::{self, b::C as D, e::*}; pub(crate) use f::G as _; use ::std::x; fn h() { use i::J; }");
        let imports: Vec<String> = found.imports.iter().map(written).collect();
        assert_eq!(imports, ["a as a", "a::b::C as D", "a::e as *", "pub f::G as _", "i::J as J"]);
    }

    #[test]
    fn paths_are_told_from_fields_and_variables() {
        let found =
            found("fn a(x: &'b C) -> impl D + use<'b> { x.e(f::g::<H>(), i(j), k, m!(n::O), ..P::new()) != q }");
        let paths: Vec<String> = found.paths.iter().map(|path| path.join("::")).collect();
        assert_eq!(paths, ["C", "D", "f::g", "H", "i", "m", "n::O", "P::new"]);
    }
}
