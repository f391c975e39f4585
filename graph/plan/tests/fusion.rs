//! What fusion must not do, on the smallest graphs that show it. `measurements/faults.md` lists the faults that these
//! tests notice.

use afterimage_graph::check::{CheckOptions, Facts, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Pass, PassKind, Registry, Resource};
use afterimage_graph::prelude::*;
use afterimage_plan::{
    Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, PlannedPass, Requirement, When, plan, verify,
};

use super::support::{FRAME, all_formats};

static SOFT: Shader = Shader::new(
    "soft",
    "fn soft(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return 0.5 * (tap(source, source_sampler, at.uv) + tap(source, source_sampler, at.uv + 0.5 / at.size));
    }
    fn far(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return tap(source, source_sampler, vec2f(1.0) - at.uv);
    }
    fn beside(source: texture_2d<f32>, source_sampler: sampler, at: Point, other: vec4f) -> vec4f {
        return other + tap(source, source_sampler, at.uv);
    }
    fn dim(source: vec4f) -> vec4f { return 0.5 * source; }",
);
static LATE: Shader = Shader::new(
    "late",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;
    @group(0) @binding(2) var<storage, read> before: array<vec4f>;
    @compute @workgroup_size(1)
    fn late_show(@builtin(global_invocation_id) id: vec3u) {
        textureStore(result, id.xy, texel(source, vec2i(id.xy)) + before[0]);
    }",
);
// It reads no image, so nothing but the buffer orders it.
static STORE: Shader = Shader::new(
    "store",
    "@group(0) @binding(0) var<storage, read_write> kept: array<vec4f>;
    @compute @workgroup_size(1)
    fn late_store() { kept[0] = kept[0] + vec4f(1.0); }",
);
static METER: Shader = Shader::new(
    "meter",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var<storage, read_write> value: array<vec4f>;
    @compute @workgroup_size(1)
    fn meter() { value[0] = texel(source, vec2i(0)); }",
);
pub const SOURCE: Input = Input::image("source", "An image.");
pub const RESULT: Output = Output::image("result", OutputState::same("source"), "An image.");

/// Declares a kind of this test.
macro_rules! kind {
    ($kind:ident, $doc:literal, [$($input:expr),*], $output:expr, $record:expr) => {
        node_kind! {
            #[doc = $doc]
            pub struct $kind {}

            const INPUTS: &'static [Input] = &[$($input),*];
            const OUTPUTS: &'static [Output] = &[$output];
        }
        impl Node for $kind {
            fn record(&self, pass: &mut Recorder<'_>) {
                let record: fn(&mut Recorder<'_>) = $record;
                record(pass)
            }
        }
    };
}

pub(crate) use kind;

/// The description of an image as large as the source.
pub fn like_source(pass: &mut Recorder<'_>) -> ImageDesc {
    let source = pass.image("source");
    ImageDesc::new(pass.desc(source).size)
}

kind!(Soft, "Reads its neighbors.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&SOFT, "soft").write("result", desc);
});
kind!(Far, "Reads from anywhere.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&SOFT, "far").write("result", desc);
});
kind!(
    Beside,
    "Reads one image around the pixel, and the pixel of another.",
    [SOURCE, Input::image("other", "An image.")],
    RESULT,
    |pass| {
        let desc = like_source(pass);
        pass.function(&SOFT, "beside").write("result", desc);
    }
);
kind!(Dim, "Reads one pixel.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    pass.function(&SOFT, "dim").write("result", desc);
});
kind!(Late, "Shows what it has kept, and then counts on.", [SOURCE], RESULT, |pass| {
    let desc = like_source(pass);
    let kept = pass.add_buffer("kept", 16, BufferLife::Persistent);
    let result = pass.output("result", desc);
    let groups = [desc.size.width, desc.size.height, 1];
    pass.compute(&LATE, "late_show").image("result", result).buffer("before", kept).dispatch(groups);
    pass.compute(&STORE, "late_store").buffer("kept", kept).dispatch([1, 1, 1]);
});
kind!(
    Meter,
    "A value of an image.",
    [SOURCE],
    Output::new("result", PortType::Value, OutputState::Always(ColorState::Data), "A value."),
    |pass| {
        let value = pass.add_buffer("value", 16, BufferLife::Frame);
        pass.compute(&METER, "meter").buffer("value", value).dispatch([1, 1, 1]);
        pass.set_output("result", InputValue::Buffer(value));
    }
);

