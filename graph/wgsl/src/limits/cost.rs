//! The work of compiling a function. Drivers inline every call, and write out what a device has no instruction for.
//!
//! The weights are measured with llvmpipe, which takes up to 16 microseconds for a weight of 1: two seconds for the
//! limit.

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, BinaryOperator, Expression, Function, Handle, MathFunction, Module, ScalarKind, Span, Statement,
    TypeInner,
};

use super::merged::Merged;
use super::{CALLS, LOOPS, OPERATIONS};
use crate::direct_reads::{has, is_read};
use crate::walk::statements;

/// An operation on one component.
const OPERATION: usize = 3;
/// A division of whole numbers, which drivers write out.
const DIVISION: usize = 400;
/// A choice, for each component.
const SELECT: usize = 12;
/// A component of a vector at a computed index.
const COMPONENT: usize = 96;
/// A branch, and a case of a `switch`.
const BRANCH: usize = 64;
/// A read of a texture.
const READ: usize = 128;
/// A function of the library that reads textures. Its code to repair and filter host images does not run for untrusted
/// kernels, which read sanitized copies.
const LIBRARY_READ: Cost = Cost { operations: 1800, merged: 0, loops: 0, calls: 0, is_reader: true };
/// The square of the uses of values that branches have made is divided by it: llvmpipe takes two seconds for a
/// thousand.
const MERGED: usize = 10;

/// The first function that takes too long to compile, and why.
pub(crate) fn check_cost(
    module: &Module,
    info: &ModuleInfo,
    is_of_library: &dyn Fn(Option<&String>) -> bool,
) -> Option<(Span, String)> {
    let mut costs: Vec<Cost> = Vec::with_capacity(module.functions.len());
    let mut all_merged: Vec<Merged> = Vec::with_capacity(module.functions.len());
    // A module declares functions before those that call them.
    for (handle, function) in module.functions.iter() {
        let types = Types { module, info: &info[handle], function };
        let is_reader = has(function, is_read);
        let merged = Merged::of(function, &|value| types.numbers(value), &all_merged);
        let mut cost = Cost { operations: types.expressions(), merged: merged.uses, is_reader, ..Cost::default() };
        statements(&function.body, &mut |statement| cost.statement(statement, &costs));
        if cost.is_reader && is_of_library(function.name.as_ref()) {
            cost = LIBRARY_READ;
        }
        let exceeded = OPERATIONS.exceeded(cost.all_operations()).or_else(|| LOOPS.exceeded(cost.loops));
        if let Some(message) = exceeded.or_else(|| CALLS.exceeded(cost.calls)) {
            return Some((module.functions.get_span(handle), message));
        }
        costs.push(cost);
        all_merged.push(merged);
    }
    None
}

/// What a function and all that it calls takes.
#[derive(Clone, Copy, Default)]
struct Cost {
    operations: usize,
    /// Uses of values that branches have made.
    merged: usize,
    loops: usize,
    /// Calls inside of calls.
    calls: usize,
    /// Whether it reads textures.
    is_reader: bool,
}

impl Cost {
    /// Its operations, with what it takes to use values that branches have made.
    fn all_operations(&self) -> usize {
        self.operations.saturating_add(self.merged.saturating_mul(self.merged) / MERGED)
    }

    fn add(&mut self, operations: usize, loops: usize) {
        self.operations = self.operations.saturating_add(operations);
        self.loops = self.loops.saturating_add(loops);
    }

    /// Adds a statement without those in it; `known` holds the costs of the functions before.
    fn statement(&mut self, statement: &Statement, known: &[Self]) {
        match statement {
            Statement::Call { function, .. } => {
                let called = known[function.index()];
                self.add(called.operations, called.loops);
                self.merged = self.merged.saturating_add(called.merged);
                self.calls = self.calls.max(called.calls + 1);
                self.is_reader |= called.is_reader;
            }
            Statement::Block(_) => {}
            Statement::If { .. } => self.add(BRANCH, 0),
            Statement::Switch { cases, .. } => self.add(BRANCH * cases.len(), 0),
            Statement::Loop { .. } => self.add(BRANCH, 1),
            _ => self.add(1, 0),
        }
    }
}

/// The types of a function's expressions.
struct Types<'m> {
    module: &'m Module,
    info: &'m FunctionInfo,
    function: &'m Function,
}

