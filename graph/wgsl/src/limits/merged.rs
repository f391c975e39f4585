//! Uses of values that branches have merged: a variable after an `if` that sets it, and the result of a function gives
//! that returns in one.
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
    result: Root,
}

/// Number of components of an expression.
type Numbers<'w> = &'w dyn Fn(Handle<Expression>) -> usize;

impl Merged {
    /// Summary of a function; `known` holds those before it.
    pub(super) fn of(function: &Function, numbers: Numbers<'_>, known: &[Self]) -> Self {
        let mut walk = Walk {
            function,
            numbers,
            known,
            roots: vec![Root::Computed; function.expressions.len()],
            locals: vec![Root::Computed; function.local_variables.len()],
            made: Vec::new(),
            arguments: vec![0; function.arguments.len()],
            sets: vec![false; function.arguments.len()],
            result: None,
        };
        for (handle, expression) in function.expressions.iter() {
            if let Expression::FunctionArgument(index) = expression {
                walk.roots[handle.index()] = Root::Argument(*index as usize);
            }
        }
        walk.block(&function.body, false);
        let uses = walk.made.iter().filter(|uses| **uses > FEW).fold(0, |sum: usize, uses| sum.saturating_add(*uses));
        Self { uses, arguments: walk.arguments, sets: walk.sets, result: walk.result.unwrap_or_default() }
    }
}

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Root {
    /// An operation, or a constant.
    #[default]
    Computed,
    Argument(usize),
    /// Branches; its number in [`Walk::made`].
    Branches(usize),
}

struct Walk<'w> {
    function: &'w Function,
    numbers: Numbers<'w>,
    known: &'w [Merged],
    /// Of each expression so far.
    roots: Vec<Root>,
    locals: Vec<Root>,
    /// The uses of each value that branches have made.
    made: Vec<usize>,
    arguments: Vec<usize>,
    sets: Vec<bool>,
    result: Option<Root>,
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
                let roots: Vec<Root> = arguments.iter().map(|argument| self.root(*argument)).collect();
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
                        Root::Computed => Root::Computed,
                        Root::Argument(index) => roots[index],
                        Root::Branches(_) => self.make(),
                    };
                }
            }
            Statement::Return { value: Some(value) } => {
                let is_only = !is_branch && self.result.is_none();
                self.result = Some(if is_only { self.root(*value) } else { Root::Branches(0) });
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
            (None, Root::Argument(index)) => self.sets[index] |= is_branch || matches!(root, Root::Branches(_)),
            _ => {}
        }
    }

    /// A value that branches have made.
    fn make(&mut self) -> Root {
        self.made.push(0);
        Root::Branches(self.made.len() - 1)
    }

    fn add(&mut self, root: Root, uses: usize) {
        let sum = match root {
            Root::Computed => return,
            Root::Argument(index) => &mut self.arguments[index],
            Root::Branches(index) => &mut self.made[index],
        };
        *sum = sum.saturating_add(uses);
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
    fn root(&self, value: Handle<Expression>) -> Root {
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
                if self.is_constant(*left) || self.is_constant(*right) { root } else { Root::Computed }
            }
            Expression::Relational { argument, .. } => self.used(&[*argument]),
            Expression::Select { condition, accept, reject } => self.used(&[*condition, *accept, *reject]),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                let all: Vec<_> = [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().collect();
                self.used(&all)
            }
            _ => Root::Computed,
        };
        self.roots[handle.index()] = root;
    }

    /// Counts the operands of an operation. Compilers remove it if it gives its only operand back, such as a sum with
    /// zero, so it counts as that.
    fn used(&mut self, operands: &[Handle<Expression>]) -> Root {
        for operand in operands {
            self.add(self.root(*operand), (self.numbers)(*operand));
        }
        self.common(operands)
    }

    /// Common origin of all of these, apart from constants.
    fn common(&self, operands: &[Handle<Expression>]) -> Root {
        let mut others = operands.iter().filter(|operand| !self.is_constant(**operand));
        let first = others.next().map_or(Root::Computed, |first| self.root(*first));
        if others.all(|other| self.root(*other) == first) { first } else { Root::Computed }
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
