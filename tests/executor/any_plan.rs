//! However a graph is planned, its pixels are the same to the bit: with another order, another placement, no sharing of
//! memory, no overlap, and NaN in memory that an image takes over from another.

use std::ops::Range;
use std::sync::Arc;

use afterimage_generators::{Recipe, Rng, hold_some};
use afterimage_graph::check::{Condition, Graph, Source};
use afterimage_graph::node::{ImageId, Pass, Resource};
use afterimage_plan::codegen::codegen;
use afterimage_plan::{
    Alias, Batch, Lifetime, Options, PlacedPlan, Plan, PlannedPass, Refresh, Requirement, ScheduledPass, Stage, When,
    verify, verify_placed,
};
use petgraph::graph::{DiGraph, NodeIndex};

use super::{bits, lively, nan_kernel};
use crate::support::gpu::{Picture, Run, built_in};
use crate::support::player::Player;
use crate::support::sweep;

/// The random graphs: six in a whole sweep, otherwise the first of them.
fn seeds() -> Range<u64> {
    if sweep::is_whole() { 1..7 } else { 1..2 }
}

/// Pyramids, volumes, values and two outputs among at most forty nodes, with wires to earlier frames.
fn graph(seed: u64) -> Graph {
    Recipe { seed: seed + 100, nodes: 14 + 3 * seed as usize, histories: 3, off: 8 }.graph()
}

/// All outputs of three frames of a moving picture, the second of which is a cut.
fn film(player: &mut Player, plan: &Arc<Plan>, input: &str) -> Vec<Vec<u32>> {
    player.executor.load(plan.clone()).unwrap_or_else(|error| panic!("{error}"));
    player.executor.count_from(0);
    let mut shown = Vec::new();
    for (frame, scene) in scenes().iter().enumerate() {
        player.frame(&[(input, scene)], 0.1, frame == 1);
        shown.extend(plan.outputs.iter().map(|output| bits(&player.output(&output.name))));
    }
    shown
}

fn scenes() -> [Picture; 3] {
    let lively = lively(53, 37);
    [1.0_f32, 0.25, 3.0].map(|light| {
        let lit = |x, y| lively.at(x, y).map(|channel| channel * light);
        Picture::new(lively.width, lively.height, lit)
    })
}

fn planned(player: &Player, graph: &Graph, input: &str, change: impl Fn(&mut Run<'_>)) -> Arc<Plan> {
    let mut run = Run::new(graph);
    run.options.row_downsample = When::Never;
    change(&mut run);
    let plan = run.plan(&player.gpu, &[(input, &scenes()[0])]);
    assert_eq!(verify(&plan), Ok(()));
    Arc::new(plan)
}

const ALIASES: [Alias; 3] = [Alias::None, Alias::Pool, Alias::Placed];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_way_to_run_a_random_graph_gives_the_same_bits() {
    let mut player = Player::new();
    let mut changing = 0;
    for (seed, holds) in seeds().flat_map(|seed| [(seed, false), (seed, true)]) {
        let mut graph = graph(seed);
        if holds {
            hold_some(&mut graph, seed);
        }
        let plan = planned(&player, &graph, "picture", |_| {});
        assert_eq!(!plan.savings.cached.is_empty(), holds);
        let wanted = film(&mut player, &plan, "picture");
        changing += usize::from(wanted[0] != wanted[2 * graph.outputs.len()]);
        for alias in ALIASES {
            for [serial, batches_first] in [[false, false], [true, false], [false, true]] {
                let row_downsample = When::Never;
                let options = Options { alias, serial, batches_first, row_downsample, ..Options::default() };
                let plan = planned(&player, &graph, "picture", |run| run.options = options);
                assert_eq!(film(&mut player, &plan, "picture"), wanted, "seed {seed}, {options:?}");
            }
        }
        let other = planned(&player, &shuffled(&graph, seed), "picture", |_| {});
        assert_eq!(film(&mut player, &other, "picture"), wanted, "seed {seed} in another order");
    }
    assert!(changing > seeds().count(), "most films show something that changes");
}

/// The same graph with its nodes written down in another order.
fn shuffled(graph: &Graph, seed: u64) -> Graph {
    let mut rng = Rng::new(seed);
    let mut order: Vec<usize> = (0..graph.nodes.len()).collect();
    (1..order.len()).rev().for_each(|at| order.swap(at, rng.below(at + 1)));
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, old)| place[*old] = new);
    let mut graph = graph.clone();
    let moved = |source: &mut Source| {
        if let Source::Node { node, .. } = source {
            *node = place[*node];
        }
    };
    graph.nodes.iter_mut().flat_map(|node| &mut node.wires).flatten().for_each(moved);
    graph.outputs.iter_mut().for_each(|output| moved(&mut output.source));
    graph.nodes = order.iter().map(|old| graph.nodes[*old].clone()).collect();
    let mut wires = DiGraph::new();
    for _ in &graph.nodes {
        wires.add_node(());
    }
    for edge in graph.wires.raw_edges() {
        let [from, to] = [edge.source(), edge.target()].map(|node| NodeIndex::new(place[node.index()]));
        wires.add_edge(from, to, ());
    }
    graph.wires = wires;
    graph
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_placement_gives_the_same_bits() {
    let mut player = Player::new();
    for seed in seeds() {
        let plan = planned(&player, &graph(seed), "picture", |_| {});
        let wanted = film(&mut player, &plan, "picture");
        for (what, places) in [("upside down", upside_down(&plan)), ("moved up", moved_up(&plan))] {
            let placed = PlacedPlan::keeping(plan.clone(), &places);
            assert_eq!(verify_placed(&placed), Ok(()), "seed {seed}: {what}");
            assert_ne!(placed, PlacedPlan::new(plan.clone()), "seed {seed}: {what}");
            let moved = with_own_places(&placed);
            assert_eq!(verify(&moved), Ok(()), "seed {seed}: {what}");
            player.renew();
            assert_eq!(film(&mut player, &Arc::new(moved), "picture"), wanted, "seed {seed}: {what}");
        }
    }
}

