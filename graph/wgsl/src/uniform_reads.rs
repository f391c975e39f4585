//! Which members of its uniform a kernel reads, at the present numbers of the uniform.
//!
//! Promises, override constants and the numbers of the uniform decide conditions, and what is behind a condition that
//! does not hold is not read. So a kernel computes the same for another uniform that has equal members here.

use std::collections::BTreeSet;

use naga::{
    BinaryOperator, Block, Expression, Function, GlobalVariable, Handle, Literal, LocalVariable, Module, Statement,
    TypeInner, UnaryOperator,
};

use crate::error::ShaderError;
use crate::link::{Declared, Instance, Linker};
use crate::sample_mode::SampleMode;
use crate::shader::Shader;
use crate::validate::validate_uncompiled;
use crate::walk::{blocks, statements};

/// The name of the uniform in a kernel function's arguments and among the variables of an entry point.
const UNIFORM: &str = "params";

/// A linked file, to ask which members of their uniform its kernels read.
pub struct UniformReads {
    module: Module,
    declared: Vec<Declared>,
    instance: Instance,
}

impl UniformReads {
    /// Links a file in which these promises hold and the override constants have these values.
    ///
    /// # Errors
    /// The first error in the file or its imports.
    pub fn new(shader: &Shader, promises: &[&str], constants: &[(&str, f64)]) -> Result<Self, ShaderError> {
        let source = shader.source();
        let mut linker = Linker::new(SampleMode::Plain);
        let instance = linker.add(source, promises)?;
        for (name, value) in constants {
            linker.set_override(instance, name, *value);
        }
        let (linked, declared) = linker.link_whole(instance, source.file.has_workgroups())?;
        Ok(Self { module: validate_uncompiled(&linked.text, &linked.map)?.0, declared, instance })
    }

    /// For each byte of the uniform of a kernel function or an entry point, whether it is of a member that is read. All
    /// are, where the file has no such kernel.
    pub fn mask(&self, kernel: &str, uniform: &[u8]) -> Vec<bool> {
        let entry = self.module.entry_points.iter().find(|entry| self.is_named(&entry.name, kernel));
        let mut function = self.module.functions.iter().map(|(_, function)| function);
        let function = function.find(|function| function.name.as_ref().is_some_and(|name| self.is_named(name, kernel)));
        let Some(function) = entry.map(|entry| &entry.function).or(function) else { return vec![true; uniform.len()] };
        let global = self.module.global_variables.iter().find(|(_, variable)| {
            variable.space == naga::AddressSpace::Uniform
                && variable.name.as_ref().is_some_and(|name| self.is_named(name, UNIFORM))
        });
        let global = global.map(|(handle, _)| handle);
        let is_uniform = |argument: &naga::FunctionArgument| argument.name.as_deref() == Some(UNIFORM);
        let arguments: Vec<bool> = function.arguments.iter().map(is_uniform).collect();
        let mut walk =
            Walk { module: &self.module, uniform, global, read: vec![false; uniform.len()], seen: BTreeSet::new() };
        walk.function(function, &arguments);
        walk.read
    }

    /// Whether a name of the module is that of a declaration of the file.
    fn is_named(&self, name: &str, original: &str) -> bool {
        let mut declared = self.declared.iter().filter(|declared| declared.instance == self.instance);
        declared.any(|declared| declared.name == name && declared.original == original)
    }
}

/// A walk over a kernel and the functions that it calls.
struct Walk<'m> {
    module: &'m Module,
    uniform: &'m [u8],
    /// The variable that holds the uniform of an entry point.
    global: Option<Handle<GlobalVariable>>,
    read: Vec<bool>,
    /// Functions that were walked over, with the arguments that were the uniform.
    seen: BTreeSet<(Handle<Function>, Vec<bool>)>,
}

/// A number or a flag that is known.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
enum Known {
    Flag(bool),
    Number(f64),
}

/// A function of the walk, with the arguments that hold the uniform.
#[derive(Clone, Copy)]
struct Body<'f> {
    function: &'f Function,
    arguments: &'f [bool],
}

