//! Resolution of names, and the declarations that a module needs.

use super::instance::{Instance, Part, Target};
use crate::error::ShaderError;
use crate::module::{DeclarationKind, Symbol};

#[derive(Clone, Copy)]
pub(super) struct Roots<'r> {
    /// The instance whose declarations are all in it.
    pub(super) whole: Instance,
    pub(super) entries: &'r [(Instance, &'r str)],
}

/// Marks what the roots need, and all assertions of authors.
pub(super) fn reach(parts: &mut [Part<'_>], roots: Roots<'_>) {
    let mut open = Vec::new();
    for (instance, name) in roots.entries {
        let found = parts[instance.index()].module.declaration_of(name);
        open.extend(found.map(|declaration| (*instance, declaration)));
    }
    for (index, part) in parts.iter().enumerate() {
        let instance = Instance(index as u32);
        for (at, declaration) in part.module.declarations.iter().enumerate() {
            let is_repeated = declaration.name.is_some_and(|name| part.module.declaration(name) != Some(at));
            let is_kept = match declaration.kind {
                DeclarationKind::Assertion => !part.is_framework,
                DeclarationKind::Unknown => true,
                _ => is_repeated,
            };
            if is_kept || instance == roots.whole {
                open.push((instance, at));
            }
        }
    }
    while let Some((instance, declaration)) = open.pop() {
        let part = &mut parts[instance.index()];
        if std::mem::replace(&mut part.reached[declaration], true) {
            continue;
        }
        let module = part.module;
        for symbol in &module.declarations[declaration].used {
            if let Target::Declared(instance, symbol) = follow(parts, instance, *symbol) {
                let declared = parts[instance.index()].module.declaration(symbol);
                open.extend(declared.map(|declaration| (instance, declaration)));
            }
        }
    }
}

/// Meaning of a name of an instance, after replacements.
fn follow(parts: &mut [Part<'_>], instance: Instance, symbol: Symbol) -> Target {
    let target = resolve(parts, instance, symbol);
    if let Target::Replaced(index) = target {
        return replacing(parts, instance, index);
    }
    target
}

/// Meaning of the replacement of a name.
pub(super) fn replacing(parts: &[Part<'_>], instance: Instance, replacement: usize) -> Target {
    let code = Instance(parts.len() as u32 - 1);
    let by = &parts[instance.index()].replacements[replacement].by;
    declared(parts, code, by).unwrap_or(Target::Language)
}

fn resolve(parts: &mut [Part<'_>], instance: Instance, symbol: Symbol) -> Target {
    if let Some(known) = parts[instance.index()].targets[symbol.index()] {
        return known;
    }
    let target = look_up(parts, instance, symbol);
    parts[instance.index()].targets[symbol.index()] = Some(target);
    target
}

fn look_up(parts: &[Part<'_>], instance: Instance, symbol: Symbol) -> Target {
    let part = &parts[instance.index()];
    if let Some(index) = part.replacements.iter().position(|replacement| replacement.name == symbol) {
        return Target::Replaced(index);
    }
    if part.module.declaration(symbol).is_some() {
        return Target::Declared(instance, symbol);
    }
    let name = part.module.name(symbol);
    // Only generated code refers to files by their instances.
    match reference(name).filter(|_| instance.index() + 1 == parts.len()) {
        Some((other, name)) => meaning(parts, other, name),
        None => imported(parts, instance, name),
    }
}

/// References of generated code by [`Linker::name`](super::linker::Linker::name): WGSL has no names that begin like
/// this.
pub(super) fn reference(name: &str) -> Option<(Instance, &str)> {
    let (instance, name) = name.strip_prefix("__")?.split_once('_')?;
    Some((Instance(instance.parse().ok()?), name))
}

/// Meaning of a name in a file, also of one that the file itself does not use.
fn meaning(parts: &[Part<'_>], instance: Instance, name: &str) -> Target {
    declared(parts, instance, name).unwrap_or_else(|| imported(parts, instance, name))
}

fn declared(parts: &[Part<'_>], instance: Instance, name: &str) -> Option<Target> {
    let module = parts.get(instance.index())?.module;
    let symbol = module.symbol(name).filter(|symbol| module.declaration(*symbol).is_some())?;
    Some(Target::Declared(instance, symbol))
}

/// Meaning of a name that the file does not declare: from its imports, or else from the files that all know.
fn imported(parts: &[Part<'_>], instance: Instance, name: &str) -> Target {
    let Some(part) = parts.get(instance.index()) else { return Target::Language };
    let import = part.module.symbol(name).and_then(|symbol| part.imported.get(&symbol));
    match import {
        Some((instance, symbol)) => Target::Declared(*instance, *symbol),
        None => part.prelude.iter().find_map(|file| declared(parts, *file, name)).unwrap_or(Target::Language),
    }
}

/// That files declare what the generated code names in them.
pub(super) fn check(parts: &[Part<'_>]) -> Result<(), ShaderError> {
    let code = parts.last().expect("the generated code is the last part");
    let reached = code.module.declarations.iter().zip(&code.reached).filter(|(_, reached)| **reached);
    for used in reached.flat_map(|(declaration, _)| &declaration.uses) {
        let is_unknown = code.targets[used.symbol.index()] == Some(Target::Language);
        if let Some((instance, name)) = reference(code.module.name(used.symbol)).filter(|_| is_unknown) {
            let file = parts[instance.index()].file;
            return Err(ShaderError::new(file.name(), (0, 0), format!("the file declares no `{name}`")));
        }
    }
    Ok(())
}
