//! Passes that share a dispatch, against each in a dispatch of its own.

use std::sync::Arc;

use afterimage_graph::node::{Resource, Work};
use afterimage_graph::plan::{Horizontal, Plan, Tiles, verify};

use super::{at_tier, lively};
use crate::support::gpu::{Picture, Run, shipped};
use crate::support::player::Player;

fn planned(player: &Player, graph: &afterimage_graph::check::Graph, scene: &Picture, horizontal: Horizontal) -> Plan {
    let mut run = Run::new(graph);
    // Where passes are not made in tiles there are more of them to share a batch, and rows are walked at any size.
    (run.options.horizontal, run.options.batches_first, run.options.tile) = (horizontal, true, Tiles::Never);
    let plan = run.plan(&player.gpu, &[("scene", scene)]);
    assert_eq!(verify(&plan), Ok(()));
    plan
}

/// Two frames, the second of which remembers the first.
fn film(player: &mut Player, plan: &Plan, scene: &Picture) -> Vec<u32> {
    player.renew();
    player.executor.load(Arc::new(plan.clone())).unwrap_or_else(|error| panic!("{error}"));
    [0.0, 0.25].iter().for_each(|time| player.frame(&[("scene", scene)], *time, *time == 0.0));
    let outputs = plan.outputs.iter().map(|output| player.output(&output.name));
    outputs.flat_map(|picture| picture.pixels).flatten().map(f32::to_bits).collect()
}

fn shared(plan: &Plan) -> usize {
    plan.launches.iter().filter(|launch| launch.len() > 1).count()
}

/// Meters that nothing waits for, halvings and a lattice: all of them read the scene.
const READERS: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: -0.5),
        "bright": Extract(source: "exposed", method: Knee, threshold: 0.5, knee: 0.25),
        "mips": Downsample(source: "bright", levels: 4, filter: Tap13, firefly: Groups),
        "bloom": Upsample(source: "mips", blend: Add, filter: Tent),
        "grid": GridBuild(source: "scene", stops: -0.5),
        "smooth": GridBlur(source: "grid"),
        "around": LogGaussian(source: "scene", stops: -0.5),
        "local": LocalToneMap(source: "exposed", grid: "smooth", gaussian: "around", contrast: 0.6, detail: 1.1),
        "lit": Composite(base: "local", bloom: "bloom", blend: Add, strength: 0.2),
        "counted": Histogram(source: "scene"),
        "metered": AutoExposure(histogram: "counted"),
        "seen": Purkinje(source: "lit", meter: "metered"),
    },
    outputs: { "out": "seen" },
)"#;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sharing_a_dispatch_changes_no_bit() {
    let mut player = Player::new();
    let graphs = [shipped("tsushima.ron", None), shipped("tsushima-night.ron", None), at_tier(READERS, None)];
    let mut most = 0;
    for graph in &graphs {
        for (width, height) in [(640, 360), (333, 101), (64, 3), (1, 1)] {
            let scene = lively(width, height);
            let alone = planned(&player, graph, &scene, Horizontal::Never);
            assert_eq!((shared(&alone), alone.launches.len()), (0, alone.recording.passes.len()));
            let wanted = film(&mut player, &alone, &scene);
            for horizontal in [Horizontal::Small, Horizontal::Always] {
                let plan = planned(&player, graph, &scene, horizontal);
                assert!(shared(&plan) > 0, "{width}x{height}, {horizontal:?}: nothing is shared");
                assert!(film(&mut player, &plan, &scene) == wanted, "{width}x{height}, {horizontal:?}: other bits");
                most = plan.launches.iter().map(ExactSizeIterator::len).max().unwrap_or(0).max(most);
            }
        }
    }
    assert!(most > 2, "at most {most} passes shared a dispatch");
}

/// All that look at the scene, a meter, the lattices and a halving by rows, do so in one dispatch where nothing keeps them apart.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_readers_of_a_scene_share_a_dispatch() {
    let mut player = Player::new();
    let graph = at_tier(READERS, None);
    let scene = lively(1024, 512);
    let plans = [Horizontal::Never, Horizontal::Always].map(|horizontal| {
        let mut run = Run::new(&graph);
        (run.options.horizontal, run.options.batches_first, run.options.tile) = (horizontal, true, Tiles::Always);
        run.plan(&player.gpu, &[("scene", &scene)])
    });
    let [alone, together] = &plans;
    let input = Resource::Image(together.inputs[0].1);
    let reads = |pass: &usize| together.recording.passes[*pass].reads().contains(&input);
    let readers: Vec<usize> = (0..together.recording.passes.len()).filter(reads).collect();
    let launches: Vec<usize> = readers.iter().map(|pass| together.launch_of(*pass)).collect();
    assert_eq!(together.launches[launches[0]].len(), 3, "{}", together.to_text());
    assert_eq!(launches.iter().collect::<std::collections::BTreeSet<_>>().len(), 2, "once to analyse, once to compose");
    let works = &together.recording.passes[together.launches[launches[0]].clone()];
    assert!(works.iter().any(|pass| matches!(&pass.work, Work::Rows(rows) if rows.lanes == 256)));
    assert!(works.iter().any(|pass| matches!(&pass.work, Work::Cells(cells) if cells.workgroup() == 256)));
    assert!(works.iter().any(|pass| matches!(&pass.work, Work::Entry(_))));
    assert!(film(&mut player, alone, &scene) == film(&mut player, together, &scene));
    assert!(together.to_text().contains("beside"), "{}", together.to_text());
}