/// A plan for a device whose images need less memory than those of this one.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_that_do_not_fit_their_places_have_memory_of_their_own() {
    let mut player = Player::new();
    let fits = planned(&player, &graph(seeds().start), "picture", |_| {});
    let wanted = film(&mut player, &fits, "picture");
    let mut tight = (*fits).clone();
    for image in tight.images.iter_mut().filter(|image| image.offset.is_some()) {
        (image.offset, image.requirement) = (Some(0), Some(Requirement { bytes: 1, alignment: 1 }));
    }
    player.renew();
    assert_eq!(film(&mut player, &Arc::new(tight), "picture"), wanted);
}

/// What lay at the bottom of the heap lies at its top.
fn upside_down(plan: &Arc<Plan>) -> PlacedPlan {
    let mut turned = PlacedPlan::new(plan.clone());
    for (offset, image) in turned.placement.offsets.iter_mut().zip(&plan.images) {
        if let (Some(offset), Some(wants)) = (offset, image.requirement) {
            let from_top = turned.placement.heap - *offset - wants.bytes;
            *offset = from_top - from_top % wants.alignment;
        }
    }
    turned
}

/// A larger heap whose beginning nobody uses.
fn moved_up(plan: &Arc<Plan>) -> PlacedPlan {
    let mut moved = PlacedPlan::new(plan.clone());
    let requirements = plan.images.iter().filter_map(|image| image.requirement);
    let step = requirements.map(|wants| wants.alignment).max().unwrap_or(1);
    moved.placement.heap += step;
    moved.placement.offsets.iter_mut().flatten().for_each(|offset| *offset += step);
    moved
}

/// A plan with a placement as its own.
fn with_own_places(placed: &PlacedPlan) -> Plan {
    let mut plan = (*placed.plan).clone();
    for (image, offset) in plan.images.iter_mut().zip(&placed.placement.offsets) {
        image.offset = *offset;
    }
    for (batch, aliasing) in plan.batches.iter_mut().zip(&placed.placement.aliasing) {
        batch.aliasing.clone_from(aliasing);
    }
    let ends = plan.images.iter().filter_map(|image| Some(image.offset? + image.requirement?.bytes));
    plan.memory.placed = ends.max().unwrap_or(0);
    plan
}

/// A compiler that sees two steps at once may contract a product and a sum; more than that it may not do.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn fusion_changes_nothing_but_the_last_bits_where_nothing_is_rounded_between() {
    let mut player = Player::new();
    let mut fused = 0;
    for seed in seeds() {
        let mut graph = graph(seed);
        graph.nodes.iter_mut().for_each(|node| node.format = None);
        let exact = |fuse| Options { exact: true, fuse, row_downsample: When::Never, ..Options::default() };
        let [whole, apart] =
            [true, false].map(|fuse| planned(&player, &graph, "picture", |run| run.options = exact(fuse)));
        fused += apart.passes.len() - whole.passes.len();
        let [whole, apart] = [whole, apart].map(|plan| film(&mut player, &plan, "picture"));
        let pixels = whole.iter().flatten().zip(apart.iter().flatten());
        for (a, b) in pixels.map(|(a, b)| (f32::from_bits(*a), f32::from_bits(*b))) {
            assert!((a - b).abs() <= 4.0 * f32::EPSILON * a.abs(), "seed {seed}: {a} and {b}");
        }
    }
    assert!(fused > 2 * seeds().count(), "only {fused} passes were fused");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_condition_that_does_not_hold_is_a_node_that_is_off() {
    let mut player = Player::new();
    let mut seen = 0;
    for seed in seeds() {
        let (mut conditional, mut off) = (graph(seed), graph(seed));
        for at in (0..off.nodes.len()).filter(|at| at % 5 == 2) {
            if off.nodes[at].kind().can_be_off() {
                off.nodes[at].off = true;
                conditional.nodes[at].when = Some(Condition::parse("fog > 0.5").expect("a condition"));
            }
        }
        let show = |player: &mut Player, graph: &Graph, fog: f64| {
            let plan = planned(player, graph, "picture", |run| run.facts.set("fog", fog));
            film(player, &plan, "picture")
        };
        let clear = show(&mut player, &conditional, 0.0);
        assert_eq!(clear, show(&mut player, &off, 1.0), "seed {seed}");
        seen += usize::from(clear != show(&mut player, &conditional, 1.0));
    }
    assert!(2 * seen > seeds().count(), "the nodes do something");
}

