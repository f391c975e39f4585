//! Host blocks in plans: where their numbers lie, what a plan without them is, and how reports show them.

use std::collections::BTreeSet;

use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc};
use afterimage_graph::node::{Arg, BlockId, CAMERA, NodeKind, Registry, folder_kind_of};
use afterimage_graph::prelude::*;
use afterimage_plan::codegen::SlotKind;
use afterimage_plan::{
    Caps, HostImageDesc, HostInputs, Options, Plan, PlanCache, PlanError, PlanRequest, Requirement, plan, verify,
};

use super::devices::uniform_buffers;
use super::golden::assert_golden;
use super::support::{FRAME, all_formats};

static DISTANCE: Shader = Shader::new(
    "distance.wgsl",
    "import afterimage::camera::{Camera, camera_distance};
struct Distance { scale: f32 }
@group(0) @binding(0) var<uniform> eye: Camera;
@group(0) @binding(1) var<uniform> params: Distance;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;
@compute @workgroup_size(8, 8)
fn distance_of(@builtin(global_invocation_id) id: vec3u) {
    let far = camera_distance(eye, vec2f(id.xy), texel(depth, vec2i(id.xy)).x);
    textureStore(result, id.xy, vec4f(params.scale * far));
}",
);

node_kind! {
    /// The distance of what is seen, by a compute kernel.
    pub struct Distance {
        /// A factor.
        pub scale: f32 = 1.0 => within(0.0..=10.0);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("depth", "Depth.").accepts(&[ColorState::Data]), Input::block("eye", &CAMERA, "The camera.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The distance.").or_input("depth")];
}

impl Node for Distance {
    fn record(&self, pass: &mut Recorder<'_>) {
        let depth = pass.image("depth");
        let desc = pass.desc(depth).format(Format::Rgba16Float);
        let result = pass.output("result", desc);
        let groups = desc.size.div_up(8);
        pass.compute(&DISTANCE, "distance_of").image("result", result).dispatch([groups.width, groups.height, 1]);
    }
}

const HAZE: &str = r#"Kind(
    name: "Haze",
    doc: "Fog.",
    inputs: {
        "source": Image(doc: "The picture."),
        "depth": Image(doc: "Depth.", accepts: [Data]),
        "camera": Camera(doc: "The camera."),
    },
    outputs: { "result": Image(doc: "The picture in fog.", state: Same("source")) },
)"#;

const HAZE_SHADER: &str = "import afterimage::camera::{Camera, camera_distance};
fn haze(source: vec4f, depth: texture_2d<f32>, camera: Camera, at: Point) -> vec4f {
    return source * camera_distance(camera, at.uv, texel(depth, at.pixel).x);
}";

/// Two layers of fog, which are fused, and a distance; one camera may be missing.
const TEXT: &str = r#"Pipeline(
    inputs: {
        "scene": Color, "depth": Depth,
        "eye": Camera(optional: true), "light": Camera, "unread": Camera(optional: true),
    },
    nodes: {
        "low":  Haze(source: "scene", depth: "depth", camera: "eye"),
        "high": Haze(source: "low", depth: "depth", camera: "light"),
        "far":  Distance(depth: "depth", eye: "light"),
    },
    outputs: { "display": "high", "far": "far" },
)"#;

fn graph() -> Graph {
    let haze = folder_kind_of(("node.ron", HAZE), &[("haze.wgsl", HAZE_SHADER)]);
    let haze = haze.unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL, &[haze, NodeKind::of::<Distance>()]]);
    let document = parse("blocks.ron", TEXT).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = registry.expect("no two kinds share a name");
    check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// A host that gives both images and these blocks.
fn request(blocks: &[&str]) -> PlanRequest<'static> {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME), finite: false };
    let inputs = ["scene", "depth"].map(|name| (name.to_owned(), image)).into();
    let blocks = blocks.iter().map(|name| (*name).to_owned()).collect();
    PlanRequest {
        given: HostInputs { inputs, blocks, ..HostInputs::none(FRAME) },
        facts: Facts::default(),
        caps: all_formats(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    }
}

fn planned(blocks: &[&str]) -> Plan {
    let plan = plan(&graph(), &request(blocks)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()));
    plan
}

