//! Functions that read textures directly, and functions that filter them. The library's `texel` and `tap` sanitize what
//! they read; a direct read does not.

use naga::{Expression, Function, Module};

use crate::walk::with_callers;

/// The functions and entry points that load, sample or gather texels themselves, or call one that does; those of the
/// library are not counted, nor what they read.
pub(crate) fn direct_reads<'m>(module: &'m Module, is_of_library: &dyn Fn(Option<&String>) -> bool) -> Vec<&'m String> {
    with_callers(module, &|function| !is_of_library(function.name.as_ref()) && has(function, is_read))
}

/// The functions and entry points that filter texels, also through the library's `tap`, or call one that does.
pub(crate) fn filtering(module: &Module) -> Vec<&String> {
    with_callers(module, &|function| has(function, is_sample))
}

/// Returns whether a function itself has such an expression.
pub(crate) fn has(function: &Function, matches: fn(&Expression) -> bool) -> bool {
    function.expressions.iter().any(|(_, expression)| matches(expression))
}

fn is_sample(expression: &Expression) -> bool {
    matches!(expression, Expression::ImageSample { .. })
}

/// Returns whether it loads, samples or gathers texels.
pub(crate) fn is_read(expression: &Expression) -> bool {
    matches!(expression, Expression::ImageLoad { .. } | Expression::ImageSample { .. })
}

#[cfg(test)]
mod tests {
    use crate::Shader;

    const SOURCE: &str = "
// textureLoad, textureSampleLevel and textureGather in a comment read nothing.
fn through_library(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }
fn loads(source: texture_2d<f32>, at: Point) -> vec4f { return textureLoad(source, at.pixel, 0); }
fn samples(source: texture_2d<f32>, s: sampler, at: Point) -> vec4f {
    return textureSampleLevel(source, s, at.uv, 0.0);
}
fn gathers(source: texture_2d<f32>, s: sampler, at: Point) -> vec4f { return textureGather(0, source, s, at.uv); }
fn taps(source: texture_2d<f32>, s: sampler, at: Point) -> vec4f { return tap(source, s, at.uv); }
fn calls(source: texture_2d<f32>, at: Point) -> vec4f {
    for (var i = 0; i < 2; i++) { if i == 1 { return loads(source, at); } }
    return vec4f();
}
fn measures(source: texture_2d<f32>, at: Point) -> vec4f { return vec4f(vec2f(textureDimensions(source)), 0.0, 0.0); }
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> sums: array<f32>;
@compute @workgroup_size(1) fn entry() { sums[0] = textureLoad(picture, vec2i(), 0).x; }
@compute @workgroup_size(1) fn guarded_entry() { sums[0] = texel(picture, vec2i()).x; }
";

    #[test]
    fn calls_that_read_textures_directly_are_found_and_comments_are_not() {
        let shader = Shader::new("direct.wgsl", SOURCE);
        let reads = |name: &str| shader.reads_textures_itself(name);
        assert_eq!(["loads", "samples", "gathers", "calls", "entry"].map(reads), [true; 5]);
        assert_eq!(["through_library", "measures", "guarded_entry"].map(reads), [false; 3]);
        let filters = |name: &str| shader.filters_textures(name);
        assert_eq!(["samples", "gathers", "taps"].map(filters), [true; 3]);
        assert_eq!(["through_library", "loads", "calls", "entry"].map(filters), [false; 4]);
    }
}
