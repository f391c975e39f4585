//! Kinds with one fault each.

use afterimage_graph::prelude::*;

use promises::{cut_off, dark_edges, falling, leaning, restless, uneven};

/// A fault and the words by which it must be found.
pub(super) struct Planted {
    pub(super) kind: NodeKind,
    /// The image or sequence that shows it.
    pub(super) case: &'static str,
    /// A part of the verdict.
    pub(super) verdict: &'static str,
}

const fn planted<N: TypedKind + Node>(case: &'static str, verdict: &'static str) -> Planted {
    Planted { kind: NodeKind::of::<N>(), case, verdict }
}

pub(super) const ALL: &[Planted] = &[
    planted::<DividesByLight>("black", "not finite"),
    planted::<LogOfNothing>("black", "not finite"),
    planted::<KneeOfNothing>("white", "not finite"),
    planted::<Unbounded>("primaries", "out of range for Scene"),
    planted::<BelowBlack>("gray", "out of range for Scene"),
    planted::<AboveWhite>("bright", "out of range for Encoded"),
    planted::<FalseIdentity>("gray", "skipped as an identity"),
    planted::<PowerOfNegative>("wide", "not finite"),
    planted::<CountsTooFar>("gray", "panics"),
    planted::<dark_edges::DarkEdges>("white", "a constant becomes another"),
    planted::<uneven::Uneven>("white", "a constant image does not stay constant"),
    planted::<cut_off::CutOff>("firefly", "the sum of"),
    planted::<leaning::Leaning>("firefly", "a symmetric image does not stay symmetric"),
    planted::<falling::Falling>("ramp", "more light becomes less"),
    planted::<restless::Restless>("time-backwards", "after 3 frames"),
    planted::<restless::Restless>("time-huge", "after 2 frames"),
    planted::<CountsInFloats>("after-months", "stands still"),
    planted::<DrawsOtherwise>("ramp", "when drawn"),
    planted::<SharesPrivately>("edge", "when not fused"),
    planted::<DarkSlice>("black", "not finite"),
];

const SOURCE: &[Input] = &[Input::image("source", "Light.").accepts(&[ColorState::Scene])];
const RESULT: &[Output] = &[Output::image("result", OutputState::same("source"), "Light.").or_input("source")];

/// A node with one function that is named after its shader's text.
macro_rules! faulty {
    ($kind:ident, $function:literal, $fallback:expr, $wgsl:literal) => {
        impl Node for $kind {
            fn is_identity(&self, _: &InputValues) -> bool {
                let is_neutral: fn(&Self) -> bool = $fallback;
                is_neutral(self)
            }

            fn record(&self, pass: &mut Recorder<'_>) {
                static SHADER: Shader = Shader::new(concat!($function, ".wgsl"), $wgsl);
                let source = pass.image("source");
                let desc = ImageDesc::new(pass.desc(source).size);
                pass.function(&SHADER, $function).write("result", desc);
            }
        }
    };
}

mod promises;

node_kind! {
    /// A volume whose last slice divides by its light.
    pub struct DarkSlice {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] =
        &[Output::new("result", PortType::Volume, OutputState::Always(ColorState::Data), "The volume.")
            .or(Fallback::Absent)];
}

impl Node for DarkSlice {
    fn record(&self, pass: &mut Recorder<'_>) {
        static SHADER: Shader = Shader::new(
            "dark_slice.wgsl",
            "@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_3d<rgba16float, write>;
@compute @workgroup_size(8, 8)
fn dark_slice(@builtin(global_invocation_id) id: vec3u) {
    let color = texel(source, vec2i(id.xy));
    let light = color.r + color.g + color.b;
    textureStore(result, id, select(vec4f(light), vec4f(light / light), id.z == 3));
}",
        );
        let source = pass.image("source");
        let size = pass.desc(source).size;
        let desc = ImageDesc::volume(Size::volume(size.width, size.height, 4));
        let result = pass.output("result", desc);
        pass.compute(&SHADER, "dark_slice").image("source", source).image("result", result).dispatch([
            size.width.div_ceil(8),
            size.height.div_ceil(8),
            4,
        ]);
    }
}

node_kind! {
    /// Divides by a luminance that may be 0.
    pub struct DividesByLight {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    DividesByLight,
    "divides_by_light",
    |_| false,
    "fn divides_by_light(source: vec4f) -> vec4f {
    return vec4f(source.rgb * (source.g / (source.r + source.g + source.b)), source.a);
}"
);

node_kind! {
    /// Takes the logarithm of 0.
    pub struct LogOfNothing {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    LogOfNothing,
    "log_of_nothing",
    |_| false,
    "fn log_of_nothing(source: vec4f) -> vec4f {
    return vec4f(abs(source.rgb * log2(source.rgb)) / 16.0, source.a);
}"
);