const KINDS: &[NodeKind] = &[
    NodeKind::of::<Soft>(),
    NodeKind::of::<Far>(),
    NodeKind::of::<Beside>(),
    NodeKind::of::<Dim>(),
    NodeKind::of::<Late>(),
    NodeKind::of::<Meter>(),
];

/// The plan of these nodes for a frame of that size, on a device with fast workgroup memory.
pub fn planned_at(size: Size, nodes: &str, outputs: &str, options: Options) -> Plan {
    planned_on(size, nodes, outputs, options, Caps { fast_workgroup_memory: true, ..all_formats() })
}

/// The plan of these nodes for a frame of that size and a device.
pub fn planned_on(size: Size, nodes: &str, outputs: &str, options: Options, caps: Caps) -> Plan {
    let text = format!("Pipeline(inputs: {{\"in\": Color}}, nodes: {{{nodes}}}, outputs: {{{outputs}}})");
    let document = parse("fusion.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry =
        Registry::new(&[afterimage_nodes::ALL, KINDS, super::kernels::KINDS]).expect("no two kinds share a name");
    let graph = check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0;
    let image = HostImageDesc { desc: ImageDesc::new(size), finite: true };
    let given = HostInputs { inputs: [("in".to_owned(), image)].into(), ..HostInputs::none(size) };
    let (facts, dynamic, requirement) = (Facts::default(), Default::default(), &Requirement::typical);
    let request = PlanRequest { given, facts, caps, options, dynamic, requirement };
    let plan = plan(&graph, &request).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()), "{}", plan.to_text());
    plan
}

/// The plan with halvings by rows wherever they are possible, and nothing else fused.
fn by_rows_only(nodes: &str, outputs: &str) -> Plan {
    let options = Options { fuse: false, row_downsample: When::Always, ..Options::default() };
    planned_at(FRAME, nodes, outputs, options)
}

/// The passes that halve by rows, with their kernels.
fn by_rows(plan: &Plan) -> Vec<usize> {
    let rows = plan.work().filter(|pass| matches!(pass.kind, PassKind::RowDownsample(_)));
    rows.map(|pass| pass.kernels.len()).collect()
}

