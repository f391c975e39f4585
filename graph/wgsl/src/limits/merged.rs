//! Uses of values that branches have merged: a variable after an `if` that sets it, and the result of a function that
//! returns in one.
//!
//! llvmpipe keeps such a value in memory and reads all of it for each use of a number. Its compiler then takes a time
//! in proportion to the square of these uses.

use naga::{Block, Expression, Function, Handle, LocalVariable, Statement};

use crate::walk::{blocks, statements};

/// Values with fewer uses do not count: there may be many of them.
const FEW: usize = 16;

/// Summary of a function's uses of merged values.
#[derive(Clone, Default)]
pub(super) struct Merged {
    /// Uses of the numbers of values that it makes itself.
    pub(super) uses: usize,
    /// Uses of the numbers of each argument.
    arguments: Vec<usize>,
    /// True if a branch sets what the argument points to.
    sets: Vec<bool>,
    result: Value,
}

/// The value of an expression or a variable: an argument or what branches have made, by its place in [`Walk::uses`].
/// `None` for an operation or a constant.
type Value = Option<usize>;

/// Number of components of an expression.
type Numbers<'w> = &'w dyn Fn(Handle<Expression>) -> usize;

impl Merged {
    /// Summary of a function; `known` holds those before it.
    pub(super) fn of(function: &Function, numbers: Numbers<'_>, known: &[Self]) -> Self {
        let arguments = function.arguments.len();
        let mut walk = Walk {
            function,
            numbers,
            known,
            roots: vec![None; function.expressions.len()],
            locals: vec![None; function.local_variables.len()],
            uses: vec![0; arguments],
            sets: vec![false; arguments],
            result: None,
        };
        for (handle, expression) in function.expressions.iter() {
            if let Expression::FunctionArgument(index) = expression {
                walk.roots[handle.index()] = Some(*index as usize);
            }
        }
        walk.block(&function.body, false);
        let made = walk.uses.split_off(arguments);
        let uses = made.into_iter().filter(|uses| *uses > FEW).fold(0, usize::saturating_add);
        Self { uses, arguments: walk.uses, sets: walk.sets, result: walk.result.flatten() }
    }
}

struct Walk<'w> {
    function: &'w Function,
    numbers: Numbers<'w>,
    known: &'w [Merged],
    /// Of each expression so far.
    roots: Vec<Value>,
    locals: Vec<Value>,
    /// The uses of each argument, and after these of each value that branches have made.
    uses: Vec<usize>,
    sets: Vec<bool>,
    result: Option<Value>,
}

