//! The plans of the built-in pipelines.

use afterimage_graph::check::Facts;
use afterimage_graph::image::Format;
use afterimage_graph::node::{BufferId, KernelCall};
use afterimage_plan::limits::{MAX_OPERATIONS, MAX_PASS_OPERATIONS};
use afterimage_plan::{Caps, Options, verify};
use afterimage_wgsl::SampleMode;

use super::support::{all_formats, built_in, checked, pipelines, plan_everything, plan_images};
use super::sweep;

/// The files in the folder: a new one is tested without being named here.
fn files() -> Vec<String> {
    let entries = std::fs::read_dir(pipelines()).expect("the repository has pipelines");
    let names = entries.map(|entry| entry.expect("a folder can be listed").file_name());
    let names = names.map(|name| name.into_string().expect("names are UTF-8"));
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".ron")).collect();
    names.sort();
    assert!(names.len() >= 6, "only {names:?}");
    names
}

/// Each pipeline in one way of eight; in all with `AFTERIMAGE_SWEEPS=all`.
#[test]
fn every_plan_is_verified_and_equal_when_made_again() {
    for (at, name) in files().into_iter().enumerate() {
        let graph = built_in(&name);
        let ways = if sweep::is_whole() { 0..8 } else { at % 8..at % 8 + 1 };
        for way in ways {
            let caps = if way & 1 == 0 { Caps::default() } else { all_formats() };
            let options = Options { serial: way & 2 != 0, ..Options::default() };
            let plan = || match way & 4 {
                0 => plan_everything(&graph, Format::Rgba32Float, caps.clone(), options),
                _ => plan_images(&graph, Format::Rgba32Float, Facts::default(), caps.clone(), options),
            };
            let first = plan();
            verify(&first).unwrap_or_else(|faults| panic!("{name}: {faults:?}"));
            assert_eq!(first.hash(), plan().hash(), "{name}");
        }
    }
}

/// All textures of a module are limited alike where they are read: none to fewer numbers than it may hold, and none of
/// the host to more.
#[test]
fn textures_of_a_module_are_limited_as_each_of_them_must_be() {
    let (mut limited, mut beside) = (0, 0);
    for name in files() {
        let graph = built_in(&name);
        let plan = plan_everything(&graph, Format::Rgba32Float, all_formats(), Options::default());
        for (index, planned) in plan.passes.iter().enumerate() {
            let mode = plan.compose(index, Default::default()).unwrap_or_else(|error| panic!("{error}")).sample_mode;
            let textures = || planned.pass.kernels.iter().flat_map(KernelCall::textures).map(|image| plan.image(image));
            for image in textures().filter(|_| mode >= SampleMode::Sanitized) {
                let wanted = SampleMode::sanitizing(image.signedness);
                let is_given = image.sample_mode >= SampleMode::Sanitized;
                let fits = if is_given { mode == wanted } else { mode >= wanted };
                assert!(fits, "{name}: `{}` in `{}`: {mode:?}", image.label, planned.pass.label);
                if is_given { limited += 1 } else { beside += 1 }
            }
        }
    }
    assert!(limited > 10 && beside > 2, "{limited} images of hosts, beside {beside} others");
}

#[test]
fn the_state_of_a_sequence_is_what_meters_and_histories_keep() {
    let state = |name: &str| {
        let plan = plan_everything(&built_in(name), Format::Rgba32Float, all_formats(), Options::default());
        let items = plan.state().into_iter();
        items.map(|item| (item.name.clone(), item.described(), item.reach)).collect::<Vec<_>>()
    };
    assert!(state("glare.ron").is_empty(), "{:?}", state("glare.ron"));
    let meter = |name: &str, bytes: &str| (name.to_owned(), bytes.to_owned(), None::<u32>);
    let [result, range] = ["meter.result", "meter.range"].map(|name| meter(name, "16 bytes"));
    assert_eq!(state("exposure.ron"), [result, range, meter("meter.wanted_before", "4 bytes")]);
    let items = state("cinematic.ron");
    let reach_of = |name: &str| items.iter().find(|(known, ..)| known == name).map(|(.., reach)| *reach);
    assert_eq!(reach_of("metered.result"), Some(None), "{items:?}");
    // The result of anti-aliasing is made from itself, the depth from the depth buffer of its own frame.
    assert_eq!(reach_of("steady.result"), Some(None), "{items:?}");
    assert_eq!(reach_of("linear.result"), Some(Some(1)), "{items:?}");
}

