//! Blending: what stays of triangles that lie over each other, computed in f64.

use afterimage_graph::node::{Blend, BufferId, DepthTest, Load, Recorder, VertexFormat, WriteMask};
use afterimage_graph::prelude::*;
use afterimage_plan::verify;

use super::blend_modes::{MASKS, MODES, Mode, Written, blended};
use super::kinds::{CLEARS, FORMATS, LARGE, OTHER, PICK, RESULT, SHADER, Vertex, buffer, desc};
use super::{CENTER, SAMPLES, SIZE, all_drawn, at, drawn, graph, result};
use crate::support::gpu::{Picture, Run, gpu};
use crate::support::layer;

node_kind! {
    /// Two translucent triangles in one draw.
    pub struct Glass {
        /// The blending.
        pub mode: Mode = Mode::Over;
        /// The channels that are written.
        pub written: Written = Written::Everything;
        /// True if an opaque triangle is drawn in a pass before.
        pub before: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "What is drawn.").or(Fallback::Absent),
        Output::image("between", OutputState::Always(ColorState::Data), "What was there.").or(Fallback::Absent),
    ];
}

/// Translucent triangles.
fn panes() -> [[Vertex; 3]; 2] {
    let tint = |triangle: [Vertex; 3], alphas: [f32; 3]| {
        let mut alphas = alphas.into_iter();
        triangle.map(|(place, [red, green, blue, _])| {
            (place, [red / 8.0, green / 8.0, blue / 8.0, alphas.next().expect("three corners")])
        })
    };
    [tint(LARGE, [0.25, 0.5, 0.75]), tint(OTHER, [0.5, 0.125, 0.875])]
}

/// The image under them.
const UNDERLAY: [Vertex; 3] = [
    ([-0.671875, -0.875, 0.25], [0.75, 0.5, 0.25, 0.5]),
    ([0.765625, -0.5, 0.25], [0.25, 0.75, 0.5, 0.75]),
    ([0.15625, 0.9375, 0.25], [0.5, 0.25, 0.75, 0.25]),
];
const CLEAR: [f64; 4] = [0.25, 0.5, 0.125, 0.375];

impl Node for Glass {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        let color = pass.output("result", desc);
        let mut load = Load::Clear(CLEAR);
        if self.before {
            let vertices = buffer(pass, &UNDERLAY);
            let draw = pass.draw(&SHADER, "corner").fragment("colored").label("underlay").color(color, load);
            draw.vertices(vertices, &FORMATS).record(3, 1);
            load = Load::Keep;
        }
        if pass.is_output_used("between") {
            if !self.before {
                pass.clear("ground").color(color, load).record();
                load = Load::Keep;
            }
            pass.function(&PICK, "pick").read("source", color).write("between", desc);
        }
        let vertices = buffer(pass, &panes().concat());
        let draw = pass.draw(&SHADER, "corner").fragment("colored").label("panes").color(color, load);
        let draw = draw.blend(self.mode.blend()).writes(MASKS[self.written as usize].1);
        draw.vertices(vertices, &FORMATS).record(6, 1);
    }
}

/// The color drawn at a place of a pixel.
fn seen(pixel: (u32, u32), place: [f64; 2], blend: Blend, writes: WriteMask, has_underlay: bool) -> [f64; 4] {
    let of = |triangle: &[Vertex; 3]| at(triangle, SIZE, pixel, place).map(|(color, _)| color);
    let below = has_underlay.then(|| of(&UNDERLAY)).flatten().unwrap_or(CLEAR);
    panes().iter().filter_map(of).fold(below, |target, source| {
        let new = blended(blend, source, target);
        [0, 1, 2, 3].map(|channel| if writes.0[channel] { new[channel] } else { target[channel] })
    })
}