impl<'m> Types<'m> {
    fn of(&self, expression: Handle<Expression>) -> &'m TypeInner {
        self.info[expression].ty.inner_with(&self.module.types)
    }

    /// Numbers in a value of the expression's type.
    fn numbers(&self, expression: Handle<Expression>) -> usize {
        let bytes = self.of(expression).try_size(self.module.to_ctx()).unwrap_or(u32::MAX);
        (bytes as usize).div_ceil(4)
    }

    fn expressions(&self) -> usize {
        let costs = self.function.expressions.iter().map(|(handle, expression)| self.cost(handle, expression));
        costs.fold(0, usize::saturating_add)
    }

    fn cost(&self, handle: Handle<Expression>, expression: &Expression) -> usize {
        match expression {
            Expression::Literal(_) | Expression::Constant(_) | Expression::ZeroValue(_) => 0,
            Expression::FunctionArgument(_) | Expression::LocalVariable(_) | Expression::GlobalVariable(_) => 0,
            Expression::Access { base, .. } => self.access(self.of(*base)),
            read if is_read(read) => READ,
            Expression::Binary { left, right, .. } if self.is_matrix(*left) || self.is_matrix(*right) => {
                4 * OPERATION * self.numbers(handle).max(self.numbers(*left)).max(self.numbers(*right))
            }
            Expression::Binary { op: BinaryOperator::Divide | BinaryOperator::Modulo, .. }
                if self.is_integer(handle) =>
            {
                DIVISION * self.numbers(handle)
            }
            Expression::Math { fun, arg, .. } => self.numbers(*arg).max(self.numbers(handle)) * weight(*fun),
            Expression::Select { .. } => SELECT * self.numbers(handle),
            _ if self.is_integer(handle) => 2 * OPERATION * self.numbers(handle),
            _ => OPERATION * self.numbers(handle),
        }
    }

    fn is_integer(&self, expression: Handle<Expression>) -> bool {
        let kind = self.of(expression).scalar_kind();
        matches!(kind, Some(ScalarKind::Sint | ScalarKind::Uint))
    }

    fn is_matrix(&self, expression: Handle<Expression>) -> bool {
        matches!(self.of(expression), TypeInner::Matrix { .. })
    }

    /// The choice of an element: drivers compare the index with all, and copy a value that is not in memory for it.
    fn access(&self, base: &TypeInner) -> usize {
        let (inner, is_value) = match base {
            // Memory of a workgroup is addressed.
            TypeInner::Pointer { space: AddressSpace::WorkGroup, .. } => return COMPONENT,
            TypeInner::Pointer { base, .. } => (&self.module.types[*base].inner, false),
            value => (value, true),
        };
        if !matches!(inner, TypeInner::Array { .. }) {
            return COMPONENT;
        }
        let bytes = inner.try_size(self.module.to_ctx()).unwrap_or(u32::MAX);
        let numbers = (bytes as usize).div_ceil(4).max(32);
        if is_value { numbers.saturating_mul(numbers).saturating_mul(4) } else { numbers.saturating_mul(24) }
    }
}

/// The operations that a function of the language becomes, for each component.
fn weight(function: MathFunction) -> usize {
    use MathFunction as F;
    match function {
        F::Tan => 600,
        F::Log | F::Log2 => 400,
        F::Pow | F::Asin | F::Acos | F::Atan | F::Atan2 | F::Sinh | F::Cosh | F::Tanh => 500,
        F::Asinh | F::Acosh | F::Atanh | F::Refract => 500,
        F::Pack2x16float | F::Unpack2x16float | F::QuantizeToF16 => 320,
        F::Sin | F::Cos => 256,
        F::Ldexp | F::Modf | F::Frexp => 96,
        F::Exp | F::Exp2 | F::Inverse | F::Determinant => 64,
        F::Pack4x8snorm | F::Pack4x8unorm | F::Pack2x16snorm | F::Pack2x16unorm => 64,
        F::Unpack4x8snorm | F::Unpack4x8unorm | F::Unpack2x16snorm | F::Unpack2x16unorm => 64,
        F::ReverseBits | F::CountOneBits | F::CountLeadingZeros | F::CountTrailingZeros => 64,
        F::FirstLeadingBit | F::FirstTrailingBit | F::ExtractBits | F::InsertBits => 64,
        F::SmoothStep | F::FaceForward | F::Reflect | F::Normalize | F::Length | F::Distance => 48,
        _ => 12,
    }
}
