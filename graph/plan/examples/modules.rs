//! Prints the WGSL of every module that the built-in kinds and pipelines become on a device without optional features,
//! as a JSON list of texts, for validators other than naga: see `tests/page.sh`.

#![allow(clippy::print_stdout, reason = "a program that prints what it finds")]

use std::collections::BTreeSet;
use std::error::Error;

use afterimage_graph::check::{Checker, Facts, Graph};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_pipelines::{BuiltIn, PIPELINES};
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, PlanRequest, Requirement, modules, plan};

const FRAME: Size = Size { width: 1280, height: 720, depth: 1 };

fn main() -> Result<(), Box<dyn Error>> {
    let registry = Registry::new(&[afterimage_nodes::ALL])?;
    let mut found = modules(afterimage_nodes::ALL);
    for (name, text) in PIPELINES {
        let document = parse(name, text).map_err(|errors| errors.to_string())?;
        let checker = Checker::new(&document, &registry, &BuiltIn);
        let tiers = checker.tiers();
        for tier in std::iter::once(None).chain(tiers.iter().map(|tier| Some(tier.as_str()))) {
            let (graph, _) = checker.check(tier, &[]).map_err(|errors| errors.to_string())?;
            found.extend(modules_of(&graph)?);
        }
    }
    println!("{}", serde_json::to_string(&found)?);
    Ok(())
}

/// The modules of a pipeline whose host gives everything.
fn modules_of(graph: &Graph) -> Result<BTreeSet<String>, Box<dyn Error>> {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME), finite: false };
    let request = PlanRequest {
        given: HostInputs::all(FRAME, &graph.inputs, image),
        facts: Facts::default(),
        caps: Caps::default(),
        options: Options::default(),
        dynamic: BTreeSet::new(),
        requirement: &Requirement::typical,
    };
    let plan = plan(graph, &request)?;
    let source = |pass| Ok(plan.compose(pass, Default::default())?.source);
    (0..plan.passes.len()).map(source).collect()
}
