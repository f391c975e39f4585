//! Checks that untrusted files hold functions, constants and types only, and memory of a workgroup where functions have
//! one.

use std::collections::HashSet;

use super::instance::{Instance, Part, Target};
use crate::error::{ShaderError, position};
use crate::module::{Declaration, DeclarationKind, Symbol};
use crate::token::TokenKind;

const BOUND: &str = "this is bound to a resource, which the framework makes by itself: what a function reads are its \
                     arguments";
const ENTRY: &str = "this belongs to an entry point or a binding, which the framework makes by itself: write a \
                     function and take what it reads as arguments";
const ATTRIBUTE: &str = "a kind without Rust has no such attribute: only `@align`, `@size` and `@must_use`";
const WORKGROUP: &str = "a function of one pixel has no memory of a workgroup: neighbors do not run together in a \
                         draw, unless the kind declares a `workgroup` for what the function makes";
const PRIVATE: &str = "a function of one pixel keeps nothing outside of itself, because the next pixel would read it: \
                       use a `const`, or a local variable and pointers to it";
const OVERRIDE: &str = "nothing sets this `override`: give it a value, or make it a parameter of the kind";
const DIRECTIVE: &str = "a kind without Rust uses WGSL without extensions, so that it runs on every device";
const BARRIER: &str = "a function of one pixel cannot wait for others: a draw has no workgroups, unless the kind \
                       declares a `workgroup` for what the function makes, and then it is `workgroupBarrier()`";
const ATOMIC: &str = "a function of one pixel shares no memory with others, so that it needs no atomics";
const SUBGROUP: &str = "a function of one pixel does not see its neighbors: devices order pixels differently. Read a \
                        texture";
const WIDTH: &str = "numbers have 32 bits: use `f32`, `i32` or `u32`";
const RESOURCE: &str = "a function of one pixel reads `texture_2d<f32>` and `texture_3d<f32>`, and writes only its \
                        result";

const UNIFORM_LOAD: &str = "this waits in a way that only some devices check: write `workgroupBarrier()` and read \
                            the memory";

/// Beginnings of names of the language that only functions with a workgroup can use. Others cannot reach atomics.
const SHARED: [(&str, &str); 2] = [("workgroup", BARRIER), ("atomic", ATOMIC)];
/// Beginnings of names of the language that no function of a pixel can use. Derivatives are found by the lints.
const FORBIDDEN: [(&str, &str); 18] = [
    ("workgroupUniformLoad", UNIFORM_LOAD),
    ("storageBarrier", BARRIER),
    ("textureBarrier", BARRIER),
    ("subgroup", SUBGROUP),
    ("quadBroadcast", SUBGROUP),
    ("quadSwap", SUBGROUP),
    ("f64", WIDTH),
    ("i64", WIDTH),
    ("u64", WIDTH),
    ("f16", WIDTH),
    ("i16", WIDTH),
    ("u16", WIDTH),
    ("texture_storage_", RESOURCE),
    ("textureStore", RESOURCE),
    ("textureAtomic", RESOURCE),
    ("binding_array", RESOURCE),
    ("acceleration_structure", RESOURCE),
    ("ray_query", RESOURCE),
];
/// Endings of numbers that have not 32 bits.
const FORBIDDEN_SUFFIXES: [&str; 4] = ["lf", "li", "lu", "h"];
/// Attributes of functions and members that mean the same everywhere.
const ATTRIBUTES: [&str; 4] = ["align", "size", "must_use", "diagnostic"];
/// Attributes of entry points and of what is bound to them.
const ENTRY_ATTRIBUTES: [&str; 12] = [
    "compute",
    "vertex",
    "fragment",
    "workgroup_size",
    "group",
    "binding",
    "builtin",
    "location",
    "interpolate",
    "invariant",
    "blend_src",
    "id",
];

