//! Inputs of which frames state a rectangle and a factor: a pass in front reads the rectangle. It fuses with readers of
//! pixels, and takes the place of the sanitized copy for others.

use afterimage_base::image::ColorState;
use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::node::{Arg, ImageId, KernelCall, KernelOrigin, Pass};
use afterimage_wgsl::Shader;

use crate::plan::{Plan, RectangleInput};
use crate::request::{Part, PlanRequest};

#[allow(unsafe_code, reason = "the shader was unchecked")]
// SAFETY: all texels are read inside of the texture, and there are no loops.
static CROP: Shader = unsafe {
    Shader::unchecked(
        "crop.wgsl",
        "import afterimage::math::between;
struct Crop { first: vec2f, size: vec2f, factor: f32 }
// A texel of the rectangle, or the nearest one. Without a factor it is as the texture has it.
fn crop_texel(t: texture_2d<f32>, texel: vec2i, params: Crop) -> vec4f {
    let inside = vec2i(params.first) + clamp(texel, vec2i(), vec2i(params.size) - 1);
    let p = clamp(inside, vec2i(), vec2i(textureDimensions(t)) - 1);
    if params.factor == 1.0 { return texel_inside(t, p); }
    return texel_scaled(t, p, params.factor);
}
fn crop(source: texture_2d<f32>, at: Point, params: Crop) -> vec4f {
    return crop_texel(source, at.pixel, params);
}
fn crop_nearest(source: texture_2d<f32>, at: Point, params: Crop) -> vec4f {
    return crop_texel(source, vec2i(at.uv * params.size), params);
}
fn crop_filtered(source: texture_2d<f32>, at: Point, params: Crop) -> vec4f {
    let place = at.uv * params.size - 0.5;
    let base = floor(place);
    let i = vec2i(base);
    let share = place - base;
    let top = between(crop_texel(source, i, params), crop_texel(source, i + vec2i(1, 0), params), share.x);
    let next = i + vec2i(0, 1);
    let bottom = between(crop_texel(source, next, params), crop_texel(source, next + vec2i(1, 0), params), share.x);
    return between(top, bottom, share.y);
}",
    )
};

/// The pass that reads a rectangle of `source`, the host image of an input with that index in the graph.
pub(crate) fn crop_pass(index: usize, input: &GraphInput, part: Part, source: ImageId, result: ImageId) -> Pass {
    let is_color = input.state != ColorState::Data;
    let function = match part {
        Part::Rectangle => "crop",
        Part::Scaled if is_color => "crop_filtered",
        // Numbers between two distances or normals are none of the scene.
        Part::Scaled => "crop_nearest",
    };
    let args = [("source", Arg::Texture(source)), ("at", Arg::Point), ("params", Arg::Params)];
    let kernel = KernelCall {
        uniform: vec![0; RectangleInput::BYTES],
        origin: Some(KernelOrigin::Input(index)),
        ..KernelCall::function(&input.name, &CROP, function, &args)
    };
    Pass::of_functions(vec![input.name.clone()], "crop".into(), vec![kernel], result)
}

/// The inputs of a plan of which frames state a rectangle.
pub(crate) fn rectangles(graph: &Graph, request: &PlanRequest<'_>, plan: &Plan) -> Vec<RectangleInput> {
    let mut rectangles = Vec::new();
    for (name, image) in &plan.inputs {
        let Some(part) = request.given.parts.get(name) else { continue };
        let Some(index) = graph.inputs.iter().position(|input| input.name == *name) else { continue };
        rectangles.push(RectangleInput {
            name: name.clone(),
            image: *image,
            part: *part,
            scale: graph.inputs[index].scale as f32,
            places: plan.uniform_places(KernelOrigin::Input(index)),
        });
    }
    rectangles
}

impl RectangleInput {
    pub const BYTES: usize = 24;

    /// The uniform for a rectangle, whose first texel and size are given, and a factor.
    pub fn uniform(&self, first: [u32; 2], size: [u32; 2], factor: f32) -> [u8; Self::BYTES] {
        let [[x, y], [width, height]] = [first, size].map(|pair| pair.map(|number| number as f32));
        let numbers = [x, y, width, height, factor * self.scale, 0.0];
        let mut bytes = [0; Self::BYTES];
        bytes.copy_from_slice(numbers.map(f32::to_le_bytes).as_flattened());
        bytes
    }
}

#[cfg(test)]
mod tests {
    use afterimage_wgsl::UniformValue;

    use super::*;

    #[test]
    fn the_uniform_is_what_the_shader_reads() {
        let reflection = CROP.reflect().expect("the shader is valid");
        let floats = |numbers: &[f32]| UniformValue::Floats(numbers.to_vec());
        let values = [("first", floats(&[3.0, 4.0])), ("size", floats(&[5.0, 6.0])), ("factor", floats(&[1.75]))];
        let expected = reflection.pack("Crop", &values).expect("the struct has these numbers");
        let input =
            RectangleInput { name: "in".into(), image: ImageId(0), part: Part::Rectangle, scale: 0.5, places: vec![] };
        assert_eq!(input.uniform([3, 4], [5, 6], 3.5).as_slice(), expected.as_slice());
    }
}
