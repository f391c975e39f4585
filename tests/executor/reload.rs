//! Another plan is made ready while one renders, and takes over between two frames.

use std::sync::Arc;

use afterimage_gpu::{Frame, FrameKind, GpuError};
use afterimage_graph::check::Graph;
use afterimage_graph::node::{Arg, KernelCall, Pass};
use afterimage_plan::{Alias, PlacedPlan, Plan, When};
use afterimage_wgsl::Shader;

use super::histories::{BRIGHTER, TRAIL};
use super::{at_tier, bits, flat, level, lively};
use crate::support::gpu::{Picture, Run, built_in, changed};
use crate::support::layer;
use crate::support::player::Player;

fn planned(player: &Player, graph: &Graph, scene: &Picture) -> Arc<Plan> {
    Arc::new(Run::new(graph).plan(&player.gpu, &[("scene", scene)]))
}

fn step(player: &mut Player, scene: &Picture) -> Vec<u32> {
    player.frame(&[("scene", scene)], 0.1, false);
    bits(&player.output("display"))
}

/// Frames of a fresh executor.
fn alone(player: &mut Player, plan: &Arc<Plan>, scene: &Picture, frames: usize) -> Vec<Vec<u32>> {
    player.renew();
    player.executor.load(plan.clone()).unwrap_or_else(|error| panic!("{error}"));
    (0..frames).map(|_| step(player, scene)).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_old_plan_renders_until_the_new_one_is_swapped_in() {
    let _alone = layer::alone();
    let scene = lively(160, 90);
    let mut player = Player::new();
    let [old, new] = [None, Some("low")].map(|tier| planned(&player, &built_in("lynx.ron", tier), &scene));
    let frames = 40;
    let (before, after) = (alone(&mut player, &old, &scene, frames), alone(&mut player, &new, &scene, 3));
    assert_ne!(before[0], after[0], "the tiers differ");
    player.renew();
    player.executor.load(old.clone()).expect("the first plan");
    layer::messages();
    let preparation = player.executor.prepare(new);
    let mut shown = 0;
    while shown < 2 || (!preparation.is_ready() && shown < frames) {
        assert_eq!(step(&mut player, &scene), before[shown], "frame {shown} is the old plan's");
        shown += 1;
    }
    player.executor.swap(preparation).expect("the new plan");
    player.executor.reset();
    for frame in after {
        assert_eq!(step(&mut player, &scene), frame);
    }
    assert_eq!(layer::messages(), Vec::<String>::new());
}

/// Both frames are in one submission, so nothing but our own barriers is between the two plans.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn two_plans_in_one_submission_do_not_meet_in_their_memory() {
    let _alone = layer::alone();
    let scene = lively(192, 108);
    let mut player = Player::new();
    let mut lit = built_in("tsushima.ron", None);
    let old = planned(&player, &lit, &scene);
    lit.nodes.iter_mut().filter(|node| node.name == "vignette").for_each(|node| node.off = !node.off);
    let new = planned(&player, &lit, &scene);
    let wanted = alone(&mut player, &new, &scene, 1).remove(0);
    player.renew();
    player.executor.load(old).expect("the first plan");
    step(&mut player, &scene);
    layer::messages();
    let input = player.upload(&scene);
    let frame = Frame { inputs: &[("scene", &input)], kind: FrameKind::Cut, ..Frame::default() };
    let mut encoder = player.gpu.device.create_command_encoder(&Default::default());
    player.executor.encode(&mut encoder, &frame).expect("the last frame of the old plan");
    player.executor.load(new).expect("the second plan");
    player.executor.encode(&mut encoder, &frame).expect("the first frame of the new plan");
    player.gpu.queue.submit([encoder.finish()]);
    assert_eq!(bits(&player.output("display")), wanted);
    assert_eq!(layer::messages(), Vec::<String>::new());
}

