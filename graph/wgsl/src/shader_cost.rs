//! Cost of functions per pixel.

use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction, Module, Statement,
};

use crate::direct_reads::is_read;

/// Powers, exponentials and logarithms of a number, at most, of a function that takes less time than to store an image
/// and to read it again. On an H200 that trip takes as long as eight powers.
const FEW_POWERS: usize = 6;

/// Turns of a loop, at most, that are as good as none.
const FEW_TURNS: i64 = 4;
/// Turns of a loop, at most, that compute no more than many powers.
const SOME_TURNS: i64 = 8;

/// Cost of a function and all that it calls. Code that a constant switches off does not count.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShaderCost {
    powers: usize,
    has_loop: bool,
    pressure: RegisterPressure,
    reads: usize,
}

/// Number of registers that a function needs: more texels in flight need more of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum RegisterPressure {
    /// Few powers, and loops of a few turns at most.
    #[default]
    Low,
    /// Many powers, or loops of some turns.
    Medium,
    /// Loops of many turns, or of a number that no constant states.
    High,
}

/// The cost of each function of a module.
pub(crate) fn shader_costs(module: &Module) -> Vec<(&String, ShaderCost)> {
    let mut shader_costs: Vec<ShaderCost> = Vec::with_capacity(module.functions.len());
    // A module declares functions before those that call them.
    for (_, function) in module.functions.iter() {
        shader_costs.push(ShaderCost::of(module, function, &shader_costs));
    }
    let named = module.functions.iter().zip(shader_costs);
    named.filter_map(|((_, function), cost)| Some((function.name.as_ref()?, cost))).collect()
}

impl ShaderCost {
    /// Returns whether it takes longer than a trip of its result through memory.
    pub(crate) fn is_heavy(self) -> bool {
        self.has_loop || self.powers > FEW_POWERS
    }

    pub(crate) fn register_pressure(self) -> RegisterPressure {
        if self.powers > FEW_POWERS { self.pressure.max(RegisterPressure::Medium) } else { self.pressure }
    }

    /// Upper bound of the texels that it reads through the library, in all turns of its loops.
    pub(crate) fn reads(self) -> usize {
        self.reads
    }

    /// `known` holds the cost of the functions before.
    fn of(module: &Module, function: &Function, known: &[Self]) -> Self {
        let count = |matches: fn(&Expression) -> bool| {
            function.expressions.iter().filter(|(_, expression)| matches(expression)).count()
        };
        let cost = Self { powers: count(is_power), reads: count(is_read), ..Self::default() };
        let mut walk = Walk { module, function, known, cost, turns: 1 };
        walk.block(&function.body);
        walk.cost
    }
}

/// A walk over the statements of a function that may run.
struct Walk<'m> {
    module: &'m Module,
    function: &'m Function,
    known: &'m [ShaderCost],
    cost: ShaderCost,
    /// Number of runs of the present statements.
    turns: usize,
}

impl Walk<'_> {
    /// Returns whether what follows the block may run.
    fn block(&mut self, block: &Block) -> bool {
        for (index, statement) in block.iter().enumerate() {
            let goes_on = match statement {
                Statement::Call { function, .. } => {
                    let called = self.known[function.index()];
                    self.cost.powers = self.cost.powers.saturating_add(called.powers);
                    self.cost.reads = self.cost.reads.saturating_add(called.reads.saturating_mul(self.turns));
                    self.cost.has_loop |= called.has_loop;
                    self.cost.pressure = self.cost.pressure.max(called.pressure);
                    true
                }
                Statement::Loop { body, continuing, .. } => {
                    self.cost.has_loop = true;
                    let turns = self.turns(&block[..index], body, continuing);
                    let pressure = match turns {
                        Some(..=FEW_TURNS) => RegisterPressure::Low,
                        Some(..=SOME_TURNS) => RegisterPressure::Medium,
                        _ => RegisterPressure::High,
                    };
                    self.cost.pressure = self.cost.pressure.max(pressure);
                    let outside = self.turns;
                    let turns = turns.and_then(|turns| usize::try_from(turns).ok()).unwrap_or(usize::MAX);
                    self.turns = outside.saturating_mul(turns);
                    self.block(body);
                    self.block(continuing);
                    self.turns = outside;
                    true
                }
                Statement::If { condition, accept, reject } => match self.constant(*condition) {
                    Some(Literal::Bool(true)) => self.block(accept),
                    Some(_) => self.block(reject),
                    None => {
                        let ends = [self.block(accept), self.block(reject)];
                        ends.contains(&true)
                    }
                },
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.block(&case.body);
                    }
                    true
                }
                Statement::Block(inner) => self.block(inner),
                Statement::Return { .. } | Statement::Kill => false,
                _ => true,
            };
            if !goes_on {
                return false;
            }
        }
        true
    }

    /// The turns of a loop that counts up from a constant to a constant.
    fn turns(&self, before: &[Statement], body: &Block, continuing: &Block) -> Option<i64> {
        let condition = body.iter().find_map(|statement| match statement {
            Statement::If { condition, accept, .. } if accept.is_empty() => Some(*condition),
            _ => None,
        })?;
        let Expression::Binary { op, left, right } = self.function.expressions[condition] else { return None };
        let counter = self.counter(left)?;
        let stored = |block: &[Statement]| {
            block.iter().rev().find_map(|statement| match statement {
                Statement::Store { pointer, value } if self.variable(*pointer) == Some(counter) => Some(*value),
                _ => None,
            })
        };
        let first = self.integer(stored(before).or(self.function.local_variables[counter].init)?)?;
        let Expression::Binary { op: BinaryOperator::Add, right: step, .. } =
            self.function.expressions[stored(continuing)?]
        else {
            return None;
        };
        let (end, step) = (self.integer(right)?, self.integer(step)?);
        let distance = match op {
            BinaryOperator::Less => end - first,
            BinaryOperator::LessEqual => end - first + 1,
            _ => return None,
        };
        (step > 0).then(|| (distance + step - 1).div_euclid(step))
    }

    /// The variable that an expression loads.
    fn counter(&self, expression: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        match self.function.expressions[expression] {
            Expression::Load { pointer } => self.variable(pointer),
            _ => None,
        }
    }

    fn variable(&self, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        match self.function.expressions[pointer] {
            Expression::LocalVariable(variable) => Some(variable),
            _ => None,
        }
    }

    fn integer(&self, expression: Handle<Expression>) -> Option<i64> {
        match self.constant(expression)? {
            Literal::I32(value) => Some(value.into()),
            Literal::U32(value) => Some(value.into()),
            _ => None,
        }
    }

    fn constant(&self, expression: Handle<Expression>) -> Option<Literal> {
        let literal = |expression: &Expression| match expression {
            Expression::Literal(value) => Some(*value),
            _ => None,
        };
        match &self.function.expressions[expression] {
            Expression::Constant(constant) => {
                literal(&self.module.global_expressions[self.module.constants[*constant].init])
            }
            other => literal(other),
        }
    }
}

