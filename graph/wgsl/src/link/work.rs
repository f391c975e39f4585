//! Limits of a module that grows when a compiler computes its constants.

use super::linker::Linked;
use super::source_map::GENERATED;
use crate::error::ShaderError;
use crate::limits::{DECLARATIONS, VALUE_TOKENS};
use crate::module::{DeclarationKind, Module};

/// Checks the declarations of a linked module.
pub(crate) fn check_work(linked: &Linked) -> Result<(), ShaderError> {
    let module = Module::parse(GENERATED, &linked.text)?;
    let error = |index: usize, message: String| {
        let token = module.declarations[index].tokens.start as usize;
        linked.map.error(Some(module.tokens[token].start as usize), message)
    };
    let last = module.declarations.len().saturating_sub(1);
    if let Some(message) = DECLARATIONS.exceeded(module.declarations.len()) {
        return Err(error(last, message));
    }
    let mut sizes = Sizes { module: &module, known: vec![None; module.declarations.len()] };
    for index in (0..module.declarations.len()).filter(|index| !is_function(&module, *index)) {
        if let Some(message) = VALUE_TOKENS.exceeded(sizes.of(index)) {
            return Err(error(index, message));
        }
    }
    Ok(())
}

fn is_function(module: &Module, index: usize) -> bool {
    module.declarations[index].kind == DeclarationKind::Function
}

/// Tokens of constants and types, with those that they use counted at each use.
struct Sizes<'m> {
    module: &'m Module,
    known: Vec<Option<usize>>,
}

impl Sizes<'_> {
    fn of(&mut self, index: usize) -> usize {
        if let Some(known) = self.known[index] {
            return known;
        }
        // A declaration that uses itself is an error that the validator finds.
        self.known[index] = Some(0);
        let (module, declaration) = (self.module, &self.module.declarations[index]);
        let used = declaration.uses.iter().filter_map(|used| module.declaration(used.symbol));
        let size = used
            .filter(|other| !is_function(module, *other))
            .fold(declaration.tokens.len(), |sum, other| sum.saturating_add(self.of(other)));
        self.known[index] = Some(size);
        size
    }
}
