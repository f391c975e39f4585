//! The kernels of a pass, as JSON shows them.

use std::collections::BTreeMap;

use serde::Serialize;

use super::names::Names;
use afterimage_graph::node::{Arg, Argument, KernelCall, Resource};

#[derive(Serialize)]
pub(super) struct KernelView<'a> {
    arguments: Vec<String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    constants: BTreeMap<&'static str, f64>,
    function: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    groups: Option<[u32; 3]>,
    node: &'a str,
    shader: &'a str,
}

impl<'a> KernelView<'a> {
    pub(super) fn new(kernel: &'a KernelCall, names: &Names) -> Self {
        let is_entry_point = kernel.workgroups.is_some();
        let text = |arg: &Argument| match arg.value.read().or(arg.value.written()) {
            Some(resource) if is_entry_point => format!("{} = {}", arg.name, names.of(resource)),
            _ => argument(arg.value, names),
        };
        Self {
            arguments: kernel.args.iter().map(text).collect(),
            constants: kernel.constants.iter().copied().collect(),
            function: &kernel.function,
            groups: kernel.workgroups,
            node: &kernel.node,
            shader: kernel.shader.file(),
        }
    }
}

fn argument(arg: Arg, names: &Names) -> String {
    let buffer = |buffer| names.of(Resource::Buffer(buffer));
    match arg {
        Arg::Kernel(kernel) => format!("kernel {kernel}"),
        Arg::Faults(kernel) => format!("faults of kernel {kernel}"),
        Arg::Square => "texels of the source".into(),
        Arg::SquareOf(kernel) => format!("texels of kernel {kernel}"),
        Arg::Around => "numbers around".into(),
        Arg::Pixel(image) => format!("pixel of {}", names.image(image)),
        Arg::Texture(image) => format!("texture {}", names.image(image)),
        Arg::Level(part) => format!("level {} of layer {} of {}", part.level, part.layer, names.image(part.image)),
        Arg::Storage(image) => format!("storage {}", names.image(image)),
        Arg::Buffer(id, _) => format!("buffer {}", buffer(id)),
        Arg::Value(id, components) => format!("{components} of {}", buffer(id)),
        Arg::Zero(components) => format!("zero {components}"),
        Arg::Sampler => "sampler".to_owned(),
        Arg::Point => "point".to_owned(),
        Arg::PointOf(kernel) => format!("place of kernel {kernel}"),
        Arg::Frame => "frame".to_owned(),
        Arg::Invocation => "invocation".to_owned(),
        Arg::Block(block) => format!("block {}", names.block(block)),
        Arg::Params => "params".to_owned(),
    }
}
