//! PlanCache that are made once for each distinct answer.

use std::sync::Arc;

use afterimage_graph::check::Facts;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_plan::{Caps, GivenImage, Options, Plan, PlanCache, PlanRequest, Requirement};

use crate::support::gpu::{graph, shipped};

fn planned(plans: &mut PlanCache, side: u32, facts: &[(&str, f64)]) -> Arc<Plan> {
    let size = Size::new(side, side);
    let mut told = Facts::default();
    facts.iter().for_each(|(name, number)| told.set(*name, *number));
    let setting = PlanRequest {
        size,
        inputs: [("scene".to_owned(), GivenImage { desc: ImageDesc::new(size), finite: false })].into(),
        facts: told,
        caps: Caps { storage: Format::ALL.into(), ..Caps::default() },
        options: Options::default(),
        requirement: &Requirement::typical,
    };
    plans.plan(&setting).unwrap_or_else(|error| panic!("{error}"))
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
fn a_fact_asks_for_a_plan_only_where_a_condition_answers_otherwise() {
    let mut plans = PlanCache::new(graph(LAMPS));
    let dark = planned(&mut plans, 64, &[("lamps", 0.0)]);
    let lit = planned(&mut plans, 64, &[("lamps", 4.0)]);
    assert!(dark.recording.passes.len() < lit.recording.passes.len(), "the condition leaves passes out");
    for (lamps, wanted) in [(1.0, &dark), (3.0, &dark), (5.0, &lit), (3.5, &lit), (-2.0, &dark)] {
        assert!(Arc::ptr_eq(&planned(&mut plans, 64, &[("lamps", lamps), ("rain", lamps)]), wanted), "{lamps} lamps");
    }
    let larger = planned(&mut plans, 65, &[("lamps", 4.0)]);
    assert_eq!(larger.size, Size::new(65, 65));
    assert!(Arc::ptr_eq(&planned(&mut plans, 64, &[("lamps", 4.0)]), &lit), "both sizes are remembered");
}

#[test]
fn what_was_not_asked_for_in_a_long_time_makes_room() {
    let mut plans = PlanCache::new(shipped("exposure.ron", None));
    let first = Arc::downgrade(&planned(&mut plans, 1, &[]));
    let second = Arc::downgrade(&planned(&mut plans, 2, &[]));
    for side in 3..200 {
        planned(&mut plans, side, &[]);
        planned(&mut plans, 2, &[]);
    }
    assert!(first.upgrade().is_none(), "plans must not pile up");
    assert!(second.upgrade().is_some(), "a plan that is in use stays");
}
