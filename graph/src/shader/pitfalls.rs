//! What a validator lets through and a device does not survive.

use naga::{Expression, Function, Module, Span, TypeInner};

/// What is told of a vector constant within a larger vector.
pub(super) const CONSTANT_PART: &str =
    "a vector constant of the module cannot be a part of a larger vector: write its components, `NAME.x, NAME.y`";

/// The first place where a larger vector is composed of a vector constant of the module and something that is no constant. The SPIR-V
/// that naga 30 writes for it is not valid, and drivers lose the device over it.
pub(super) fn constant_part(module: &Module) -> Option<Span> {
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let functions = module.functions.iter().map(|(_, function)| function);
    functions.chain(entries).find_map(|function| in_function(module, function))
}

fn in_function(module: &Module, function: &Function) -> Option<Span> {
    let expressions = &function.expressions;
    let is_vector_constant = |part: &naga::Handle<Expression>| match expressions[*part] {
        Expression::Constant(constant) => {
            matches!(module.types[module.constants[constant].ty].inner, TypeInner::Vector { .. })
        }
        _ => false,
    };
    let (at, _) = expressions.iter().find(|(_, expression)| match expression {
        Expression::Compose { ty, components } => {
            matches!(module.types[*ty].inner, TypeInner::Vector { .. }) && components.iter().any(is_vector_constant)
        }
        _ => false,
    })?;
    Some(expressions.get_span(at))
}

#[cfg(test)]
mod tests {
    use super::constant_part;

    fn found(body: &str) -> Option<String> {
        let source = format!("const PAIR = vec2f(1.0, 2.0);\nfn f(x: f32) -> vec3f {{ return {body}; }}");
        let module = naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{body}: {error}"));
        constant_part(&module).map(|span| source[span.to_range().unwrap_or_default()].to_owned())
    }

    #[test]
    fn a_vector_constant_in_a_larger_vector_is_found() {
        assert_eq!(found("vec3f(PAIR, x)").as_deref(), Some("vec3f(PAIR, x)"));
        assert_eq!(found("2.0 * vec3f(x, PAIR)").as_deref(), Some("vec3f(x, PAIR)"));
    }

    #[test]
    fn its_components_and_numbers_are_not() {
        for body in ["vec3f(PAIR.x, PAIR.y, x)", "vec3f(PAIR * x, x)", "vec3f(x)", "vec3f(vec2f(x), 1.0)"] {
            assert_eq!(found(body), None, "{body}");
        }
    }
}
