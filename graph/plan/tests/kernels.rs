//! What kernels read and promise: how many of them make a pass, how its module runs, and what is halved by rows.

use afterimage_graph::check::{CheckOptions, Facts, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, PassKind, Registry, folder_kind_of};
use afterimage_graph::prelude::*;
use afterimage_plan::{Caps, Options, When};

use super::fusion::{RESULT, SOURCE, kind, like_source, planned_at};
use super::support::{FRAME, all_formats, plan_images};

static MANY: Shader = Shader::new(
    "many",
    "fn soft(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return tap(source, source_sampler, at.uv);
    }
    fn far(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return tap(source, source_sampler, vec2f(1.0) - at.uv);
    }
    fn with_four(source: vec4f, a: texture_2d<f32>, b: texture_2d<f32>, c: texture_2d<f32>, at: Point) -> vec4f {
        return source + texel(a, at.pixel) + texel(b, at.pixel) + texel(c, at.pixel);
    }
    fn with_five(
        source: vec4f, a: texture_2d<f32>, b: texture_2d<f32>, c: texture_2d<f32>, d: texture_2d<f32>, at: Point,
    ) -> vec4f {
        return with_four(source, a, b, c, at) + texel(d, at.pixel);
    }",
);

const A: Input = Input::image("a", "An image.");
const B: Input = Input::image("b", "An image.");
const C: Input = Input::image("c", "An image.");
const D: Input = Input::image("d", "An image.");
kind!(Four, "Reads a pixel and three other images.", [SOURCE, A, B, C], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&MANY, "with_four").write("result", desc);
});
kind!(Five, "Reads a pixel and four other images.", [SOURCE, A, B, C, D], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&MANY, "with_five").write("result", desc);
});
kind!(Asked, "Reads from anywhere if a format is asked for.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let function = if pass.format == Some(Format::Rgba32Float) { "far" } else { "soft" };
    pass.function(&MANY, function).write("result", desc);
});

pub const KINDS: &[NodeKind] = &[
    NodeKind::of::<Four>(),
    NodeKind::of::<Five>(),
    NodeKind::of::<Asked>(),
    NodeKind::of::<super::drawing::Panes>(),
    NodeKind::of::<super::drawing::Sums>(),
    NodeKind::of::<super::drawing::Layers>(),
];

