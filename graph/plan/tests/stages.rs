//! What single stages of the planner must not do, on the smallest graphs that show it. `measurements/faults.md` lists
//! the faults that these tests notice.

use std::sync::atomic::{AtomicUsize, Ordering};

use afterimage_generators::Recipe;
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{Arg, KernelCall, NodeKind, Pass, PassKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_plan::{
    HostImageDesc, HostInputs, Options, Plan, PlanError, PlanRequest, PlannedImage, Requirement, When, plan, verify,
};
use afterimage_wgsl::SampleMode;

use super::support::{FRAME, all_formats, attempt, built_in, plan_of};

static PIXELS: Shader = Shader::new(
    "pixels",
    "fn dim(source: vec4f) -> vec4f { return 0.5 * source; }
    fn sum(source: vec4f, other: vec4f) -> vec4f { return source + other; }
    fn corner(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }",
);
static RAW: Shader = Shader::new(
    "raw",
    "fn raw(source: texture_2d<f32>, at: Point) -> vec4f { return textureLoad(source, at.pixel, 0); }",
);
static KEEP: Shader = Shader::new(
    "keep",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;
    @group(0) @binding(2) var<storage, read> before: array<vec4f>;
    @group(0) @binding(3) var<storage, read_write> kept: array<vec4f>;
    @compute @workgroup_size(1)
    fn keep_show(@builtin(global_invocation_id) id: vec3u) {
        textureStore(result, id.xy, texel(source, vec2i(id.xy)) + before[0]);
    }
    @compute @workgroup_size(1)
    fn keep_store() { kept[0] = texel(source, vec2i(0)); }",
);
const SOURCE: Input = Input::image("source", "An image.");
const RESULT: Output = Output::image("result", OutputState::same("source"), "An image.").or_input("source");

node_kind! {
    /// Two images, each made only where it is used.
    pub struct Pair {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] =
        &[RESULT, Output::image("other", OutputState::same("source"), "An image.").or_input("source")];
}

impl Node for Pair {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        for port in ["result", "other"] {
            if pass.is_output_used(port) {
                pass.function(&PIXELS, "dim").label(port).write(port, desc);
            }
        }
    }
}

node_kind! {
    /// Light, and its glow alone: the glow of a node that is off is black.
    pub struct Glow {
        /// The share of the glow in the result. At 0 the result is the source, and the glow is what it was.
        pub amount: f32 = 1.0 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[RESULT, Output::image("glow", OutputState::same("source"), "An image.")];
}

impl Node for Glow {
    fn identity_of(&self, output: &str, _: &InputValues) -> bool {
        output == "result" && self.amount == 0.0
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        for port in ["result", "glow"] {
            pass.function(&PIXELS, "dim").label(port).write(port, desc);
        }
    }
}

node_kind! {
    /// A quarter of the image.
    pub struct Corner {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("source"), "An image.")];
}

impl Node for Corner {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source).half();
        pass.function(&PIXELS, "corner").write("result", desc);
    }
}

node_kind! {
    /// Adds what it has kept of the frame before, and then keeps something of this one.
    pub struct Keep {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[RESULT];
}

impl Node for Keep {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let kept = pass.add_buffer("kept", 16, BufferLife::Persistent);
        let result = pass.output("result", desc);
        let groups = [desc.size.width, desc.size.height, 1];
        pass.compute(&KEEP, "keep_show").image("result", result).buffer("before", kept).dispatch(groups);
        pass.compute(&KEEP, "keep_store").buffer("kept", kept).dispatch([1, 1, 1]);
    }
}

node_kind! {
    /// The sum of two pixels.
    pub struct Sum {}

    const INPUTS: &'static [Input] = &[SOURCE, Input::image("other", "An image.")];
    const OUTPUTS: &'static [Output] = &[RESULT];
}

impl Node for Sum {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        pass.function(&PIXELS, "sum").write("result", desc);
    }
}

node_kind! {
    /// Loads a texel without the library.
    pub struct Raw {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[RESULT];
}

impl Node for Raw {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        pass.function(&RAW, "raw").write("result", desc);
    }
}

node_kind! {
    /// A table of 5 MiB that takes long to compute.
    pub struct Table {}

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[RESULT];
}

/// How many tables have been computed.
static COMPUTED: AtomicUsize = AtomicUsize::new(0);

impl Node for Table {
    fn record(&self, pass: &mut Recorder<'_>) {
        let table = ImageDesc::new(Size::new(1024, 640));
        pass.computed("table", table, || {
            COMPUTED.fetch_add(1, Ordering::Relaxed);
            vec![1; table.bytes() as usize]
        });
        let source = pass.image("source");
        let desc = pass.desc(source);
        pass.function(&PIXELS, "dim").write("result", desc);
    }
}

