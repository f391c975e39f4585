//! A fault planted in the barriers: the checker refuses the plan, and the validation layer sees the hazard.

use std::sync::Arc;

use afterimage_graph::plan::{Tiles, check_plan};

use super::lively;
use crate::support::gpu::{Run, shipped};
use crate::support::layer;
use crate::support::player::Player;

#[test]
fn memory_that_changes_hands_untouched_is_seen_by_the_checker_and_by_the_layer() {
    assert!(layer::is_installed(), "the validation layer is missing: apt-get install vulkan-validationlayers");
    let graph = shipped("tsushima.ron", None);
    let scene = lively(256, 144);
    let mut player = Player::new();
    let mut run = Run::new(&graph);
    run.options.tile = Tiles::Never;
    let plan = player.load(&run, &[("scene", &scene)]);
    check_plan(&plan).expect("the plan is good");
    layer::said();
    player.frame(&[("scene", &scene)], 0.0, true);
    player.output("display");
    assert_eq!(layer::said(), Vec::<String>::new());

    let mut broken = (*plan).clone();
    broken.barriers.iter_mut().for_each(|barriers| barriers.hand_overs.clear());
    let faults = check_plan(&broken).expect_err("no hand-over is left");
    assert!(faults.iter().any(|fault| fault.to_string().contains("nothing separates them")), "{faults:?}");
    player.renew();
    player.executor.load(Arc::new(broken)).expect("the executor runs what it is given");
    player.frame(&[("scene", &scene)], 0.0, true);
    player.output("display");
    let said = layer::said();
    assert!(said.iter().any(|line| line.contains("SYNC-HAZARD")), "the layer has nothing to say: {said:?}");
}
