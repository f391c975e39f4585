//! The plan under construction: what the stages before scheduling hand on.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_base::image::{Format, Size};
use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin, Pass, PassKind, Recording, VirtualImage};
use afterimage_wgsl::{Shader, UniformValue};

use crate::plan::{PlanOutput, Savings};
use crate::record_context::NodeContext;

/// The plan under construction, before its passes are ordered.
#[derive(Default)]
pub(crate) struct PlanBuilder {
    /// Images, buffers and passes, the passes in the order of recording.
    pub(crate) recording: Recording,
    /// The images that the host gives: input name and image.
    pub(crate) inputs: Vec<(String, ImageId)>,
    pub(crate) outputs: Vec<PlanOutput>,
    pub(crate) savings: Savings,
    /// The nodes with dynamic parameters that run, by their indices in the graph.
    pub(crate) dynamic: BTreeMap<usize, NodeContext>,
}

impl PlanBuilder {
    /// The images that outlive the frame or leave it: their passes must not be removed.
    pub(crate) fn kept(&self) -> BTreeSet<ImageId> {
        let outputs = self.outputs.iter().map(|output| output.image);
        let remembered = self.recording.images.iter().filter_map(|image| image.origin.previous_of());
        outputs.chain(remembered).collect()
    }
}

/// A copy of a pixel, for outputs that no node writes and for sources that need one.
#[allow(unsafe_code, reason = "the shader was unchecked")]
// SAFETY: it reads nothing.
static COPY: Shader = unsafe { Shader::unchecked("copy.wgsl", "fn copy(source: vec4f) -> vec4f { return source; }") };

/// Scales a host image. It reads through the library, which limits after the factor.
static SCALE: Shader = Shader::new(
    "scale.wgsl",
    "struct Scale { factor: f32 }
fn scale(source: texture_2d<f32>, at: Point, params: Scale) -> vec4f {
    return texel_scaled(source, at.pixel, params.factor);
}",
);

/// Copies a mip level of a layer.
static COPY_LEVEL: Shader = Shader::new(
    "copy_level.wgsl",
    "fn copy_level(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }",
);

/// Copies a volume, which no device draws to.
static COPY_VOLUME: Shader = Shader::new(
    "copy_volume.wgsl",
    "@group(0) @binding(0) var source: texture_3d<f32>;
@group(0) @binding(1) var result: texture_storage_3d<rgba16float, write>;
@compute @workgroup_size(8, 8)
fn copy_volume(@builtin(global_invocation_id) id: vec3u) {
    if any(id >= textureDimensions(source)) { return; }
    textureStore(result, id, texel3(source, vec3i(id)));
}",
);

/// A format for the numbers of an image: floats if it has them, else half floats.
pub(crate) fn float_format(format: Format) -> Format {
    match format {
        _ if format.is_depth() => Format::R32Float,
        _ if format.is_32_bit() => format,
        _ => Format::Rgba16Float,
    }
}

/// An image of finite numbers in place of an image of the host.
pub(crate) fn finite_image(label: String, source: &VirtualImage) -> VirtualImage {
    let desc = source.desc.format(float_format(source.desc.format));
    VirtualImage { label, desc, origin: Origin::Transient, finite: true, signedness: source.signedness }
}

/// A pass that multiplies the colors of the host image `source` by a factor.
pub(crate) fn scale_pass(input: &str, source: ImageId, factor: f32, result: ImageId) -> Pass {
    let args = [("source", Arg::Texture(source)), ("at", Arg::Point), ("params", Arg::Params)];
    let reflection = SCALE.reflect().expect("the shader is valid");
    let values = [("factor", UniformValue::Floats(vec![factor]))];
    let kernel = KernelCall {
        uniform: reflection.pack("Scale", &values).expect("the struct has one number"),
        ..KernelCall::function(input, &SCALE, "scale", &args)
    };
    Pass::of_functions(vec![input.to_owned()], "scale".into(), vec![kernel], result)
}

/// A kernel that copies a pixel of `source`.
pub(crate) fn copy_kernel(node: &str, source: ImageId) -> KernelCall {
    copy_of(node, Arg::Pixel(source))
}

/// A pass that copies the pixels of an image, or zero, to `result`.
pub(crate) fn copy_pass(node: &str, what: Arg, result: ImageId) -> Pass {
    Pass::of_functions(vec![node.to_owned()], "copy".into(), vec![copy_of(node, what)], result)
}

/// A pass that copies one mip level of one layer.
pub(crate) fn copy_level_pass(node: &str, level: Arg, result: ImageId) -> Pass {
    let kernel = KernelCall::function(node, &COPY_LEVEL, "copy_level", &[("source", level), ("at", Arg::Point)]);
    Pass::of_functions(vec![node.to_owned()], "copy".into(), vec![kernel], result)
}

/// A pass that copies the texels of a volume.
pub(crate) fn copy_volume_pass(node: &str, source: ImageId, result: ImageId, size: Size) -> Pass {
    let args = [("source", Arg::Texture(source)), ("result", Arg::Storage(result))];
    let groups = [size.width.div_ceil(8), size.height.div_ceil(8), size.depth];
    let kernel =
        KernelCall { workgroups: Some(groups), ..KernelCall::function(node, &COPY_VOLUME, "copy_volume", &args) };
    Pass {
        nodes: vec![node.to_owned()],
        label: "copy".into(),
        kernels: vec![kernel],
        results: Vec::new(),
        kind: PassKind::Compute,
    }
}

fn copy_of(node: &str, what: Arg) -> KernelCall {
    KernelCall::function(node, &COPY, "copy", &[("source", what)])
}

#[cfg(test)]
mod tests {
    use afterimage_base::image::{ImageDesc, Signedness};

    use super::*;

    #[test]
    fn a_finite_image_keeps_the_negative_numbers_that_its_source_may_have() {
        for signedness in [Signedness::Unsigned, Signedness::Extended, Signedness::Signed] {
            let (label, desc) = ("in".to_owned(), ImageDesc::new(Size::new(4, 3)));
            let source = VirtualImage { label, desc, origin: Origin::Input("in".into()), finite: false, signedness };
            let made = finite_image("in.copy".into(), &source);
            assert_eq!((made.signedness, made.finite), (signedness, true));
        }
    }
}