/// Where the new plan's images lay in the old one, they still lie; and a heap that is large enough is kept.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_keep_their_places_in_the_heap() {
    let scene = lively(640, 360);
    let mut player = Player::new();
    let mut graph = built_in("tsushima.ron", None);
    let old = planned(&player, &graph, &scene);
    graph.nodes.iter_mut().filter(|node| node.name == "grid").for_each(|node| node.off = true);
    let new = planned(&player, &graph, &scene);
    assert_ne!(old.memory.placed, new.memory.placed, "a fresh plan would have another heap");
    player.executor.load(old.clone()).expect("the first plan");
    step(&mut player, &scene);
    player.executor.load(new.clone()).expect("the second plan");
    let running = player.executor.loaded().expect("a plan is loaded").placed_plan();
    assert_eq!(running.placement.heap, old.memory.placed);
    assert_eq!(afterimage_plan::verify_placed(&running), Ok(()));
    let (kept, fresh) = (in_place(&running, &old), in_place(&PlacedPlan::new(new.clone()), &old));
    assert!(kept > fresh, "{kept} images lie where they lay, {fresh} without keeping");
    player.executor.reset();
    let shown = step(&mut player, &scene);
    assert_eq!(shown, alone(&mut player, &new, &scene, 1)[0]);
}

fn in_place(placed: &PlacedPlan, old: &Arc<Plan>) -> usize {
    let places = |placed: &PlacedPlan| -> Vec<(String, u64)> {
        let named = placed.plan.image_names().into_iter().zip(&placed.placement.offsets);
        named.filter_map(|(name, offset)| Some((name, (*offset)?))).collect()
    };
    let old = places(&PlacedPlan::new(old.clone()));
    places(placed).iter().filter(|place| old.contains(place)).count()
}

fn trail(player: &mut Player, scene: &Picture, output: &str) -> f32 {
    player.frame(&[("scene", scene)], 0.1, false);
    level(&player.output(output))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_goes_on_through_frames_that_pass_before_the_swap() {
    let scene = flat(8, 4, 1.0);
    let mut player = Player::new();
    let [first, second] = [TRAIL, BRIGHTER].map(|text| planned(&player, &at_tier(text, None), &scene));
    player.executor.load(first).expect("the first plan");
    assert_eq!(trail(&mut player, &scene, "out"), 0.5);
    let preparation = player.executor.prepare(second);
    assert_eq!([(); 2].map(|()| trail(&mut player, &scene, "out")), [0.75, 0.875]);
    player.executor.swap(preparation).expect("the second plan");
    assert_eq!(trail(&mut player, &scene, "out"), 2.0 * 0.9375);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn numbers_that_were_prepared_for_another_plan_come_with_their_plan() {
    let scene = lively(64, 36);
    let mut player = Player::new();
    let of = |player: &Player, node: &str| {
        let nodes = format!("\"lit\": {node}");
        let text =
            format!("Pipeline(inputs: {{\"scene\": Color}}, nodes: {{{nodes}}}, outputs: {{\"display\": \"lit\"}})");
        planned(player, &at_tier(&text, None), &scene)
    };
    let [first, second, other] = [
        "Exposure(source: \"scene\", stops: 1.0)",
        "Exposure(source: \"scene\", stops: 2.0)",
        "Gaussian(source: \"scene\", sigma: 2.0)",
    ]
    .map(|node| of(&player, node));
    let wanted = alone(&mut player, &second, &scene, 1).remove(0);
    assert_ne!(wanted, alone(&mut player, &other, &scene, 1).remove(0));
    player.renew();
    player.executor.load(first).expect("the first plan");
    let preparation = player.executor.prepare(second);
    while !preparation.is_ready() {
        std::thread::yield_now();
    }
    player.executor.load(other).expect("a plan in between");
    player.executor.swap(preparation).expect("the second plan");
    assert_eq!(step(&mut player, &scene), wanted);
}

/// A trail that remembers one frame, beside an image that is remembered for three.
const DEEPER: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "trail": Composite(base: "scene", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
        "twice": Exposure(source: "scene", stops: 1.0),
    },
    outputs: { "out": "trail", "now": "twice", "past": "twice@previous:3" },
)"#;

/// Frames go on while a plan is prepared whose histories have another depth, and two plans may be prepared at once.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_goes_on_in_a_plan_with_a_deeper_one_and_in_another_that_was_prepared_beside_it() {
    let scene = flat(8, 4, 1.0);
    for frames in 0..4 {
        let mut player = Player::new();
        let plans = [TRAIL, DEEPER, BRIGHTER].map(|text| planned(&player, &at_tier(text, None), &scene));
        let [shallow, deep, brighter] = plans;
        let mut wanted = 0.0;
        let mut half_way = || {
            wanted = 0.5 + 0.5 * wanted;
            wanted
        };
        player.executor.load(shallow).expect("the first plan");
        assert_eq!(trail(&mut player, &scene, "out"), half_way());
        let preparations = [deep, brighter].map(|plan| player.executor.prepare(plan));
        for _ in 0..frames {
            assert_eq!(trail(&mut player, &scene, "out"), half_way());
        }
        let [deep, brighter] = preparations;
        player.executor.swap(deep).expect("the deeper plan");
        for past in [0.0, 0.0, 0.0, 2.0] {
            assert_eq!(trail(&mut player, &scene, "out"), half_way(), "after {frames} frames");
            assert_eq!(level(&player.output("past")), past);
        }
        player.executor.swap(brighter).expect("the third plan");
        assert_eq!(trail(&mut player, &scene, "out"), 2.0 * half_way(), "after {frames} frames");
    }
}

