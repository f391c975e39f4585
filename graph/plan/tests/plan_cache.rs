//! The plan cache: one plan for each distinct answer.

use std::sync::Arc;

use afterimage_graph::check::Facts;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanCache, PlanRequest, Requirement};

use super::support::{all_formats, built_in, checked};

fn planned(plans: &mut PlanCache, side: u32, facts: &[(&str, f64)]) -> Arc<Plan> {
    planned_with(plans, Size::new(side, side), Size::new(side, side), facts)
}

/// The plan for a frame of one size and a host image of another.
fn planned_with(plans: &mut PlanCache, size: Size, image: Size, facts: &[(&str, f64)]) -> Arc<Plan> {
    let mut facts_set = Facts::default();
    facts.iter().for_each(|(name, number)| facts_set.set(*name, *number));
    let request = PlanRequest {
        given: HostInputs {
            inputs: [("scene".to_owned(), HostImageDesc { desc: ImageDesc::new(image), finite: false })].into(),
            ..HostInputs::none(size)
        },
        facts: facts_set,
        caps: all_formats(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    plans.plan(&request).unwrap_or_else(|error| panic!("{error}"))
}

const LAMPS: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "soft": Gaussian(source: "scene", kernel: Sigma, sigma: 2.0, when: "lamps > 3"),
        "lit": Composite(base: "scene", bloom: "soft", blend: Add, strength: 0.5),
    },
    outputs: { "out": "lit" },
)"#;

#[test]
fn a_fact_needs_another_plan_only_if_a_condition_changes() {
    let mut plans = PlanCache::new(checked(LAMPS));
    let dark = planned(&mut plans, 64, &[("lamps", 0.0)]);
    let lit = planned(&mut plans, 64, &[("lamps", 4.0)]);
    assert!(dark.passes.len() < lit.passes.len(), "the condition disables passes");
    for (lamps, wanted) in [(1.0, &dark), (3.0, &dark), (5.0, &lit), (3.5, &lit), (-2.0, &dark)] {
        assert!(Arc::ptr_eq(&planned(&mut plans, 64, &[("lamps", lamps), ("rain", lamps)]), wanted), "{lamps} lamps");
    }
    let larger = planned(&mut plans, 65, &[("lamps", 4.0)]);
    assert_eq!(larger.size, Size::new(65, 65));
    assert!(Arc::ptr_eq(&planned(&mut plans, 64, &[("lamps", 4.0)]), &lit), "both sizes are kept");
}

#[test]
fn a_frame_of_another_size_needs_another_plan_also_with_the_same_images() {
    let mut plans = PlanCache::new(checked(LAMPS));
    let sides = [64, 32, 64].map(|side| {
        let plan = planned_with(&mut plans, Size::new(side, side), Size::new(64, 64), &[]);
        plan.size.width
    });
    assert_eq!(sides, [64, 32, 64]);
    let image = |side| Size::new(side, side);
    let [small, large] = [16, 48].map(|side| planned_with(&mut plans, Size::new(64, 64), image(side), &[]));
    assert!(!Arc::ptr_eq(&small, &large), "images of another size need another plan, too");
}

#[test]
fn other_switches_and_another_device_need_another_plan() {
    let mut plans = PlanCache::new(checked(LAMPS));
    let size = Size::new(64, 64);
    let mut plan = |options: Options, caps: Caps| {
        let inputs = [("scene".to_owned(), HostImageDesc { desc: ImageDesc::new(size), finite: false })].into();
        let requirement = &Requirement::typical;
        let request = PlanRequest {
            given: HostInputs { inputs, ..HostInputs::none(size) },
            facts: Facts::default(),
            caps,
            options,
            dynamic: Default::default(),
            requirement,
        };
        plans.plan(&request).unwrap_or_else(|error| panic!("{error}"))
    };
    let first = plan(Options::default(), all_formats());
    let serial = plan(Options { serial: true, ..Options::default() }, all_formats());
    let plain = plan(Options::default(), Caps::default());
    assert!(!Arc::ptr_eq(&first, &serial) && !Arc::ptr_eq(&first, &plain));
    assert!(Arc::ptr_eq(&first, &plan(Options::default(), all_formats())), "the first is kept");
}

#[test]
fn plans_unused_for_long_are_dropped() {
    let mut plans = PlanCache::new(built_in("exposure.ron"));
    let first = Arc::downgrade(&planned(&mut plans, 1, &[]));
    let second = Arc::downgrade(&planned(&mut plans, 2, &[]));
    for side in 3..200 {
        planned(&mut plans, side, &[]);
        planned(&mut plans, 2, &[]);
    }
    assert!(first.upgrade().is_none(), "plans must not pile up");
    assert!(second.upgrade().is_some(), "a plan that is in use stays");
}