/// Checks what is in the module of untrusted files, and what they use of the framework's library.
/// Only with workgroups may they share memory.
pub(super) fn check_contents(parts: &[Part<'_>], has_workgroups: bool) -> Result<(), ShaderError> {
    for part in parts.iter().filter(|part| part.file.is_untrusted()) {
        let at =
            |byte: usize, why: &str| Err(ShaderError::new(part.file.name(), position(part.file.text(), byte), why));
        if let Some(directive) = part.module.directives.first() {
            return at(directive.start, DIRECTIVE);
        }
        if let Some((token, why)) = reached(part).find_map(|declaration| forbidden(part, declaration, has_workgroups)) {
            return at(part.module.tokens[token].start as usize, why);
        }
        for import in part.module.imports.iter().filter(|_| !has_workgroups) {
            let imported = part.imported.get(&import.name).map(|(instance, _)| *instance);
            if let Some(why) = imported.and_then(|instance| needs_workgroup(parts, instance, &mut HashSet::new())) {
                return at(import.at(0), why);
            }
        }
    }
    Ok(())
}

fn reached<'p>(part: &'p Part<'_>) -> impl Iterator<Item = &'p Declaration> {
    let declarations = part.module.declarations.iter().zip(&part.reached);
    declarations.filter(|(_, reached)| **reached).map(|(declaration, _)| declaration)
}

/// Reason for which a file of the library is for whole kernels only: a use of it, or of its imports. Those may have
/// private variables, which the importing file cannot name.
fn needs_workgroup(parts: &[Part<'_>], file: Instance, seen: &mut HashSet<Instance>) -> Option<&'static str> {
    let part = &parts[file.index()];
    if !part.is_framework || !seen.insert(file) {
        return None;
    }
    let own = reached(part)
        .find_map(|declaration| variable(part, declaration).or_else(|| name(part, declaration, &SHARED)))
        .map(|(_, why)| why);
    let imports = part.module.imports.iter().filter_map(|import| part.imported.get(&import.name));
    let mut of_import =
        |(file, _): &(Instance, Symbol)| needs_workgroup(parts, *file, seen).filter(|why| *why != PRIVATE);
    own.or_else(|| imports.into_iter().find_map(&mut of_import))
}

/// The token that a declaration must not have, and why.
fn forbidden(part: &Part<'_>, declaration: &Declaration, has_workgroups: bool) -> Option<(usize, &'static str)> {
    let is_permitted = |(_, why): &(usize, &str)| has_workgroups && *why == WORKGROUP;
    let shared: &[_] = if has_workgroups { &[] } else { &SHARED };
    let found = variable(part, declaration).filter(|found| !is_permitted(found)).or_else(|| unset(part, declaration));
    found
        .or_else(|| attribute(part, declaration))
        .or_else(|| name(part, declaration, shared))
        .or_else(|| name(part, declaration, &FORBIDDEN))
        .or_else(|| number(part, declaration))
}

/// The token with that index in a declaration, as text.
fn word<'p>(part: &'p Part<'_>, declaration: &Declaration, at: usize) -> Option<&'p str> {
    let token = part.module.tokens_of(declaration).get(at)?;
    Some(token.of(part.file.text()))
}

/// The variable that is declared, and why there is none.
fn variable(part: &Part<'_>, declaration: &Declaration) -> Option<(usize, &'static str)> {
    if declaration.kind != DeclarationKind::Variable {
        return None;
    }
    let keyword = (0..).find(|at| word(part, declaration, *at).is_none_or(|word| word == "var"))?;
    let has_space = word(part, declaration, keyword + 1) == Some("<");
    let why = match word(part, declaration, keyword + 2).filter(|_| has_space) {
        Some("private") => PRIVATE,
        Some("workgroup") => WORKGROUP,
        _ => BOUND,
    };
    let name =
        (keyword..).find(|at| word(part, declaration, at + 1).is_none_or(|word| matches!(word, ":" | "=" | ";")));
    Some((declaration.tokens.start as usize + name.unwrap_or(keyword), why))
}

/// An `override` without a value.
fn unset(part: &Part<'_>, declaration: &Declaration) -> Option<(usize, &'static str)> {
    let tokens = part.module.tokens_of(declaration);
    let is_unset = declaration.kind == DeclarationKind::Override && !tokens.iter().any(|token| token.is('='));
    is_unset.then_some((declaration.tokens.start as usize, OVERRIDE))
}

fn attribute(part: &Part<'_>, declaration: &Declaration) -> Option<(usize, &'static str)> {
    let tokens = part.module.tokens_of(declaration);
    let attributes = (0..tokens.len()).filter(|at| tokens[*at].is('@'));
    let named = attributes.filter_map(|at| Some((at, word(part, declaration, at + 1)?)));
    let (at, name) = named.into_iter().find(|(_, name)| !ATTRIBUTES.contains(name))?;
    let why = if ENTRY_ATTRIBUTES.contains(&name) { ENTRY } else { ATTRIBUTE };
    Some((declaration.tokens.start as usize + at, why))
}

/// The use of a name of the language that is among those.
fn name(
    part: &Part<'_>,
    declaration: &Declaration,
    forbidden: &[(&str, &'static str)],
) -> Option<(usize, &'static str)> {
    declaration.uses.iter().find_map(|used| {
        let is_language = matches!(part.targets[used.symbol.index()], None | Some(Target::Language));
        let name = part.module.name(used.symbol);
        let found = forbidden.iter().filter(|_| is_language).find(|(beginning, _)| name.starts_with(beginning))?;
        Some((used.token as usize, found.1))
    })
}

fn number(part: &Part<'_>, declaration: &Declaration) -> Option<(usize, &'static str)> {
    let is_forbidden = |at: &usize| {
        let token = part.module.tokens[*at];
        let text = token.of(part.file.text());
        token.kind == TokenKind::Number && FORBIDDEN_SUFFIXES.iter().any(|suffix| text.ends_with(suffix))
    };
    (declaration.tokens.start as usize..declaration.tokens.end as usize).find(is_forbidden).map(|at| (at, WIDTH))
}