/// One plan remembers an image for one frame, the next another image for three frames as well: the first history is
/// still the same.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_history_stays_where_another_begins() {
    let scene = flat(8, 4, 1.0);
    for frames in 1..5 {
        let mut player = Player::new();
        let [shallow, deep] = [TRAIL, DEEPER].map(|text| planned(&player, &at_tier(text, None), &scene));
        let mut wanted = 0.0;
        let mut half_way = || {
            wanted = 0.5 + 0.5 * wanted;
            wanted
        };
        player.executor.load(shallow.clone()).expect("the first plan");
        for _ in 0..frames {
            assert_eq!(trail(&mut player, &scene, "out"), half_way());
        }
        player.executor.load(deep).expect("the second plan");
        for past in [0.0, 0.0, 0.0, 2.0, 2.0] {
            assert_eq!(trail(&mut player, &scene, "out"), half_way(), "after {frames} frames");
            assert_eq!(level(&player.output("past")), past);
        }
        player.executor.load(shallow).expect("the first plan again");
        assert_eq!(trail(&mut player, &scene, "out"), half_way());
    }
}

/// A window that changes its size resets the trail; the eye stays adapted.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_adaptation_goes_on_where_an_image_is_reset() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "bins": Histogram(source: "scene"),
            "meter": AutoExposure(histogram: "bins"),
            "exposed": Exposure(source: "scene", meter: "meter"),
            "trail": Composite(base: "exposed", bloom: "trail@previous", blend: Mix, strength: 0.5, filter: Bilinear),
        },
        outputs: { "exposed": "exposed", "trail": "trail" },
    )"#;
    let graph = at_tier(text, None);
    let exposed = |sizes: [(u32, u32); 2]| {
        let mut player = Player::new();
        let [dim, bright] = [(0, 0.2), (1, 8.0)].map(|(at, light)| flat(sizes[at].0, sizes[at].1, light));
        player.load(&Run::new(&graph), &[("scene", &dim)]);
        player.frame(&[("scene", &dim)], 0.1, true);
        player.load(&Run::new(&graph), &[("scene", &bright)]);
        player.frame(&[("scene", &bright)], 0.1, false);
        ["exposed", "trail"].map(|name| level(&player.output(name)))
    };
    let [kept, resized] = [[(64, 36); 2], [(64, 36), (96, 54)]].map(exposed);
    assert_eq!(kept[0], resized[0], "the adaptation goes on");
    assert!(kept[0] > 1.0, "the eye is dazzled: {}", kept[0]);
    assert_eq!(resized[1], 0.5 * resized[0], "the trail is reset");
    assert!(kept[1] > resized[1], "a trail of the same size goes on");
}

