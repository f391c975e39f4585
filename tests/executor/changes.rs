//! One executor, plan after plan.

use std::sync::Arc;

use afterimage_gpu::{Frame, GpuError};
use afterimage_graph::image::Size;
use afterimage_graph::node::Origin;
use afterimage_plan::{Alias, Options, When};

use super::{at_tier, bits, lively};
use crate::support::gpu::{Picture, Run, built_in};
use crate::support::player::Player;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_tier_swapped_between_two_frames_is_the_tier_from_the_start() {
    let scene = lively(160, 90);
    let [full, low] = [None, Some("low")].map(|tier| built_in("lynx.ron", tier));
    for alias in [Alias::Placed, Alias::Pool, Alias::None] {
        let mut player = Player::new();
        let mut show = |renew: bool, graph| {
            if renew {
                player.renew();
            }
            let mut run = Run::new(graph);
            run.options.alias = alias;
            player.load(&run, &[("scene", &scene)]);
            player.frame(&[("scene", &scene)], 0.1, true);
            bits(&player.output("display"))
        };
        let [first_full, first_low] = [&full, &low].map(|graph| show(true, graph));
        assert_ne!(first_full, first_low, "the tiers differ");
        for _ in 0..2 {
            assert_eq!(show(false, &full), first_full, "{alias:?}");
            assert_eq!(show(false, &low), first_low, "{alias:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_adaptation_goes_on_through_a_change_of_tier_and_size() {
    let [dim, bright] = [0.2, 8.0].map(|light| super::flat(160, 90, light));
    let exposures = |change: bool| {
        let [full, low] = [None, Some("low")].map(|tier| built_in("tsushima.ron", tier));
        let mut player = Player::new();
        player.load(&Run::new(&full), &[("scene", &dim)]);
        player.frame(&[("scene", &dim)], 0.1, true);
        player.frame(&[("scene", &bright)], 0.05, false);
        if change {
            player.load(&Run::new(&low), &[("scene", &bright)]);
        }
        player.frame(&[("scene", &bright)], 0.05, false);
        player.output("display").at(80, 45)[0]
    };
    // A new adaptation would show the bright picture as it shows the dim one.
    let [kept, changed] = [false, true].map(exposures);
    assert!((kept - changed).abs() < 2.5 / 255.0, "{kept} {changed}");
    let graph = built_in("tsushima.ron", None);
    let settled = Run::new(&graph).frame(&[("scene", &bright)])[0].at(80, 45)[0];
    assert!(kept - settled > 0.1, "the eye is still dazzled: {kept} and {settled}");
}

const TWO: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 1.0),
        "soft": Gaussian(source: "exposed", kernel: Sigma, sigma: 2.0),
        "lit": Composite(base: "exposed", bloom: "soft", blend: Add, strength: 0.5),
    },
    outputs: { "out": "lit" },
)"#;

/// After a change of numbers the images of the last frame are still there: only uniforms were written. The last pass
/// alone shows it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn another_number_rewrites_a_uniform_and_nothing_else() {
    let scene = lively(64, 36);
    let mut player = Player::new();
    let [graph, stronger] = [TWO.into(), TWO.replace("0.5", "2.0")].map(|text: String| at_tier(&text, None));
    let plan = player.load(&Run::new(&graph), &[("scene", &scene)]);
    let input = player.upload(&scene);
    let frame = Frame { inputs: &[("scene", &input)], ..Frame::default() };
    player.run(&frame).expect("a frame");
    let texture = player.executor.output("out").expect("it is an output").clone();
    player.load(&Run::new(&stronger), &[("scene", &scene)]);
    let mut encoder = player.gpu.device.create_command_encoder(&Default::default());
    let last = plan.passes.len() - 1;
    player.executor.encode_pass(&mut encoder, &frame, last).expect("one pass");
    player.gpu.queue.submit([encoder.finish()]);
    let alone = player.output("out");
    assert_eq!(player.executor.output("out"), Some(&texture));
    player.renew();
    player.load(&Run::new(&stronger), &[("scene", &scene)]);
    player.frame(&[("scene", &scene)], 0.0, false);
    assert_eq!(bits(&alone), bits(&player.output("out")));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_window_of_any_size_shows_what_a_fresh_executor_shows() {
    let graph = built_in("exposure.ron", None);
    let mut player = Player::new();
    let mut show = |scene: &Picture, renew: bool| {
        if renew {
            player.renew();
        }
        player.load(&Run::new(&graph), &[("scene", scene)]);
        player.frame(&[("scene", scene)], 0.0, true);
        player.output("display")
    };
    let scenes = [(64, 36), (131, 77), (1, 1), (64, 36), (200, 3)].map(|(width, height)| lively(width, height));
    let one_after_another: Vec<Picture> = scenes.iter().map(|scene| show(scene, false)).collect();
    for (scene, seen) in scenes.iter().zip(&one_after_another) {
        assert_eq!(bits(seen), bits(&show(scene, true)), "{}x{}", scene.width, scene.height);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_that_the_device_refuses_leaves_the_old_one_running() {
    let graph = at_tier(TWO, None);
    let scene = lively(64, 36);
    let mut player = Player::new();
    let run = Run { options: Options { alias: Alias::None, ..Options::default() }, ..Run::new(&graph) };
    let plan = player.load(&run, &[("scene", &scene)]);
    player.frame(&[("scene", &scene)], 0.0, false);
    let before = player.output("out");
    let mut impossible = (*plan).clone();
    let used =
        |index: &usize| plan.images[*index].lifetime.is_some() && plan.images[*index].origin == Origin::Transient;
    let image = (0..plan.images.len()).find(used).expect("the plan makes images");
    let too_large = Size::new(1 << 20, 1);
    impossible.images[image].desc.size = too_large;
    for slot in &mut impossible.memory.slots {
        slot.desc.size = too_large;
    }
    let error = player.executor.load(Arc::new(impossible)).expect_err("no device has such images");
    assert!(matches!(error, GpuError::Refused { .. } | GpuError::OutOfMemory { .. }), "{error}");
    player.frame(&[("scene", &scene)], 0.0, false);
    assert_eq!(bits(&player.output("out")), bits(&before));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_single_pass_runs_without_those_before_it() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: { "soft": Gaussian(source: "scene", kernel: Sigma, sigma: 2.0) },
        outputs: { "out": "soft" },
    )"#;
    let graph = at_tier(text, None);
    let mut player = Player::new();
    let mut run = Run::new(&graph);
    run.options.row_downsample = When::Never;
    let (scene, other) = (lively(64, 36), super::flat(64, 36, 9.0));
    let plan = player.load(&run, &[("scene", &scene)]);
    assert_eq!(plan.passes.len(), 2, "{}", plan.to_text());
    player.frame(&[("scene", &scene)], 0.0, true);
    let before = bits(&player.output("out"));
    let input = player.upload(&other);
    let frame = Frame { inputs: &[("scene", &input)], ..Frame::default() };
    let mut run_pass = |pass: usize| {
        let mut encoder = player.gpu.device.create_command_encoder(&Default::default());
        player.executor.encode_pass(&mut encoder, &frame, pass).expect("one pass");
        player.gpu.queue.submit([encoder.finish()]);
        bits(&player.output("out"))
    };
    assert_eq!(run_pass(1), before, "the image of the first pass is as it was");
    assert_eq!(run_pass(0), before, "and the second did not run");
    assert_ne!(run_pass(1), before);
}
