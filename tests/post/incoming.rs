//! The frame in which a plan comes in that was made in the background.

use std::sync::Arc;

use afterimage_graph::node::Resource;
use afterimage_plan::Plan;

use super::Host;
use crate::support::gpu::changed;

/// The passes that name an image of the host.
fn naming_the_host(plan: &Plan) -> usize {
    let of_host = |image| {
        plan.inputs.iter().any(|(_, input)| *input == image) || plan.outputs.iter().any(|output| output.image == image)
    };
    plan.work().filter(|pass| pass.resources().filter_map(Resource::image).any(of_host)).count()
}

/// Bind groups that name no image of the host come with the plan.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_that_comes_in_needs_only_the_bind_groups_of_the_hosts_images() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    host.frame().unwrap();
    assert_eq!(host.post.executor().passes_bound(), naming_the_host(&host.plan()), "the plan was loaded at once");
    let mut counts = Vec::new();
    for emissive in [false, true, false, true] {
        host.post.set_fact("emissive", emissive);
        let old = host.plan();
        host.frame().unwrap();
        host.post.finish_changes().unwrap();
        let plan = host.plan();
        assert!(!Arc::ptr_eq(&old, &plan), "another plan comes in");
        host.frame().unwrap();
        let bound = host.post.executor().passes_bound();
        assert_eq!(bound, naming_the_host(&plan));
        host.frame().unwrap();
        assert_eq!(host.post.executor().passes_bound(), 0, "the next frame has all that it needs");
        counts.push((bound, plan.passes.len()));
    }
    let (bound, passes) = counts[1];
    assert!(2 * bound < passes, "{counts:?}");
}

/// What handles have set while a plan is being made holds in its first frame, and so do values that were set before.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn values_that_are_set_while_a_plan_is_made_hold_in_its_first_frame() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    let (strength, stops) = ("lit.strength", "exposed.stops");
    let (strength, stops) = (host.post.parameter::<f32>(strength), host.post.parameter::<f32>(stops));
    let (strength, stops) = (strength.unwrap(), stops.unwrap());
    host.frame().unwrap();
    for (number, emissive) in [false, true, false, true].into_iter().enumerate() {
        let value = 0.1 + 0.2 * number as f32;
        host.post.set(strength, value).unwrap();
        host.post.set_fact("emissive", emissive);
        host.frame().unwrap();
        host.post.set(stops, value).unwrap();
        host.post.finish_changes().unwrap();
        let shown = host.shown();
        let text = format!("{value:?}");
        let mut wanted = Host::new(changed("caracal.ron", None, &[("lit.strength", &text), ("exposed.stops", &text)]));
        for name in ["lit.strength", "exposed.stops"] {
            wanted.post.control(name).unwrap();
        }
        wanted.post.set_fact("emissive", emissive);
        super::assert_same(&shown, &wanted.shown());
    }
}
