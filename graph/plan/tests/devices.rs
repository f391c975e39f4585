//! A plan keeps to what its device can do, and uses it up to the last byte.

use std::collections::BTreeSet;

use afterimage_generators::Recipe;
use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, ImageDesc};
use afterimage_graph::node::{PassKind, Resource};
use afterimage_plan::codegen::SlotKind;
use afterimage_plan::{
    Caps, HostImageDesc, HostInputs, Options, Plan, PlanError, PlanRequest, PlannedPass, Requirement, Stage, When, plan,
};
use proptest::prelude::*;

use super::fusion::planned_on;
use super::model::blurs;
use super::support::{FRAME, all_formats, built_in, checked, plan_images, plan_on};

/// What the framework writes for a pass: an author's compute kernel keeps to what every device has by the contract.
fn is_ours(planned: &PlannedPass) -> bool {
    planned.pass.kind != PassKind::Compute
}

/// Uniform buffers that the module of a pass binds, beside that of the frame's time and number.
pub fn uniform_buffers(plan: &Plan, index: usize) -> usize {
    let composed = plan.compose(index, Default::default()).unwrap_or_else(|error| panic!("{error}"));
    let is_uniform = |kind| matches!(kind, SlotKind::Extent | SlotKind::Params | SlotKind::Block(_));
    composed.slots.iter().filter(|slot| is_uniform(slot.kind)).count()
}

/// Each pass is within what the device can do.
#[track_caller]
pub fn assert_fits(plan: &Plan, caps: &Caps, what: &str) {
    for (index, planned) in plan.passes.iter().enumerate() {
        let label = format!("{what}: {}", planned.pass.label);
        let written = planned.pass.writes().into_iter().filter_map(Resource::image);
        let formats: Vec<Format> = written.map(|image| plan.image(image).desc.format).collect();
        let possible = if planned.stage == Stage::Fragment { &caps.renderable } else { &caps.storage };
        assert!(formats.iter().all(|format| possible.contains(format)), "{label} writes {formats:?}");
        if planned.stage == Stage::Compute && is_ours(planned) {
            assert!(formats.len() <= caps.max_storage_images as usize, "{label} writes {} images", formats.len());
            let composed = plan.compose(index, Default::default()).unwrap_or_else(|error| panic!("{error}"));
            let invocations: u32 = composed.workgroup.iter().product();
            assert!(uniform_buffers(plan, index) <= caps.max_uniform_buffers as usize, "{label}");
            assert!(invocations <= caps.workgroup_invocations, "{label} has {invocations} invocations");
        }
    }
    let too_large = plan.images.iter().find(|image| {
        let ImageDesc { size, volume, .. } = image.desc;
        size.width.max(size.height).max(size.depth) > if volume { caps.max_volume_side } else { caps.max_side }
    });
    assert_eq!(too_large, None, "{what}");
}

fn some_formats() -> impl Strategy<Value = BTreeSet<Format>> {
    any::<u32>().prop_map(|bits| {
        let chosen = Format::ALL.into_iter().enumerate().filter(|(at, _)| bits >> at & 1 == 1);
        chosen.map(|(_, format)| format).chain([Format::R32Float, Format::Rgba16Float, Format::Rgba32Float]).collect()
    })
}

fn devices() -> impl Strategy<Value = Caps> {
    let sizes = (1_u32..6, 7_u32..9);
    (some_formats(), some_formats(), sizes, any::<[bool; 3]>()).prop_map(|(storage, renderable, sizes, flags)| {
        let (max_storage_images, invocations) = sizes;
        let [filter_32_bit, fast_workgroup_memory, prefer_fragment] = flags;
        let workgroup_invocations = 1 << invocations;
        let limits = Caps { max_storage_images, workgroup_invocations, ..Caps::default() };
        Caps { storage, renderable, filter_32_bit, fast_workgroup_memory, prefer_fragment, ..limits }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) })]

    #[test]
    fn every_plan_fits_its_device(seed in any::<u64>(), caps in devices(), always in any::<bool>()) {
        let when = if always { When::Always } else { When::WhereItPays };
        let options = Options { row_downsample: when, ..Options::default() };
        let graph = Recipe { seed, nodes: 24, histories: 1, off: 5 }.graph();
        let plan = plan_on(&graph, FRAME, options, caps.clone()).expect("the graph can be planned");
        assert_fits(&plan, &caps, "a graph");
        let (nodes, outputs) = blurs(seed);
        assert_fits(&planned_on(FRAME, &nodes, &outputs, options, caps.clone()), &caps, &nodes);
    }
}

