//! Immediates, and draws in the place of dispatches.

use afterimage_graph::check::Facts;
use afterimage_graph::image::Format;
use afterimage_graph::node::PassKind;
use afterimage_plan::codegen::{CodeOptions, Slot, SlotKind};
use afterimage_plan::{Alias, Caps, Options, Plan, Stage, verify};

use super::support::{all_formats, built_in, plan_images};

/// Immediates take the place of one binding: that of the frame's constants.
#[test]
fn a_compute_kernel_takes_the_frame_as_immediates_or_bound() {
    let graph = built_in("exposure.ron");
    let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), all_formats(), Options::default());
    let mut with_frame = 0;
    for (index, planned) in plan.passes.iter().enumerate().filter(|(_, p)| p.pass.kind == PassKind::Compute) {
        let compose = |immediates| {
            plan.compose(index, CodeOptions { immediates, ..Default::default() })
                .unwrap_or_else(|error| panic!("{}: {error}", planned.pass.label))
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

/// Parameters in a storage buffer take the binding of the uniform.
#[test]
fn functions_read_their_parameters_from_a_storage_buffer_on_a_processor() {
    let graph = built_in("exposure.ron");
    let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), all_formats(), Options::default());
    let mut with_params = 0;
    for index in 0..plan.passes.len() {
        let compose = |on_processor| {
            let options = CodeOptions { on_processor, ..CodeOptions::default() };
            plan.compose(index, options).unwrap_or_else(|error| panic!("{error}"))
        };
        let (uniform, stored) = (compose(false), compose(true));
        let places = |slots: &[Slot], kind| slots.iter().position(|slot| slot.kind == kind);
        let place = places(&stored.slots, SlotKind::StoredParams);
        if plan.passes[index].pass.kind != PassKind::Compute {
            assert_eq!(place, places(&uniform.slots, SlotKind::Params));
        }
        assert_eq!(stored.source.matches("var<storage, read> params").count(), usize::from(place.is_some()));
        stored.validate().unwrap_or_else(|error| panic!("{error}"));
        with_params += usize::from(place.is_some());
    }
    assert!(with_params > 0);
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
