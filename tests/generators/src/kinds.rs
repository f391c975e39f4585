//! Kinds of nodes that only random graphs have: point and gather kernels, pyramids, volumes, values that stay on the
//! GPU, two outputs.
#![allow(unreachable_pub, reason = "`node_kind!` makes each kind public")]

use afterimage_graph::node::{ImageId, NodeKind};
use afterimage_graph::prelude::*;

static TINT: Shader =
    Shader::new("tint", "fn tint(source: vec4f) -> vec4f { return source * vec4f(0.5, 0.75, 1.0, 1.0); }");
static LAY: Shader = Shader::new(
    "lay",
    "fn lay(base: vec4f, over: texture_2d<f32>, over_sampler: sampler, at: Point) -> vec4f {
        return mix(base, tap(over, over_sampler, at.uv), 0.25);
    }",
);
static COPY: Shader = Shader::new(
    "look",
    "fn look(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return 0.5 * (tap(source, source_sampler, at.uv) + tap(source, source_sampler, at.uv + vec2f(0.01, 0.02)));
    }",
);
static BAKE: Shader = Shader::new(
    "bake",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var result: texture_storage_3d<rgba16float, write>;
    @compute @workgroup_size(4, 4, 4)
    fn bake(@builtin(global_invocation_id) id: vec3u) {
        let p = vec2i(id.xy) * (1 + vec2i(vec3i(id).zz));
        textureStore(result, id, texel(source, p));
    }",
);
static SLICE: Shader = Shader::new(
    "slice",
    "fn slice(base: vec4f, volume: texture_3d<f32>, volume_sampler: sampler, at: Point) -> vec4f {
        return base + 0.125 * tap3(volume, volume_sampler, vec3f(at.uv, fract(base.r)));
    }",
);
static METER: Shader = Shader::new(
    "meter",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var<storage, read> before: array<vec4f>;
    @group(0) @binding(2) var<storage, read_write> sum: array<vec4f>;
    @group(0) @binding(3) var<storage, read_write> value: array<vec4f>;
    @compute @workgroup_size(1)
    fn meter_sum() { sum[0] = 0.5 * (before[0] + texel(source, vec2i(1, 1))); }
    @compute @workgroup_size(1)
    fn meter_keep() { value[0] = sum[0]; }",
);
static SCALE: Shader = Shader::new(
    "scale",
    "fn scale(source: vec4f, value: vec4f) -> vec4f { return source * (0.5 + 0.5 * fract(value)); }",
);

const ANY: OutputState = OutputState::same("source");