#[test]
fn the_plans_of_the_built_in_pipelines_fit_devices_of_which_each_lacks_something() {
    let devices = [
        Caps::default(),
        Caps { prefer_fragment: true, ..Caps::default() },
        Caps { filter_32_bit: true, ..all_formats() },
        Caps { fast_workgroup_memory: true, max_storage_images: 1, ..all_formats() },
        Caps { fast_workgroup_memory: true, workgroup_invocations: 128, ..all_formats() },
    ];
    for name in ["caracal", "exposure", "glare", "grade", "hdr", "lynx", "tsushima", "tsushima-night"] {
        let graph = built_in(&format!("{name}.ron"));
        for caps in &devices {
            let plan = plan_images(&graph, Format::Rgba32Float, Facts::default(), caps.clone(), Options::default());
            assert_fits(&plan, caps, name);
        }
    }
}

#[test]
fn an_image_or_a_volume_is_as_large_as_the_device_allows_and_no_larger() {
    let graph = |seed| Recipe { seed, nodes: 40, histories: 0, off: 0 }.graph();
    let is_volume = |plan: &Plan| plan.images.iter().find(|image| image.desc.volume).map(|image| image.desc.size);
    let plan = |seed, caps| plan_on(&graph(seed), FRAME, Options::default(), caps);
    let with_volume = |seed: &u64| is_volume(&plan(*seed, all_formats()).expect("it fits")).is_some();
    let seed = (0..20).find(with_volume).expect("some graph has a volume");
    let flat = |max_side| plan(seed, Caps { max_side, ..all_formats() });
    assert!(flat(640).is_ok());
    let error = PlanError::TooLarge { label: "picture".into(), size: FRAME, limit: 639 };
    assert_eq!(flat(639).expect_err("the frame is 640 wide"), error);
    let whole = plan(seed, all_formats()).expect("it fits");
    let volumes = whole.images.iter().filter(|image| image.desc.volume).map(|image| image.desc.size);
    let longest = volumes.map(|size| size.width.max(size.height).max(size.depth)).max().expect("there is a volume");
    let deep = |max_volume_side| plan(seed, Caps { max_volume_side, ..all_formats() });
    assert!(deep(longest).is_ok());
    assert!(matches!(deep(longest - 1), Err(PlanError::TooLarge { limit, .. }) if limit == longest - 1));
}

/// What is wrong with a request whose image has that many samples in each pixel.
fn error_of_samples(input: &str, node: &str, samples: u32) -> Option<String> {
    let graph = checked(&format!(
        r#"Pipeline(inputs: {{ "in": {input} }}, nodes: {{ "a": {node}(source: "in") }}, outputs: {{ "out": "a" }})"#
    ));
    let given = HostImageDesc { desc: ImageDesc::new(FRAME).multisampled(samples), finite: false };
    let request = PlanRequest {
        given: HostInputs { inputs: [("in".to_owned(), given)].into(), ..HostInputs::none(FRAME) },
        facts: Facts::default(),
        caps: all_formats(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    plan(&graph, &request).err().map(|error| error.to_string())
}

#[test]
fn an_image_with_samples_that_its_input_does_not_state_is_an_error_that_tells_what_to_do() {
    let (several, one) = ("Color(multisampled: true)", "Color");
    assert_eq!(error_of_samples(several, "Resolve", 4), None);
    assert_eq!(error_of_samples(one, "Exposure", 1), None);
    let error = error_of_samples(several, "Resolve", 1).expect("it has one sample");
    assert!(error.starts_with("input `in` is multisampled, but its image has one sample in each pixel"), "{error}");
    assert!(error.contains("a host gives the image that it draws to"), "{error}");
    let error = error_of_samples(one, "Exposure", 4).expect("it has several samples");
    assert!(error.starts_with("input `in` is not multisampled, but its image has 4 samples in each pixel"), "{error}");
    assert!(error.contains("declare the input as `multisampled: true`, and wire it to a `Resolve`"), "{error}");
}

/// Of a format that the device can neither store nor draw, the next wider one is taken, and no wider one.
#[test]
fn formats_are_as_narrow_as_the_device_allows() {
    let options = Options { fuse: false, ..Options::default() };
    let asked = |seed, caps: Caps| {
        let graph = Recipe { seed, nodes: 40, histories: 0, off: 0 }.graph();
        let plan = plan_on(&graph, FRAME, options, caps).expect("the graph can be planned");
        let written = plan.work().flat_map(|pass| pass.writes()).filter_map(Resource::image);
        written.map(|image| (image, plan.image(image).desc.format)).collect::<std::collections::BTreeMap<_, _>>()
    };
    let few = [Format::Rgba16Float, Format::R32Float, Format::Rgba32Float];
    let caps = Caps { storage: few.into(), renderable: few.into(), ..Caps::default() };
    let mut widened = 0;
    for seed in 0..20 {
        let chosen = asked(seed, caps.clone());
        for (image, wanted) in asked(seed, all_formats()) {
            let mut wider = wanted;
            while !caps.storage.contains(&wider) && !caps.renderable.contains(&wider) {
                wider = wider.wider();
                widened += 1;
            }
            assert_eq!(chosen[&image], wider, "{image:?} of graph {seed}");
        }
    }
    assert!(widened > 20, "{widened} steps");
}