fn is_power(expression: &Expression) -> bool {
    use MathFunction as F;
    let powers =
        [F::Pow, F::Exp, F::Exp2, F::Log, F::Log2, F::Sin, F::Cos, F::Tan, F::Asin, F::Acos, F::Atan, F::Atan2];
    matches!(expression, Expression::Math { fun, .. } if powers.contains(fun))
}

#[cfg(test)]
mod tests {
    use super::RegisterPressure;
    use crate::Shader;

    #[test]
    fn functions_with_loops_and_many_powers_are_heavy_also_through_calls() {
        let calls = "power(v.x) + power(v.y) + power(v.z)";
        let source = format!(
            "fn power(x: f32) -> f32 {{ return exp2(log2(x)); }}
fn few(v: vec4f) -> vec4f {{ return vec4f({calls}); }}
fn many(v: vec4f) -> vec4f {{ return vec4f({calls} + exp(v.w)); }}
fn turns(v: vec4f) -> vec4f {{ var x = v; for (var i = 0; i < 2; i++) {{ x *= v; }} return x; }}
fn calls(v: vec4f) -> vec4f {{ if v.x > 0.0 {{ return turns(v); }} return v; }}"
        );
        let shader = Shader::loaded("heavy.wgsl".into(), source);
        assert_eq!(["many", "turns", "calls"].map(|name| shader.is_heavy(name)), [true; 3]);
        assert_eq!(["few", "power"].map(|name| shader.is_heavy(name)), [false; 2]);
        assert_eq!(["few", "turns"].map(|name| shader.register_pressure(name)), [RegisterPressure::Low; 2]);
        assert_eq!(shader.register_pressure("many"), RegisterPressure::Medium);
    }

    #[test]
    fn the_register_pressure_of_a_loop_follows_from_its_turns() {
        let source = "const OFF: bool = false;
fn square(t: texture_2d<f32>, at: Point) -> vec4f {
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) { for (var x = -1; x <= 1; x++) { sum += texel(t, at.pixel + vec2i(x, y)); } }
    return sum;
}
fn eight(v: vec4f) -> vec4f { var x = v; for (var i = 0u; i < 16u; i += 2u) { x *= v; } return x; }
fn nine(v: vec4f) -> vec4f { var x = v; for (var i = 0; i < 9; i++) { x *= v; } return x; }
fn given(v: vec4f) -> vec4f { var x = v; for (var i = 0; i < i32(v.x); i++) { x *= v; } return x; }
fn waits(v: vec4f) -> vec4f { var x = v; while x.x > 0.0 { x -= v; } return x; }
fn off(v: vec4f) -> vec4f { if OFF { return nine(v); } return v; }
fn ended(v: vec4f) -> vec4f { if !OFF { return v; } return nine(v); }";
        let shader = Shader::loaded("loops.wgsl".into(), source.into());
        assert_eq!(["square", "off", "ended"].map(|name| shader.register_pressure(name)), [RegisterPressure::Low; 3]);
        assert_eq!(shader.register_pressure("eight"), RegisterPressure::Medium);
        assert_eq!(["nine", "given", "waits"].map(|name| shader.register_pressure(name)), [RegisterPressure::High; 3]);
    }
}