impl Walk<'_> {
    fn block(&mut self, block: &Block, is_branch: bool) {
        block.iter().for_each(|statement| self.statement(statement, is_branch));
    }

    fn statement(&mut self, statement: &Statement, is_branch: bool) {
        match statement {
            Statement::Emit(range) => range.clone().for_each(|handle| self.expression(handle)),
            Statement::Store { pointer, value } => self.store(*pointer, *value, is_branch),
            Statement::Call { function, arguments, result } => {
                let called = &self.known[function.index()];
                let roots: Vec<Value> = arguments.iter().map(|argument| self.root(*argument)).collect();
                for ((root, uses), (argument, is_set)) in
                    roots.iter().zip(&called.arguments).zip(arguments.iter().zip(&called.sets))
                {
                    self.add(*root, *uses);
                    if let Some(local) = self.local(*argument).filter(|_| *is_set) {
                        self.locals[local.index()] = self.make();
                    }
                }
                if let Some(result) = result {
                    self.roots[result.index()] = match called.result {
                        Some(index) if index >= roots.len() => self.make(),
                        argument => argument.and_then(|index| roots[index]),
                    };
                }
            }
            Statement::Return { value: Some(value) } => {
                let is_only = !is_branch && self.result.is_none();
                self.result = Some(if is_only { self.root(*value) } else { self.make() });
            }
            Statement::If { .. } | Statement::Switch { .. } => {
                let before = self.locals.clone();
                for branch in blocks(statement) {
                    self.locals.clone_from(&before);
                    self.block(branch, true);
                }
                self.locals = before;
                for local in self.stored(statement) {
                    self.locals[local.index()] = self.make();
                }
            }
            _ => blocks(statement).into_iter().for_each(|block| self.block(block, true)),
        }
    }

    /// The variables that a statement sets, each once.
    fn stored(&self, statement: &Statement) -> Vec<Handle<LocalVariable>> {
        let mut stored = Vec::new();
        for block in blocks(statement) {
            statements(block, &mut |statement| {
                if let Statement::Store { pointer, .. } = statement {
                    stored.extend(self.local(*pointer));
                }
            });
        }
        stored.sort();
        stored.dedup();
        stored
    }

    fn store(&mut self, pointer: Handle<Expression>, value: Handle<Expression>, is_branch: bool) {
        let (root, is_whole) = (self.root(value), !self.is_part(pointer));
        match (self.local(pointer), self.root(pointer)) {
            // A part of a variable leaves the others as they are.
            (Some(local), _) if is_whole => self.locals[local.index()] = root,
            (None, Some(index)) if index < self.sets.len() => {
                self.sets[index] |= is_branch || root.is_some_and(|root| root >= self.sets.len());
            }
            _ => {}
        }
    }

    /// A value that branches have made.
    fn make(&mut self) -> Value {
        self.uses.push(0);
        Some(self.uses.len() - 1)
    }

    fn add(&mut self, value: Value, uses: usize) {
        if let Some(index) = value {
            self.uses[index] = self.uses[index].saturating_add(uses);
        }
    }

    /// The variable that a pointer leads into.
    fn local(&self, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(local) => Some(local),
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.local(base),
            _ => None,
        }
    }

    fn is_part(&self, pointer: Handle<Expression>) -> bool {
        matches!(self.function.expressions[pointer], Expression::Access { .. } | Expression::AccessIndex { .. })
    }

    /// Origin of a value, or of the target of a pointer.
    fn root(&self, value: Handle<Expression>) -> Value {
        self.local(value).map_or(self.roots[value.index()], |local| self.locals[local.index()])
    }

    /// Finds where an expression comes from, and counts what it uses.
    fn expression(&mut self, handle: Handle<Expression>) {
        let root = match &self.function.expressions[handle] {
            // These are the same numbers.
            Expression::Load { pointer: base }
            | Expression::Access { base, .. }
            | Expression::AccessIndex { base, .. }
            | Expression::Splat { value: base, .. }
            | Expression::Swizzle { vector: base, .. } => self.root(*base),
            Expression::Compose { components, .. } => self.common(components),
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => self.used(&[*expr]),
            Expression::Binary { left, right, .. } => {
                let root = self.used(&[*left, *right]);
                if self.is_constant(*left) || self.is_constant(*right) { root } else { None }
            }
            Expression::Relational { argument, .. } => self.used(&[*argument]),
            Expression::Select { condition, accept, reject } => self.used(&[*condition, *accept, *reject]),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                let all: Vec<_> = [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().collect();
                self.used(&all)
            }
            _ => None,
        };
        self.roots[handle.index()] = root;
    }

    /// Counts the operands of an operation. Compilers remove it if it gives its only operand back, such as a sum with
    /// zero, so it counts as that.
    fn used(&mut self, operands: &[Handle<Expression>]) -> Value {
        for operand in operands {
            self.add(self.root(*operand), (self.numbers)(*operand));
        }
        self.common(operands)
    }

    /// Common origin of all of these, apart from constants.
    fn common(&self, operands: &[Handle<Expression>]) -> Value {
        let mut others = operands.iter().filter(|operand| !self.is_constant(**operand));
        let first = others.next().and_then(|first| self.root(*first));
        if others.all(|other| self.root(*other) == first) { first } else { None }
    }

    fn is_constant(&self, value: Handle<Expression>) -> bool {
        match &self.function.expressions[value] {
            Expression::Literal(_) | Expression::Constant(_) | Expression::ZeroValue(_) => true,
            Expression::Splat { value, .. } => self.is_constant(*value),
            Expression::Compose { components, .. } => components.iter().all(|component| self.is_constant(*component)),
            _ => false,
        }
    }
}
