//! Tree of the entries between two brackets: fields, values, a list or a map.

use super::syntax;
use super::tokens::Tokens;
use super::tree::{Field, Group, Item, Tree};
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned};

/// An entry of a group: `value` or `key: value`.
pub(super) struct Entry {
    pub(super) key: Option<Item>,
    pub(super) value: Item,
    /// True if it may be a part of the entry before it.
    pub(super) follows_error: bool,
}

/// `( ... )`: fields if any entry has a name, values otherwise.
pub(super) fn struct_or_tuple(name: Option<Spanned<String>>, group: Group<Entry>, tokens: &mut Tokens<'_>) -> Tree {
    let Group { entries, mut is_partial } = group;
    let has_names = entries.iter().any(|entry| entry.key.is_some());
    if !has_names && !entries.is_empty() {
        let items: Vec<Item> = entries.into_iter().map(|entry| entry.value).collect();
        let is_broken = is_partial || items.iter().any(|item| item.value.is_broken());
        return if is_broken { Tree::Broken } else { Tree::Tuple(name, items) };
    }
    if !has_names && name.is_none() && !is_partial {
        return Tree::Tuple(None, Vec::new());
    }
    let mut fields = Vec::new();
    for entry in entries {
        match field(entry, tokens) {
            Some(field) => fields.push(field),
            None => is_partial = true,
        }
    }
    Tree::Struct(name, Group { entries: fields, is_partial })
}

/// An entry as a field; `None` if its name cannot be read.
fn field(entry: Entry, tokens: &mut Tokens<'_>) -> Option<Field> {
    let Entry { key, value, follows_error } = entry;
    match key {
        Some(Item { value: Tree::Name(name), location }) => Some((Spanned::new(name, location), value)),
        Some(Item { value: Tree::Text(name), location }) => {
            tokens.report(syntax::quoted_name(&location, &name));
            Some((Spanned::new(name, location), value))
        }
        other => {
            let location = other.map_or(value.location, |key| key.location);
            if !follows_error && !value.value.is_broken() {
                tokens.report(no_name(&location, tokens));
            }
            None
        }
    }
}

fn no_name(location: &Location, tokens: &Tokens<'_>) -> Diagnostic {
    let before = tokens.lexer.text[..location.start].strip_suffix(',');
    let written = &tokens.lexer.text[location.span()];
    let ends = |text: &str| text.ends_with(|c: char| c.is_ascii_digit());
    let begins = written.starts_with(|c: char| c.is_ascii_digit());
    match before {
        Some(before) if ends(before) && begins => {
            let is_part = |c: char| c.is_ascii_digit() || c == '-';
            let whole = &before[before.trim_end_matches(is_part).len()..];
            let digits = written.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
            syntax::decimal_comma(location, &format!("{whole}.{digits}"))
        }
        _ => syntax::no_name(location, written),
    }
}

pub(super) fn list(open: &Location, group: Group<Entry>, tokens: &mut Tokens<'_>) -> Tree {
    let named = group.entries.iter().find_map(|entry| entry.key.as_ref());
    if let Some(key) = named {
        tokens.report(syntax::list_with_names(&key.location, open));
        return Tree::Broken;
    }
    let items: Vec<Item> = group.entries.into_iter().map(|entry| entry.value).collect();
    let is_broken = group.is_partial || items.iter().any(|item| item.value.is_broken());
    if is_broken { Tree::Broken } else { Tree::List(items) }
}

pub(super) fn map(group: Group<Entry>) -> Tree {
    let entries = group.entries.into_iter().filter_map(|entry| Some((entry.key?, entry.value))).collect();
    Tree::Map(Group { entries, is_partial: group.is_partial })
}
