//! Changes of an instance's text, each of whole tokens. A name that the file does not declare changes nothing.

use std::ops::Range;

use super::instance::Part;
use crate::module::{Declaration, DeclarationKind};

/// A declaration with the text of its tokens.
struct Found<'m> {
    declaration: &'m Declaration,
    /// The index of its first token.
    first: usize,
    words: Vec<&'m str>,
}

impl Found<'_> {
    fn position(&self, word: &str) -> Option<usize> {
        self.words.iter().position(|other| *other == word)
    }

    /// The tokens in the parentheses of an attribute.
    fn argument(&self, attribute: &str) -> Option<Range<usize>> {
        let at = (1..self.words.len()).find(|at| self.words[at - 1] == "@" && self.words[*at] == attribute)?;
        let mut depth = 0;
        let mut closes = |word: &str| {
            depth += i32::from(word == "(") - i32::from(word == ")");
            depth == 0
        };
        let length = self.words[at + 1..].iter().position(|word| closes(word))?;
        Some(at + 2..at + 1 + length)
    }
}

fn find<'m>(part: &Part<'m>, name: &str) -> Option<Found<'m>> {
    let (module, text): (_, &'m str) = (part.module, part.file.text());
    let declaration = &module.declarations[module.declaration_of(name)?];
    let words = module.tokens_of(declaration).iter().map(|token| token.of(text)).collect();
    Some(Found { declaration, first: declaration.tokens.start as usize, words })
}

/// Other text for some tokens of a declaration.
fn set(part: &mut Part<'_>, found: &Found<'_>, tokens: Range<usize>, text: impl Into<String>) {
    let bytes = part.module.bytes(found.first + tokens.start..found.first + tokens.end);
    part.edits.push((bytes, text.into()));
}

pub(super) fn bind(part: &mut Part<'_>, variable: &str, group: u32, binding: u32) {
    let Some(found) = find(part, variable) else { return };
    for (attribute, value) in [("group", group), ("binding", binding)] {
        if let Some(tokens) = found.argument(attribute) {
            set(part, &found, tokens, value.to_string());
        }
    }
}

pub(super) fn set_storage_format(part: &mut Part<'_>, variable: &str, format: &str) {
    let Some(found) = find(part, variable) else { return };
    let texture = found.words.iter().position(|word| word.starts_with("texture_storage_"));
    if let Some(at) = texture.filter(|at| found.words.get(at + 1) == Some(&"<") && at + 3 < found.words.len()) {
        set(part, &found, at + 2..at + 3, format);
    }
}

/// Gives a constant or an alias another value.
pub(super) fn set_value(part: &mut Part<'_>, name: &str, value: &str) {
    let Some(found) = find(part, name) else { return };
    let is_valued = matches!(found.declaration.kind, DeclarationKind::Constant | DeclarationKind::Alias);
    if let Some(equals) = found.position("=").filter(|_| is_valued) {
        set(part, &found, equals + 1..found.words.len() - 1, value);
    }
}

/// Makes the overrides of a file constants, which are evaluated when the file is read and not only on the device.
pub(super) fn make_overrides_constant(part: &mut Part<'_>) {
    let module = part.module;
    for declaration in module.declarations.iter().filter(|it| it.kind == DeclarationKind::Override) {
        let tokens = module.tokens_of(declaration);
        if let Some(keyword) = tokens.iter().find(|token| token.of(part.file.text()) == "override") {
            part.edits.push((keyword.start as usize..keyword.end as usize, "const".into()));
        }
    }
}

pub(super) fn set_override(part: &mut Part<'_>, name: &str, value: f64) {
    let Some(found) = find(part, name).filter(|found| found.declaration.kind == DeclarationKind::Override) else {
        return;
    };
    let (Some(keyword), Some(end)) = (found.position("override"), found.words.len().checked_sub(1)) else { return };
    let equals = found.position("=").unwrap_or(end);
    let ty = found.position(":").and_then(|at| found.words.get(at + 1)).copied();
    let first = found.words.get(equals + 1).copied().unwrap_or_default();
    let value = literal(value, ty, first);
    set(part, &found, 0..keyword + 1, "const");
    if equals == end {
        set(part, &found, end..end + 1, format!(" = {value};"));
    } else {
        set(part, &found, equals + 1..end, value);
    }
}

/// A number of that type, or of the type that the first token of the present value shows.
fn literal(value: f64, ty: Option<&str>, present: &str) -> String {
    let suffixed = |suffix: char| present.ends_with(suffix) && !present.starts_with("0x");
    match ty {
        Some("bool") => (value != 0.0).to_string(),
        Some("f32" | "f16") => format!("{value:?}"),
        Some(_) => format!("{}", value as i64),
        None if matches!(present, "true" | "false") => (value != 0.0).to_string(),
        None if suffixed('u') => format!("{}u", value as i64),
        None if present.contains(['.', 'e']) || suffixed('f') => format!("{value:?}f"),
        None => format!("{}", value as i64),
    }
}

pub(super) fn make_immediate(part: &mut Part<'_>, variable: &str) {
    let Some(found) = find(part, variable) else { return };
    for attribute in ["group", "binding"] {
        if let Some(tokens) = found.argument(attribute) {
            set(part, &found, tokens.start - 3..tokens.end + 1, "");
        }
    }
    if let Some(at) = found.position("uniform") {
        set(part, &found, at..at + 1, "immediate");
    }
}

#[cfg(test)]
mod tests {
    use super::literal;

    #[test]
    fn a_number_is_written_in_the_type_of_the_constant() {
        for (value, ty, present, written) in [
            (2.0, Some("f32"), "1", "2.0"),
            (0.5, Some("f16"), "", "0.5"),
            (3.0, Some("u32"), "1.0", "3"),
            (-3.0, Some("i32"), "", "-3"),
            (1.0, Some("bool"), "false", "true"),
            (0.0, Some("bool"), "true", "false"),
            (1.0, None, "false", "true"),
            (0.0, None, "true", "false"),
            (7.0, None, "1u", "7u"),
            (7.0, None, "0x1fu", "7"),
            (7.0, None, "1.5", "7.0f"),
            (7.0, None, "1e3", "7.0f"),
            (7.0, None, "1f", "7.0f"),
            (7.0, None, "0x1f", "7"),
            (7.0, None, "1", "7"),
            (7.0, None, "", "7"),
        ] {
            assert_eq!(literal(value, ty, present), written, "{value} for {ty:?} and `{present}`");
        }
    }
}
