//! Functions that compute much for each pixel.

use naga::{Expression, Function, MathFunction, Module, Statement};

use crate::walk::statements;

/// Powers, exponentials and logarithms of a number, at most, of a function that takes less time than to store an image
/// and to read it again. On an H200 that trip takes as long as eight powers.
const FEW_POWERS: usize = 6;

/// The functions that take longer than a trip of their result through memory: those with a loop or many powers, also in
/// what they call.
pub(crate) fn heavy(module: &Module) -> Vec<&String> {
    let mut works: Vec<Work> = Vec::with_capacity(module.functions.len());
    // A module declares functions before those that call them.
    for (_, function) in module.functions.iter() {
        works.push(Work::of(function, &works));
    }
    let is_heavy = |work: &Work| work.has_loop || work.powers > FEW_POWERS;
    let heavy = module.functions.iter().zip(&works).filter(|(_, work)| is_heavy(work));
    heavy.filter_map(|((_, function), _)| function.name.as_ref()).collect()
}

/// What a function and all that it calls computes.
#[derive(Clone, Copy, Default)]
struct Work {
    powers: usize,
    has_loop: bool,
}

impl Work {
    /// `known` holds the work of the functions before.
    fn of(function: &Function, known: &[Self]) -> Self {
        let powers = function.expressions.iter().filter(|(_, expression)| is_power(expression)).count();
        let mut work = Self { powers, has_loop: false };
        statements(&function.body, &mut |statement| match statement {
            Statement::Call { function, .. } => {
                let called = known[function.index()];
                work.powers = work.powers.saturating_add(called.powers);
                work.has_loop |= called.has_loop;
            }
            Statement::Loop { .. } => work.has_loop = true,
            _ => {}
        });
        work
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
    }
}
