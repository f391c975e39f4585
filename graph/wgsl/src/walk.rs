//! Walks over naga's modules: statements however deep, and functions with those that call them.

use std::collections::BTreeSet;

use naga::{Block, Function, Handle, Module, Statement};

pub(crate) fn blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// Visits every statement of a block, however deep.
pub(crate) fn statements(block: &Block, visit: &mut impl FnMut(&Statement)) {
    for statement in block.iter() {
        visit(statement);
        blocks(statement).into_iter().for_each(|block| statements(block, visit));
    }
}

/// Visits every function that a block calls, once for each call.
pub(crate) fn calls(block: &Block, visit: &mut impl FnMut(Handle<Function>)) {
    statements(block, &mut |statement| {
        if let Statement::Call { function, .. } = statement {
            visit(*function);
        }
    });
}

/// The functions and entry points for which `holds` is true, and those that call one of them.
pub(crate) fn with_callers<'m>(module: &'m Module, holds: &dyn Fn(&Function) -> bool) -> Vec<&'m String> {
    let mut found = BTreeSet::new();
    let is_found = |function: &Function, found: &BTreeSet<Handle<Function>>| {
        let mut calls_one = false;
        calls(&function.body, &mut |callee| calls_one |= found.contains(&callee));
        calls_one || holds(function)
    };
    // A module declares functions before those that call them.
    for (handle, function) in module.functions.iter() {
        if is_found(function, &found) {
            found.insert(handle);
        }
    }
    let functions = found.iter().filter_map(|handle| module.functions[*handle].name.as_ref());
    let entries = module.entry_points.iter().filter(|entry| is_found(&entry.function, &found));
    functions.chain(entries.map(|entry| &entry.name)).collect()
}
