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
/// A number of an array that is copied, such as an argument into a variable: llvmpipe takes 0.13 s for each copy of
/// eight, and 0.01 s for an array that is made of numbers.
const COPIED: usize = 1000;
/// A read of a texture.
const READ: usize = 128;
/// A function of the library that reads textures. Its code to repair and filter host images does not run for untrusted
/// kernels, which read sanitized copies.
const LIBRARY_READ: Cost =
    Cost { compile: CompileCost { operations: 1800, merged: 0 }, loops: 0, calls: 0, is_reader: true };
/// The square of the uses of values that branches have made is divided by it: llvmpipe takes two seconds for a
/// thousand.
const MERGED: usize = 10;

/// Cost of the compilation of a function with all that it calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CompileCost {
    operations: usize,
    /// Uses of values that branches have made.
    merged: usize,
}

impl CompileCost {
    /// Its operations, with what it takes to use values that branches have made. [`OPERATIONS`] take two seconds on
    /// llvmpipe.
    pub fn operations(self) -> usize {
        self.operations.saturating_add(self.merged.saturating_mul(self.merged) / MERGED)
    }
}

impl std::iter::Sum for CompileCost {
    fn sum<I: Iterator<Item = Self>>(costs: I) -> Self {
        costs.fold(Self::default(), |sum, cost| Self {
            operations: sum.operations.saturating_add(cost.operations),
            merged: sum.merged.saturating_add(cost.merged),
        })
    }
}

/// The first function that takes too long to compile, and why.
pub(crate) fn check_cost(
    module: &Module,
    info: &ModuleInfo,
    is_of_library: &dyn Fn(Option<&String>) -> bool,
) -> Option<(Span, String)> {
    let costs = function_costs(module, info, is_of_library).0;
    module.functions.iter().zip(costs).find_map(|((handle, _), cost)| {
        let operations = OPERATIONS.exceeded(cost.compile.operations());
        let message = operations.or_else(|| LOOPS.exceeded(cost.loops)).or_else(|| CALLS.exceeded(cost.calls))?;
        Some((module.functions.get_span(handle), message))
    })
}

/// Compilation cost of each function and each entry point of a module.
pub(crate) fn compile_costs<'m>(
    module: &'m Module,
    info: &ModuleInfo,
    is_of_library: &dyn Fn(Option<&String>) -> bool,
) -> Vec<(&'m String, CompileCost)> {
    let (functions, merged) = function_costs(module, info, is_of_library);
    let entries = module.entry_points.iter().enumerate().map(|(index, entry)| {
        let types = Types { module, info: info.get_entry_point(index), function: &entry.function };
        (&entry.name, types.cost_of_all(&functions, &merged).0.compile)
    });
    let named = module.functions.iter().zip(&functions);
    let named = named.filter_map(|((_, function), cost)| Some((function.name.as_ref()?, cost.compile)));
    named.chain(entries).collect()
}

fn function_costs(
    module: &Module,
    info: &ModuleInfo,
    is_of_library: &dyn Fn(Option<&String>) -> bool,
) -> (Vec<Cost>, Vec<Merged>) {
    let mut costs: Vec<Cost> = Vec::with_capacity(module.functions.len());
    let mut all_merged: Vec<Merged> = Vec::with_capacity(module.functions.len());
    // A module declares functions before those that call them.
    for (handle, function) in module.functions.iter() {
        let types = Types { module, info: &info[handle], function };
        let (mut cost, merged) = types.cost_of_all(&costs, &all_merged);
        if cost.is_reader && is_of_library(function.name.as_ref()) {
            cost = LIBRARY_READ;
        }
        costs.push(cost);
        all_merged.push(merged);
    }
    (costs, all_merged)
}

/// Cost of a function and all that it calls.
#[derive(Clone, Copy, Default)]
struct Cost {
    compile: CompileCost,
    loops: usize,
    calls: usize,
    /// True if it reads textures.
    is_reader: bool,
}

impl Cost {
    fn add(&mut self, operations: usize, loops: usize) {
        self.compile.operations = self.compile.operations.saturating_add(operations);
        self.loops = self.loops.saturating_add(loops);
    }

    /// Adds a statement without those in it; `known` holds the costs of the functions before.
    fn statement(&mut self, statement: &Statement, known: &[Self]) {
        match statement {
            Statement::Call { function, .. } => {
                let called = known[function.index()];
                self.add(called.compile.operations, called.loops);
                self.compile.merged = self.compile.merged.saturating_add(called.compile.merged);
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

    /// The cost of the function; `known` and `merged` are of the functions before.
    fn cost_of_all(&self, known: &[Cost], merged: &[Merged]) -> (Cost, Merged) {
        let merged = Merged::of(self.function, &|value| self.numbers(value), merged);
        let compile = CompileCost { operations: self.expressions(), merged: merged.uses };
        let mut cost = Cost { compile, is_reader: has(self.function, is_read), ..Cost::default() };
        statements(&self.function.body, &mut |statement| {
            cost.statement(statement, known);
            cost.add(self.copy(statement), 0);
        });
        (cost, merged)
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

    /// The copy of an array.
    fn copy(&self, statement: &Statement) -> usize {
        let Statement::Store { value, .. } = statement else { return 0 };
        let is_made = matches!(
            self.function.expressions[*value],
            Expression::Compose { .. } | Expression::Constant(_) | Expression::ZeroValue(_)
        );
        let is_copy = !is_made && matches!(self.of(*value), TypeInner::Array { .. });
        if is_copy { self.numbers(*value).saturating_mul(COPIED) } else { 0 }
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
