//! Operations of an invocation, counted in the module that a pass runs.
//!
//! Code that no value of the module's constants reaches is not counted, and a loop counts as often as it turns where
//! that is known. A branch that depends on data counts with both sides, and a loop of unknown length counts once.

use std::collections::BTreeMap;

use naga::proc::TypeResolution;
use naga::valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, Module, Statement, TypeInner,
    UnaryOperator,
};

/// Turns of a loop whose end may depend on data, after which its length counts as unknown.
const MAX_TURNS: usize = 64;

/// The part of the library that runs for texels that are not finite only.
const REPAIR: &str = "sanitize_repair";

/// Operations of an invocation of an entry point: one for each component of a result, and one for each store.
pub fn operations(module: &Module, entry: &str) -> u64 {
    let info =
        Validator::new(ValidationFlags::all(), Capabilities::all()).validate(module).expect("the module is valid");
    let mut counter = Counter { module, info: &info, known: BTreeMap::new() };
    let index = module.entry_points.iter().position(|point| point.name == entry).expect("the module has the entry");
    counter.run(&module.entry_points[index].function, info.get_entry_point(index), Vec::new())
}

/// A scalar that does not depend on data. Floats are their bits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Scalar {
    Bool(bool),
    Integer(i64),
    Float(u32),
}

/// How a block ends.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Next,
    Break,
    Continue,
    Return,
}

struct Counter<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
    /// Operations of functions with arguments.
    known: BTreeMap<(Handle<Function>, Vec<Option<Scalar>>), u64>,
}

/// A call of a function.
struct Frame<'m> {
    function: &'m Function,
    info: &'m FunctionInfo,
    arguments: Vec<Option<Scalar>>,
    locals: BTreeMap<Handle<LocalVariable>, Scalar>,
    values: BTreeMap<Handle<Expression>, Scalar>,
    operations: u64,
}

impl<'m> Counter<'m> {
    fn run(&mut self, function: &'m Function, info: &'m FunctionInfo, arguments: Vec<Option<Scalar>>) -> u64 {
        let (locals, values) = (BTreeMap::new(), BTreeMap::new());
        let mut frame = Frame { function, info, arguments, locals, values, operations: 0 };
        for (handle, variable) in function.local_variables.iter() {
            let value = match variable.init {
                Some(init) => self.value(&frame, init),
                None => zero(&self.module.types[variable.ty].inner),
            };
            frame.locals.extend(value.map(|value| (handle, value)));
        }
        self.block(&mut frame, &function.body);
        frame.operations
    }

    fn block(&mut self, frame: &mut Frame<'m>, block: &'m Block) -> End {
        for statement in block.iter() {
            let end = self.statement(frame, statement);
            if end != End::Next {
                return end;
            }
        }
        End::Next
    }