/// A device binds 16 textures in a pass: the framework uses up to 12 in one that it fuses.
#[test]
fn passes_are_fused_as_long_as_all_that_they_read_can_be_bound() {
    let four = |name: &str, source: &str| format!(r#""{name}": Four(source: "{source}", a: "in", b: "in", c: "in"), "#);
    let five = |name: &str, source: &str| {
        format!(r#""{name}": Five(source: "{source}", a: "in", b: "in", c: "in", d: "in"), "#)
    };
    let passes = |nodes: String, last: &str| {
        let plan = planned_at(FRAME, &nodes, &format!(r#""out": "{last}""#), Options::default());
        plan.work().map(|pass| pass.kernels.len()).collect::<Vec<_>>()
    };
    assert_eq!(passes(four("x", "in") + &four("y", "x"), "y"), [2], "eight");
    // A pixel that a fused kernel makes is not read: two fused passes read one image less.
    assert_eq!(passes(four("x", "in") + &four("y", "x") + &five("z", "y"), "z"), [3], "twelve");
    assert_eq!(passes(five("x", "in") + &four("y", "x") + &five("z", "y"), "z").len(), 2, "thirteen");
    let many: String = (1..6).map(|at| five(&format!("n{at}"), &format!("n{}", at - 1))).collect();
    assert!(passes(five("n0", "in") + &many, "n5").iter().all(|kernels| *kernels <= 2));
}

#[test]
fn a_kind_is_told_which_format_the_file_asks_for() {
    for (format, function) in [("", "soft"), (", format: Rgba32Float", "far"), (", format: Rgba16Float", "soft")] {
        let node = format!(r#""a": Asked(source: "in"{format})"#);
        let plan = planned_at(FRAME, &node, r#""out": "a""#, Options::default());
        assert_eq!(&*plan.passes[0].pass.kernels[0].function, function, "{format}");
    }
}

/// A driver clears the memory of a workgroup for a kernel that nobody vouches for, and for no other one.
#[test]
fn what_a_kernel_promises_decides_how_its_module_runs() {
    let nodes = r#""late": Late(source: "in"), "soft": Soft(source: "late"), "dim": Dim(source: "soft"),
        "half": Downsample(source: "dim", levels: 1), "mean": MeanLuminance(source: "half.coarsest"),
        "meter": Adapt(mean: "mean"), "out": Exposure(source: "dim", meter: "meter")"#;
    let plan = planned_at(FRAME, nodes, r#""out": "out""#, Options { fuse: false, ..Options::default() });
    let mut seen = [0; 3];
    for (number, pass) in plan.work().enumerate() {
        let composed = plan.compose(number, Default::default()).unwrap_or_else(|error| panic!("{error}"));
        let is_own = pass.nodes.iter().all(|node| ["late", "soft", "dim"].contains(&node.as_str()));
        assert_eq!(composed.unchecked, !is_own, "{}", pass.label);
        assert_eq!(composed.zero_workgroup_memory, pass.nodes == ["late"], "{}", pass.label);
        seen[if is_own { usize::from(pass.nodes == ["late"]) } else { 2 }] += 1;
    }
    assert!(seen[0] == 2 && seen[1] == 2 && seen[2] >= 3, "{seen:?}\n{}", plan.to_text());
}

/// At every size but where a side has one texel, which is not halved.
#[test]
fn an_image_with_an_odd_side_is_halved_by_rows() {
    let half = r#""soft": Soft(source: "in"), "half": Downsample(source: "soft", levels: 1),
        "out": Far(source: "half.coarsest")"#;
    let halved = |(width, height)| {
        let options = Options { row_downsample: When::Always, ..Options::default() };
        let plan = planned_at(Size::new(width, height), half, r#""out": "out""#, options);
        plan.work().find_map(|pass| match pass.kind {
            PassKind::RowDownsample(rows) => Some(rows.odd),
            _ => None,
        })
    };
    for (size, odd) in [((640, 360), [0, 0]), ((641, 360), [1, 0]), ((640, 361), [0, 1]), ((3, 361), [1, 1])] {
        assert_eq!(halved(size), Some(odd), "{size:?}");
    }
    assert_eq!([(1, 360), (640, 1), (1, 1)].map(halved), [None; 3]);
}

/// Neighbors hand each other texels as half floats.
#[test]
fn images_of_floats_are_not_halved_by_rows() {
    let halved = |soft: &str, half: &str| {
        let nodes = format!(
            r#""soft": Soft(source: "in"{soft}), "half": Downsample(source: "soft", levels: 1{half}),
            "out": Far(source: "half.coarsest")"#
        );
        let options = Options { row_downsample: When::Always, ..Options::default() };
        let plan = planned_at(FRAME, &nodes, r#""out": "out""#, options);
        plan.work().any(|pass| matches!(pass.kind, PassKind::RowDownsample(_)))
    };
    let floats = ", format: Rgba32Float";
    assert_eq!([halved("", ""), halved(floats, ""), halved("", floats)], [true, false, false]);
}

/// A kind without Rust whose function sums texels of its source by these lines.
fn reading(lines: &str) -> NodeKind {
    let text = r#"Kind(name: "Reading", doc: "Reads an image.",
        inputs: { "source": Image(doc: "An image.") },
        outputs: { "result": Image(doc: "The sum.", state: Same("source")) })"#;
    let shader = format!(
        "fn read(t: texture_2d<f32>, p: vec2i) -> vec4f {{ return texel(t, p); }}
fn reading(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {{
    var sum = vec4f();
    let p = at.pixel;
    {lines}
    return sum;
}}"
    );
    folder_kind_of(("node.ron", text), &[("reading.wgsl", &shader)]).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Nine texels at most, and none that is filtered; on a processor none.
#[test]
fn an_untrusted_function_repairs_a_few_texels_itself_and_reads_a_copy_for_many() {
    let square =
        "for (var y = -1; y <= 1; y++) { for (var x = -1; x <= 1; x++) { sum += read(source, p + vec2i(x, y)); } }";
    for (lines, has_copy) in [
        ("sum = texel(source, p + 1);", false),
        (square, false),
        (&format!("{square} sum += texel(source, p);"), true),
        (&square.replace("y <= 1", "y <= 2"), true),
        (&square.replace("y <= 1", "y <= p.x"), true),
        ("sum = tap(source, source_sampler, at.uv);", true),
        ("sum = textureLoad(source, p, 0);", true),
    ] {
        let kinds = [reading(lines)];
        let registry = Registry::new(&[&kinds]).expect("one kind");
        let text = r#"Pipeline(inputs: { "in": Color }, nodes: { "a": Reading(source: "in") }, outputs: { "a": "a" })"#;
        let document = parse("reading.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
        let (graph, _) =
            check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
        for (fast_workgroup_memory, has_copy) in [(true, has_copy), (false, true)] {
            let caps = Caps { fast_workgroup_memory, ..all_formats() };
            let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), caps, Options::default());
            let copies = plan.work().filter(|pass| pass.label == "sanitize").count();
            assert_eq!(copies, usize::from(has_copy), "{lines}\n{}", plan.to_text());
        }
    }
}