/// The plan with a pass before each batch for every flat image whose life begins in it, which fills the image with NaN.
fn poisoned(plan: &Plan) -> (Plan, usize) {
    let mut poisoned = plan.clone();
    poisoned.batches.clear();
    let mut scheduled: Vec<ScheduledPass> = Vec::new();
    let mut now: Vec<Range<usize>> = Vec::new();
    for (number, batch) in plan.batches.iter().enumerate() {
        let first = poisoned.batches.len();
        let mut before = batch.clone();
        for image in born(plan, number) {
            // Only the first pass that writes the memory must wait for its owner before.
            let aliasing = before.aliasing.extract_if(.., |barrier| barrier.image == image).collect();
            let at = scheduled.len();
            poisoned.batches.push(Batch { passes: at..at + 1, transitions: Vec::new(), aliasing });
            scheduled.push(ScheduledPass {
                pass: poison(image),
                stage: Stage::Compute,
                stores: Vec::new(),
                recorded: at,
                refresh: [Refresh::EachFrame].into(),
            });
        }
        let at = scheduled.len();
        poisoned.batches.push(Batch { passes: at..at + batch.passes.len(), ..before });
        scheduled.extend(plan.passes[batch.passes.clone()].iter().map(PlannedPass::scheduled));
        now.push(first..poisoned.batches.len() - 1);
    }
    for life in poisoned.images.iter_mut().filter_map(|image| image.lifetime.as_mut()) {
        // What leaves the frame lives until after its last batch.
        let last = now.get(life.last).map_or(poisoned.batches.len(), |batches| batches.end);
        *life = Lifetime { first: now[life.first].start, last };
    }
    let filled = scheduled.len() - plan.passes.len();
    poisoned.passes = codegen(scheduled, &poisoned.images);
    (poisoned, filled)
}

/// The flat images that no batch before has mentioned and whose memory others use, too.
fn born(plan: &Plan, batch: usize) -> Vec<ImageId> {
    let writes = plan.batches[batch].passes.clone().flat_map(|pass| plan.passes[pass].pass.writes());
    let images = writes.filter_map(|resource| match resource {
        Resource::Image(image) => Some(image),
        Resource::Buffer(_) => None,
    });
    let is_born = |image: &ImageId| {
        let shares = plan.images[image.0 as usize].offset.is_some();
        let begins = plan.images[image.0 as usize].lifetime.is_some_and(|life| life.first == batch);
        shares && begins && !plan.image(*image).desc.volume
    };
    images.filter(is_born).collect()
}

fn poison(image: ImageId) -> Pass {
    Pass::of_functions(vec!["poison".into()], "poison".into(), vec![nan_kernel()], image)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nan_in_memory_of_another_image_is_never_seen() {
    let mut player = Player::new();
    for seed in seeds() {
        for alias in ALIASES {
            let plan = planned(&player, &graph(seed), "picture", |run| run.options.alias = alias);
            let wanted = film(&mut player, &plan, "picture");
            let (poisoned, filled) = poisoned(&plan);
            assert!(filled > 0, "seed {seed}: nothing is poisoned");
            assert_eq!(film(&mut player, &Arc::new(poisoned), "picture"), wanted, "seed {seed}, {alias:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nan_in_memory_is_never_seen_in_a_built_in_pipeline() {
    let mut player = Player::new();
    let all = ["tsushima", "tsushima-night", "lynx", "caracal", "glare", "exposure", "grade", "hdr"];
    // The longest pipeline, or all of them in a whole sweep.
    for name in if sweep::is_whole() { &all[..] } else { &all[..1] } {
        for row_downsample in [When::Never, When::Always] {
            let plan = planned(&player, &built_in(&format!("{name}.ron"), None), "scene", |run| {
                run.options.row_downsample = row_downsample;
            });
            // Grain follows the number of the frame, so both films begin with the first.
            player.renew();
            let wanted = film(&mut player, &plan, "scene");
            let (poisoned, _) = poisoned(&plan);
            player.renew();
            assert_eq!(film(&mut player, &Arc::new(poisoned), "scene"), wanted, "{name}, {row_downsample:?}");
        }
    }
}