/// Compares each texel with what is seen in its middle. Channels that the format has not are those of a read: 0, 0, 1.
fn assert_seen(found: &Picture, channels: usize, step: f64, expected: impl Fn((u32, u32)) -> [f64; 4], what: &str) {
    for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
        let (found, expected) = (found.at(x, y), expected((x, y)));
        for channel in 0..channels {
            let (found, expected) = (f64::from(found[channel]), expected[channel]);
            assert!(
                (found - expected).abs() <= step * expected.abs().max(1.0),
                "{what} {x}, {y}: channel {channel} is {found} and not {expected}"
            );
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn triangles_are_blended_by_each_formula_and_keep_what_is_masked() {
    let mut pictures = Vec::new();
    for (mode, blend) in MODES {
        for before in [false, true] {
            let node = format!("Glass(mode: {mode}, before: {before})");
            let found = result(&node);
            let expected = |pixel| seen(pixel, CENTER, blend, WriteMask::ALL, before);
            assert_seen(&found, 4, 1e-5, expected, &node);
            pictures.push((node, found.pixels));
        }
    }
    for (at, (node, pixels)) in pictures.iter().enumerate() {
        let same = pictures[..at].iter().find(|(_, other)| other == pixels);
        assert_eq!(same.map(|(other, _)| other), None, "{node} shows the same");
    }
    for (mode, blend) in [MODES[0], MODES[1], MODES[8]] {
        for (written, writes) in MASKS {
            let node = format!("Glass(mode: {mode}, written: {written}, before: true)");
            let expected = |pixel| seen(pixel, CENTER, blend, writes, true);
            assert_seen(&result(&node), 4, 1e-5, expected, &node);
        }
    }
}

/// The picture of a plan that is not exact.
fn stored(nodes: &str) -> Picture {
    let _alone = layer::alone();
    let graph = graph(nodes, "result");
    let mut run = Run::new(&graph);
    run.size = SIZE;
    layer::messages();
    let found = run.frame(&[]).remove(0);
    assert_eq!(layer::messages(), Vec::<String>::new(), "{nodes}");
    found
}

/// Each blend is rounded to the format.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_format_of_a_color_is_blended() {
    let formats = [
        ("Rgba16Float", 4, 2.0_f64.powi(-10)),
        ("Rg16Float", 2, 2.0_f64.powi(-10)),
        ("R16Float", 1, 2.0_f64.powi(-10)),
        ("Rg11b10Ufloat", 3, 2.0_f64.powi(-5)),
        ("Rgb10a2Unorm", 3, 1.1 / 1023.0),
        ("Rgba8Unorm", 4, 1.1 / 255.0),
        ("R32Float", 1, 1e-5),
        ("Rgba32Float", 4, 1e-5),
    ];
    for (format, channels, step) in formats {
        for (mode, blend) in [MODES[1], MODES[6], MODES[8]] {
            let nodes = format!("\"result\": Glass(mode: {mode}, before: true, format: {format})");
            let has_codes = format.ends_with("Unorm");
            let limit = |number: f64| if has_codes { number.min(1.0) } else { number };
            // Codes hold nothing above 1, and each of three blends begins with what is held.
            let expected = |pixel| seen(pixel, CENTER, blend, WriteMask::ALL, true).map(limit);
            assert_seen(&stored(&nodes), channels, 3.0 * step, expected, &nodes);
        }
    }
}

node_kind! {
    /// Two translucent triangles with four samples in each pixel.
    pub struct GlassSamples {}

    const OUTPUTS: &'static [Output] =
        &[Output::new("samples", PortType::Multisampled, OutputState::Always(ColorState::Data), "The colors.")];
}

impl Node for GlassSamples {
    fn record(&self, pass: &mut Recorder<'_>) {
        let color = pass.output("samples", desc(pass).multisampled(4));
        let vertices = flat(pass);
        let draw = pass.draw(&SHADER, "corner").fragment("colored").color(color, Load::Clear(CLEAR));
        draw.blend(Blend::OVER).vertices(vertices, &FORMATS).record(6, 1);
    }
}

/// The triangles in one color each, so that it does not matter where in a pixel it is taken.
fn flat_panes() -> [[Vertex; 3]; 2] {
    panes().map(|triangle| triangle.map(|(place, _)| (place, triangle[0].1)))
}

fn flat(pass: &mut Recorder<'_>) -> BufferId {
    buffer(pass, &flat_panes().concat())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn samples_are_blended_one_by_one() {
    let nodes = "\"samples\": GlassSamples(), \"result\": Resolve(source: \"samples\", gain: 0.0)";
    let (_, found) = drawn(nodes, "result");
    let sample = |pixel, place| {
        let of = |triangle: &[Vertex; 3]| at(triangle, SIZE, pixel, place).map(|(color, _)| color);
        flat_panes().iter().filter_map(of).fold(CLEAR, |target, source| blended(Blend::OVER, source, target))
    };
    let expected = |pixel| {
        let samples = SAMPLES.map(|place| sample(pixel, place));
        [0, 1, 2, 3].map(|channel| samples.iter().map(|sample| sample[channel]).sum::<f64>() / 4.0)
    };
    // Samples have half floats also in a reference.
    assert_seen(&found, 4, 2.0 * 2.0_f64.powi(-11), expected, "samples");
}

/// What is read between two passes is what the first has drawn, also where it is blended.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_is_read_before_a_blend_is_what_was_there() {
    let nodes = "\"result\": Glass(mode: Sum, before: true)";
    let (plan, found) = all_drawn(nodes, "result,result.between");
    assert_seen(&found[0], 4, 1e-5, |pixel| seen(pixel, CENTER, Blend::ADD, WriteMask::ALL, true), "both");
    let below = |pixel| at(&UNDERLAY, SIZE, pixel, CENTER).map_or(CLEAR, |(color, _)| color);
    assert_seen(&found[1], 4, 1e-5, below, "between");
    let drawings = || plan.passes.iter().filter(|planned| planned.pass.drawing().is_some());
    assert!(drawings().all(|planned| planned.stores == [true]), "a blend needs what was stored");
    let of_one = all_drawn(nodes, "result.between").0;
    let labels: Vec<&str> = of_one.passes.iter().map(|planned| planned.pass.label.as_str()).collect();
    assert!(labels.contains(&"underlay") && !labels.contains(&"panes"), "{labels:?}");
}

node_kind! {
    /// Light upon light in an image, which kernels read that filter it or load its texels: before the last light, and
    /// after it.
    pub struct Glow {
        /// True if the image is a layer of several.
        pub layered: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "All lights.").or(Fallback::Absent),
        Output::image("first", OutputState::Always(ColorState::Data), "One light.").or(Fallback::Absent),
    ];
}