impl Walk<'_> {
    fn function(&mut self, function: &Function, arguments: &[bool]) {
        self.block(Body { function, arguments }, &function.body);
    }

    /// Walks over a block up to a statement that leaves it; whether there is one.
    fn block(&mut self, body: Body<'_>, block: &Block) -> bool {
        block.iter().any(|statement| self.statement(body, statement))
    }

    /// Walks over a statement; whether it leaves its block.
    fn statement(&mut self, body: Body<'_>, statement: &Statement) -> bool {
        match statement {
            Statement::Emit(range) => {
                range.clone().for_each(|expression| self.expression(body, expression));
                false
            }
            Statement::Block(block) => self.block(body, block),
            Statement::If { condition, accept, reject } => match self.known(body, *condition, 0) {
                Some(Known::Flag(true)) => self.block(body, accept),
                Some(Known::Flag(false)) => self.block(body, reject),
                _ => {
                    let leaves = self.block(body, accept);
                    self.block(body, reject) && leaves
                }
            },
            Statement::Switch { cases, .. } => {
                for case in cases {
                    self.block(body, &case.body);
                }
                false
            }
            Statement::Loop { body: inner, continuing, .. } => {
                self.block(body, inner);
                self.block(body, continuing);
                false
            }
            Statement::Store { value, .. } => {
                self.whole(body, *value);
                false
            }
            Statement::Return { value } => {
                if let Some(value) = value {
                    self.whole(body, *value);
                }
                true
            }
            Statement::Break | Statement::Continue | Statement::Kill => true,
            Statement::Call { function, arguments, .. } => {
                let arguments: Vec<bool> = arguments.iter().map(|argument| self.is_uniform(body, *argument)).collect();
                if self.seen.insert((*function, arguments.clone())) {
                    self.function(&self.module.functions[*function], &arguments);
                }
                false
            }
            _ => false,
        }
    }

    /// Notes what an expression reads of the uniform.
    fn expression(&mut self, body: Body<'_>, expression: Handle<Expression>) {
        match &body.function.expressions[expression] {
            Expression::AccessIndex { base, index } if self.is_uniform(body, *base) => {
                if let Some((offset, size)) = self.member(body, *base, *index) {
                    let end = self.read.len().min((offset + size) as usize);
                    self.read[(offset as usize).min(end)..end].fill(true);
                }
            }
            Expression::Compose { components, .. } => {
                components.iter().for_each(|component| self.whole(body, *component));
            }
            _ => {}
        }
    }

    /// Notes that all of the uniform is read, if that is what the expression is.
    fn whole(&mut self, body: Body<'_>, expression: Handle<Expression>) {
        if self.is_uniform(body, expression) {
            self.read.fill(true);
        }
    }

    /// Whether an expression is the uniform as a whole.
    fn is_uniform(&self, body: Body<'_>, expression: Handle<Expression>) -> bool {
        match &body.function.expressions[expression] {
            Expression::FunctionArgument(index) => body.arguments.get(*index as usize) == Some(&true),
            Expression::GlobalVariable(variable) => self.global == Some(*variable),
            Expression::Load { pointer } => self.is_uniform(body, *pointer),
            _ => false,
        }
    }

    /// Offset and size of a member of the uniform.
    fn member(&self, body: Body<'_>, base: Handle<Expression>, index: u32) -> Option<(u32, u32)> {
        let ty = self.uniform_type(body, base)?;
        let TypeInner::Struct { members, .. } = &self.module.types[ty].inner else { return None };
        let member = members.get(index as usize)?;
        Some((member.offset, self.module.types[member.ty].inner.size(self.module.to_ctx())))
    }

    fn uniform_type(&self, body: Body<'_>, base: Handle<Expression>) -> Option<Handle<naga::Type>> {
        match &body.function.expressions[base] {
            Expression::FunctionArgument(index) => Some(body.function.arguments[*index as usize].ty),
            Expression::GlobalVariable(variable) => Some(self.module.global_variables[*variable].ty),
            Expression::Load { pointer } => self.uniform_type(body, *pointer),
            _ => None,
        }
    }

    /// The value of an expression that does not depend on the pixel.
    fn known(&self, body: Body<'_>, expression: Handle<Expression>, depth: usize) -> Option<Known> {
        if depth > MAX_DEPTH {
            return None;
        }
        let known = |expression| self.known(body, expression, depth + 1);
        match &body.function.expressions[expression] {
            Expression::Literal(literal) => of_literal(*literal),
            Expression::Constant(constant) => {
                match &self.module.global_expressions[self.module.constants[*constant].init] {
                    Expression::Literal(literal) => of_literal(*literal),
                    _ => None,
                }
            }
            Expression::Load { pointer } => match &body.function.expressions[*pointer] {
                Expression::LocalVariable(variable) => self.local(body, *variable, depth + 1),
                Expression::AccessIndex { base, index } => self.number(body, *base, *index),
                _ => None,
            },
            Expression::AccessIndex { base, index } => self.number(body, *base, *index),
            Expression::Unary { op: UnaryOperator::LogicalNot, expr } => match known(*expr)? {
                Known::Flag(flag) => Some(Known::Flag(!flag)),
                Known::Number(_) => None,
            },
            Expression::Unary { op: UnaryOperator::Negate, expr } => match known(*expr)? {
                Known::Number(number) => Some(Known::Number(-number)),
                Known::Flag(_) => None,
            },
            Expression::Binary { op, left, right } => of_operator(*op, known(*left)?, known(*right)?),
            _ => None,
        }
    }

    /// A scalar member of the uniform.
    fn number(&self, body: Body<'_>, base: Handle<Expression>, index: u32) -> Option<Known> {
        if !self.is_uniform(body, base) {
            return None;
        }
        let TypeInner::Struct { members, .. } = &self.module.types[self.uniform_type(body, base)?].inner else {
            return None;
        };
        let member = members.get(index as usize)?;
        let TypeInner::Scalar(scalar) = self.module.types[member.ty].inner else { return None };
        let bytes = self.uniform.get(member.offset as usize..)?.first_chunk()?;
        match scalar.kind {
            naga::ScalarKind::Float => Some(Known::Number(f32::from_le_bytes(*bytes).into())),
            naga::ScalarKind::Uint => Some(Known::Number(u32::from_le_bytes(*bytes).into())),
            naga::ScalarKind::Sint => Some(Known::Number(i32::from_le_bytes(*bytes).into())),
            _ => None,
        }
    }

    /// The value of a local variable that always has the same one.
    fn local(&self, body: Body<'_>, variable: Handle<LocalVariable>, depth: usize) -> Option<Known> {
        let LocalVariable { name, init, .. } = &body.function.local_variables[variable];
        let mut values = Vec::new();
        match init {
            Some(init) => values.push(self.known(body, *init, depth + 1)),
            // naga makes variables without a name for `&&` and `||`, and stores them before they are read.
            None if name.is_some() => values.push(None),
            None => {}
        }
        self.stores(body, &body.function.body, variable, depth, &mut values);
        let first = values.first().copied().flatten()?;
        values.iter().all(|value| *value == Some(first)).then_some(first)
    }

    /// The values that statements which may run store in a local variable.
    fn stores(
        &self,
        body: Body<'_>,
        block: &Block,
        variable: Handle<LocalVariable>,
        depth: usize,
        values: &mut Vec<Option<Known>>,
    ) {
        let is_variable = |pointer: Handle<Expression>| match &body.function.expressions[pointer] {
            Expression::LocalVariable(other) => *other == variable,
            _ => false,
        };
        for statement in block.iter() {
            match statement {
                Statement::Store { pointer, value } if is_variable(*pointer) => {
                    values.push(self.known(body, *value, depth + 1));
                }
                Statement::Call { arguments, .. } if arguments.iter().any(|argument| is_variable(*argument)) => {
                    values.push(None);
                }
                Statement::If { condition, accept, reject } => {
                    let condition = if stores_in(body.function, statement, variable) {
                        self.known(body, *condition, depth + 1)
                    } else {
                        continue;
                    };
                    if condition != Some(Known::Flag(false)) {
                        self.stores(body, accept, variable, depth, values);
                    }
                    if condition != Some(Known::Flag(true)) {
                        self.stores(body, reject, variable, depth, values);
                    }
                }
                other => {
                    for block in blocks(other) {
                        self.stores(body, block, variable, depth, values);
                    }
                }
            }
        }
    }
}