#[test]
fn each_block_that_is_read_has_its_own_part_of_the_uniform_buffer() {
    let plan = planned(&["eye", "light", "unread"]);
    let names: Vec<(&str, BlockId)> = plan.blocks.iter().map(|block| (block.name.as_str(), block.id)).collect();
    assert_eq!(names, [("eye", BlockId(2)), ("light", BlockId(3))], "the third is read by nobody");
    let ends = plan.passes.iter().map(|pass| {
        let uniform = &pass.uniform;
        (uniform.offset + uniform.bytes.len() as u64).max(uniform.extent_offset + 8)
    });
    let mut end = ends.max().expect("there are passes");
    for block in &plan.blocks {
        assert!(block.offset >= end && block.offset.is_multiple_of(256), "{} begins at {}", block.name, block.offset);
        assert_eq!(plan.block(block.id), block);
        end = block.offset + block.block.bytes() as u64;
    }
    assert_eq!(plan.uniform_buffer().len() as u64, end, "the buffer ends with the last block");
    assert!(CAMERA.bytes() > 64 && std::ptr::eq(plan.blocks[0].block, &CAMERA));
}

#[test]
fn a_module_binds_each_block_that_its_kernels_read() {
    let plan = planned(&["eye", "light"]);
    let mut bound: Vec<Vec<BlockId>> = Vec::new();
    for index in 0..plan.passes.len() {
        let composed = plan.compose(index, Default::default()).unwrap_or_else(|error| panic!("{error}"));
        composed.validate().unwrap_or_else(|error| panic!("{error}\n{}", composed.source));
        let blocks = composed.slots.iter().filter_map(|slot| match slot.kind {
            SlotKind::Block(block) => Some(block),
            _ => None,
        });
        bound.push(blocks.collect());
        let read: BTreeSet<BlockId> = plan.passes[index].pass.args().filter_map(Arg::block).collect();
        assert!(bound[index].iter().copied().eq(read), "pass {index} binds {:?}", bound[index]);
        assert_eq!(composed.source.matches("@binding(").count(), composed.slots.len(), "{}", composed.source);
    }
    bound.sort();
    let [eye, light] = [BlockId(2), BlockId(3)];
    assert_eq!(bound.last(), Some(&vec![light]), "{bound:?}");
    assert!(bound.contains(&vec![eye, light]), "two layers of fog are one pass: {}", plan.to_text());
}

/// Two layers of fog that are one pass have three: its size, and two cameras. Depth is stored with its size alone.
#[test]
fn passes_are_fused_as_far_as_a_device_has_uniform_buffers() {
    let plan_with = |caps| plan(&graph(), &PlanRequest { caps, ..request(&["eye", "light"]) });
    let bound = |most: u32| {
        let caps = Caps { max_fused_uniform_buffers: most, ..all_formats() };
        let plan = plan_with(caps).unwrap_or_else(|error| panic!("{error}"));
        let mut counts: Vec<usize> = (0..plan.passes.len()).map(|index| uniform_buffers(&plan, index)).collect();
        counts.sort_unstable();
        counts
    };
    assert_eq!([bound(11), bound(3), bound(2)], [vec![1, 2, 3], vec![1, 2, 3], vec![1, 2, 2, 2]]);
    let few = Caps { max_uniform_buffers: 1, max_fused_uniform_buffers: 1, ..all_formats() };
    let error = plan_with(few).expect_err("each of the passes has two");
    assert!(matches!(error, PlanError::TooManyUniformBuffers { count: 2, limit: 1, .. }), "{error}");
}

#[test]
fn a_node_without_its_block_gives_its_fallback_and_a_block_that_must_be_there_is_named() {
    let plan = planned(&["light"]);
    assert!(plan.savings.skipped.iter().any(|skipped| skipped.node == "low"), "{:?}", plan.savings.skipped);
    assert_eq!(plan.blocks.len(), 1);
    let error = afterimage_plan::plan(&graph(), &request(&["eye"])).expect_err("the light is missing");
    assert_eq!(error, PlanError::MissingInput("light".into()));
}

#[test]
fn other_blocks_need_another_plan() {
    let mut plans = PlanCache::new(graph());
    let mut plan = |blocks: &[&str]| plans.plan(&request(blocks)).expect("it can be planned");
    let (both, one) = (plan(&["eye", "light"]), plan(&["light"]));
    assert!(both.blocks.len() == 2 && one.blocks.len() == 1);
    assert!(std::sync::Arc::ptr_eq(&both, &plan(&["eye", "light"])));
}

#[test]
fn the_reports_of_a_plan_with_blocks_are_as_known() {
    let plan = planned(&["eye", "light"]);
    assert_golden("blocks.txt", &plan.to_text());
    assert_golden("blocks.json", &plan.to_json());
}
