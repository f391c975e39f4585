//! A fault planted in the barriers: the checker refuses the plan, and the validation layer sees the hazard.

use std::sync::Arc;

use afterimage_plan::{When, verify};

use super::{at_tier, lively};
use crate::support::gpu::Run;
use crate::support::layer;
use crate::support::player::Player;

/// Two blurs that have nothing to do with each other: what is between the passes of one lies where that of the other
/// has lain. Their sizes differ, or both would be one texture, of which wgpu knows by itself.
const TWO_BLURS: &str = r#"Pipeline(
    inputs: { "scene": Color, "small": Color },
    nodes: {
        "narrow": Gaussian(source: "scene", kernel: Sigma, sigma: 2.0),
        "wide": Gaussian(source: "small", kernel: Sigma, sigma: 5.0),
    },
    outputs: { "narrow": "narrow", "wide": "wide" },
)"#;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_that_changes_hands_untouched_is_seen_by_the_checker_and_by_the_layer() {
    let _alone = layer::alone();
    assert!(layer::is_installed(), "the validation layer is missing: apt-get install vulkan-validationlayers");
    let graph = at_tier(TWO_BLURS, None);
    let (scene, small) = (lively(256, 144), lively(128, 72));
    let inputs = [("scene", &scene), ("small", &small)];
    let mut player = Player::new();
    let mut run = Run::new(&graph);
    run.options.tile = When::Never;
    run.options.row_downsample = When::Never;
    run.options.serial = true;
    let plan = player.load(&run, &inputs);
    verify(&plan).expect("the plan is good");
    assert!(plan.batches.iter().any(|batch| !batch.aliasing.is_empty()), "memory changes hands");
    layer::said();
    player.frame(&inputs, 0.0, true);
    player.output("wide");
    assert_eq!(layer::said(), Vec::<String>::new());

    let mut broken = (*plan).clone();
    broken.batches.iter_mut().for_each(|batch| batch.aliasing.clear());
    let faults = verify(&broken).expect_err("no hand-over is left");
    assert!(faults.iter().any(|fault| fault.to_string().contains("nothing separates them")), "{faults:?}");
    player.renew();
    player.executor.load(Arc::new(broken)).expect("the executor runs what it is given");
    player.frame(&inputs, 0.0, true);
    player.output("wide");
    let said = layer::said();
    assert!(said.iter().any(|line| line.contains("SYNC-HAZARD")), "the layer has nothing to say: {said:?}");
    assert!(said.iter().all(|line| line.contains("SYNC-HAZARD")), "{said:?}");
}
