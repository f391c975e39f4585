//! What the scene does not need costs nothing.

use afterimage_plan::Plan;

use crate::support::gpu::{Picture, Run, gpu, shipped};

fn plan(name: &str, change: impl Fn(&mut Run<'_>)) -> Plan {
    let graph = shipped(name, None);
    let picture = Picture::new(640, 360, |_, _| [0.5; 4]);
    let mut run = Run::new(&graph);
    change(&mut run);
    run.plan(&gpu(), &[("scene", &picture)])
}

/// Every node that some pass works for.
fn works(plan: &Plan) -> Vec<&str> {
    plan.recording.passes.iter().flat_map(|pass| &pass.nodes).map(String::as_str).collect()
}

const GLOW: [&str; 5] = ["glowing", "mips", "soft", "bloom", "lit"];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_caracal_without_lights_in_view_has_no_pass_for_its_glow() {
    let lit = plan("caracal.ron", |run| run.facts.set("emissive", true));
    assert!(GLOW.iter().all(|node| works(&lit).contains(node)), "{:?}", works(&lit));
    let dark = plan("caracal.ron", |run| run.facts.set("emissive", false));
    assert!(!works(&dark).iter().any(|node| GLOW.contains(node)), "{:?}", works(&dark));
    assert_eq!(dark.recording.passes.len(), 1, "exposure, curve and encoding are one pass: {:?}", works(&dark));
    let told = dark.skipped.iter().find(|left| left.node == "glowing").expect("the plan says what it left out");
    assert!(told.why.contains("emissive"), "{}", told.why);
    assert!(dark.memory.placed < lit.memory.placed / 10, "{} of {} bytes", dark.memory.placed, lit.memory.placed);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_noon_has_no_night_vision_and_a_night_has() {
    assert!(!works(&plan("tsushima.ron", |_| {})).contains(&"seen"));
    assert!(works(&plan("tsushima-night.ron", |_| {})).contains(&"seen"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn neutral_grading_is_left_out_of_a_plan_and_says_so() {
    let plan = plan("tsushima.ron", |_| {});
    for node in ["seen", "white", "graded", "look", "grain"] {
        assert!(plan.skipped.iter().any(|left| left.node == node), "`{node}` is at its neutral values");
        assert!(!works(&plan).contains(&node));
    }
}