node_kind! {
    /// A knee whose width is divided by.
    pub struct KneeOfNothing {
        /// Width.
        pub knee: f32 = 0.5 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    KneeOfNothing,
    "knee_of_nothing",
    |_| false,
    "struct KneeOfNothing { knee: f32 }
fn knee_of_nothing(source: vec4f, params: KneeOfNothing) -> vec4f {
    let share = clamp((source.rgb - 1.0) / params.knee, vec3f(0.0), vec3f(60000.0));
    return vec4f(min(source.rgb / params.knee, vec3f(65504.0 / params.knee)) * min(share, vec3f(1.0)) * 0.5, source.a);
}"
);

node_kind! {
    /// Makes bright light brighter than a half float can hold.
    pub struct Unbounded {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    Unbounded,
    "unbounded",
    |_| false,
    "fn unbounded(source: vec4f) -> vec4f {
    return vec4f(source.rgb * 4.0, source.a);
}"
);

node_kind! {
    /// Takes away more light than there is.
    pub struct BelowBlack {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    BelowBlack,
    "below_black",
    |_| false,
    "fn below_black(source: vec4f) -> vec4f {
    return vec4f(source.rgb - 0.5, source.a);
}"
);

node_kind! {
    /// Encodes and does not stop at white.
    pub struct AboveWhite {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::Always(ColorState::Encoded), "The signal.")];
}
faulty!(
    AboveWhite,
    "above_white",
    |_| false,
    "fn above_white(source: vec4f) -> vec4f {
    return vec4f(sqrt(source.rgb), source.a);
}"
);

node_kind! {
    /// Says that it changes nothing at 0, and does.
    pub struct FalseIdentity {
        /// Share of the effect.
        pub amount: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
    }

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    FalseIdentity,
    "false_identity",
    |me| me.amount == 0.0,
    "struct FalseIdentity { amount: f32 }
fn false_identity(source: vec4f, params: FalseIdentity) -> vec4f {
    return vec4f(source.rgb * (0.9 - 0.5 * params.amount), source.a);
}"
);

node_kind! {
    /// Raises to a power what may be negative.
    pub struct PowerOfNegative {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    PowerOfNegative,
    "power_of_negative",
    |_| false,
    "fn power_of_negative(source: vec4f) -> vec4f {
    return vec4f(pow(source.rgb, vec3f(0.4)), source.a);
}"
);

node_kind! {
    /// Counts beyond the end of a table while it is recorded.
    pub struct CountsTooFar {
        /// How far.
        pub levels: u32 = 2 => within(1.0..=8.0);
    }

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for CountsTooFar {
    fn record(&self, pass: &mut Recorder<'_>) {
        const WEIGHTS: [f32; 4] = [0.4, 0.3, 0.2, 0.1];
        static SHADER: Shader = Shader::new(
            "counts_too_far.wgsl",
            "struct CountsTooFar { weight: f32 }
fn counts_too_far(source: vec4f, params: CountsTooFar) -> vec4f { return source * params.weight; }",
        );
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let weight = WEIGHTS[self.levels as usize - 1];
        pass.function(&SHADER, "counts_too_far").set("weight", weight).write("result", desc);
    }
}

node_kind! {
    /// Counts frames in floats, which have no odd numbers after three days.
    pub struct CountsInFloats {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}
faulty!(
    CountsInFloats,
    "counts_in_floats",
    |_| false,
    "fn counts_in_floats(source: vec4f, frame: Frame) -> vec4f {
    return vec4f(source.rgb * (0.5 + 0.5 * fract(0.37 * f32(frame.index))), source.a);
}"
);

node_kind! {
    /// Has another curve for devices that draw.
    pub struct DrawsOtherwise {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for DrawsOtherwise {
    fn record(&self, pass: &mut Recorder<'_>) {
        static SHADER: Shader = Shader::new(
            "draws_otherwise.wgsl",
            "fn draws_otherwise(source: vec4f) -> vec4f { return vec4f(sqrt(source.rgb), source.a); }
fn draws_otherwise_fast(source: vec4f) -> vec4f {
    let bits = (bitcast<vec3u>(source.rgb) >> vec3u(1u)) + vec3u(0x1fc00000u);
    return vec4f(select(vec3f(0.0), bitcast<vec3f>(bits), source.rgb > vec3f(0.0)), source.a);
}",
        );
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let function = if pass.caps.prefer_fragment { "draws_otherwise_fast" } else { "draws_otherwise" };
        pass.function(&SHADER, function).write("result", desc);
    }
}

node_kind! {
    /// Passes a number to the next function in a private variable, and not in the image.
    pub struct SharesPrivately {}

    const INPUTS: &'static [Input] = SOURCE;
    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for SharesPrivately {
    fn record(&self, pass: &mut Recorder<'_>) {
        static SHADER: Shader = Shader::new(
            "shares_privately.wgsl",
            "var<private> shares_privately_peak: f32;
fn shares_privately_take(source: vec4f) -> vec4f {
    shares_privately_peak = max(source.r, max(source.g, source.b));
    return source;
}
fn shares_privately_give(taken: vec4f) -> vec4f { return vec4f(taken.rgb / (1.0 + shares_privately_peak), taken.a); }",
        );
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let taken = pass.transient("taken", desc);
        pass.function(&SHADER, "shares_privately_take").write_to(taken);
        pass.function(&SHADER, "shares_privately_give").read("taken", taken).write("result", desc);
    }
}
