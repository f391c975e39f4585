//! The order in which work is done must not be seen, wherever no order is asked for.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_generators::Rng;
use afterimage_gpu::{Frame, FrameKind};
use afterimage_plan::{Options, Plan, verify};

use super::reference::undithered;
use super::{bits, scene};
use crate::support::gpu::{Picture, Run, built_in};
use crate::support::player::Player;

/// The plan with the passes of each batch in another order, each on its own.
fn shuffled(plan: &Plan, rng: &mut Rng) -> Plan {
    let mut order: Vec<usize> = (0..plan.passes.len()).collect();
    for batch in plan.batches.iter().map(|batch| &batch.passes) {
        for last in (batch.start + 1..batch.end).rev() {
            order.swap(last, batch.start + rng.below(last + 1 - batch.start));
        }
    }
    let mut other = plan.clone();
    other.passes = order.iter().map(|at| plan.passes[*at].clone()).collect();
    other
}

/// The places of the passes in the recording.
fn recorded(plan: &Plan) -> Vec<usize> {
    plan.passes.iter().map(|planned| planned.recorded).collect()
}

/// Two frames, the second of which remembers the first.
fn frames(player: &mut Player, plan: Plan, scenes: &[Picture; 2]) -> Vec<u32> {
    player.renew();
    player.executor.load(Arc::new(plan)).unwrap_or_else(|error| panic!("{error}"));
    player.frame(&[("scene", &scenes[0])], 0.0, true);
    player.frame(&[("scene", &scenes[1])], 0.25, false);
    bits(&[player.output("display")])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn passes_may_run_in_any_order_within_their_batch() {
    let graph = built_in(super::PIPELINE, None);
    let scenes = [0.0, 0.6].map(|walk| scene(192, 108, walk));
    let mut player = Player::new();
    // The fewest batches are the widest.
    let mut run = Run::new(&graph);
    run.options.batches_first = true;
    let plan = run.plan(&player.gpu, &[("scene", &scenes[0])]);
    let wanted = frames(&mut player, plan.clone(), &scenes);
    let mut rng = Rng::new(3);
    let mut orders = BTreeSet::from([recorded(&plan)]);
    for round in 0..6 {
        let other = shuffled(&plan, &mut rng);
        orders.insert(recorded(&other));
        verify(&other).unwrap_or_else(|faults| panic!("round {round}: {faults:?}"));
        assert!(frames(&mut player, other, &scenes) == wanted, "round {round} has other bits");
    }
    assert!(orders.len() > 4, "the orders differ: {:?}", plan.batches);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn plans_that_order_passes_otherwise_have_the_same_bits() {
    // With the Gaussian there are passes that do not depend on each other.
    let graph = undithered(&[("local.share", "0.4")]);
    let scenes = [0.0, 0.6].map(|walk| scene(192, 108, walk));
    let mut player = Player::new();
    let [usual, serial, fewest] = [(false, false), (true, false), (false, true)].map(|(serial, batches_first)| {
        let mut run = Run::new(&graph);
        run.options = Options { serial, batches_first, ..Options::default() };
        run.plan(&player.gpu, &[("scene", &scenes[0])])
    });
    assert!(serial.batches.len() > usual.batches.len());
    let wanted = frames(&mut player, usual, &scenes);
    assert!(frames(&mut player, serial, &scenes) == wanted, "a batch for each pass");
    assert!(frames(&mut player, fewest, &scenes) == wanted, "fewest batches");
}

/// Several sequences on one device, their frames submitted one sequence after the other, in turns, or backwards in one
/// batch.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sequences_do_not_see_in_which_order_they_are_submitted() {
    let graph = built_in(super::PIPELINE, None);
    let scenes = [0.0, 0.5, 1.0].map(|walk| scene(96, 54, walk));
    let player = Player::new();
    let plan = Arc::new(Run::new(&graph).plan(&player.gpu, &[("scene", &scenes[0])]));
    let views = scenes.each_ref().map(|scene| player.upload(scene));
    // Sequence by sequence, what its three frames show: each begins with another scene.
    let run = |batches: &[&[usize]]| {
        let mut executors = [0, 1, 2].map(|_| player.spare(plan.clone()));
        let mut frames = [0; 3];
        for batch in batches {
            let record = |sequence: &usize| {
                let frame = frames[*sequence];
                frames[*sequence] += 1;
                let inputs = [("scene", &views[(sequence + frame) % 3])];
                let mut encoder = player.gpu.device.create_command_encoder(&Default::default());
                let frame = Frame { inputs: &inputs, dt: 0.1, kind: FrameKind::cut_if(frame == 0), ..Frame::default() };
                executors[*sequence].encode(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
                encoder.finish()
            };
            let commands: Vec<_> = batch.iter().map(record).collect();
            player.gpu.queue.submit(commands.into_iter().rev());
        }
        assert_eq!(frames, [3; 3], "every sequence is whole");
        executors.map(|executor| bits(&[player.read(executor.output("display").expect("it is an output"))]))
    };
    let wanted = run(&[&[0], &[0], &[0], &[1], &[1], &[1], &[2], &[2], &[2]]);
    assert_ne!(wanted[0], wanted[1], "the sequences differ");
    assert!(run(&[&[2], &[0], &[1], &[1], &[2], &[0], &[0], &[2], &[1]]) == wanted, "in turns");
    assert!(run(&[&[0, 1, 2], &[2, 0, 1], &[1, 2, 0]]) == wanted, "batches, the last recorded first");
}
