//! Plans for devices and frames that tests share.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_generators::Recipe;
use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, GivenImage, Options, Plan, PlanError, PlanRequest, Requirement, plan};

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
    let given = GivenImage { desc: ImageDesc::new(size), finite: true };
    let inputs = BTreeMap::from([("picture".to_owned(), given)]);
    let requirement = &Requirement::typical;
    plan(graph, &PlanRequest { size, inputs, facts: Facts::default(), caps, options, requirement })
}

/// The graph of a text of built-in kinds.
pub fn checked(text: &str) -> Graph {
    checked_as("test.ron", text)
}

/// The graph of a built-in pipeline.
pub fn built_in(name: &str) -> Graph {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines").join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    checked_as(&path.to_string_lossy(), &text)
}

fn checked_as(path: &str, text: &str) -> Graph {
    let document = parse(path, text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let options = CheckOptions { loader: &Files, ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// Reads files that a pipeline names.
struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(path).map(Into::into).map_err(|error| error.to_string())
    }
}
