//! Inputs and outputs in rectangles of the host's images.

use afterimage_graph::check::{Facts, GraphInput};
use afterimage_graph::image::{Format, ImageDesc};
use afterimage_graph::node::Resource;
use afterimage_plan::codegen::CodeOptions;
use afterimage_plan::{HostImageDesc, HostInputs, Options, Part, Plan, PlanRequest, Requirement, plan, verify};

use super::support::{FRAME, all_formats, built_in};

fn planned(name: &str, part: Option<Part>) -> Plan {
    let graph = built_in(name);
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(Format::Rgba16Float), finite: false };
    let mut given = HostInputs::all(FRAME, &graph.inputs, image);
    if let Some(part) = part {
        let has_parts = |input: &&GraphInput| input.block.is_none() && !input.multisampled && !input.volume;
        let images = graph.inputs.iter().filter(has_parts);
        given.parts = images.map(|input| (input.name.clone(), part)).collect();
        given.rectangles = graph.outputs.iter().map(|output| output.name.clone()).collect();
    }
    let (facts, caps, options) = (Facts::default(), all_formats(), Options::default());
    let requirement = &Requirement::typical;
    let request = PlanRequest { given, facts, caps, options, dynamic: Default::default(), requirement };
    plan(&graph, &request).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn every_pipeline_can_have_all_its_images_in_rectangles() {
    for name in ["lynx.ron", "tsushima.ron", "caracal.ron", "cookbook.ron", "cinematic.ron", "exposure.ron"] {
        let whole = planned(name, None);
        assert!(whole.rectangles.is_empty() && !whole.to_json().contains("rectangle"), "{name}");
        for part in [Part::Rectangle, Part::Scaled] {
            let plan = planned(name, Some(part));
            assert_eq!(verify(&plan), Ok(()), "{name}");
            let more = plan.inputs.len() + plan.outputs.len();
            assert!(plan.passes.len() <= whole.passes.len() + more, "{name}: {} passes", plan.passes.len());
            assert!(plan.hash() != whole.hash() && plan.to_json().contains("\"in_rectangle\": true"), "{name}");
            for index in 0..plan.passes.len() {
                let composed = plan
                    .compose(index, CodeOptions { immediates: true, ..Default::default() })
                    .unwrap_or_else(|error| panic!("{name}: {error}"));
                composed.validate().unwrap_or_else(|error| panic!("{name}: {error}"));
            }
            places(name, &plan);
        }
    }
}

/// The numbers of rectangles lie where the passes that use them look.
fn places(name: &str, plan: &Plan) {
    for input in &plan.rectangles {
        let reads = |pass: &&afterimage_graph::node::Pass| pass.reads().contains(&Resource::Image(input.image));
        let cropped = plan.work().filter(reads).flat_map(|pass| &pass.kernels);
        let functions: Vec<_> = cropped.filter(|kernel| kernel.function.starts_with("crop")).collect();
        assert_eq!(input.places.len(), functions.len(), "{name}: {}", input.name);
        let buffer = plan.uniform_buffer();
        let is_empty = |place: &u64| buffer[*place as usize..][..24].iter().all(|byte| *byte == 0);
        assert!(input.places.iter().all(is_empty), "{name}: the executor writes them");
    }
    for output in &plan.outputs {
        assert!(output.in_rectangle && plan.origin_places(output).count() == 1, "{name}: {}", output.name);
        let resource = Resource::Image(output.image);
        assert!(plan.work().all(|pass| !pass.reads().contains(&resource)), "{name}: a pass reads {}", output.name);
    }
}
