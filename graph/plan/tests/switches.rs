//! The switches for half floats, subgroups and immediates, and what a device prefers.

use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::Format;
use afterimage_graph::node::PassKind;
use afterimage_plan::codegen::{Slot, SlotKind};
use afterimage_plan::{Alias, Caps, Options, Plan, Stage, verify};

use super::planned::{all_formats, built_in, plan_images};

fn both() -> Options {
    Options { half: true, subgroups: true, ..Options::default() }
}

/// The source of every pass, as the device gets it.
fn sources(plan: &Plan) -> Vec<String> {
    let composed = |pass| plan.compose(pass, false).unwrap_or_else(|error| panic!("{error}")).source;
    (0..plan.passes.len()).map(composed).collect()
}

/// A device with every feature.
fn full() -> Caps {
    Caps { half_arithmetic: true, subgroups: true, ..all_formats() }
}

fn planned(graph: &Graph, options: Options, format: Format, caps: Caps) -> Plan {
    plan_images(graph, format, Facts::default(), caps, options)
}

#[test]
fn switches_apply_wherever_the_device_allows() {
    let graph = built_in("tsushima.ron");
    let count = |plan: &Plan, word: &str| sources(plan).iter().filter(|source| source.contains(word)).count();
    let without = planned(&graph, Options::default(), Format::Rgba16Float, full());
    assert_eq!((count(&without, "f16;"), count(&without, "subgroupBroadcastFirst")), (0, 0));
    let with = planned(&graph, both(), Format::Rgba16Float, full());
    assert!(sources(&with).iter().all(|source| source.starts_with("enable f16;\n")));
    let uses = (count(&with, "subgroupMax"), count(&with, "subgroupAdd"));
    assert!(uses.0 > 0 && uses.1 > 0, "the histogram's maximum and the sums of the meter: {uses:?}");
    assert!(with.ignored.is_empty());
    assert_ne!(with.hash(), without.hash());
    // An input in 32 bits is read in 32 bits; what is stored after it is not.
    let from_32_bits = planned(&graph, both(), Format::Rgba32Float, full());
    let (all, half) = (sources(&from_32_bits).len(), count(&from_32_bits, "enable f16;"));
    assert!(0 < half && half < all, "{half} of {all}");
}

#[test]
fn a_switch_that_the_device_lacks_is_reported_and_changes_nothing() {
    let graph = built_in("lynx.ron");
    let plain = planned(&graph, Options::default(), Format::Rgba16Float, all_formats());
    let asked = planned(&graph, both(), Format::Rgba16Float, all_formats());
    let ignored: Vec<&str> = asked.ignored.iter().map(|ignored| ignored.switch).collect();
    assert_eq!(ignored, ["subgroups", "half"]);
    assert!(asked.to_text().contains("ignored\n  subgroups  the device has no"), "{}", asked.to_text());
    assert_eq!((asked.options, sources(&asked)), (plain.options, sources(&plain)));
    let exact = planned(&graph, Options { exact: true, ..both() }, Format::Rgba16Float, full());
    assert!(sources(&exact).iter().all(|source| !source.contains("f16;")));
    assert_eq!(exact.ignored[0].why, "`exact` wants all bits");
}

/// Immediates take the place of one binding: that of the frame's constants.
#[test]
fn a_compute_kernel_takes_the_frame_as_immediates_or_bound() {
    let graph = built_in("exposure.ron");
    let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), all_formats(), Options::default());
    let mut with_frame = 0;
    for (index, planned) in plan.passes.iter().enumerate().filter(|(_, p)| p.pass.kind == PassKind::Compute) {
        let compose = |immediates| {
            plan.compose(index, immediates).unwrap_or_else(|error| panic!("{}: {error}", planned.pass.label))
        };
        let (bound, immediate) = (compose(false), compose(true));
        let has_frame = bound.slots.iter().any(|slot| slot.kind == SlotKind::Frame);
        let others: Vec<Slot> = bound.slots.iter().filter(|slot| slot.kind != SlotKind::Frame).copied().collect();
        assert_eq!((bound.immediate, immediate.immediate), (false, has_frame), "{}", planned.pass.label);
        assert_eq!(immediate.slots, others, "{}", planned.pass.label);
        for (composed, immediates) in [(&bound, 0), (&immediate, usize::from(has_frame))] {
            assert_eq!(composed.source.matches("var<immediate>").count(), immediates, "{}", composed.source);
            assert_eq!(composed.source.matches("@binding(").count(), composed.slots.len(), "{}", composed.source);
        }
        with_frame += usize::from(has_frame);
    }
    assert!(with_frame > 0, "a kernel adapts over time");
}

/// Images that are drawn to have layouts of their own, so they must not overlap others in a heap.
#[test]
fn a_plan_with_a_draw_has_no_heap() {
    let caps = Caps { prefer_fragment: true, ..Caps::default() };
    let graph = built_in("lynx.ron");
    let planned = |caps| plan_images(&graph, Format::Rgba16Float, Facts::default(), caps, Options::default());
    let (drawn, dispatched) = (planned(caps), planned(all_formats()));
    let has_draw = |plan: &Plan| plan.passes.iter().any(|planned| planned.stage == Stage::Fragment);
    assert_eq!((has_draw(&drawn), drawn.options.alias), (true, Alias::Pool));
    assert_eq!((has_draw(&dispatched), dispatched.options.alias), (false, Alias::Placed));
    let mut broken = drawn;
    broken.options.alias = Alias::Placed;
    let faults = verify(&broken).expect_err("drawn images in a heap");
    assert!(faults.iter().any(|fault| fault.to_string().contains("is drawn, but images share a heap")), "{faults:?}");
}
