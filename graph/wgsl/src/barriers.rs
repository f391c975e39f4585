//! Memory that the invocations of a workgroup share, and barriers, in untrusted files.
//!
//! An invocation that waits for one which has gone another way may halt a device. The validator does not see that
//! invocations leave a loop at different times, so the rule here is stricter: barriers stand where all arrive.

use naga::{AddressSpace, Block, Expression, Function, Handle, Module, Span, Statement};

use crate::limits::BARRIERS;
use crate::walk::{blocks, statements, with_callers};

const BRANCH: &str = "not every invocation may arrive at this barrier: it stands in a branch or a loop";
const RETURN: &str = "not every invocation may arrive at this barrier: a `return` stands before it";

/// The functions and entry points that use memory of a workgroup or wait for others, and those that call one.
pub(crate) fn sharing(module: &Module) -> Vec<&String> {
    with_callers(module, &|function| {
        let is_shared = |expression: &Expression| match expression {
            Expression::GlobalVariable(global) => module.global_variables[*global].space == AddressSpace::WorkGroup,
            _ => false,
        };
        let mut waits = false;
        statements(&function.body, &mut |statement| waits |= is_barrier(statement));
        waits || function.expressions.iter().any(|(_, expression)| is_shared(expression))
    })
}

/// The first barrier that not every invocation may reach, or function with too many, and why it is wrong.
pub(crate) fn check_barriers(module: &Module) -> Option<(Span, String)> {
    let mut waits = Waits { of: Vec::with_capacity(module.functions.len()) };
    // A module declares functions before those that call them.
    for (handle, function) in module.functions.iter() {
        if let Some((span, why)) = waits.misplaced(&function.body, &mut false) {
            return Some((span, why.to_owned()));
        }
        let count = waits.count(&function.body);
        if let Some(message) = BARRIERS.exceeded(count) {
            return Some((module.functions.get_span(handle), message));
        }
        waits.of.push(count);
    }
    None
}

fn is_barrier(statement: &Statement) -> bool {
    matches!(statement, Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. })
}

/// The barriers of the functions before.
struct Waits {
    /// With those of the functions that they call, counted at each call.
    of: Vec<usize>,
}

impl Waits {
    /// The barriers of a statement itself, without those in it.
    fn own(&self, statement: &Statement) -> usize {
        let called = |function: &Handle<Function>| self.of[function.index()];
        match statement {
            Statement::Call { function, .. } => called(function),
            statement => usize::from(is_barrier(statement)),
        }
    }

    fn count(&self, block: &Block) -> usize {
        let mut count = 0_usize;
        statements(block, &mut |statement| count = count.saturating_add(self.own(statement)));
        count
    }

    /// The first barrier that not every invocation reaches, in a block that all enter. `left` states whether one may
    /// have left the function before.
    fn misplaced(&self, block: &Block, left: &mut bool) -> Option<(Span, &'static str)> {
        for (statement, span) in block.span_iter() {
            if self.own(statement) > 0 && *left {
                return Some((*span, RETURN));
            }
            if let Statement::Block(inner) = statement {
                if let Some(found) = self.misplaced(inner, left) {
                    return Some(found);
                }
                continue;
            }
            for inner in blocks(statement) {
                if let Some(span) = self.first(inner) {
                    return Some((span, BRANCH));
                }
                statements(inner, &mut |statement| *left |= matches!(statement, Statement::Return { .. }));
            }
        }
        None
    }

    /// The first barrier of a block, however deep.
    fn first(&self, block: &Block) -> Option<Span> {
        block.span_iter().find_map(|(statement, span)| match self.own(statement) {
            0 => blocks(statement).into_iter().find_map(|inner| self.first(inner)),
            _ => Some(*span),
        })
    }
}
