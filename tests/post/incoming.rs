//! The frame in which a plan comes in that was made in the background.

use std::sync::Arc;

use afterimage_graph::image::Size;
use afterimage_graph::node::Resource;
use afterimage_plan::Plan;

use super::Host;
use crate::support::gpu::changed;

/// The passes that name images of the host: all, or inputs alone.
fn naming_the_host(plan: &Plan, with_outputs: bool) -> usize {
    let of_host = |image| {
        plan.inputs.iter().any(|(_, input)| *input == image)
            || with_outputs && plan.outputs.iter().any(|output| output.image == image)
    };
    plan.work().filter(|pass| pass.resources().filter_map(Resource::image).any(of_host)).count()
}

/// Bind groups come with the plan, also those of the images of the frame before.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_that_comes_in_needs_bind_groups_for_new_images_only() {
    let mut host = Host::new(changed("caracal.ron", None, &[]));
    host.frame().unwrap();
    assert_eq!(host.post.executor().passes_bound(), naming_the_host(&host.plan(), true), "it was loaded at once");
    for (number, emissive) in [false, true, false, true].into_iter().enumerate() {
        host.post.set_fact("emissive", emissive);
        let old = host.plan();
        host.frame().unwrap();
        host.post.finish_changes().unwrap();
        let plan = host.plan();
        assert!(!Arc::ptr_eq(&old, &plan), "another plan comes in");
        let has_new_scene = number >= 2;
        if has_new_scene {
            host.scene = super::scene(&host.gpu, Size::new(96, 54));
        }
        let shown = host.shown();
        let naming = if has_new_scene { naming_the_host(&plan, false) } else { 0 };
        assert_eq!(host.post.executor().passes_bound(), naming, "{number}");
        assert!(!has_new_scene || naming > 0);
        host.frame().unwrap();
        assert_eq!(host.post.executor().passes_bound(), 0, "the next frame has all that it needs");
        let mut wanted = Host::new(changed("caracal.ron", None, &[]));
        wanted.post.set_fact("emissive", emissive);
        super::assert_same(&shown, &wanted.shown());
    }
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
