//! Free names of a declaration, which can mean something outside of it: not members, locals, parameters, attributes and
//! enumerants.

use super::kind::DeclarationKind;
use crate::token::{Token, TokenKind};

/// Names by the indices of their tokens.
#[derive(Default)]
pub(super) struct Names {
    /// Names that may be declared at the top level, in the order of the text.
    pub(super) uses: Vec<usize>,
    /// Names of parameters and local variables, where they are declared.
    pub(super) locals: Vec<usize>,
}

pub(super) fn names_of(text: &str, tokens: &[Token], kind: DeclarationKind) -> Names {
    let mut reader =
        Reader { text, tokens, at: 0, names: Names::default(), scopes: Vec::new(), pending: Vec::new(), pointers: 0 };
    match kind {
        DeclarationKind::Function => reader.function(),
        DeclarationKind::Struct => reader.members(),
        _ => reader.rest(),
    }
    reader.names
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    Block,
    /// With the block after the header of a `for`.
    For,
}

struct Reader<'t> {
    text: &'t str,
    tokens: &'t [Token],
    at: usize,
    names: Names,
    /// Each open scope with the names that it has declared.
    scopes: Vec<(Scope, Vec<&'t str>)>,
    /// Names that are known from the end of their statement, or of their parameter list, on.
    pending: Vec<&'t str>,
    /// Pointer types that are read, one inside of the other.
    pointers: u32,
}

/// No language has pointers to pointers; a file may.
const MAX_POINTERS: u32 = 16;
/// Attributes whose arguments are enumerants.
const NAMING_ATTRIBUTES: [&str; 3] = ["builtin", "interpolate", "diagnostic"];
/// Words of the language that no declaration can have for a name.
const KEYWORDS: [&str; 21] = [
    "alias",
    "break",
    "case",
    "const",
    "const_assert",
    "continue",
    "continuing",
    "default",
    "discard",
    "else",
    "false",
    "fn",
    "for",
    "if",
    "let",
    "loop",
    "override",
    "return",
    "struct",
    "true",
    "var",
];
const ACCESS: [&str; 3] = ["read", "write", "read_write"];