static TORN: Shader = Shader::new("torn.wgsl", "fn torn(at: Point) -> vec4f { return nothing; }");

/// The plan with a shader that does not compile in place of one of its functions.
fn broken(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    let mut functions = plan.passes.iter_mut().map(|planned| &mut planned.pass);
    let pass = functions.rfind(|pass| pass.function_result().is_some()).expect("the plan has functions");
    let result = pass.function_result().expect("it was found by it");
    let kernel = KernelCall::function("torn", &TORN, "torn", &[("at", Arg::Point)]);
    *pass = Pass::of_functions(pass.nodes.clone(), pass.label.clone(), vec![kernel], result);
    plan
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_broken_shader_is_an_error_and_the_old_plan_renders_on() {
    let scene = lively(64, 36);
    let graph = built_in("exposure.ron", None);
    let mut player = Player::new();
    let plan = planned(&player, &graph, &scene);
    let wanted = alone(&mut player, &plan, &scene, 4);
    let shown = alone(&mut player, &plan, &scene, 2);
    assert_eq!(shown, wanted[..2]);
    let preparation = player.executor.prepare(Arc::new(broken(&plan)));
    assert_eq!(step(&mut player, &scene), wanted[2]);
    let error = player.executor.swap(preparation).expect_err("the shader is broken");
    assert!(matches!(error, GpuError::Shader(_)) && error.to_string().contains("identifier: `nothing`"), "{error}");
    assert_eq!(step(&mut player, &scene), wanted[3], "the adaptation goes on");
}

/// The shader is good, but no device has so many workgroups: the plan's last check is the device's own.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plan_that_the_device_refuses_leaves_histories_as_they_are() {
    let scene = flat(64, 36, 1.0);
    let mut player = Player::new();
    let graph = at_tier(TRAIL, None);
    let mut run = Run::new(&graph);
    run.options.alias = Alias::None;
    run.options.row_downsample = When::Never;
    let plan = player.load(&run, &[("scene", &scene)]);
    let mut too_large = (*plan).clone();
    for image in &mut too_large.images {
        image.desc.size.width = 1 << 20;
    }
    assert_eq!([(); 2].map(|()| trail(&mut player, &scene, "out")), [0.5, 0.75]);
    let error = player.executor.load(Arc::new(too_large)).expect_err("no device has such images");
    assert!(matches!(error, GpuError::Refused { .. } | GpuError::OutOfMemory { .. }), "{error}");
    assert_eq!(trail(&mut player, &scene, "out"), 0.875);
}

/// Numbers alone are written into the plan that they were prepared for, and into no other.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn numbers_that_come_after_another_plan_bring_their_own_plan() {
    let scene = lively(64, 36);
    let mut player = Player::new();
    let brighter = changed("lynx.ron", None, &[("exposed.stops", "1.5")]);
    let graphs = [built_in("lynx.ron", None), brighter, built_in("exposure.ron", None)];
    let [first, numbers, other] = graphs.map(|graph| planned(&player, &graph, &scene));
    let wanted = alone(&mut player, &numbers, &scene, 1);
    assert_ne!(wanted, alone(&mut player, &first, &scene, 1), "the numbers matter");
    player.renew();
    player.executor.load(first).expect("the first plan");
    step(&mut player, &scene);
    let preparation = player.executor.prepare(numbers);
    player.executor.load(other).expect("another plan");
    step(&mut player, &scene);
    player.executor.swap(preparation).expect("the plan with other numbers");
    player.executor.reset();
    assert_eq!(step(&mut player, &scene), wanted[0]);
}