    fn statement(&mut self, frame: &mut Frame<'m>, statement: &'m Statement) -> End {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    frame.operations += self.cost(frame, expression);
                    let value = self.compute(frame, expression);
                    frame.values.remove(&expression);
                    frame.values.extend(value.map(|value| (expression, value)));
                }
            }
            Statement::Block(block) => return self.block(frame, block),
            Statement::If { condition, accept, reject } => match self.value(frame, *condition) {
                Some(Scalar::Bool(true)) => return self.block(frame, accept),
                Some(_) => return self.block(frame, reject),
                None => return self.branches(frame, &[accept, reject]),
            },
            Statement::Switch { cases, .. } => {
                let bodies: Vec<&Block> = cases.iter().map(|case| &case.body).collect();
                return match self.branches(frame, &bodies) {
                    End::Break => End::Next,
                    end => end,
                };
            }
            Statement::Loop { body, continuing, break_if } => return self.turns(frame, body, continuing, *break_if),
            Statement::Break => return End::Break,
            Statement::Continue => return End::Continue,
            Statement::Return { .. } | Statement::Kill => return End::Return,
            Statement::Store { pointer, value } => {
                let value = self.value(frame, *value);
                if let Some(local) = local(frame.function, *pointer) {
                    frame.locals.remove(&local);
                    let is_whole = matches!(frame.function.expressions[*pointer], Expression::LocalVariable(_));
                    frame.locals.extend(value.filter(|_| is_whole).map(|value| (local, value)));
                }
            }
            Statement::Call { function, arguments, .. } => {
                let values: Vec<_> = arguments.iter().map(|argument| self.value(frame, *argument)).collect();
                for local in arguments.iter().filter_map(|argument| local(frame.function, *argument)) {
                    frame.locals.remove(&local);
                }
                frame.operations += self.call(*function, values);
            }
            Statement::ImageStore { .. } | Statement::Atomic { .. } => frame.operations += 1,
            _ => {}
        }
        End::Next
    }

    fn call(&mut self, function: Handle<Function>, arguments: Vec<Option<Scalar>>) -> u64 {
        let called = &self.module.functions[function];
        if called.name.as_deref().is_some_and(|name| name.starts_with(REPAIR)) {
            return 0;
        }
        let key = (function, arguments);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let operations = self.run(called, &self.info[function], key.1.clone());
        self.known.insert(key, operations);
        operations
    }

    /// Blocks of which data chooses one. Where they end differently, what follows them runs.
    fn branches(&mut self, frame: &mut Frame<'m>, blocks: &[&'m Block]) -> End {
        let before = frame.locals.clone();
        let (mut ends, mut after) = (Vec::new(), Vec::new());
        for block in blocks {
            frame.locals.clone_from(&before);
            ends.push(self.block(frame, block));
            after.push(std::mem::take(&mut frame.locals));
        }
        let first = after.first().cloned().unwrap_or_default();
        let is_kept =
            |name: &Handle<LocalVariable>, value: &Scalar| after.iter().all(|other| other.get(name) == Some(value));
        frame.locals = first.into_iter().filter(|(name, value)| is_kept(name, value)).collect();
        let is_one_end = ends.windows(2).all(|pair| pair[0] == pair[1]);
        ends.first().copied().filter(|_| is_one_end).unwrap_or(End::Next)
    }

    fn turns(
        &mut self,
        frame: &mut Frame<'m>,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
    ) -> End {
        let mut first = None;
        for _ in 0..MAX_TURNS {
            match self.block(frame, body) {
                End::Break => return End::Next,
                End::Return => return End::Return,
                End::Next | End::Continue => {}
            }
            self.block(frame, continuing);
            if break_if.and_then(|condition| self.value(frame, condition)) == Some(Scalar::Bool(true)) {
                return End::Next;
            }
            first.get_or_insert(frame.operations);
        }
        frame.operations = first.unwrap_or(frame.operations);
        frame.locals.clear();
        End::Next
    }

    /// What an expression holds, which was computed where it was emitted.
    fn value(&self, frame: &Frame<'_>, expression: Handle<Expression>) -> Option<Scalar> {
        match &frame.function.expressions[expression] {
            Expression::Literal(value) => literal(*value),
            Expression::Constant(constant) => {
                match &self.module.global_expressions[self.module.constants[*constant].init] {
                    Expression::Literal(value) => literal(*value),
                    _ => None,
                }
            }
            Expression::ZeroValue(ty) => zero(&self.module.types[*ty].inner),
            Expression::FunctionArgument(index) => frame.arguments.get(*index as usize).copied().flatten(),
            _ => frame.values.get(&expression).copied(),
        }
    }

    fn compute(&self, frame: &Frame<'_>, expression: Handle<Expression>) -> Option<Scalar> {
        let value = |expression| self.value(frame, expression);
        match &frame.function.expressions[expression] {
            Expression::Load { pointer } => match &frame.function.expressions[*pointer] {
                Expression::LocalVariable(local) => frame.locals.get(local).copied(),
                _ => None,
            },
            Expression::Unary { op: UnaryOperator::LogicalNot, expr } => match value(*expr)? {
                Scalar::Bool(value) => Some(Scalar::Bool(!value)),
                _ => None,
            },
            Expression::Binary { op, left, right } => binary(*op, value(*left)?, value(*right)?),
            Expression::Select { condition, accept, reject } => match value(*condition)? {
                Scalar::Bool(true) => value(*accept),
                _ => value(*reject),
            },
            _ => value(expression),
        }
    }

    /// Moves of numbers cost nothing.
    fn cost(&self, frame: &Frame<'_>, expression: Handle<Expression>) -> u64 {
        let is_counted = match &frame.function.expressions[expression] {
            Expression::As { convert, .. } => convert.is_some(),
            Expression::Unary { .. }
            | Expression::Binary { .. }
            | Expression::Select { .. }
            | Expression::Relational { .. }
            | Expression::Math { .. }
            | Expression::ImageLoad { .. }
            | Expression::ImageSample { .. } => true,
            _ => false,
        };
        let inner = match &frame.info[expression].ty {
            TypeResolution::Handle(ty) => &self.module.types[*ty].inner,
            TypeResolution::Value(inner) => inner,
        };
        match (is_counted, inner) {
            (false, _) => 0,
            (true, TypeInner::Vector { size, .. }) => *size as u64,
            (true, TypeInner::Matrix { columns, rows, .. }) => *columns as u64 * *rows as u64,
            (true, _) => 1,
        }
    }
}