static LOAD: Shader = Shader::new(
    "draw_load.wgsl",
    "fn load(source: texture_2d<f32>, at: Point) -> vec4f { return textureLoad(source, at.pixel, 0); }",
);

/// Two of them are more than the largest half float.
const BRIGHT: f32 = 40000.0;

impl Node for Glow {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        let light = LARGE.map(|(place, _)| (place, [BRIGHT, 1.0, 0.25, 0.5]));
        let sum = pass.transient("sum", if self.layered { desc.with_layers(2) } else { desc });
        let part = sum.level(0).layer(u32::from(self.layered));
        let shine = |pass: &mut Recorder<'_>, load| {
            let vertices = buffer(pass, &light);
            let draw = pass.draw(&SHADER, "corner").fragment("colored").color(part, load);
            draw.blend(Blend::ADD).vertices(vertices, &FORMATS).record(3, 1);
        };
        shine(pass, Load::Clear(CLEARS[3]));
        let load = |pass: &mut Recorder<'_>, output| match self.layered {
            true => pass.function(&LOAD, "load").read_level("source", part).write(output, desc),
            false => pass.function(&LOAD, "load").read("source", sum).write(output, desc),
        };
        load(pass, "first");
        shine(pass, Load::Keep);
        load(pass, "result");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sums_that_are_not_finite_are_limited_where_they_are_read() {
    let _alone = layer::alone();
    // A reference holds larger sums than half floats, which some devices limit themselves.
    for (layered, exact) in [(false, false), (true, false), (false, true), (true, true)] {
        let graph = graph(&format!("\"result\": Glow(layered: {layered})"), "result,result.first");
        let mut run = Run::new(&graph);
        (run.size, run.options.exact) = (SIZE, exact);
        layer::messages();
        let found = run.frame(&[]);
        assert_eq!(layer::messages(), Vec::<String>::new());
        let covered = |pixel| at(&LARGE, SIZE, pixel, CENTER).is_some();
        for (picture, lights) in [(&found[1], 1.0), (&found[0], 2.0)] {
            let expected = |pixel| match covered(pixel) {
                true => [(7.0 + lights * f64::from(BRIGHT)).min(65504.0), lights, 0.25 * lights, 0.5 * lights],
                false => CLEARS[3],
            };
            assert_seen(
                picture,
                4,
                2.0_f64.powi(-11),
                expected,
                &format!("{lights} lights, layered: {layered}, exact: {exact}"),
            );
        }
    }
}

