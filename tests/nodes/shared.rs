//! Kernels that sum up one image in one pass, against each in a pass of its own.

use std::sync::Arc;

use afterimage_graph::check::NoFiles;
use afterimage_graph::node::{CellReduce, Pass, PassKind, Resource};
use afterimage_plan::codegen::codegen;
use afterimage_plan::{Plan, PlannedPass, ScheduledPass, verify};
use half::f16;

use super::probes::scene;
use crate::support::gpu::{Picture, Run, changed, gpu};
use crate::support::harness::checked;
use crate::support::player::Player;

/// Several nodes that read `scene`, of which `around` shows its averages unblurred.
fn pipeline(nodes: &str) -> afterimage_graph::check::Graph {
    checked(
        &format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ {nodes}, \"result\": ProbeVolume(volume: \"grid\") }}, \
         outputs: {{ \"grid\": \"result\", \"around\": \"around\" }})"
        ),
        &NoFiles,
    )
}

const PLAIN: &str = "\"grid\": GridBuild(source: \"scene\"), \"around\": LogGaussian(source: \"scene\", sigma: 0.0)";

/// What is read as in the richest pipeline, lattices of one size, lattices with few invocations for each cell and with
/// sides of their own, one of nine pixels.
const WAYS: [&str; 6] = [
    PLAIN,
    "\"counted\": Histogram(source: \"scene\"), \"metered\": AutoExposure(histogram: \"counted\"), \
     \"grid\": GridBuild(source: \"scene\", meter: \"metered\", stops: 0.5), \
     \"around\": LogGaussian(source: \"scene\", meter: \"metered\", sigma: 0.0, width: 128, height: 64)",
    "\"grid\": GridBuild(source: \"scene\", width: 32, height: 32, depth: 256), \
     \"around\": LogGaussian(source: \"scene\", sigma: 0.0, width: 32, height: 32)",
    "\"grid\": GridBuild(source: \"scene\", width: 9, height: 5), \
     \"around\": LogGaussian(source: \"scene\", sigma: 0.0, width: 72, height: 40)",
    "\"grid\": GridBuild(source: \"scene\", width: 16, height: 24), \
     \"around\": LogGaussian(source: \"scene\", sigma: 0.0, width: 256, height: 24)",
    "\"grid\": GridBuild(source: \"scene\", step: 3), \"around\": LogGaussian(source: \"scene\", sigma: 0.0, step: 3)",
];

/// The passes that reduce an image by cells.
fn reductions(plan: &Plan) -> Vec<&Pass> {
    plan.work().filter(|pass| matches!(pass.kind, PassKind::CellReduce(_))).collect()
}

/// The plans with the kernels joined and alone.
fn plans(player: &Player, nodes: &str, scene: &Picture) -> [Plan; 2] {
    let graph = pipeline(nodes);
    [true, false].map(|fuse| {
        let mut run = Run::new(&graph);
        run.options.fuse = fuse;
        run.plan(&player.gpu, &[("scene", scene)])
    })
}

fn shown(player: &mut Player, plan: &Plan, scene: &Picture) -> [Picture; 2] {
    player.renew();
    player.executor.load(Arc::new(plan.clone())).unwrap_or_else(|error| panic!("{error}"));
    player.frame(&[("scene", scene)], 0.0, true);
    ["grid", "around"].map(|name| player.output(name))
}

/// The place of a half float among all half floats.
fn rank(value: f32) -> i32 {
    let bits = f16::from_f32(value).to_bits();
    let magnitude = i32::from(bits & 0x7fff);
    if bits >> 15 == 1 { -magnitude } else { magnitude }
}

