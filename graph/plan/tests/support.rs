//! Plans for devices and frames that tests share.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_generators::Recipe;
use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanError, PlanRequest, Requirement, plan};

/// The size of most frames.
pub const FRAME: Size = Size { width: 640, height: 360, depth: 1 };

/// The capabilities of a device that can store every format.
pub fn all_formats() -> Caps {
    Caps { storage: Format::ALL.into(), ..Caps::default() }
}

/// The plan of a random graph.
pub fn plan_of(recipe: Recipe, options: Options) -> Result<Plan, PlanError> {
    plan_at(&recipe.graph(), FRAME, options)
}

/// The plan of a random graph for a frame of that size, on a device that can store every format.
pub fn plan_at(graph: &Graph, size: Size, options: Options) -> Result<Plan, PlanError> {
    plan_on(graph, size, options, all_formats())
}

/// The plan of a random graph for a device.
pub fn plan_on(graph: &Graph, size: Size, options: Options, caps: Caps) -> Result<Plan, PlanError> {
    let given = HostImageDesc { desc: ImageDesc::new(size), finite: true };
    let inputs = BTreeMap::from([("picture".to_owned(), given)]);
    let requirement = &Requirement::typical;
    plan(
        graph,
        &PlanRequest {
            given: HostInputs { inputs, ..HostInputs::none(size) },
            facts: Facts::default(),
            caps,
            options,
            dynamic: Default::default(),
            requirement,
        },
    )
}

/// The plan of a graph of built-in kinds: every required input is an unsanitized image of the format and has the size
/// of the frame.
pub fn plan_images(graph: &Graph, format: Format, facts: Facts, caps: Caps, options: Options) -> Plan {
    attempt(graph, format, facts, (caps, options)).unwrap_or_else(|error| panic!("{error}"))
}

/// The plan for a host that gives all optional inputs, too.
pub fn plan_everything(graph: &Graph, format: Format, caps: Caps, options: Options) -> Plan {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(format), finite: false };
    let given = HostInputs::all(FRAME, &graph.inputs, image);
    let (facts, requirement) = (Facts::default(), &Requirement::typical);
    let request = PlanRequest { given, facts, caps, options, dynamic: Default::default(), requirement };
    plan(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// The plan for a host that gives all inputs that are not optional, or the error.
pub fn attempt(
    graph: &Graph,
    format: Format,
    facts: Facts,
    (caps, options): (Caps, Options),
) -> Result<Plan, PlanError> {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(format), finite: false };
    let given = HostInputs::all(FRAME, graph.inputs.iter().filter(|input| !input.optional), image);
    let requirement = &Requirement::typical;
    plan(graph, &PlanRequest { given, facts, caps, options, dynamic: Default::default(), requirement })
}

/// The graph of a text of built-in kinds.
pub fn checked(text: &str) -> Graph {
    checked_with("test.ron", text, &Files)
}

/// The folder of the built-in pipelines.
pub fn pipelines() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines")
}

/// The graph of a built-in pipeline.
pub fn built_in(name: &str) -> Graph {
    let path = pipelines().join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    checked_with(&path.to_string_lossy(), &text, &Files)
}

/// The graph of a text that names files.
pub fn checked_with(path: &str, text: &str, loader: &dyn Loader) -> Graph {
    let document = parse(path, text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let options = CheckOptions { loader, ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// Reads files that a pipeline names.
pub struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(path).map(Into::into).map_err(|error| error.to_string())
    }
}