/// How deep expressions are followed.
const MAX_DEPTH: usize = 64;

/// Whether a statement, however deep, stores in a local variable or hands it to a function.
fn stores_in(function: &Function, statement: &Statement, variable: Handle<LocalVariable>) -> bool {
    let is_variable = |pointer: &Handle<Expression>| match function.expressions[*pointer] {
        Expression::LocalVariable(other) => other == variable,
        _ => false,
    };
    let mut found = false;
    for block in blocks(statement) {
        statements(block, &mut |statement| match statement {
            Statement::Store { pointer, .. } => found |= is_variable(pointer),
            Statement::Call { arguments, .. } => found |= arguments.iter().any(is_variable),
            _ => {}
        });
    }
    found
}

fn of_literal(literal: Literal) -> Option<Known> {
    match literal {
        Literal::Bool(flag) => Some(Known::Flag(flag)),
        Literal::F32(number) => Some(Known::Number(number.into())),
        Literal::I32(number) => Some(Known::Number(number.into())),
        Literal::U32(number) => Some(Known::Number(number.into())),
        _ => None,
    }
}

/// Comparisons and logic. Arithmetic is left to the device, which rounds in its own way.
fn of_operator(op: BinaryOperator, left: Known, right: Known) -> Option<Known> {
    let flag = match (op, left, right) {
        (BinaryOperator::LogicalAnd, Known::Flag(left), Known::Flag(right)) => left && right,
        (BinaryOperator::LogicalOr, Known::Flag(left), Known::Flag(right)) => left || right,
        (BinaryOperator::Equal, ..) => left == right,
        (BinaryOperator::NotEqual, ..) => left != right,
        (BinaryOperator::Less, ..) => left < right,
        (BinaryOperator::LessEqual, ..) => left <= right,
        (BinaryOperator::Greater, ..) => left > right,
        (BinaryOperator::GreaterEqual, ..) => left >= right,
        _ => return None,
    };
    Some(Known::Flag(flag))
}

