//! Histories: results of earlier frames.

use afterimage_plan::Stage;

use super::{at_tier, flat, level, without_features};
use crate::support::gpu::{Picture, Run};
use crate::support::player::Player;

/// Half of what comes and half of what was.
pub(super) const TRAIL: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "trail": Composite(base: "scene", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear) },
    outputs: { "out": "trail" },
)"#;

/// The trail with a node behind it.
pub(super) const BRIGHTER: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "trail": Composite(base: "scene", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
        "brighter": Exposure(source: "trail", stops: 1.0),
    },
    outputs: { "out": "brighter" },
)"#;

fn load(player: &mut Player, text: &str, scene: &Picture) {
    let graph = at_tier(text, None);
    player.load(&Run::new(&graph), &[("scene", scene)]);
}

fn step(player: &mut Player, scene: &Picture, reset: bool) -> f32 {
    player.frame(&[("scene", scene)], 0.1, reset);
    level(&player.output("out"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_past_of_a_first_frame_is_black_and_then_what_was_made() {
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    load(&mut player, TRAIL, &scene);
    let levels: Vec<f32> = [false, false, false, true, false].map(|reset| step(&mut player, &scene, reset)).into();
    assert_eq!(levels, [0.5, 0.75, 0.875, 0.5, 0.75]);
    player.executor.reset();
    assert_eq!(step(&mut player, &scene, false), 0.5);
}

/// Each frame is drawn into the next texture of the ring.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_that_is_drawn_is_kept_as_one_that_is_dispatched() {
    let scene = flat(8, 4, 1.0);
    let graph = at_tier(TRAIL, None);
    let mut player = Player::new();
    let plan = player.load(&Run { prefer_fragment: true, ..Run::new(&graph) }, &[("scene", &scene)]);
    assert!(plan.passes.iter().all(|planned| planned.stage == Stage::Fragment));
    let levels: Vec<f32> = [false, false, false, true, false].map(|reset| step(&mut player, &scene, reset)).into();
    assert_eq!(levels, [0.5, 0.75, 0.875, 0.5, 0.75]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn counting_from_a_number_resets() {
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    load(&mut player, TRAIL, &scene);
    assert_eq!([(); 2].map(|()| step(&mut player, &scene, false)), [0.5, 0.75]);
    player.executor.count_from(7);
    assert_eq!([(); 2].map(|()| step(&mut player, &scene, false)), [0.5, 0.75]);
}

/// What another history of the same size has left is not the past of one that begins.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_begins_black_also_in_the_place_of_another() {
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    for name in ["trail", "other", "trail", "third", "trail"] {
        load(&mut player, &TRAIL.replace("trail", name), &scene);
        assert_eq!([(); 3].map(|()| step(&mut player, &scene, false)), [0.5, 0.75, 0.875], "{name}");
    }
}

/// Where passes are timed, those of the next plan are, too.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn another_plan_is_timed_as_the_one_before() {
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    load(&mut player, TRAIL, &scene);
    if !player.executor.enable_timing().expect("queries can be made") {
        return assert!(
            player.executor.loaded().expect("a plan is loaded").pass_times().expect("nothing fails").is_none(),
            "the device has no queries"
        );
    }
    for (text, passes) in [(TRAIL, 1), (BRIGHTER, 1), (TRAIL, 1)] {
        load(&mut player, text, &scene);
        step(&mut player, &scene, false);
        let times = player
            .executor
            .loaded()
            .expect("a plan is loaded")
            .pass_times()
            .expect("they can be read")
            .expect("they are measured");
        assert!(times.len() >= passes, "{} times", times.len());
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_wire_reaches_back_as_far_as_it_says() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: { "twice": Exposure(source: "scene", stops: 1.0) },
        outputs: { "now": "twice", "one": "twice@previous", "three": "twice@previous:3" },
    )"#;
    let graph = at_tier(text, None);
    let mut player = Player::new();
    player.load(&Run::new(&graph), &[("scene", &flat(8, 4, 0.0))]);
    let frames = (1..=8).map(|frame| {
        player.frame(&[("scene", &flat(8, 4, frame as f32))], 0.1, frame == 6);
        ["now", "one", "three"].map(|name| level(&player.output(name)))
    });
    let frames: Vec<[f32; 3]> = frames.collect();
    let then = |frame: f32| 2.0 * frame;
    let wanted = [
        [then(1.0), 0.0, 0.0],
        [then(2.0), then(1.0), 0.0],
        [then(3.0), then(2.0), 0.0],
        [then(4.0), then(3.0), then(1.0)],
        [then(5.0), then(4.0), then(2.0)],
        [then(6.0), 0.0, 0.0],
        [then(7.0), then(6.0), 0.0],
        [then(8.0), then(7.0), 0.0],
    ];
    assert_eq!(frames, wanted);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn another_plan_keeps_a_history_that_is_in_both() {
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    load(&mut player, TRAIL, &scene);
    assert_eq!([(); 2].map(|()| step(&mut player, &scene, false)), [0.5, 0.75]);
    load(&mut player, BRIGHTER, &scene);
    assert_eq!(step(&mut player, &scene, false), 2.0 * 0.875);
    // Another number of the same node: only its uniform differs.
    load(&mut player, &BRIGHTER.replace("0.5", "0.25"), &scene);
    assert_eq!(step(&mut player, &scene, false), 2.0 * (0.75 + 0.25 * 0.875));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_of_another_size_is_reset() {
    let (small, large) = (flat(8, 4, 1.0), flat(16, 8, 1.0));
    let mut player = Player::new();
    for scene in [&small, &large, &small] {
        load(&mut player, TRAIL, scene);
        let levels = [(); 2].map(|()| step(&mut player, scene, false));
        assert_eq!(levels, [0.5, 0.75], "{}x{}", scene.width, scene.height);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_past_of_a_node_that_is_off_is_black() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "twice": Exposure(source: "scene", stops: 1.0),
            "other": Exposure(source: "scene", stops: 2.0),
        },
        outputs: { "now": "other", "past": "twice@previous" },
        tiers: { "low": { "twice": Off } },
    )"#;
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    let [high, low] = [None, Some("low")].map(|tier| at_tier(text, tier));
    for graph in [&high, &low, &low, &high] {
        player.load(&Run::new(graph), &[("scene", &scene)]);
        for frame in 0..3 {
            player.frame(&[("scene", &scene)], 0.1, false);
            let past = level(&player.output("past"));
            let runs = graph.node("twice").is_some_and(|(_, node)| !node.off);
            assert_eq!(past, if runs && frame > 0 { 2.0 } else { 0.0 }, "frame {frame}, running: {runs}");
        }
    }
}

/// A device with nothing beyond what WebGPU promises.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn histories_need_no_feature_of_the_device() {
    let mut player = Player::on(without_features());
    let scene = flat(8, 4, 1.0);
    load(&mut player, TRAIL, &scene);
    let levels = [false, false, true].map(|reset| step(&mut player, &scene, reset));
    assert_eq!(levels, [0.5, 0.75, 0.5]);
}
