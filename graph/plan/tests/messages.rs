//! What requests are refused for, which nodes are skipped and why, and what reports say, in words.

use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::node::{Arg, KernelCall, Registry};
use afterimage_graph::prelude::*;
use afterimage_plan::{
    HostImageDesc, HostInputs, Options, Part, Plan, PlanDiff, PlanError, PlanRequest, Requirement, diff, plan, verify,
};

use super::support::{FRAME, all_formats, checked};

fn text(inputs: &str, nodes: &str, output: &str) -> String {
    format!(r#"Pipeline(inputs: {{ {inputs} }}, nodes: {{ {nodes} }}, outputs: {{ "out": "{output}" }})"#)
}

/// A request that gives all inputs of a graph.
fn request(graph: &Graph) -> PlanRequest<'static> {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME), finite: true };
    PlanRequest {
        given: HostInputs::all(FRAME, &graph.inputs, image),
        facts: Facts::default(),
        caps: all_formats(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    }
}

fn given<'r>(request: &'r mut PlanRequest<'static>, input: &str) -> &'r mut ImageDesc {
    &mut request.given.inputs.get_mut(input).expect("it is given").desc
}

type Change = fn(&mut PlanRequest<'static>);

/// The right request is planned; with one change it is refused in these words.
#[test]
fn what_a_request_lacks_is_told() {
    let plain = text(r#""in": Color"#, r#""a": Exposure(source: "in", stops: 1.0)"#, "a");
    let samples = text(r#""in": Color(multisampled: true)"#, r#""a": Resolve(source: "in")"#, "a");
    let volume = text(
        r#""in": Color, "depth": Data, "fog": Color(volume: true)"#,
        r#""a": VolumetricComposite(source: "in", depth: "depth", volume: "fog")"#,
        "a",
    );
    let two = text(r#""in": Color, "more": Color"#, r#""a": Composite(base: "in", bloom: "more")"#, "a");
    let table: [(&str, Change, &str); 11] = [
        (
            &two,
            |request| request.given.inputs.retain(|name, _| name != "more"),
            "the pipeline needs an image for its input `more`",
        ),
        (
            &plain,
            |request| *given(request, "in") = ImageDesc::new(FRAME).multisampled(4),
            "input `in` is not multisampled, but its image has 4 samples in each pixel: declare the input as \
             `multisampled: true`, and wire it to a `Resolve`",
        ),
        (
            &samples,
            |request| *given(request, "in") = ImageDesc::new(FRAME),
            "input `in` is multisampled, but its image has one sample in each pixel, as images of files have: a host \
             gives the image that it draws to",
        ),
        (
            &samples,
            |request| request.given.parts.extend([("in".to_owned(), Part::Rectangle)]),
            "rectangles and factors are not supported for the multisampled input `in`",
        ),
        (
            &volume,
            |request| *given(request, "fog") = ImageDesc::new(FRAME),
            "input `fog` is a volume, but its image is none: a host gives a 3-D texture",
        ),
        (
            &volume,
            |request| *given(request, "in") = ImageDesc::volume(Size::volume(4, 4, 4)),
            "input `in` is an image, but a volume is given: declare the input as `volume: true`, and wire it to a \
             `VolumetricComposite`",
        ),
        (
            &volume,
            |request| request.given.parts.extend([("fog".to_owned(), Part::Scaled)]),
            "rectangles and factors are not supported for the volume input `fog`",
        ),
        (
            &plain,
            |request| request.caps.max_side = 639,
            "image `in` is 640x360, but this device allows at most 639 texels a side",
        ),
        (
            &volume,
            |request| request.caps.max_volume_side = 8,
            "image `fog` is 9x5x3, but this device allows at most 8 texels a side",
        ),
        (
            &plain,
            |request| request.caps.max_uniform_buffers = 1,
            "pass `exposure` has 2 uniform buffers, but this device allows at most 1",
        ),
        (
            &plain,
            |request| request.caps.max_memory = 1 << 20,
            "the images of a frame take 3.6 MiB, but may take at most 1.0 MiB",
        ),
    ];
    for (text, change, message) in table {
        let graph = checked(text);
        plan(&graph, &request(&graph)).unwrap_or_else(|error| panic!("{message}: {error}"));
        let mut changed = request(&graph);
        change(&mut changed);
        let error = plan(&graph, &changed).map(|_| ()).expect_err(message).to_string();
        assert_eq!(error, message);
    }
    let graph = checked(&plain);
    let with = |change: Change| {
        let mut request = request(&graph);
        change(&mut request);
        plan(&graph, &request).map(|_| ())
    };
    assert_eq!(with(|request| request.caps.max_side = 640), Ok(()));
    assert_eq!(with(|request| request.caps.max_uniform_buffers = 2), Ok(()));
}

#[test]
fn other_errors_name_the_node_and_the_limit() {
    let node = || "soft".to_owned();
    let table = [
        (PlanError::TooMuchMemory { bytes: 3 << 30, limit: (1 << 30) - (1 << 20) }, "take 3.0 GiB, but may"),
        (PlanError::TooMuchMemory { bytes: 3 << 30, limit: (1 << 30) - (1 << 20) }, "at most 1023.0 MiB"),
        (
            PlanError::NoBands { node: node(), why: "it draws geometry".into() },
            "node `soft` cannot be made band by band: it draws geometry",
        ),
        (PlanError::NothingToShow(node()), "output `soft` comes from a node that is off and has no fallback"),
        (PlanError::UnstableHistory(node()), "the size of `soft@previous` grows from frame to frame"),
        (PlanError::TooManyPasses(node()), "the nodes up to `soft` have more than 16384 passes"),
        (PlanError::TooManyTables(node()), "the nodes up to `soft` compute more than 8 tables"),
        (
            PlanError::TooLargeTables { node: node(), bytes: 12, limit: 10 },
            "the tables of the nodes up to `soft` have 12 bytes, more than 10",
        ),
    ];
    for (error, part) in table {
        assert!(error.to_string().contains(part), "{error}");
    }
}

static SHADER: Shader = Shader::new(
    "larger.wgsl",
    "fn larger(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }
fn seen(source: vec4f) -> vec4f { return source; }",
);

node_kind! {
    /// A larger image of the frame before: no size fits it.
    pub struct Larger {}

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::Always(ColorState::Scene), "An image.")];
}

impl Node for Larger {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let Size { width, height, .. } = pass.desc(source).size;
        pass.function(&SHADER, "larger").write("result", ImageDesc::new(Size::new(width + 1, height)));
    }
}

node_kind! {
    /// A node whose readers get nothing when it does not run.
    pub struct Fades {
        pub amount: f32 = 1.0 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image."), Input::image("mask", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "An image.").or(Fallback::Absent)];
}

impl Node for Fades {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        pass.function(&SHADER, "seen").write("result", desc);
    }
}

fn own(text: &str) -> Graph {
    let kinds = [NodeKind::of::<Larger>(), NodeKind::of::<Fades>()];
    let registry = Registry::new(&[afterimage_nodes::ALL, &kinds]).expect("no two kinds share a name");
    let document = afterimage_graph::document::parse("own.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = afterimage_graph::check::CheckOptions::default();
    afterimage_graph::check::check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

#[test]
fn an_image_that_grows_from_frame_to_frame_is_refused_and_one_that_settles_is_not() {
    let history = |source: &str, nodes: &str| {
        let nodes = format!(r#""a": Larger(source: "{source}"), "b": Exposure(source: "a", stops: 1.0) {nodes}"#);
        let graph = own(&text(r#""in": Color"#, &nodes, "b"));
        plan(&graph, &request(&graph)).map(|plan| plan.image(plan.outputs[0].image).desc.size.width)
    };
    assert_eq!(history("a@previous", ""), Err(PlanError::UnstableHistory("a".into())));
    assert_eq!(history("in", ""), Ok(641));
    // Each further image of an earlier frame is one more round, and all settle.
    let chain = r#", "c": Larger(source: "in")"#;
    assert_eq!(history("c@previous", chain), Ok(642));
    let chain = r#", "c": Larger(source: "d@previous"), "d": Larger(source: "e@previous"), "e": Larger(source: "in")"#;
    assert_eq!(history("c@previous", chain), Ok(644));
}

/// What is skipped, with the reason, in the order of the plan.
fn skipped(graph: &Graph, change: impl FnOnce(&mut PlanRequest<'static>)) -> Result<Vec<String>, PlanError> {
    let mut request = request(graph);
    change(&mut request);
    let plan = plan(graph, &request)?;
    assert_eq!(verify(&plan), Ok(()));
    Ok(plan.savings.skipped.into_iter().map(|skipped| format!("{}: {}", skipped.node, skipped.why)).collect())
}

#[test]
fn every_node_that_does_not_run_is_listed_with_its_reason() {
    let lamps = text(
        r#""in": Color"#,
        r#""a": Exposure(source: "in", stops: 1.0, when: "lamps > 3"), "b": Vignette(source: "a")"#,
        "b",
    );
    let lamps = checked(&lamps);
    let lit = |lamps: f64| move |request: &mut PlanRequest<'static>| request.facts.set("lamps", lamps);
    assert_eq!(skipped(&lamps, lit(4.0)), Ok(vec![]));
    assert_eq!(skipped(&lamps, lit(3.0)), Ok(vec!["a: `when: lamps > 3` does not hold".into()]));
    let mut off = lamps.clone();
    off.nodes[0].off = true;
    assert_eq!(skipped(&off, lit(4.0)), Ok(vec!["a: switched off".into()]));
    let neutral = checked(&text(
        r#""in": Color"#,
        r#""a": Exposure(source: "in", stops: 0.0), "c": Gaussian(source: "in", sigma: 2.0),
           "b": Vignette(source: "a")"#,
        "b",
    ));
    assert_eq!(skipped(&neutral, |_| ()), Ok(vec!["a: changes nothing here".into(), "c: nobody needs it".into()]));
    // Without its image a node has nothing to give, and its readers have nothing either; without another one it gives
    // its fallback, which here is nothing, too.
    let fades = |inputs: &str, nodes: &str| own(&text(inputs, nodes, "b"));
    let faded = r#""a": Fades(source: "in", mask: "mask"), "b": Composite(base: "in", bloom: "a", strength: 0.5)"#;
    let graph = fades(r#""in": Color, "mask": Color(optional: true)"#, faded);
    assert_eq!(skipped(&graph, |_| ()), Ok(vec![]));
    let reasons =
        skipped(&graph, |request| request.given.inputs.retain(|name, _| name != "mask")).expect("`b` has a fallback");
    assert_eq!(reasons[0], "a: nothing arrives at its input `mask`");
    assert!(reasons[1].starts_with("b: "), "{reasons:?}");
    let graph = fades(
        r#""in": Color, "mask": Color"#,
        &faded.replace("base: \"in\", bloom: \"a\"", "base: \"a\", bloom: \"in\""),
    );
    let mut off = graph.clone();
    off.nodes[graph.node("a").expect("it is there").0].off = true;
    assert_eq!(skipped(&off, |_| ()), Err(PlanError::NothingToShow("out".into())));
    assert_eq!(skipped(&graph, |_| ()), Ok(vec![]));
}

/// The kernels that read the host's image of an input of that type, with a rectangle.
fn cropping(input: &str, part: Option<Part>) -> Vec<KernelCall> {
    let graph = checked(&text(
        &format!(r#""in": {input}, "scene": Color"#),
        r#""a": Composite(base: "scene", bloom: "in", strength: 0.5)"#,
        "a",
    ));
    let mut request = request(&graph);
    request.given.parts.extend(part.map(|part| ("in".to_owned(), part)));
    let plan = plan(&graph, &request).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()));
    let read = plan.inputs.iter().find(|(name, _)| name == "in").expect("it is given").1;
    for rectangle in &plan.rectangles {
        assert_eq!((rectangle.name.as_str(), rectangle.image, Some(rectangle.part)), ("in", read, part));
        assert_eq!(rectangle.scale, if input.contains("scale") { 1.5 } else { 1.0 });
    }
    assert_eq!(plan.rectangles.len(), usize::from(part.is_some()));
    let kernels = plan.work().flat_map(|pass| &pass.kernels);
    kernels.filter(|kernel| kernel.args.iter().any(|arg| arg.value == Arg::Texture(read))).cloned().collect()
}

#[test]
fn a_rectangle_is_filtered_where_it_is_scaled_and_a_factor_is_applied_once() {
    let functions = |input: &str, part: Option<Part>| -> Vec<String> {
        cropping(input, part).iter().map(|kernel| kernel.function.to_string()).collect()
    };
    assert_eq!(functions("Color", Some(Part::Rectangle)), ["crop"]);
    assert_eq!(functions("Color", Some(Part::Scaled)), ["crop_filtered"]);
    assert_eq!(functions("Color(scale: 1.5)", Some(Part::Scaled)), ["crop_filtered"]);
    let scaled = cropping("Color(scale: 1.5)", None);
    assert_eq!(scaled.iter().map(|kernel| &*kernel.function).collect::<Vec<_>>(), ["scale"]);
    assert_eq!(scaled[0].uniform[..4], 1.5_f32.to_le_bytes());
    assert!(!functions("Color", None).iter().any(|function| function == "scale"));
    let depths =
        checked(&text(r#""in": Color, "depth": Data"#, r#""a": DepthOfField(source: "in", depth: "depth")"#, "a"));
    let mut request = request(&depths);
    request.given.parts.insert("depth".into(), Part::Scaled);
    let plan = plan(&depths, &request).unwrap_or_else(|error| panic!("{error}"));
    let functions: Vec<&str> = plan.work().flat_map(|pass| &pass.kernels).map(|kernel| &*kernel.function).collect();
    assert!(!functions.contains(&"crop_filtered"), "{functions:?}");
}

#[test]
fn a_difference_is_told_in_numbers_and_percent() {
    let table = ["a: one".to_owned()];
    let change = PlanDiff {
        added: table.to_vec(),
        removed: vec!["b: two".into()],
        resized: vec![("c".into(), "1 x 1".into(), "2 x 2".into())],
        passes: (4, 5),
        batches: (3, 3),
        bytes_moved: (8 << 20, 6 << 20),
        peak_memory: (0, 1 << 20),
    };
    let expected = "passes       4 -> 5 (+25.0 %)\nbatches      3 -> 3\n\
                    bytes moved  8.0 MiB -> 6.0 MiB (-25.0 %) a frame\n\
                    peak memory  0.0 MiB -> 1.0 MiB\n- b: two\n+ a: one\n~ c: 1 x 1 -> 2 x 2\n";
    assert_eq!(change.to_string(), expected);
    let none = PlanDiff { added: vec![], removed: vec![], resized: vec![], ..change.clone() };
    let same = PlanDiff { passes: (4, 4), bytes_moved: (7, 7), peak_memory: (1 << 10, 1 << 10), ..none.clone() };
    assert!(same.is_empty() && !none.is_empty());
    assert_eq!(same.to_string(), "the plans do the same work in the same memory\n");
    let one_differs = [
        PlanDiff { added: table.to_vec(), ..same.clone() },
        PlanDiff { removed: table.to_vec(), ..same.clone() },
        PlanDiff { resized: change.resized.clone(), ..same.clone() },
        PlanDiff { passes: (4, 5), ..same.clone() },
        PlanDiff { batches: (2, 3), ..same.clone() },
        PlanDiff { bytes_moved: (7, 8), ..same.clone() },
        PlanDiff { peak_memory: (1 << 20, 1 << 10), ..same.clone() },
    ];
    assert!(one_differs.iter().all(|change| !change.is_empty()));
    let text = one_differs[6].to_string();
    assert!(text.contains("peak memory  1.0 MiB -> 0.001 MiB (-99.9 %)\n"), "{text}");
}

#[test]
fn plans_differ_in_what_was_added_removed_and_resized() {
    let plan_at = |nodes: &str, size: Size| -> Plan {
        let graph = checked(&text(r#""in": Color"#, nodes, "b"));
        let mut request = request(&graph);
        request.given.size = size;
        *given(&mut request, "in") = ImageDesc::new(size);
        plan(&graph, &request).unwrap_or_else(|error| panic!("{error}"))
    };
    let one = r#""a": Exposure(source: "in", stops: 1.0), "b": Vignette(source: "a")"#;
    let other = r#""c": Exposure(source: "in", stops: 1.0), "b": Vignette(source: "c")"#;
    let (small, large) = (plan_at(one, Size::new(64, 32)), plan_at(one, Size::new(128, 32)));
    let change = diff(&small, &large);
    assert!(change.added.is_empty() && change.removed.is_empty(), "{change}");
    let (_, before, after) = change.resized.iter().find(|(name, ..)| name == "in").expect("its size differs");
    assert!(before.starts_with("64") && after.starts_with("128") && after.ends_with("Rgba16Float"), "{change}");
    assert_eq!((change.bytes_moved.0 * 2, change.passes), (change.bytes_moved.1, (1, 1)));
    let renamed = diff(&small, &plan_at(other, Size::new(64, 32)));
    assert!(renamed.removed.iter().all(|pass| pass.starts_with('a')) && !renamed.removed.is_empty(), "{renamed}");
    assert!(renamed.added.iter().all(|pass| pass.starts_with('c')) && !renamed.added.is_empty(), "{renamed}");
}
