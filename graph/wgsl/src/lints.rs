//! Lints for code that a validator accepts and a device does not survive.

use naga::{Block, Expression, Function, Literal, Module, SampleLevel, ShaderStage, Span, Statement, TypeInner};

use crate::walk::{blocks, statements};

const CONSTANT_PART: &str =
    "a vector constant of the module cannot be a part of a larger vector: write its components, `NAME.x, NAME.y`";
const POINTER: &str = "a function takes pointers to whole variables only, and this leads to a part of one: copy the \
                       part into a `var`, give a pointer to that, and copy it back, or return the new values";
const NEIGHBORS: &str = "this compares neighboring pixels of a draw, which a dispatch has not: read textures through \
                          `tap(source, source_sampler, uv)` or `texel(source, pixel)`";
const DISCARD: &str = "a dispatch cannot discard a pixel: return what came in";
const ENDLESS: &str = "this loop never ends: it has no `break` and no `return`";

/// The first place that no device should see, and why.
pub(crate) fn first(module: &Module) -> Option<(Span, &'static str)> {
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let functions = module.functions.iter().map(|(_, function)| function);
    let told = |span: Option<Span>, why| span.map(|span| (span, why));
    let draws = draws_only(module);
    functions.chain(entries).find_map(|function| {
        told(constant_part(module, function), CONSTANT_PART)
            .or_else(|| told(pointer_to_part(module, function), POINTER))
            .or_else(|| told(neighbors(function).filter(|_| !draws), NEIGHBORS))
            .or_else(|| told(find(&function.body, &is_discard).filter(|_| !draws), DISCARD))
            .or_else(|| told(find(&function.body, &|statement| is_endless(function, statement)), ENDLESS))
    })
}

/// Returns whether all entry points are of a drawing pass, whose fragments have neighbors and can be discarded.
fn draws_only(module: &Module) -> bool {
    let is_of_draw = |stage: ShaderStage| matches!(stage, ShaderStage::Vertex | ShaderStage::Fragment);
    !module.entry_points.is_empty() && module.entry_points.iter().all(|entry| is_of_draw(entry.stage))
}

/// Expressions that need the pixels around: derivatives, and samples with an implicit level of detail.
fn neighbors(function: &Function) -> Option<Span> {
    let (at, _) = function.expressions.iter().find(|(_, expression)| {
        matches!(
            expression,
            Expression::Derivative { .. }
                | Expression::ImageSample { level: SampleLevel::Auto | SampleLevel::Bias(_), .. }
        )
    })?;
    Some(function.expressions.get_span(at))
}

fn is_discard(statement: &Statement) -> bool {
    matches!(statement, Statement::Kill)
}

/// A loop that nothing in it ends.
fn is_endless(function: &Function, statement: &Statement) -> bool {
    match statement {
        Statement::Loop { body, break_if: None, .. } => !leaves(function, body, true),
        _ => false,
    }
}

/// Returns whether something in the block leaves the function, or the loop that the block belongs to.
fn leaves(function: &Function, block: &Block, is_own: bool) -> bool {
    let inside = |block: &Block, is_own: bool| leaves(function, block, is_own);
    block.iter().any(|statement| match statement {
        Statement::Break => is_own,
        Statement::Return { .. } | Statement::Kill => true,
        // Their `break` ends them and no other.
        Statement::Loop { body, continuing, .. } => inside(body, false) || inside(continuing, false),
        Statement::Switch { cases, .. } => cases.iter().any(|case| inside(&case.body, false)),
        // `while true` is a branch whose other side, which breaks, is never taken.
        Statement::If { condition, accept, reject } => match function.expressions[*condition] {
            Expression::Literal(Literal::Bool(true)) => inside(accept, is_own),
            Expression::Literal(Literal::Bool(false)) => inside(reject, is_own),
            _ => inside(accept, is_own) || inside(reject, is_own),
        },
        Statement::Block(block) => inside(block, is_own),
        _ => false,
    })
}

/// The first such statement, however deep.
fn find(block: &Block, matches: &dyn Fn(&Statement) -> bool) -> Option<Span> {
    block.span_iter().find_map(|(statement, span)| match statement {
        statement if matches(statement) => Some(*span),
        statement => blocks(statement).into_iter().find_map(|block| find(block, matches)),
    })
}

