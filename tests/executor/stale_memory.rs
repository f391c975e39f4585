//! What memory held before a frame must not be seen in it.

use std::sync::Arc;

use afterimage_graph::node::{ImageId, Origin, Pass};
use afterimage_plan::codegen::codegen;
use afterimage_plan::{Alias, Plan, PlannedPass, ScheduledPass, When};

use super::{bits, lively, nan_kernel};
use crate::support::gpu::{Picture, Run, built_in};
use crate::support::player::Player;

/// The same images and passes, but every pass that writes one image fills it with NaN.
fn poisoned(plan: &Plan) -> (Plan, usize) {
    let mut plan = plan.clone();
    let mut filled = 0;
    let mut scheduled: Vec<ScheduledPass> = plan.passes.iter().map(PlannedPass::scheduled).collect();
    for ScheduledPass { pass, .. } in &mut scheduled {
        let Some(result) = pass.function_result() else { continue };
        *pass = Pass::of_functions(pass.nodes.clone(), pass.label.clone(), vec![nan_kernel()], result);
        filled += 1;
    }
    plan.passes = codegen(scheduled, &plan.images);
    (plan, filled)
}

fn transients(plan: &Plan) -> usize {
    let made = |index: &usize| plan.image(ImageId(*index as u32)).origin == Origin::Transient;
    let used = |index: &usize| plan.images[*index].lifetime.is_some();
    (0..plan.images.len()).filter(used).filter(made).count()
}

/// In a texture of its own each image finds what the plan before has left in it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_full_of_nan_before_a_frame_are_not_seen_in_it() {
    let scene = lively(96, 54);
    for name in ["tsushima.ron", "lynx.ron", "caracal.ron", "glare.ron"] {
        let graph = built_in(name, None);
        let mut run = Run::new(&graph);
        run.options.alias = Alias::None;
        run.options.row_downsample = When::Never;
        let mut player = Player::new();
        let inputs = [("scene", &scene)];
        let plan = player.load(&run, &inputs);
        player.frame(&inputs, 0.0, true);
        let clean = player.output("display");
        player.renew();
        let (poison, filled) = poisoned(&plan);
        assert!(2 * filled > transients(&plan), "{name}: only {filled} images are poisoned");
        player.executor.load(Arc::new(poison)).unwrap_or_else(|error| panic!("{name}: {error}"));
        player.frame(&inputs, 0.0, true);
        player.executor.load(plan).unwrap_or_else(|error| panic!("{name}: {error}"));
        player.frame(&inputs, 0.0, true);
        assert_eq!(bits(&player.output("display")), bits(&clean), "{name}");
    }
}

/// In shared memory each image finds what another one has left in this frame or the one before.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_does_not_see_the_one_before() {
    let (bright, dim) = (lively(96, 54), super::flat(96, 54, 0.01));
    for name in ["tsushima.ron", "lynx.ron", "caracal.ron", "glare.ron", "exposure.ron", "grade.ron", "hdr.ron"] {
        let graph = built_in(name, None);
        let mut player = Player::new();
        let mut show = |scenes: &[&Picture]| {
            player.renew();
            player.load(&Run::new(&graph), &[("scene", &dim)]);
            for scene in scenes {
                player.frame(&[("scene", scene)], 0.0, true);
            }
            bits(&player.output(&graph.outputs[0].name))
        };
        assert_eq!(show(&[&bright, &dim]), show(&[&dim]), "{name}");
    }
}
