//! Reports of plans with what others lack: images of many heights, long names, numbers that change while the plan runs,
//! tables, two sizes, and nothing at all.

use std::collections::BTreeSet;

use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_plan::{Alias, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, When, diff, plan};

use super::fusion::planned_on;
use super::golden::assert_golden;
use super::support::{FRAME, all_formats, checked};

/// A pyramid, whose images have all heights on paper, and a name that no bar holds.
const PYRAMID: &str = r#""a": Dim(source: "in"), "levels": Downsample(source: "a", levels: 5),
    "the_wide_bloom_of_all_levels": Upsample(source: "levels"),
    "lit": Composite(base: "a", bloom: "the_wide_bloom_of_all_levels"), "late": Late(source: "lit"),
    "past": Composite(base: "late", bloom: "lit@previous")"#;

fn pyramid(size: Size, options: Options) -> Plan {
    let options = Options { fuse: false, row_downsample: When::Never, ..options };
    planned_on(size, PYRAMID, r#""out": "past""#, options, all_formats())
}

#[test]
fn the_reports_of_a_pyramid_are_as_known() {
    let plan = pyramid(FRAME, Options::default());
    assert_golden("pyramid.svg", &plan.to_svg());
    assert_golden("pyramid.txt", &plan.to_text());
    let pooled = pyramid(FRAME, Options { alias: Alias::Pool, ..Options::default() });
    assert_golden("pyramid-pooled.svg", &pooled.to_svg());
    let larger = pyramid(Size::new(1280, 700), Options { serial: true, ..Options::default() });
    assert_golden("pyramid-larger.txt", &diff(&plan, &larger).to_string());
    assert_golden("pyramid-smaller.txt", &diff(&larger, &plan).to_string());
    assert_eq!(diff(&plan, &plan).to_string(), "the plans do the same work in the same memory\n");
}

const LIVE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "around": LogGaussian(source: "scene", width: 16, height: 8),
        "mean": MeanLuminance(source: "scene"),
        "meter": Adapt(mean: "mean"),
        "exposed": Exposure(source: "scene", meter: "meter"),
    },
    outputs: { "out": "exposed", "around": "around" },
)"#;

/// The plan of a graph with these parameters dynamic.
fn live(graph: &Graph, dynamic: &[&str]) -> Plan {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(Format::Rgba16Float), finite: false };
    let request = PlanRequest {
        given: HostInputs::all(FRAME, &graph.inputs, image),
        facts: Facts::default(),
        caps: all_formats(),
        options: Options::default(),
        dynamic: dynamic.iter().map(|name| graph.parameter(name).expect("it has one")).collect::<BTreeSet<_>>(),
        requirement: &Requirement::typical,
    };
    plan(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_reports_of_a_meter_are_as_known() {
    let graph = checked(LIVE);
    let plan = live(&graph, &["exposed.stops", "meter.min_ev"]);
    assert_golden("meter.txt", &plan.to_text());
    assert_golden("meter.svg", &plan.to_svg());
}

#[test]
fn a_plan_that_only_copies_has_reports_too() {
    let text = r#"Pipeline(inputs: { "scene": Color }, nodes: {}, outputs: { "out": "scene" })"#;
    let plan = live(&checked(text), &[]);
    assert_golden("copy.txt", &plan.to_text());
    assert_golden("copy.svg", &plan.to_svg());
}