#[cfg(test)]
mod tests {
    use super::UniformReads;
    use crate::Shader;

    const SOURCE: &str = "
struct Look { strength: f32, knee: f32, tint: vec3f, mode: u32, spare: f32 }
const CLIPS: bool = false;
fn bent(v: vec4f, params: Look) -> vec4f {
    let compresses = !CLIPS && params.strength > 0.0;
    if compresses { return v * params.knee; }
    return v;
}
fn shown(v: vec4f, params: Look) -> vec4f { return bent(v, params) * vec4f(params.tint, 1.0); }
fn chosen(v: vec4f, params: Look) -> vec4f {
    if params.mode == 2u { return v * params.spare; }
    var turned = v;
    turned.x = params.knee;
    return turned;
}
fn copied(v: vec4f, params: Look) -> vec4f {
    let all = params;
    var look = params;
    look.knee = 0.0;
    return v * look.spare;
}
";

    /// An entry point, which has its uniform in a variable.
    const ENTRY: &str = "
struct Look { strength: f32, knee: f32, tint: vec3f, mode: u32, spare: f32 }
@group(0) @binding(0) var<uniform> params: Look;
@group(0) @binding(1) var<storage, read_write> result: array<f32>;
fn bent() -> f32 { return params.knee; }
@compute @workgroup_size(1)
fn made() { if params.strength > 0.0 { result[0] = bent(); } }
";

    /// The members that a function reads.
    fn read(function: &str, promises: &[&str], strength: f32, mode: u32) -> Vec<&'static str> {
        read_of(SOURCE, function, promises, strength, mode)
    }

    fn read_of(text: &str, function: &str, promises: &[&str], strength: f32, mode: u32) -> Vec<&'static str> {
        let shader = Shader::loaded("look.wgsl".into(), text.into());
        let layout = shader.reflect().expect("it is valid").layout("Look").expect("it is declared").clone();
        let mut uniform = vec![0; layout.size as usize];
        uniform[layout.members[0].offset as usize..][..4].copy_from_slice(&strength.to_le_bytes());
        uniform[layout.members[3].offset as usize..][..4].copy_from_slice(&mode.to_le_bytes());
        let reads = UniformReads::new(&shader, promises, &[]).expect("it is valid");
        let mask = reads.mask(function, &uniform);
        let names = ["strength", "knee", "tint", "mode", "spare"];
        let members = layout.members.iter().zip(names).filter(|(member, _)| mask[member.offset as usize]);
        members.map(|(_, name)| name).collect()
    }

    #[test]
    fn what_is_behind_a_condition_that_does_not_hold_is_not_read() {
        assert_eq!(read("shown", &[], 1.0, 0), ["strength", "knee", "tint"]);
        assert_eq!(read("shown", &[], 0.0, 0), ["strength", "tint"]);
        assert_eq!(read("shown", &["CLIPS"], 1.0, 0), ["tint"]);
        assert_eq!(read("chosen", &[], 1.0, 2), ["mode", "spare"]);
        assert_eq!(read("chosen", &[], 1.0, 1), ["knee", "mode"]);
    }

    #[test]
    fn an_entry_point_reads_the_members_of_its_variable() {
        assert_eq!(read_of(ENTRY, "made", &[], 1.0, 0), ["strength", "knee"]);
        assert_eq!(read_of(ENTRY, "made", &[], 0.0, 0), ["strength"]);
    }

    #[test]
    fn a_copy_of_the_uniform_reads_all_of_it() {
        assert_eq!(read("copied", &[], 0.0, 0), ["strength", "knee", "tint", "mode", "spare"]);
        assert_eq!(read("nothing", &[], 0.0, 0).len(), 5, "of a kernel that is not there nothing is known");
    }
}