const KINDS: &[NodeKind] = &[
    NodeKind::of::<Pair>(),
    NodeKind::of::<Glow>(),
    NodeKind::of::<Corner>(),
    NodeKind::of::<Keep>(),
    NodeKind::of::<Sum>(),
    NodeKind::of::<Raw>(),
    NodeKind::of::<Table>(),
];

fn graph(nodes: &str, outputs: &str) -> Graph {
    let text = format!("Pipeline(inputs: {{\"in\": Color}}, nodes: {{{nodes}}}, outputs: {{{outputs}}})");
    let document = parse("stages.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL, KINDS]).expect("no two kinds share a name");
    check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// The plan of these nodes, for an image of the host that may hold any number.
fn planned(nodes: &str, outputs: &str) -> Plan {
    let plan = attempted(nodes, outputs).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()));
    plan
}

fn attempted(nodes: &str, outputs: &str) -> Result<Plan, PlanError> {
    let options = Options { row_downsample: When::Never, ..Options::default() };
    attempt(&graph(nodes, outputs), Format::Rgba16Float, Facts::default(), (all_formats(), options))
}

#[test]
fn a_table_beyond_the_limit_is_refused_before_it_is_computed() {
    let table = |at, source| format!(r#""t{at}": Table(source: "{source}"), "#);
    let (one, two) = (table(0, "in"), table(0, "in") + &table(1, "t0"));
    planned(&one, r#""out": "t0""#);
    assert_eq!(COMPUTED.load(Ordering::Relaxed), 1);
    let error = attempted(&two, r#""out": "t1""#).expect_err("two tables of 5 MiB");
    assert_eq!(error, PlanError::TooLargeTables { node: "t1".into(), bytes: 10 << 20, limit: 8 << 20 });
    assert_eq!(COMPUTED.load(Ordering::Relaxed), 2, "the second table was computed");
}

/// The place of the pass that calls a function.
fn place(plan: &Plan, function: &str) -> usize {
    let calls = |pass: &Pass| pass.kernels.iter().any(|kernel| &*kernel.function == function);
    plan.work().position(calls).unwrap_or_else(|| panic!("no pass calls `{function}`:\n{}", plan.to_text()))
}

#[test]
fn every_wanted_output_of_a_node_is_made_and_no_other() {
    let labels = |outputs| {
        let plan = planned(r#""pair": Pair(source: "in")"#, outputs);
        let mut labels: Vec<String> = plan.work().map(|pass| pass.label.clone()).collect();
        labels.sort();
        labels
    };
    assert_eq!(labels(r#""a": "pair", "b": "pair.other""#), ["other", "result"]);
    assert_eq!(labels(r#""b": "pair.other", "a": "pair""#), ["other", "result"]);
    assert_eq!(labels(r#""b": "pair.other""#), ["other"]);
}

#[test]
fn a_pass_that_only_feeds_the_next_frame_stays_after_the_pass_that_reads_the_one_before() {
    let plan = planned(r#""keep": Keep(source: "in")"#, r#""out": "keep""#);
    let (show, store) = (place(&plan, "keep_show"), place(&plan, "keep_store"));
    let batch = |pass: usize| plan.batches.iter().position(|batch| batch.passes.contains(&pass));
    assert!(batch(show) < batch(store), "the kept value is replaced before it is read:\n{}", plan.to_text());
}

/// What the arguments of the kernels of a pass hold that come from other kernels.
fn earlier(pass: &Pass) -> Vec<Vec<usize>> {
    let of_kernel = |kernel: &KernelCall| {
        let numbers = kernel.args.iter().filter_map(|arg| if let Arg::Kernel(k) = arg.value { Some(k) } else { None });
        numbers.collect()
    };
    pass.kernels.iter().map(of_kernel).collect()
}

#[test]
fn a_fused_kernel_reads_the_kernel_that_made_its_pixel() {
    let chain = r#""a": Pair(source: "in"), "b": Saturation(source: "a", amount: 0.5), "c": Pair(source: "b"),
        "d": Saturation(source: "c", amount: 0.25)"#;
    let plan = planned(chain, r#""out": "d""#);
    let [pass] = plan.work().collect::<Vec<_>>()[..] else { panic!("one pass:\n{}", plan.to_text()) };
    assert_eq!(earlier(pass), [vec![], vec![0], vec![1], vec![2]]);
}

/// The second producer moves the kernels of its reader, one of which reads the first producer.
#[test]
fn a_kernel_of_two_pixels_reads_the_two_kernels_that_made_them() {
    let both =
        r#""a": Pair(source: "in"), "b": Saturation(source: "in", amount: 0.5), "c": Sum(source: "a", other: "b")"#;
    let plan = planned(both, r#""out": "c""#);
    let [pass] = plan.work().collect::<Vec<_>>()[..] else { panic!("one pass:\n{}", plan.to_text()) };
    let [.., sum] = pass.kernels.as_slice() else { panic!("a pass has kernels") };
    let made = |argument: &str| match sum.arg(argument) {
        Some(Arg::Kernel(kernel)) => pass.kernels[kernel].node.as_str(),
        other => panic!("{other:?}"),
    };
    assert_eq!((made("source"), made("other"), pass.kernels.len()), ("a", "b", 3));
}

#[test]
fn two_outputs_of_one_node_are_two_images() {
    let plan = planned(r#""a": Pair(source: "in")"#, r#""x": "a", "y": "a""#);
    let [x, y] = plan.outputs.as_slice() else { panic!("two outputs") };
    assert_ne!(x.image, y.image, "the host gets a texture for each output");
}

#[test]
fn a_history_has_the_size_of_what_it_is_the_past_of() {
    let plan = planned(
        r#""small": Corner(source: "in"), "lit": Composite(base: "in", bloom: "small@previous")"#,
        r#""out": "lit""#,
    );
    let past = |image: &PlannedImage| Some((image.desc, plan.image(image.origin.previous_of()?).desc));
    let pasts: Vec<_> = plan.images.iter().filter_map(past).collect();
    assert_eq!(pasts, [(ImageDesc::new(FRAME.half()), ImageDesc::new(FRAME.half()))]);
}

/// At its neutral value the node is an identity, but its result of the frame before is asked for.
#[test]
fn a_node_whose_past_is_read_runs_also_where_it_changes_nothing() {
    let nodes =
        r#""same": Saturation(source: "in", amount: 1.0), "lit": Composite(base: "in", bloom: "same@previous")"#;
    let plan = planned(nodes, r#""out": "lit""#);
    assert!(plan.work().any(|pass| pass.nodes.contains(&"same".to_owned())), "{}", plan.to_text());
}

/// The passes of the node `glow` in a plan, and why nodes are skipped.
fn glowing(nodes: &str, outputs: &str) -> (usize, Vec<String>) {
    let plan = planned(nodes, outputs);
    let passes = plan.work().filter(|pass| pass.nodes.iter().any(|node| node == "glow")).count();
    (passes, plan.savings.skipped.iter().map(|skipped| format!("{}: {}", skipped.node, skipped.why)).collect())
}

#[test]
fn each_output_of_a_node_that_is_off_has_its_own_fallback() {
    let nodes = r#""glow": Glow(source: "in"), "blur": Gaussian(source: "glow.glow"),
        "lit": Composite(base: "glow", bloom: "blur")"#;
    let off = r#""out": "lit"}, set: {"glow": Off"#;
    let reasons = ["glow: switched off", "blur: changes nothing here", "lit: changes nothing here"];
    assert_eq!(glowing(nodes, off), (0, reasons.map(String::from).into()));
    let source = planned(nodes, off);
    let Some(Arg::Pixel(read)) =
        source.work().next().and_then(|pass| pass.kernels[0].args.first()).map(|arg| arg.value)
    else {
        panic!("{}", source.to_text())
    };
    assert_eq!(read, source.inputs[0].1, "the result of the node that is off is its source");
}

#[test]
fn an_output_that_equals_its_fallback_is_replaced_although_the_node_runs_for_another() {
    let neutral = r#""glow": Glow(source: "in", amount: 0.0)"#;
    assert_eq!(glowing(neutral, r#""out": "glow""#), (0, vec!["glow: nobody needs it".into()]));
    let plan = planned(&format!(r#"{neutral}, "sum": Sum(source: "glow", other: "glow.glow")"#), r#""out": "sum""#);
    let sum = plan.work().flat_map(|pass| &pass.kernels).find(|kernel| &*kernel.function == "sum").expect("it runs");
    assert_eq!(sum.arg("source"), Some(Arg::Pixel(plan.inputs[0].1)), "{}", plan.to_text());
    assert!(matches!(sum.arg("other"), Some(Arg::Kernel(_) | Arg::Pixel(_))), "{}", plan.to_text());
    assert_eq!(glowing(&neutral.replace("0.0", "1.0"), r#""out": "glow""#), (1, Vec::new()));
}

#[test]
fn every_kernel_of_a_fused_pass_is_read_by_a_later_one() {
    let built_in = ["tsushima.ron", "lynx.ron", "caracal.ron", "grade.ron"].map(|name| {
        let options = Options { row_downsample: When::Never, ..Options::default() };
        super::support::plan_images(&built_in(name), Format::Rgba32Float, Facts::default(), all_formats(), options)
    });
    let recipe = |seed| Recipe { seed, nodes: 60, histories: 2, off: 5 };
    let random = (0..20).map(|seed| plan_of(recipe(seed), Options::default()).expect("the graph can be planned"));
    let mut joints = 0;
    for plan in built_in.into_iter().chain(random) {
        let fused = plan.work().filter(|pass| matches!(pass.kind, PassKind::Point | PassKind::Gather));
        for pass in fused {
            let earlier = earlier(pass);
            for (index, numbers) in earlier.iter().enumerate() {
                assert!(numbers.iter().all(|number| *number < index), "{}: {earlier:?}", pass.label);
                joints += numbers.len();
            }
            let last = pass.kernels.len() - 1;
            let is_read = |kernel: usize| earlier.iter().flatten().any(|number| *number == kernel);
            assert!((0..last).all(is_read), "{}: {earlier:?}", pass.label);
        }
    }
    assert!(joints > 100, "only {joints} kernels read others");
}

#[test]
fn functions_sanitize_what_they_read_of_the_host() {
    let plan = planned(r#""a": Pair(source: "in"), "b": Gaussian(source: "in")"#, r#""a": "a", "b": "b""#);
    let host = plan.inputs[0].1;
    assert_eq!(plan.image(host).sample_mode, SampleMode::SanitizedLight);
    for (index, pass) in plan.work().enumerate() {
        let reads_host = pass.args().filter_map(Arg::read).any(|read| read.image() == Some(host));
        let source = plan.compose(index, Default::default()).unwrap_or_else(|error| panic!("{error}")).source;
        let sanitizes = source.contains("TEXEL_SANITIZE: u32 = 3u") || source.contains(", at0.pixel, host0_0, 3u)");
        assert_eq!(sanitizes, reads_host, "{}:\n{source}", pass.label);
    }
}

/// The plan of a node for an image of the host at 1920x1080.
fn large(node: &str, finite: bool) -> Plan {
    let size = Size::new(1920, 1080);
    let image = HostImageDesc { desc: ImageDesc::new(size), finite };
    let request = PlanRequest {
        given: HostInputs { inputs: [("in".to_owned(), image)].into(), ..HostInputs::none(size) },
        facts: Facts::default(),
        caps: all_formats(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    let plan = plan(&graph(&format!(r#""a": {node}"#), r#""a": "a""#), &request);
    plan.unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_pixels_of_an_invocation_are_loaded_before_one_is_examined() {
    let plan = large(r#"Exposure(source: "in", stops: 1.0)"#, false);
    let source = plan.compose(0, Default::default()).unwrap_or_else(|error| panic!("{error}")).source;
    let entry = source.split("@compute").nth(1).and_then(|code| code.split("@vertex").next()).expect("an entry point");
    let loads: Vec<usize> = entry.match_indices("textureLoad").map(|(at, _)| at).collect();
    let examined = entry.find("sanitize").expect("the pixels are examined");
    // The last one is that of a pixel that is made again.
    assert!(loads.len() == 5 && loads[..4].iter().all(|at| *at < examined), "{entry}");
}

#[test]
fn texels_that_are_examined_one_by_one_leave_an_invocation_one_texel() {
    let node = r#"Extract(source: "in", fireflies: Limit)"#;
    let [repaired, finite] = [false, true].map(|finite| large(node, finite).passes[0].workgroups);
    assert_eq!((repaired, finite), ([120, 135, 1], [120, 34, 1]));
}

#[test]
fn functions_that_load_texels_themselves_share_a_sanitized_copy() {
    let plan = planned(r#""a": Raw(source: "in"), "b": Raw(source: "in")"#, r#""a": "a", "b": "b""#);
    let host = plan.inputs[0].1;
    let copy = plan.work().find(|pass| pass.label == "sanitize").and_then(Pass::written_image).expect("a copy is made");
    let readers = |image| plan.work().filter(|pass| pass.args().any(|arg| arg == Arg::Texture(image))).count();
    assert_eq!((readers(host), readers(copy), plan.passes.len()), (0, 2, 3), "{}", plan.to_text());
}