/// The variable of a function that a pointer leads into.
fn local(function: &Function, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
    match function.expressions[pointer] {
        Expression::LocalVariable(local) => Some(local),
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => local(function, base),
        _ => None,
    }
}

fn literal(value: Literal) -> Option<Scalar> {
    match value {
        Literal::Bool(value) => Some(Scalar::Bool(value)),
        Literal::U32(value) => Some(Scalar::Integer(value.into())),
        Literal::I32(value) => Some(Scalar::Integer(value.into())),
        Literal::F32(value) => Some(Scalar::Float(value.to_bits())),
        _ => None,
    }
}

fn zero(inner: &TypeInner) -> Option<Scalar> {
    match inner {
        TypeInner::Scalar(scalar) if scalar.kind == naga::ScalarKind::Bool => Some(Scalar::Bool(false)),
        TypeInner::Scalar(scalar) if scalar.kind == naga::ScalarKind::Float => Some(Scalar::Float(0)),
        TypeInner::Scalar(_) => Some(Scalar::Integer(0)),
        _ => None,
    }
}

fn binary(op: BinaryOperator, left: Scalar, right: Scalar) -> Option<Scalar> {
    use BinaryOperator as Op;
    let order = match (left, right) {
        (Scalar::Integer(left), Scalar::Integer(right)) => Some(left.cmp(&right)),
        (Scalar::Float(left), Scalar::Float(right)) => f32::from_bits(left).partial_cmp(&f32::from_bits(right)),
        (Scalar::Bool(left), Scalar::Bool(right)) => Some(left.cmp(&right)),
        _ => None,
    };
    let compared = match op {
        Op::Equal => order?.is_eq(),
        Op::NotEqual => order?.is_ne(),
        Op::Less => order?.is_lt(),
        Op::LessEqual => order?.is_le(),
        Op::Greater => order?.is_gt(),
        Op::GreaterEqual => order?.is_ge(),
        Op::LogicalAnd | Op::And if left == Scalar::Bool(false) || right == Scalar::Bool(false) => false,
        Op::LogicalOr | Op::InclusiveOr if left == Scalar::Bool(true) || right == Scalar::Bool(true) => true,
        _ => return arithmetic(op, left, right),
    };
    Some(Scalar::Bool(compared))
}

/// Integers count turns of loops, which come nowhere near the ends of their types.
fn arithmetic(op: BinaryOperator, left: Scalar, right: Scalar) -> Option<Scalar> {
    let (Scalar::Integer(left), Scalar::Integer(right)) = (left, right) else { return None };
    let value = match op {
        BinaryOperator::Add => left + right,
        BinaryOperator::Subtract => left - right,
        BinaryOperator::Multiply => left.checked_mul(right)?,
        BinaryOperator::Divide => left.checked_div(right)?,
        BinaryOperator::Modulo => left.checked_rem(right)?,
        BinaryOperator::ShiftLeft => left.checked_shl(u32::try_from(right).ok()?)?,
        BinaryOperator::ShiftRight => left.checked_shr(u32::try_from(right).ok()?)?,
        _ => return None,
    };
    Some(Scalar::Integer(value))
}

#[cfg(test)]
mod tests {
    use super::operations;

    fn count(body: &str) -> u64 {
        let source = format!(
            "const OFF: bool = false;
override_free_marker
@group(0) @binding(0) var<uniform> data: vec4f;
@group(0) @binding(1) var<storage, read_write> result: vec4f;
fn squares(v: vec4f, turns: i32) -> vec4f {{
    var all = v;
    for (var i = 0; i < turns; i++) {{ all *= v; }}
    return all;
}}
@compute @workgroup_size(1) fn main() {{ {body} }}"
        )
        .replace("override_free_marker", "");
        operations(&naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{error}")), "main")
    }

    #[test]
    fn live_operations_are_counted_as_often_as_they_run() {
        assert_eq!(count("result = data;"), 0);
        assert_eq!(count("result = data * data + data;"), 8);
        assert_eq!(count("if OFF { result = data * data; }"), 0);
        // Each turn compares, multiplies four numbers and counts; the last one only compares.
        assert_eq!(count("result = squares(data, 3);"), 3 * 6 + 1);
        // An unknown number of turns counts once, and a branch on data with both sides.
        assert_eq!(count("result = squares(data, i32(data.x));"), 1 + 6);
        assert_eq!(count("if data.x > 0.0 { result = data * data; } else { result = data + data; }"), 1 + 4 + 4);
    }
}