impl<'t> Reader<'t> {
    fn is(&self, at: usize, sign: char) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(sign))
    }

    fn name(&self, at: usize) -> Option<&'t str> {
        let token = self.tokens.get(at).filter(|token| token.kind == TokenKind::Name)?;
        Some(token.of(self.text))
    }

    /// Reads a token that means the same in every declaration; whether it was one.
    fn common(&mut self) -> bool {
        if self.is(self.at, '@') {
            self.attribute();
        } else if self.is(self.at, '.') && self.name(self.at + 1).is_some() {
            self.at += 2;
        } else if let Some(name) = self.name(self.at) {
            self.word(name);
        } else {
            return false;
        }
        true
    }

    fn attribute(&mut self) {
        let names = self.name(self.at + 1).is_some_and(|name| NAMING_ATTRIBUTES.contains(&name));
        self.at += 2;
        if names && self.is(self.at, '(') {
            self.skip_to(')');
        }
    }

    fn skip_to(&mut self, sign: char) {
        while self.at < self.tokens.len() && !self.is(self.at, sign) {
            self.at += 1;
        }
        self.at += 1;
    }

    fn word(&mut self, name: &'t str) {
        let is_known = self.scopes.iter().any(|(_, names)| names.contains(&name));
        if !is_known && !KEYWORDS.contains(&name) {
            self.names.uses.push(self.at);
        }
        self.at += 1;
        if !self.is(self.at, '<') || is_known {
            return;
        }
        if name == "var" || name.starts_with("texture_storage_") {
            self.skip_to('>');
        } else if name == "ptr" && self.pointers < MAX_POINTERS {
            self.pointers += 1;
            self.pointer();
            self.pointers -= 1;
        }
    }

    /// The template list of a pointer's type: address space, type and perhaps access.
    fn pointer(&mut self) {
        self.at += 2;
        let (mut depth, mut commas) = (1, 0);
        while depth > 0 && self.at < self.tokens.len() {
            let is_access = commas == 2 && self.name(self.at).is_some_and(|name| ACCESS.contains(&name));
            let kind = self.tokens[self.at].kind;
            match kind {
                TokenKind::Sign('<') => depth += 1,
                TokenKind::Sign('>') => depth -= 1,
                TokenKind::Sign(',') if depth == 1 => commas += 1,
                _ if depth == 1 && is_access => {}
                _ if self.common() => continue,
                _ => {}
            }
            self.at += 1;
        }
    }

    fn rest(&mut self) {
        while self.at < self.tokens.len() {
            if !self.common() {
                self.at += 1;
            }
        }
    }

    fn members(&mut self) {
        while self.at < self.tokens.len() {
            let is_member = self.name(self.at).is_some() && self.is(self.at + 1, ':');
            if is_member || !self.common() {
                self.at += 1;
            }
        }
    }

    fn function(&mut self) {
        let mut depth = 0;
        // Parameters and the result.
        while self.at < self.tokens.len() && !(depth == 0 && self.is(self.at, '{')) {
            if depth == 1 && self.is(self.at + 1, ':') && self.name(self.at).is_some() {
                self.declare(self.at);
                self.at += 1;
                continue;
            }
            let kind = self.tokens[self.at].kind;
            match kind {
                TokenKind::Sign('(') => depth += 1,
                TokenKind::Sign(')') => depth -= 1,
                _ if self.common() => continue,
                _ => {}
            }
            self.at += 1;
        }
        self.body();
    }

    fn declare(&mut self, at: usize) {
        self.names.locals.push(at);
        self.pending.extend(self.name(at));
    }

    fn body(&mut self) {
        while self.at < self.tokens.len() {
            let kind = self.tokens[self.at].kind;
            match kind {
                TokenKind::Sign('{') => self.open(Scope::Block),
                TokenKind::Sign('}') => self.close(),
                TokenKind::Sign(';') => self.end_statement(),
                TokenKind::Name => {
                    self.statement_word();
                    continue;
                }
                _ if self.common() => continue,
                _ => {}
            }
            self.at += 1;
        }
    }

    fn statement_word(&mut self) {
        let word = self.name(self.at).expect("the token is a name");
        match word {
            "for" => {
                self.open(Scope::For);
                self.at += 1;
            }
            "let" | "var" | "const" => {
                self.common();
                if self.name(self.at).is_some() {
                    self.declare(self.at);
                    self.at += 1;
                }
            }
            _ => self.word(word),
        }
    }

    fn open(&mut self, scope: Scope) {
        self.scopes.push((scope, std::mem::take(&mut self.pending)));
    }

    fn close(&mut self) {
        self.scopes.pop();
        if self.scopes.last().is_some_and(|(scope, _)| *scope == Scope::For) {
            self.scopes.pop();
        }
    }

    fn end_statement(&mut self) {
        if let Some((_, names)) = self.scopes.last_mut() {
            names.append(&mut self.pending);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::token::tokens;

    fn uses(text: &str, kind: DeclarationKind) -> Vec<&str> {
        let tokens = tokens(text).expect("every comment ends");
        let names = names_of(text, &tokens, kind);
        names.uses.iter().map(|at| tokens[*at].of(text)).collect()
    }

    fn in_function(text: &str) -> Vec<&str> {
        uses(text, DeclarationKind::Function)
    }

    #[test]
    fn members_and_attributes_are_not_names_of_the_file() {
        let text = "struct S { @align(N) @size(16) size: vec4<T>, @builtin(position) position: vec4f, }";
        assert_eq!(uses(text, DeclarationKind::Struct), ["S", "N", "vec4", "T", "vec4f"]);
        assert_eq!(in_function("fn f(p: P) -> Q { return p.size.xy + g(p.f).f; }"), ["f", "P", "Q", "g"]);
        let text = "fn f(@builtin(local_invocation_id) size: vec3u) { }";
        assert_eq!(in_function(text), ["f", "vec3u"]);
    }

    #[test]
    fn locals_hide_the_names_of_the_file_from_the_end_of_their_statement() {
        assert_eq!(in_function("fn f(x: x) { let y = y; g(y); }"), ["f", "x", "y", "g"]);
        assert_eq!(in_function("fn f() { if a { let a = 1; a; } a; }"), ["f", "a", "a"]);
        assert_eq!(
            in_function("fn f() { for (var i = i; i < n; i++) { let n = i; n; } i; n; }"),
            ["f", "i", "n", "i", "n"]
        );
        assert_eq!(in_function("fn f() { loop { let k = 1; continuing { break if k > k; } } k; }").last(), Some(&"k"));
    }

    #[test]
    fn enumerants_are_not_names_of_the_file() {
        let text = "@group(G) @binding(B) var<storage, read_write> x: array<T>;";
        assert_eq!(uses(text, DeclarationKind::Variable), ["G", "B", "x", "array", "T"]);
        let text = "var x: texture_storage_2d<rgba16float, write>;";
        assert_eq!(uses(text, DeclarationKind::Variable), ["x", "texture_storage_2d"]);
        let text = "fn f(p: ptr<storage, array<T, write>, read>, q: ptr<function, write>) { }";
        assert_eq!(in_function(text), ["f", "ptr", "array", "T", "write", "ptr", "write"]);
    }
}