/// The first place where a larger vector is composed of a vector constant of the module and something that is no
/// constant. The SPIR-V that naga 30 writes for it is not valid, and drivers lose the device over it.
fn constant_part(module: &Module, function: &Function) -> Option<Span> {
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

/// The first pointer to a part of a variable that is given to a function. naga 30 accepts it, and its writer of SPIR-V
/// panics.
fn pointer_to_part(module: &Module, function: &Function) -> Option<Span> {
    let mut found = None;
    statements(&function.body, &mut |statement| {
        if let Statement::Call { arguments, function: callee, .. } = statement {
            let parameters = module.functions[*callee].arguments.iter();
            let given = parameters.zip(arguments).find(|(parameter, given)| {
                let takes_pointer = module.types[parameter.ty].inner.pointer_space().is_some();
                let is_part =
                    matches!(function.expressions[**given], Expression::Access { .. } | Expression::AccessIndex { .. });
                takes_pointer && is_part
            });
            found = found.or_else(|| given.map(|(_, given)| function.expressions.get_span(*given)));
        }
    });
    found
}

#[cfg(test)]
mod tests {
    use super::{CONSTANT_PART, DISCARD, ENDLESS, NEIGHBORS, POINTER, first};

    fn told(source: &str) -> Option<(String, &'static str)> {
        let module = naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{source}: {error}"));
        first(&module).map(|(span, why)| (source[span.to_range().unwrap_or_default()].to_owned(), why))
    }

    fn found(body: &str) -> Option<String> {
        let (text, why) = told(&format!("const PAIR = vec2f(1.0, 2.0);\nfn f(x: f32) -> vec3f {{ return {body}; }}"))?;
        assert_eq!(why, CONSTANT_PART);
        Some(text)
    }

    fn in_body(body: &str) -> Option<&'static str> {
        let before = "@group(0) @binding(0) var t: texture_2d<f32>; @group(0) @binding(1) var s: sampler;";
        told(&format!("{before} fn f(x: f32) -> f32 {{ var y = x; {body} return y; }}")).map(|(_, why)| why)
    }

    #[test]
    fn loops_without_an_end_are_found() {
        for body in [
            "loop { }",
            "for (;;) { y += 1.0; }",
            "while true { y += 1.0; }",
            "while (true) { }",
            "if x > 0.0 { loop { switch 1 { default { break; } } } }",
        ] {
            assert_eq!(in_body(body), Some(ENDLESS), "{body}");
        }
        for body in [
            "loop { if y > 9.0 { break; } y += 1.0; }",
            "loop { return y; }",
            "while y < 9.0 { y += 1.0; }",
            "while true { if y > 9.0 { break; } y += 1.0; }",
        ] {
            assert_eq!(in_body(body), None, "{body}");
        }
    }

    #[test]
    fn what_only_a_draw_can_do_is_found() {
        assert_eq!(in_body("y = dpdx(x);"), Some(NEIGHBORS));
        assert_eq!(in_body("y = textureSample(t, s, vec2f(x)).x;"), Some(NEIGHBORS));
        assert_eq!(in_body("y = textureSampleLevel(t, s, vec2f(x), 0.0).x;"), None);
        assert_eq!(in_body("if x < 0.0 { discard; }"), Some(DISCARD));
    }

    #[test]
    fn pointers_to_parts_of_variables_are_found() {
        let order = |declared: &str, one: &str| {
            let order = "fn order(a: ptr<function, f32>, b: f32) { *a = min(*a, b); }";
            told(&format!("struct S {{ x: f32, v: vec3f }} {order} fn f(x: f32) {{ {declared} order({one}, x); }}"))
        };
        for (declared, part) in [
            ("var v = array<f32, 3>();", "&v[0]"),
            ("var v = array<f32, 3>(); let i = i32(x);", "&v[i]"),
            ("var v = array<array<f32, 2>, 2>();", "&v[0][1]"),
            ("var s = S();", "&s.x"),
            ("var v = array<S, 2>(); let p = &v[1];", "&(*p).x"),
        ] {
            assert_eq!(order(declared, part).map(|(_, why)| why), Some(POINTER), "{part}");
        }
        assert_eq!(order("var v = 1.0;", "&v"), None);
        assert_eq!(order("var v = 1.0; let p = &v;", "p"), None);
    }

    #[test]
    fn a_drawing_pass_may_do_it() {
        let discards = "fn cut(x: f32) { if dpdx(x) < 0.0 { discard; } }";
        let entry = "@fragment fn main(@location(0) x: f32) -> @location(0) vec4f { cut(x); return vec4f(x); }";
        let draws = format!("{discards} {entry}");
        assert_eq!(told(&draws), None);
        let with_dispatch = format!("{draws} @compute @workgroup_size(1) fn other() {{ }}");
        assert_eq!(told(&with_dispatch).map(|(_, why)| why), Some(NEIGHBORS));
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