node_kind! {
    /// Two images in one draw, blended in two ways, with a depth.
    pub struct GlassPair {}

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "The sum.").or(Fallback::Absent),
        Output::image("rest", OutputState::Always(ColorState::Data), "The smallest.").or(Fallback::Absent),
    ];
}

static PAIR: Shader = Shader::new(
    "draw_pair.wgsl",
    "struct Corner { @builtin(position) place: vec4f, @location(0) color: vec4f }
struct Pair { @location(0) first: vec4f, @location(1) second: vec4f }
@vertex fn corner(@location(0) place: vec3f, @location(1) color: vec4f) -> Corner {
    return Corner(vec4f(place, 1.0), color);
}
@fragment fn pair(corner: Corner) -> Pair { return Pair(corner.color, 1.0 - corner.color); }",
);

impl Node for GlassPair {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        let (first, second) = (pass.output("result", desc), pass.output("rest", desc));
        let depth = pass.transient("depth", desc.format(Format::Depth32Float));
        let vertices = buffer(pass, &panes().concat());
        let draw = pass.draw(&PAIR, "corner").fragment("pair").color(first, Load::Clear(CLEAR)).blend(Blend::ADD);
        let draw = draw.color(second, Load::Clear(CLEAR)).blend(Blend::MIN).writes(WriteMask::COLOR);
        let draw = draw.depth(depth, DepthTest::default());
        draw.vertices(vertices, &[VertexFormat::Float32x3, VertexFormat::Float32x4]).record(6, 1);
    }
}

/// What lies behind is not blended, and each attachment has its own formula.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn attachments_are_blended_apart_and_hidden_fragments_not_at_all() {
    let (_, found) = all_drawn("\"result\": GlassPair()", "result,result.rest");
    let visible = |pixel| {
        let of = |triangle: &[Vertex; 3]| at(triangle, SIZE, pixel, CENTER);
        let mut nearest = 1.0;
        panes()
            .iter()
            .filter_map(of)
            .filter(move |(_, depth)| {
                let passes = *depth < nearest;
                nearest = if passes { *depth } else { nearest };
                passes
            })
            .map(|(color, _)| color)
            .collect::<Vec<_>>()
    };
    let sum = |pixel| visible(pixel).into_iter().fold(CLEAR, |target, source| blended(Blend::ADD, source, target));
    assert_seen(&found[0], 4, 1e-5, sum, "the sum");
    let least = |pixel| {
        let rest = visible(pixel).into_iter().map(|color| color.map(|channel| 1.0 - channel));
        let [red, green, blue, _] = rest.fold(CLEAR, |target, source| blended(Blend::MIN, source, target));
        [red, green, blue, CLEAR[3]]
    };
    assert_seen(&found[1], 4, 1e-5, least, "the smallest");
    let both = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
    let counts = both.fold([0; 3], |mut counts, pixel| {
        counts[visible(pixel).len()] += 1;
        counts
    });
    assert!(counts.iter().all(|count| *count > 50), "pixels with 0, 1 and 2 visible triangles: {counts:?}");
}

node_kind! {
    /// Shows an image.
    pub struct Show {}

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.").accepts(&[ColorState::Data])];
    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for Show {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        pass.function(&PICK, "pick").write("result", desc);
    }
}

/// A history of an image into which several passes draw has what the last of them left.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_later_frame_sees_all_that_was_blended() {
    let _alone = layer::alone();
    let nodes = "\"pane\": Glass(mode: Sum, before: true), \"past\": Show(source: \"pane@previous\")";
    let graph = graph(nodes, "past,pane");
    let mut run = Run::new(&graph).exact();
    run.size = SIZE;
    verify(&run.plan(&gpu(), &[])).unwrap_or_else(|faults| panic!("{faults:?}"));
    layer::messages();
    let frames = run.frames(&[], &[(0.0, true), (0.1, false), (0.1, false)]);
    assert_eq!(layer::messages(), Vec::<String>::new());
    let sum = |pixel| seen(pixel, CENTER, Blend::ADD, WriteMask::ALL, true);
    for (number, pictures) in frames.iter().enumerate() {
        let past = |pixel| if number == 0 { [0.0; 4] } else { sum(pixel) };
        assert_seen(&pictures[0], 4, 1e-5, past, &format!("the past in frame {number}"));
        assert_seen(&pictures[1], 4, 1e-5, sum, &format!("frame {number}"));
    }
}