/// What the meters of a built-in pipeline measure, and the state that follows from it.
fn metered(name: &str) -> (Vec<String>, Vec<String>) {
    let plan = plan_everything(&built_in(name), Format::Rgba32Float, all_formats(), Options::default());
    let metering = plan.metering();
    let is_apart = |pass: &usize| !metering.integrating.contains(pass);
    assert!(metering.measuring.iter().all(is_apart), "{name}: {metering:?}");
    let names = plan.buffer_names();
    let named = |buffers: &[BufferId]| buffers.iter().map(|buffer| names[buffer.0 as usize].clone()).collect();
    (named(&metering.measured), named(&metering.state))
}

#[test]
fn meters_of_the_scene_measure_frames_in_any_order() {
    let of = |measured: &str, meter: &str| {
        let state = ["result", "range", "wanted_before"].map(|port| format!("{meter}.{port}"));
        (vec![measured.to_owned()], state.to_vec())
    };
    assert_eq!(metered("exposure.ron"), of("bins.result", "meter"));
    assert_eq!(metered("tsushima.ron"), of("counted.result", "metered"));
    assert_eq!(metered("hdr.ron"), of("bins.result", "meter"));
    // Its meter reads what anti-aliasing has made from all frames before.
    assert_eq!(metered("cinematic.ron"), Default::default());
    assert_eq!(metered("glare.ron"), Default::default());
}

#[test]
fn what_is_measured_depends_on_the_histogram_and_not_on_the_exposure() {
    let hash = |bins: &str, meter: &str| {
        let graph = checked(&format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ \"bins\": Histogram(source: \"scene\"{bins}), \
             \"meter\": AutoExposure(histogram: \"bins\"{meter}), \"lit\": Exposure(source: \"scene\", meter: \
             \"meter\") }}, outputs: {{ \"light\": \"lit\" }})"
        ));
        let plan = plan_everything(&graph, Format::Rgba32Float, all_formats(), Options::default());
        plan.measuring_hash(&plan.metering())
    };
    assert_eq!(hash("", ""), hash("", ", key: 0.3, adaptation: Linear"));
    assert_ne!(hash("", ""), hash(", lo: -10.0", ""));
    assert_ne!(hash("", ""), hash(", weight: Spot", ""));
}

/// What is compiled for a pass of a built-in pipeline does not decide what is fused.
#[test]
fn built_in_pipelines_are_below_the_bounds_of_compilation() {
    for name in files() {
        let plan = plan_everything(&built_in(&name), Format::Rgba32Float, all_formats(), Options::default());
        let mut all = 0;
        for planned in &plan.passes {
            let operations = planned.pass.compile_cost().operations();
            let is_joined = planned.pass.nodes.len() > 1;
            let label = &planned.pass.label;
            assert!(!is_joined || operations <= MAX_PASS_OPERATIONS, "{name}: {label} has {operations}");
            all += operations;
        }
        assert!(all <= MAX_OPERATIONS / 2, "{name}: {all}");
    }
}

/// A pass takes in as many functions as a driver compiles in a few seconds.
#[test]
fn fusion_stops_where_a_pass_takes_too_long_to_compile() {
    let nodes: Vec<String> = (0..80)
        .map(|at| {
            let source = if at == 0 { "scene".to_owned() } else { format!("n{}", at - 1) };
            format!("\"n{at}\": HueCurves(source: \"{source}\", hue_red: 4.0)")
        })
        .collect();
    let text = format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ {} }}, outputs: {{ \"out\": \"n79\" }})",
        nodes.join(", ")
    );
    let plan = plan_everything(&checked(&text), Format::Rgba32Float, all_formats(), Options::default());
    let operations: Vec<usize> = plan.passes.iter().map(|planned| planned.pass.compile_cost().operations()).collect();
    assert!(operations.iter().all(|operations| *operations <= MAX_PASS_OPERATIONS), "{operations:?}");
    assert!(operations.len() > 1 && operations.len() < 40, "{operations:?}");
}
