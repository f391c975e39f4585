//! The names of declarations in a linked module: unique, and where it goes as their authors wrote them.

use rustc_hash::FxHashMap;

use super::instance::{Instance, Part, Target};
use crate::module::Symbol;

/// Who has a name: an instance or several of them.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Owner {
    One(Instance),
    Several,
}

/// Chooses the name of each declaration that is in the module.
///
/// A name stays as it is unless another instance has it too, for whatever it is there: then a local variable there
/// could hide the declaration, or the declaration something of the language.
pub(super) fn choose_names(parts: &mut [Part<'_>]) {
    let mut owners = owners(parts);
    let mut chosen: Vec<(usize, Symbol, String)> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let reached = part.module.declarations.iter().zip(&part.reached).filter(|(_, reached)| **reached);
        for symbol in reached.filter_map(|(declaration, _)| declaration.name) {
            let name = part.module.name(symbol);
            if owners.get(name) != Some(&Owner::One(Instance(index as u32))) {
                chosen.push((index, symbol, String::new()));
            }
        }
    }
    chosen.dedup_by_key(|(index, symbol, _)| (*index, *symbol));
    let mut made: Vec<String> = Vec::new();
    for (index, symbol, name) in &mut chosen {
        let part = &parts[*index];
        let is_free = |name: &str| !owners.contains_key(name) && made.iter().all(|other| other != name);
        *name = free_name(part, *symbol, is_free);
        made.push(name.clone());
    }
    owners.clear();
    drop(owners);
    for (index, symbol, name) in chosen {
        parts[index].renamed[symbol.index()] = Some(name);
    }
}

/// Every name that stays in the text of the module.
fn owners<'m>(parts: &[Part<'m>]) -> FxHashMap<&'m str, Owner> {
    let mut owners = FxHashMap::default();
    for (index, part) in parts.iter().enumerate() {
        let instance = Instance(index as u32);
        let mut note = |symbol: &Symbol| {
            let owner = owners.entry(part.module.name(*symbol)).or_insert(Owner::One(instance));
            if *owner != Owner::One(instance) {
                *owner = Owner::Several;
            }
        };
        let reached = part.module.declarations.iter().zip(&part.reached).filter(|(_, reached)| **reached);
        for (declaration, _) in reached {
            declaration.locals.iter().for_each(&mut note);
            let stays = |symbol: &&Symbol| match part.targets[symbol.index()] {
                Some(Target::Declared(other, _)) => other == instance,
                Some(Target::Replaced(_)) => false,
                _ => true,
            };
            declaration.used.iter().filter(stays).for_each(&mut note);
        }
    }
    owners
}

/// The name with that of its file in front, and with a number if it must be.
fn free_name(part: &Part<'_>, symbol: Symbol, is_free: impl Fn(&str) -> bool) -> String {
    let name = part.module.name(symbol);
    let prefixed = format!("{}_{name}", namespace(part));
    if is_free(&prefixed) {
        return prefixed;
    }
    let numbered = (2..).map(|number| format!("{prefixed}_{number}"));
    numbered.into_iter().find(|name| is_free(name)).expect("there are enough numbers")
}

/// The name of the file as a part of names: letters, digits and single underscores.
fn namespace(part: &Part<'_>) -> String {
    let stem = part.file.stem();
    let mut namespace = String::with_capacity(stem.len());
    for c in stem.chars() {
        let c = if c.is_ascii_alphanumeric() { c } else { '_' };
        if !(c == '_' && (namespace.is_empty() || namespace.ends_with('_'))) {
            namespace.push(c);
        }
    }
    let namespace = namespace.trim_end_matches('_');
    if namespace.starts_with(|c: char| c.is_ascii_alphabetic()) {
        namespace.to_owned()
    } else {
        format!("file{namespace}")
    }
}
