//! What the planner chooses among good plans, compared with `golden/choices.txt`: the hashes of the plans of many
//! graphs in every way, and where images stay when a plan follows another one. `AFTERIMAGE_BLESS=1` writes the file
//! again. A change of one line is meant, or a fault that no property of plans shows.

use std::fmt::Write as _;
use std::sync::Arc;

use afterimage_generators::Recipe;
use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, Size};
use afterimage_plan::{Caps, Options, PlacedPlan, Plan};

use super::fusion::{planned_at, planned_on};
use super::golden::assert_golden;
use super::model::{blurs, ways};
use super::planned::{FRAME, all_formats, built_in, plan_at, plan_images, plan_on};
use super::properties::switch_one;

/// The first digits of the hash, of which one in four billion pairs has the same.
fn hash(plan: &Plan) -> String {
    plan.hash().to_string()[..8].to_owned()
}

fn line(text: &mut String, name: &str, plans: impl Iterator<Item = Plan>) {
    let hashes: Vec<String> = plans.map(|plan| hash(&plan)).collect();
    writeln!(text, "{name}: {}", hashes.join(" ")).expect("a string grows");
}

/// Devices of which each lacks something else.
fn devices() -> [Caps; 5] {
    let all = all_formats;
    [
        Caps::default(),
        Caps { prefer_fragment: true, ..Caps::default() },
        Caps { filter_32_bit: true, ..all() },
        Caps { tiles: true, max_storage_images: 1, ..all() },
        Caps { tiles: true, workgroup_bytes: 4 << 10, workgroup_invocations: 128, ..all() },
    ]
}

#[test]
fn what_is_chosen_for_many_graphs_is_as_known() {
    let mut text = String::new();
    for seed in 0..48 {
        let graph = Recipe { seed, nodes: 8 + 2 * seed as usize, histories: 2, off: 8 }.graph();
        let planned = |(_, options)| plan_at(&graph, FRAME, options).expect("the graph can be planned");
        let on = |caps| plan_on(&graph, FRAME, Options::default(), caps).expect("the graph can be planned");
        line(&mut text, &format!("graph {seed}"), ways().into_iter().map(planned).chain(devices().map(on)));
    }
    for seed in 0..40 {
        let (nodes, outputs) = blurs(seed);
        for (width, height) in [(97, 61), (480, 272), (1280, 720), (2560, 1440), (3840, 2160)] {
            let size = Size::new(width, height);
            let planned = |(_, options)| planned_at(size, &nodes, &outputs, options);
            let on = |caps| planned_on(size, &nodes, &outputs, Options::default(), caps);
            let plans = ways().into_iter().map(planned).chain(devices().map(on));
            line(&mut text, &format!("pipeline {seed} at {width}x{height}"), plans);
        }
    }
    assert_golden("choices.txt", &text);
}

#[test]
fn what_is_chosen_for_the_built_in_pipelines_on_other_devices_fits_these() {
    for name in ["caracal", "exposure", "glare", "grade", "hdr", "lynx", "tsushima", "tsushima-night"] {
        let graph = built_in(&format!("{name}.ron"));
        for caps in devices() {
            let plan = plan_images(&graph, Format::Rgba32Float, Facts::default(), caps.clone(), Options::default());
            super::devices::assert_fits(&plan, &caps, name);
        }
    }
}

#[test]
fn what_stays_in_its_place_when_a_node_is_switched_is_as_known() {
    let mut text = String::new();
    for seed in 0..40 {
        let mut graph = Recipe { seed, nodes: 12 + seed as usize, histories: 1, off: 5 }.graph();
        let planned =
            |graph: &_| Arc::new(plan_at(graph, FRAME, Options::default()).expect("the graph can be planned"));
        let mut placed = PlacedPlan::new(planned(&graph));
        write!(text, "graph {seed}:").expect("a string grows");
        for edit in 0..4 {
            switch_one(&mut graph, seed + 100 * edit);
            placed = PlacedPlan::keeping(planned(&graph), &placed);
            let offsets: Vec<u64> = placed.placement.offsets.iter().flatten().map(|offset| offset >> 16).collect();
            let sum = offsets.iter().fold(0_u32, |sum, offset| sum.wrapping_mul(31).wrapping_add(*offset as u32));
            let barriers: usize = placed.placement.aliasing.iter().flatten().map(|barrier| barrier.owners.len()).sum();
            write!(text, " {} KiB {sum:08x} {barriers}", placed.placement.heap >> 10).expect("a string grows");
        }
        text.push('\n');
    }
    assert_golden("kept.txt", &text);
}
