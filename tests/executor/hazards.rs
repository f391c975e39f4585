//! A plan without its aliasing barriers: `verify` refuses it, and the validation layer reports the hazard.

use std::sync::Arc;

use afterimage_plan::{When, verify};

use super::{at_tier, lively};
use crate::support::gpu::Run;
use crate::support::layer;
use crate::support::player::Player;

/// Two independent blurs: the image between the passes of one aliases that of the other. Their sizes differ, because
/// images with equal descriptors would share a texture, which wgpu tracks by itself.
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
fn a_missing_aliasing_barrier_is_found_by_verify_and_by_the_validation_layer() {
    let _alone = layer::alone();
    assert!(layer::is_installed(), "the validation layer is missing: apt-get install vulkan-validationlayers");
    let graph = at_tier(TWO_BLURS, None);
    let (scene, small) = (lively(256, 144), lively(128, 72));
    let inputs = [("scene", &scene), ("small", &small)];
    let mut player = Player::new();
    let mut run = Run::new(&graph);
    run.options.row_downsample = When::Never;
    run.options.serial = true;
    let plan = player.load(&run, &inputs);
    verify(&plan).expect("the plan is good");
    assert!(plan.batches.iter().any(|batch| !batch.aliasing.is_empty()), "images share memory");
    layer::messages();
    player.frame(&inputs, 0.0, true);
    player.output("wide");
    assert_eq!(layer::messages(), Vec::<String>::new());

    let mut broken = (*plan).clone();
    broken.batches.iter_mut().for_each(|batch| batch.aliasing.clear());
    let faults = verify(&broken).expect_err("no aliasing barrier is left");
    assert!(faults.iter().any(|fault| fault.to_string().contains("nothing separates them")), "{faults:?}");
    player.renew();
    player.executor.load(Arc::new(broken)).expect("the executor runs what it is given");
    player.frame(&inputs, 0.0, true);
    player.output("wide");
    let messages = layer::messages();
    assert!(messages.iter().any(|line| line.contains("SYNC-HAZARD")), "the layer reports no hazard: {messages:?}");
    assert!(messages.iter().all(|line| line.contains("SYNC-HAZARD")), "{messages:?}");
}
