//! Rust text as tokens, without the items that only tests compile.

use std::path::Path;

use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};

/// The tokens of a file, without items under `#[cfg(test)]` and `#[test]`.
///
/// # Panics
///
/// Panics if the text is not Rust; `name` appears in the message.
pub fn product_tokens(text: &str, name: &Path) -> Vec<TokenTree> {
    without_tests(all_tokens(text, name))
}

/// All tokens of a file.
///
/// # Panics
///
/// Panics if the text is not Rust; `name` appears in the message.
pub fn all_tokens(text: &str, name: &Path) -> TokenStream {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.parse().unwrap_or_else(|error| panic!("{}: {error}", name.display()))
}

fn without_tests(stream: TokenStream) -> Vec<TokenTree> {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    let mut kept = Vec::with_capacity(tokens.len());
    let mut at = 0;
    while at < tokens.len() {
        if is_punct(tokens.get(at), '#') && tokens.get(at + 1).and_then(bracketed).is_some_and(is_for_tests) {
            at = item_end(&tokens, at);
        } else {
            kept.push(cleaned(tokens[at].clone()));
            at += 1;
        }
    }
    kept
}

fn cleaned(token: TokenTree) -> TokenTree {
    let TokenTree::Group(group) = token else { return token };
    let mut inner = Group::new(group.delimiter(), without_tests(group.stream()).into_iter().collect());
    inner.set_span(group.span());
    inner.into()
}

/// True if an attribute limits its item to tests: `test`, `cfg(test)`, `cfg(all(test, ..))`.
fn is_for_tests(attribute: &Group) -> bool {
    let text = attribute.stream().to_string().replace(' ', "");
    text == "test" || text == "cfg(test)" || text.starts_with("cfg(all(test,")
}

/// The position after the item that begins at `at`, its attributes included.
fn item_end(tokens: &[TokenTree], mut at: usize) -> usize {
    while is_punct(tokens.get(at), '#') {
        at += 2;
    }
    let ends_with_semicolon = is_value_item(&tokens[at.min(tokens.len())..]);
    while let Some(token) = tokens.get(at) {
        at += 1;
        let is_body = matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
        if is_punct(Some(token), ';') || is_body && !ends_with_semicolon {
            break;
        }
    }
    at
}

/// True if these tokens begin an item that may contain braces before the semicolon that ends it.
fn is_value_item(tokens: &[TokenTree]) -> bool {
    let mut idents = tokens.iter().filter_map(ident).map(Ident::to_string);
    match idents.find(|word| !matches!(word.as_str(), "pub" | "unsafe" | "async" | "extern")).as_deref() {
        Some("const") => idents.next().is_some_and(|next| next != "fn" && next != "unsafe" && next != "async"),
        Some("use" | "static" | "type" | "let") => true,
        _ => false,
    }
}

/// The identifier, if the token is one.
pub fn ident(token: &TokenTree) -> Option<&Ident> {
    match token {
        TokenTree::Ident(ident) => Some(ident),
        _ => None,
    }
}

/// The text of the identifier, without `r#`, if the token is one.
pub fn word(token: Option<&TokenTree>) -> Option<String> {
    let text = ident(token?)?.to_string();
    Some(text.strip_prefix("r#").map(str::to_owned).unwrap_or(text))
}

/// True if the token is this identifier or keyword.
pub fn is_word(token: Option<&TokenTree>, text: &str) -> bool {
    token.and_then(ident).is_some_and(|ident| ident == text)
}

/// True if the token is this character of punctuation.
pub fn is_punct(token: Option<&TokenTree>, wanted: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == wanted)
}

/// True if `::` begins at this position.
pub fn is_path_separator(tokens: &[TokenTree], at: usize) -> bool {
    is_punct(tokens.get(at), ':') && is_punct(tokens.get(at + 1), ':')
}

/// The group, if the token is one with these delimiters.
pub fn group(token: Option<&TokenTree>, delimiter: Delimiter) -> Option<&Group> {
    match token? {
        TokenTree::Group(group) if group.delimiter() == delimiter => Some(group),
        _ => None,
    }
}

fn bracketed(token: &TokenTree) -> Option<&Group> {
    group(Some(token), Delimiter::Bracket)
}

/// Calls `visit` with each list of tokens: this one, then those of the groups in it, at every depth.
pub fn each_list(tokens: &[TokenTree], visit: &mut impl FnMut(&[TokenTree])) {
    visit(tokens);
    for token in tokens {
        if let TokenTree::Group(group) = token {
            each_list(&group.stream().into_iter().collect::<Vec<_>>(), visit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(text: &str) -> String {
        product_tokens(text, Path::new("a.rs")).into_iter().collect::<TokenStream>().to_string()
    }

    #[test]
    fn items_of_tests_are_removed_whole() {
        assert_eq!(kept("#[cfg(test)] mod tests { fn a() {} } struct B;"), "struct B ;");
        assert_eq!(kept("#[cfg(test)] mod tests; struct B;"), "struct B ;");
        assert_eq!(kept("#[cfg(test)] #[allow(x)] pub(crate) const A: B = B { c: 1 }; struct D;"), "struct D ;");
        assert_eq!(kept("#[cfg(test)] const fn a() {} struct D;"), "struct D ;");
        assert_eq!(kept("mod m { #[test] fn a() {} fn b() {} }"), "mod m { fn b () { } }");
    }

    #[test]
    fn other_conditions_are_kept() {
        assert_eq!(kept("#[cfg(not(test))] struct A;"), "# [cfg (not (test))] struct A ;");
    }
}