/// Declares a test kind: its ports, and what it records.
macro_rules! kind {
    ($kind:ident, $doc:literal, [$($input:expr),*], [$($output:expr),*], $record:expr) => {
        node_kind! {
            #[doc = $doc]
            pub struct $kind {}

            const INPUTS: &'static [Input] = &[$($input),*];
            const OUTPUTS: &'static [Output] = &[$($output),*];
        }
        impl Node for $kind {
            fn record(&self, pass: &mut Recorder<'_>) {
                let record: fn(&mut Recorder<'_>) = $record;
                record(pass)
            }
        }
    };
}

const SOURCE: Input = Input::image("source", "An image.");
const RESULT: Output = Output::image("result", ANY, "An image.");
const SOURCE_OR_RESULT: Output = Output::image("result", ANY, "An image.").or_input("source");

fn sized(pass: &mut Recorder<'_>, port: &str, change: fn(Size) -> Size) -> ImageDesc {
    let image = pass.image(port);
    ImageDesc::new(change(pass.desc(image).size))
}

fn look(pass: &mut Recorder<'_>, source: ImageId, result: ImageId) {
    pass.function(&COPY, "look").read("source", source).write_to(result);
}

kind!(Tint, "Changes each pixel.", [SOURCE], [SOURCE_OR_RESULT], |pass| {
    let desc = sized(pass, "source", |size| size);
    pass.function(&TINT, "tint").write("result", desc);
});
kind!(
    Lay,
    "Lays one image over another.",
    [Input::image("base", "An image."), Input::image("over", "An image.")],
    [Output::image("result", OutputState::same("base"), "An image.").or_input("base")],
    |pass| {
        let over = pass.image("over");
        let desc = sized(pass, "base", |size| size);
        pass.function(&LAY, "lay").read("over", over).write("result", desc);
    }
);
kind!(Blur, "Two passes with an image between.", [SOURCE], [SOURCE_OR_RESULT], |pass| {
    let (source, desc) = (pass.image("source"), sized(pass, "source", |size| size));
    let between = pass.transient("between", desc);
    look(pass, source, between);
    let result = pass.output("result", desc);
    look(pass, between, result);
});
kind!(Shrink, "Half the size.", [SOURCE], [RESULT], |pass| {
    let (source, desc) = (pass.image("source"), sized(pass, "source", Size::half));
    let result = pass.output("result", desc);
    look(pass, source, result);
});
kind!(
    Grow,
    "The size of another image.",
    [SOURCE, Input::image("like", "An image.")],
    [Output::image("result", ANY, "An image.").or_input("like")],
    |pass| {
        let (source, desc) = (pass.image("source"), sized(pass, "like", |size| size));
        let result = pass.output("result", desc);
        look(pass, source, result);
    }
);
kind!(Levels, "A pyramid.", [SOURCE], [Output::new("result", PortType::Pyramid, ANY, "Levels.")], |pass| {
    let (mut above, mut desc) = (pass.image("source"), sized(pass, "source", |size| size));
    let mut levels = Vec::new();
    for index in 0..desc.size.levels().clamp(1, 6) {
        desc = desc.half();
        let level = pass.level(format_args!("result.{index}"), desc);
        look(pass, above, level);
        levels.push(level);
        above = level;
    }
    pass.set_output("result", InputValue::Pyramid(levels));
});
kind!(
    Join,
    "Joins a pyramid from its coarsest level up.",
    [Input::new("source", PortType::Pyramid, "Levels.")],
    [RESULT],
    |pass| {
        let levels = pass.pyramid("source");
        let (coarsest, finer) = levels.split_last().expect("a pyramid has a level");
        let mut joined = *coarsest;
        for (index, level) in finer.iter().enumerate().rev() {
            let result = pass.level(format_args!("result.{index}"), ImageDesc::new(pass.desc(*level).size));
            pass.function(&LAY, "lay").read("base", *level).read("over", joined).write_to(result);
            joined = result;
        }
        pass.set_output("result", InputValue::Image(joined));
    }
);
kind!(Bake, "A volume.", [SOURCE], [Output::new("result", PortType::Volume, ANY, "A volume.")], |pass| {
    let size = sized(pass, "source", |size| size.div_up(16)).size;
    let result = pass.output("result", ImageDesc::volume(Size::volume(size.width, size.height, 16)));
    let groups = size.div_up(4);
    pass.compute(&BAKE, "bake").image("result", result).dispatch([groups.width, groups.height, 4]);
});
kind!(
    Slice,
    "Looks into a volume.",
    [Input::image("base", "An image."), Input::new("volume", PortType::Volume, "A volume.")],
    [Output::image("result", OutputState::same("base"), "An image.").or_input("base")],
    |pass| {
        let desc = sized(pass, "base", |size| size);
        pass.function(&SLICE, "slice").write("result", desc);
    }
);
kind!(
    Meter,
    "A value that remembers the frame before.",
    [SOURCE],
    [Output::new("value", PortType::Value, OutputState::Nothing, "A value.")],
    |pass| {
        let sum = pass.add_buffer("sum", 16, BufferLife::Frame);
        let value = pass.output_value("value", BufferLife::Persistent);
        pass.compute(&METER, "meter_sum").buffer("before", value).buffer("sum", sum).dispatch([1, 1, 1]);
        pass.compute(&METER, "meter_keep").buffer("sum", sum).buffer("value", value).dispatch([1, 1, 1]);
    }
);
kind!(
    Scale,
    "Scales by a value.",
    [SOURCE, Input::new("value", PortType::Value, "A value.")],
    [SOURCE_OR_RESULT],
    |pass| {
        let desc = sized(pass, "source", |size| size);
        pass.function(&SCALE, "scale").write("result", desc);
    }
);
kind!(
    Split,
    "Two images, one of half the size.",
    [SOURCE],
    [RESULT, Output::image("small", ANY, "An image.")],
    |pass| {
        let (source, desc) = (pass.image("source"), sized(pass, "source", |size| size));
        let (whole, half) = (pass.output("result", desc), pass.output("small", desc.half()));
        look(pass, source, whole);
        look(pass, source, half);
    }
);

/// The kinds and their weights: how often each is chosen.
pub(crate) const KINDS: [(NodeKind, u32); 12] = [
    (NodeKind::of::<Tint>(), 14),
    (NodeKind::of::<Lay>(), 24),
    (NodeKind::of::<Blur>(), 14),
    (NodeKind::of::<Shrink>(), 10),
    (NodeKind::of::<Grow>(), 12),
    (NodeKind::of::<Levels>(), 5),
    (NodeKind::of::<Join>(), 5),
    (NodeKind::of::<Bake>(), 3),
    (NodeKind::of::<Slice>(), 4),
    (NodeKind::of::<Meter>(), 3),
    (NodeKind::of::<Scale>(), 4),
    (NodeKind::of::<Split>(), 4),
];