#[test]
fn a_halving_makes_its_source_itself_only_if_nothing_else_reads_it() {
    let half = r#""a": Dim(source: "in"), "half": Downsample(source: "a", levels: 1),
        "out": Far(source: "half.coarsest")"#;
    let plan = by_rows_only(half, r#""out": "out""#);
    assert_eq!((by_rows(&plan), plan.passes.len()), (vec![2], 2), "{}", plan.to_text());
    let shared = format!(r#"{half}, "far": Far(source: "a")"#);
    let plan = by_rows_only(&shared, r#""out": "out", "far": "far""#);
    assert_eq!((by_rows(&plan), plan.passes.len()), (vec![2], 4), "{}", plan.to_text());
    let remembered = format!(r#"{half}, "past": Far(source: "a@previous")"#);
    let plan = by_rows_only(&remembered, r#""out": "out", "past": "past""#);
    assert_eq!((by_rows(&plan), plan.passes.len()), (vec![2], 4), "{}", plan.to_text());
}

/// Lights without fireflies, halved; they stand between these nodes.
fn lights(before: &str, extract: &str, after: &str, outputs: &str) -> Plan {
    let nodes = format!(
        r#"{before} "bright": Extract({extract}, fireflies: Limit, before: "bright.peaks@previous"),
        "half": Downsample(source: "bright", levels: 1), "out": Far(source: "half.coarsest"), {after}"#
    );
    planned_at(FRAME, &nodes, outputs, Options { row_downsample: When::Always, ..Options::default() })
}

/// The images as large as the frame that a plan makes and keeps for other passes.
fn full_size(plan: &Plan) -> Vec<&str> {
    let made = plan.work().flat_map(Pass::writes).filter_map(Resource::image).filter(|image| {
        plan.image(*image).desc.size == FRAME && plan.outputs.iter().all(|output| output.image != *image)
    });
    made.map(|image| plan.image(image).label.as_str()).collect()
}

#[test]
fn what_looks_at_neighbors_is_made_in_the_halving() {
    // The kernels: a copy of the pixel, the limit, the selection, the halving, the peaks.
    let plan = lights("", r#"source: "in""#, "", r#""out": "out""#);
    assert_eq!((by_rows(&plan), plan.passes.len()), (vec![5], 2), "{}", plan.to_text());
    assert_eq!((full_size(&plan), plan.savings.shared_reads.len()), (vec![], 1), "{}", plan.to_text());
    // The pixel is made again for others that read no more.
    let dim = r#""dim": Dim(source: "in"),"#;
    let plan = lights(dim, r#"source: "dim""#, r#""shown": Dim(source: "dim")"#, r#""out": "out", "shown": "shown""#);
    assert_eq!((by_rows(&plan), plan.passes.len(), full_size(&plan)), (vec![5], 3, vec![]), "{}", plan.to_text());
    // And nobody makes it once more if there are none.
    let plan = lights(dim, r#"source: "dim""#, "", r#""out": "out""#);
    assert_eq!((by_rows(&plan), plan.passes.len(), full_size(&plan)), (vec![5], 2, vec![]), "{}", plan.to_text());
}

#[test]
fn what_others_need_is_stored_although_a_halving_looks_at_it() {
    // Another pass looks around a pixel of the source: the halving reads what is stored.
    let dim = r#""dim": Dim(source: "in"),"#;
    let plan = lights(dim, r#"source: "dim""#, r#""far": Far(source: "dim")"#, r#""out": "out", "far": "far""#);
    assert_eq!((by_rows(&plan), full_size(&plan)), (vec![5], vec!["dim.result"]), "{}", plan.to_text());
    // The source is shown, too.
    let plan = lights(dim, r#"source: "dim""#, "", r#""out": "out", "dim": "dim""#);
    assert_eq!((by_rows(&plan), plan.passes.len()), (vec![5], 3), "{}", plan.to_text());
    // The source looks around its own pixel: eight neighbors would each make it again.
    let far = r#""far": Far(source: "in"),"#;
    let plan = lights(far, r#"source: "far""#, "", r#""out": "out""#);
    assert_eq!((by_rows(&plan), full_size(&plan)), (vec![5], vec!["far.result"]), "{}", plan.to_text());
    // The light is stored for others, and so are peaks that this frame reads.
    let plan = lights("", r#"source: "in""#, r#""far": Far(source: "bright")"#, r#""out": "out", "far": "far""#);
    assert_eq!((by_rows(&plan), full_size(&plan)), (vec![2], vec!["bright.result"]), "{}", plan.to_text());
    let plan = lights("", r#"source: "in""#, r#""far": Far(source: "bright.peaks")"#, r#""out": "out", "far": "far""#);
    assert_eq!((by_rows(&plan), full_size(&plan)), (vec![4], vec![]), "{}", plan.to_text());
}

#[test]
fn a_light_pass_is_computed_again_for_a_few_readers_and_stored_for_many() {
    let passes = |readers: usize| {
        let reader = |at: usize| format!(r#""b{at}": Dim(source: "a"), "#);
        let output = |at: usize| format!(r#""b{at}": "b{at}", "#);
        let nodes = r#""a": Dim(source: "in"), "#.to_owned() + &(0..readers).map(reader).collect::<String>();
        let outputs: String = (0..readers).map(output).collect();
        planned_at(FRAME, &nodes, &outputs, Options::default()).passes.len()
    };
    assert_eq!([1, 2, 3, 4, 5, 6].map(passes), [1, 2, 3, 4, 6, 7]);
    // Three kernels are not light: they are computed once.
    let long = r#""a": Dim(source: "in"), "b": Dim(source: "a"), "c": Dim(source: "b"), "x": Dim(source: "c"),
        "y": Dim(source: "c")"#;
    assert_eq!(planned_at(FRAME, long, r#""x": "x", "y": "y""#, Options::default()).passes.len(), 3);
}

/// Texels of the result that a workgroup makes: from the entry point in the text of the shader, or from the pass.
fn covered(plan: &Plan, index: usize) -> Option<[u32; 2]> {
    let PlannedPass { pass, .. } = &plan.passes[index];
    let source = plan.compose(index, Default::default()).unwrap_or_else(|error| panic!("{error}")).source;
    let (_, sizes) = source.rsplit_once("@workgroup_size(").expect("a compute entry point");
    let sizes = sizes.split(')').next().expect("a bracket closes");
    let sides: Vec<u32> = sizes.split(',').map(|side| side.trim().parse().expect("a number")).collect();
    match &pass.kind {
        PassKind::Point | PassKind::Gather => {
            let rows = source.matches("textureStore(").count() as u32;
            Some([sides[0], sides[1] * rows])
        }
        // The outermost invocations only make what their neighbors need.
        PassKind::RowDownsample(rows) => Some([sides[0] - 2, rows.rows]),
        PassKind::Workgroup(_) | PassKind::Compute | PassKind::Drawing(_) => None,
    }
}

#[test]
fn the_workgroups_of_a_pass_reach_its_last_pixels_and_no_further() {
    let nodes = r#""a": Dim(source: "in"), "half": Downsample(source: "a", levels: 1),
        "b": Soft(source: "in"), "c": Soft(source: "b"), "x": Far(source: "half.coarsest"), "y": Far(source: "c"),
        "light": Extract(source: "in", fireflies: Limit), "low": Downsample(source: "light", levels: 1),
        "z": Far(source: "low.coarsest")"#;
    let mut seen = Vec::new();
    for (width, height) in
        [(1, 1), (2, 2), (15, 7), (16, 8), (17, 9), (124, 64), (126, 66), (643, 361), (800, 600), (1300, 1100)]
    {
        let options = Options { row_downsample: When::Always, ..Options::default() };
        let plan = planned_at(Size::new(width, height), nodes, r#""x": "x", "y": "y", "a": "a", "z": "z""#, options);
        for (index, planned) in plan.passes.iter().enumerate() {
            let Some(cover) = covered(&plan, index) else { continue };
            let size = plan.image(planned.pass.results.last().expect("a result").image).desc.size;
            for (axis, side) in [size.width, size.height].into_iter().enumerate() {
                let (groups, cover) = (planned.workgroups[axis], cover[axis]);
                let label = &planned.pass.label;
                assert!(groups * cover >= side, "{label} at {size}: {groups} groups of {cover}");
                assert!((groups - 1) * cover < side, "{label} at {size}: {groups} groups of {cover}");
            }
            seen.push((std::mem::discriminant(&planned.pass.kind), cover));
        }
    }
    let covers: std::collections::BTreeSet<[u32; 2]> = seen.iter().map(|(_, cover)| *cover).collect();
    let kinds: std::collections::HashSet<_> = seen.iter().map(|(kind, _)| *kind).collect();
    assert!(kinds.len() >= 3 && covers.len() >= 5, "points, gathers and rows: {covers:?}");
}

/// A pass is what its kernels make of it: only those of one pixel are points.
#[test]
fn the_kind_of_a_pass_follows_from_what_its_kernels_read() {
    let plan = by_rows_only(r#""a": Dim(source: "in"), "b": Far(source: "a")"#, r#""a": "a", "b": "b""#);
    let kinds: Vec<&PassKind> = plan.work().map(|pass: &Pass| &pass.kind).collect();
    assert_eq!(kinds, [&PassKind::Point, &PassKind::Gather]);
}