/// Numbers of the grids that differ at all, and the most units of a half float by which the averages differ.
fn difference(joined: &[Picture; 2], alone: &[Picture; 2]) -> (usize, i32) {
    let [grids, averages] = [0, 1].map(|at| {
        let [joined, alone] = [joined, alone].map(|pictures| pictures[at].pixels.as_flattened());
        assert_eq!(joined.len(), alone.len());
        joined.iter().zip(alone)
    });
    let differing = grids.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    (differing, averages.map(|(a, b)| (rank(*a) - rank(*b)).abs()).max().unwrap_or(0))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn joined_kernels_find_what_each_finds_alone() {
    let mut player = Player::new();
    for nodes in WAYS {
        // A stride is used in large pictures.
        let sizes: &[_] = match nodes.contains("step") {
            true => &[(2853, 2850), (40, 23)],
            false => &[(640, 360), (641, 359), (257, 3), (40, 23), (1, 1), (1, 40)],
        };
        for &(width, height) in sizes {
            let scene = scene(width, height);
            let [joined, alone] = plans(&player, nodes, &scene);
            assert_eq!((reductions(&joined).len(), reductions(&alone).len()), (1, 0), "{nodes}");
            let [joined, alone] = [joined, alone].map(|plan| shown(&mut player, &plan, &scene));
            let (grid, around) = difference(&joined, &alone);
            assert!(grid == 0 && around <= 1, "{width}x{height} {nodes}: {grid} numbers differ, {around} units");
            let varied = |picture: &Picture| picture.pixels.iter().any(|pixel| pixel[0] != picture.pixels[0][0]);
            assert!(varied(&joined[0]) && (width * height == 1 || varied(&joined[1])), "{nodes}: nothing was seen");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_widest_picture_is_read_to_its_ends() {
    let mut player = Player::new();
    let scene = scene(16384, 2);
    let [joined, alone] = plans(&player, PLAIN, &scene);
    let pictures = [joined, alone].map(|plan| shown(&mut player, &plan, &scene));
    let (grid, around) = difference(&pictures[0], &pictures[1]);
    assert!(grid == 0 && around <= 1, "{grid} numbers differ, {around} units");
}

/// Three lattices, each a multiple of the next: the middle one has cells of several that are made together.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn three_kernels_join_as_two_do() {
    let nodes = "\"grid\": GridBuild(source: \"scene\", width: 16, height: 8), \
                 \"around\": LogGaussian(source: \"scene\", sigma: 0.0, width: 32, height: 32), \
                 \"finer\": LogGaussian(source: \"scene\", sigma: 0.0, width: 64, height: 64), \
                 \"result\": ProbeVolume(volume: \"grid\")";
    let graph = checked(
        &format!(
            "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ {nodes} }}, \
         outputs: {{ \"grid\": \"result\", \"around\": \"around\", \"finer\": \"finer\" }})"
        ),
        &NoFiles,
    );
    let mut player = Player::new();
    let scene = scene(333, 101);
    let [joined, alone] = [true, false].map(|fuse| {
        let mut run = Run::new(&graph);
        run.options.fuse = fuse;
        run.plan(&player.gpu, &[("scene", &scene)])
    });
    assert_eq!(reductions(&joined).iter().map(|pass| pass.kernels.len()).collect::<Vec<_>>(), [3]);
    let [joined, alone] = [joined, alone].map(|plan| {
        let shown = shown(&mut player, &plan, &scene);
        (shown, player.output("finer"))
    });
    assert_eq!(difference(&joined.0, &alone.0).0, 0);
    assert!(difference(&joined.0, &alone.0).1 <= 1);
    let finer = difference(&[joined.0[0].clone(), joined.1], &[alone.0[0].clone(), alone.1]);
    assert!(finer.1 <= 1, "{} units", finer.1);
}

/// The comparison above sees what it should.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn wrong_lattices_and_lost_pixels_are_seen() {
    let mut player = Player::new();
    let scene = scene(320, 180);
    let [joined, alone] = plans(&player, PLAIN, &scene);
    let alone = shown(&mut player, &alone, &scene);
    let plants: [fn(&mut Pass, &mut CellReduce); 3] = [
        |_, cells| cells.stride = 2,
        |pass, _| pass.kernels[1].by_cells.as_mut().expect("a form by cells").cells = [64, 32],
        |pass, _| pass.kernels[0].uniform[0] ^= 0x80,
    ];
    for (number, plant) in plants.into_iter().enumerate() {
        let mut wrong = joined.clone();
        let mut scheduled: Vec<_> = wrong.passes.iter().map(PlannedPass::scheduled).collect();
        for ScheduledPass { pass, .. } in &mut scheduled {
            if let PassKind::CellReduce(mut cells) = pass.kind {
                plant(pass, &mut cells);
                pass.kind = PassKind::CellReduce(cells);
            }
        }
        wrong.passes = codegen(scheduled, &wrong.images);
        let (grid, around) = difference(&shown(&mut player, &wrong, &scene), &alone);
        assert!(grid > 0 || around > 1, "plant {number} is not seen");
    }
}

/// Tsushima with a share of the Gaussian, which the file leaves out.
fn tsushima(fuse: bool) -> Plan {
    let graph = changed("tsushima.ron", None, &[("local.share", "0.4")]);
    let picture = Picture::new(640, 360, |_, _| [0.5; 4]);
    let mut run = Run::new(&graph);
    run.options.fuse = fuse;
    run.plan(&gpu(), &[("scene", &picture)])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tsushima_reads_its_scene_once_for_grid_and_gaussian() {
    let (joined, alone) = (tsushima(true), tsushima(false));
    let label = "grid_build_nearest & log_gaussian_average";
    let pass = joined.work().find(|pass| pass.label == label).expect("the two are one pass");
    assert_eq!(pass.nodes, ["grid", "around"]);
    assert_eq!(verify(&joined), Ok(()));
    let [read] = joined.shared_reads.as_slice() else { panic!("one image is read once: {:?}", joined.shared_reads) };
    assert_eq!((read.image.as_str(), read.bytes_saved), ("scene", joined.image(joined.inputs[0].1).desc.bytes()));
    assert!(joined.to_text().contains("read once by passes that are joined"), "{}", joined.to_text());
    let json: serde_json::Value = serde_json::from_str(&joined.to_json()).expect("JSON can be read");
    let runs = json["passes"].as_array().and_then(|passes| passes.iter().find(|pass| pass["label"] == label));
    let functions = runs.and_then(|pass| pass["runs"].as_array()).expect("the pass is there");
    assert_eq!(
        functions.iter().map(|run| &run["function"]).collect::<Vec<_>>(),
        ["grid_build_nearest", "log_gaussian_average"]
    );
    assert!(reductions(&alone).is_empty() && alone.shared_reads.is_empty() && !alone.to_text().contains("read once"));
}

/// A kernel that waits for another's result is not joined with it, nor one whose lattice does not fit.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_waits_for_other_things_stays_apart() {
    // A stride of 2 is used from this size on.
    let scene = scene(1900, 1900);
    let apart = [
        "\"mean\": MeanLuminance(source: \"scene\"), \"metered\": Adapt(mean: \"mean\"), \
         \"grid\": GridBuild(source: \"scene\", meter: \"metered\"), \
         \"around\": LogGaussian(source: \"scene\", sigma: 0.0)",
        "\"grid\": GridBuild(source: \"scene\", width: 60), \"around\": LogGaussian(source: \"scene\", sigma: 0.0)",
        "\"grid\": GridBuild(source: \"scene\", width: 128), \
         \"around\": LogGaussian(source: \"scene\", width: 64, sigma: 0.0)",
        "\"grid\": GridBuild(source: \"scene\", method: Trilinear), \
         \"around\": LogGaussian(source: \"scene\", sigma: 0.0)",
        "\"grid\": GridBuild(source: \"scene\", step: 2), \"around\": LogGaussian(source: \"scene\", sigma: 0.0)",
    ];
    let player = Player::new();
    for nodes in apart {
        let [plan, _] = plans(&player, nodes, &scene);
        assert!(reductions(&plan).is_empty() && plan.shared_reads.is_empty(), "{nodes}");
    }
}

/// A pass that reads with others is seen to read and to write what each of them does.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_joined_pass_has_all_reads_and_writes() {
    let plan = tsushima(true);
    let pass = reductions(&plan)[0];
    let images = |resources: Vec<Resource>| resources.iter().filter(|r| matches!(r, Resource::Image(_))).count();
    assert_eq!((images(pass.reads()), pass.reads().len(), images(pass.writes())), (1, 2, 2));
}
