//! Faults put into correct plans: `verify` finds each of them and names the pass or image at fault.

use std::sync::Arc;

use afterimage_generators::Recipe;
use afterimage_graph::node::{BufferId, ImageId, Origin, Resource};
use afterimage_plan::{
    Alias, AliasingBarrier, Options, PlacedPlan, Plan, Stage, Transition, Use, verify, verify_placed,
};

use super::support::plan_of;

const SEEDS: std::ops::Range<u64> = 0..12;

fn plans(options: Options) -> impl Iterator<Item = Plan> {
    let recipe = |seed| Recipe { seed, nodes: 40, histories: 3, off: 5 };
    SEEDS.map(move |seed| plan_of(recipe(seed), options).expect("the graph can be planned"))
}

/// The faults of a plan, one a line; it must have some.
fn faults(plan: &Plan, what: &str) -> String {
    let faults = verify(plan).expect_err(what);
    faults.iter().map(ToString::to_string).collect::<Vec<String>>().join("\n")
}

fn assert_reports(reported: &str, parts: &[&str]) {
    let found = reported.lines().any(|line| parts.iter().all(|part| line.contains(part)));
    assert!(found, "no line has all of {parts:?}:\n{reported}");
}

#[test]
fn a_missing_barrier_is_found() {
    for plan in plans(Options::default()) {
        for batch in 0..plan.batches.len() {
            for at in 0..plan.batches[batch].transitions.len() {
                let mut broken = plan.clone();
                let dropped = broken.batches[batch].transitions.remove(at);
                let name = match dropped.resource {
                    Resource::Image(image) => &plan.image_names()[image.0 as usize],
                    Resource::Buffer(buffer) => &plan.buffer_names()[buffer.0 as usize],
                };
                let reported = faults(&broken, "a barrier is missing");
                assert_reports(&reported, &[&format!("batch {batch} uses `{name}`"), "no barrier"]);
            }
        }
    }
}

#[test]
fn a_barrier_from_or_to_another_state_is_found() {
    for plan in plans(Options::default()) {
        for batch in 0..plan.batches.len() {
            for at in 0..plan.batches[batch].transitions.len() {
                let Transition { from, to, .. } = plan.batches[batch].transitions[at];
                for (other_from, other_to) in [(Use::DepthAttachment, to), (from, Use::DepthAttachment)] {
                    let mut broken = plan.clone();
                    let changed = &mut broken.batches[batch].transitions[at];
                    (changed.from, changed.to) = (other_from, other_to);
                    let reported = faults(&broken, "a barrier has another state");
                    let told = format!("from {other_from:?} to {other_to:?}");
                    assert_reports(&reported, &[&told, &format!("must go from {from:?} to {to:?}")]);
                }
            }
        }
    }
}

#[test]
fn a_missing_export_is_found() {
    for mut plan in plans(Options::default()) {
        plan.exports.clear();
        assert_reports(&faults(&plan, "the output is not exported"), &["the end of the frame uses", "no barrier"]);
    }
}

#[test]
fn a_missing_aliasing_barrier_is_found() {
    for alias in [Alias::Placed, Alias::Pool] {
        for plan in plans(Options { alias, ..Options::default() }) {
            let batch = plan.batches.iter().position(|batch| !batch.aliasing.is_empty()).expect("images share memory");
            let mut broken = plan.clone();
            let dropped = broken.batches[batch].aliasing.remove(0);
            let name = &plan.image_names()[dropped.image.0 as usize];
            let reported = faults(&broken, "an aliasing barrier is missing");
            assert_reports(&reported, &[&format!("`{name}` takes over"), "nothing separates them"]);
        }
    }
}

/// A barrier in another batch separates too early or too late, and one that does not name every image before lets the
/// memory of that one change while it is read.
#[test]
fn an_aliasing_barrier_in_another_batch_or_with_other_images_is_found() {
    for alias in [Alias::Placed, Alias::Pool] {
        for plan in plans(Options { alias, ..Options::default() }) {
            let batch = plan.batches.iter().position(|batch| !batch.aliasing.is_empty()).expect("images share memory");
            let barrier = plan.batches[batch].aliasing[0].clone();
            let name = &plan.image_names()[barrier.image.0 as usize];
            let other = if batch + 1 < plan.batches.len() { batch + 1 } else { batch - 1 };
            let mut moved = plan.clone();
            moved.batches[batch].aliasing.remove(0);
            moved.batches[other].aliasing.push(barrier.clone());
            let reported = faults(&moved, "a barrier is in another batch");
            assert_reports(&reported, &[&format!("`{name}` takes over"), &format!("in batch {other}")]);
            let mut changed = plan.clone();
            changed.batches[batch].aliasing[0].owners = vec![barrier.image];
            let reported = faults(&changed, "a barrier names another image");
            assert_reports(&reported, &[&format!("but the plan says of `{name}` in batch {batch}")]);
        }
    }
}

#[test]
fn what_a_plan_mentions_and_does_not_have_is_found() {
    let plan = plans(Options::default()).find(|plan| plan.batches.iter().any(|batch| !batch.aliasing.is_empty()));
    let plan = plan.expect("in some plan images share memory");
    let changes: [fn(&mut Plan); 5] = [
        |plan| plan.outputs[0].image = strange(plan),
        |plan| plan.exports[0].resource = Resource::Image(strange(plan)),
        |plan| plan.batches[0].transitions[0].resource = Resource::Image(strange(plan)),
        |plan| {
            let image = strange(plan);
            first_barrier(plan).image = image;
        },
        |plan| {
            let image = strange(plan);
            first_barrier(plan).owners.push(image);
        },
    ];
    for change in changes {
        let mut broken = plan.clone();
        change(&mut broken);
        let expected = format!("the plan mentions {:?}, which is not in it", Resource::Image(strange(&plan)));
        assert_reports(&faults(&broken, "an image does not exist"), &[&expected]);
    }
    let mut broken = plan.clone();
    let buffer = Resource::Buffer(BufferId(plan.buffers.len() as u32));
    broken.batches[0].transitions[0].resource = buffer;
    assert_reports(
        &faults(&broken, "a buffer does not exist"),
        &[&format!("the plan mentions {buffer:?}, which is not in it")],
    );
}

/// An image after the last.
fn strange(plan: &Plan) -> ImageId {
    ImageId(plan.images.len() as u32)
}

fn first_barrier(plan: &mut Plan) -> &mut AliasingBarrier {
    plan.batches.iter_mut().find_map(|batch| batch.aliasing.first_mut()).expect("images share memory")
}

/// Two shared images that are alive in the same batch.
fn alive_together(plan: &Plan) -> (usize, usize) {
    let shared = |image: &usize| plan.images[*image].offset.is_some();
    let lives: Vec<(usize, _)> =
        (0..plan.images.len()).filter(shared).filter_map(|image| Some((image, plan.images[image].lifetime?))).collect();
    for (a, first) in &lives {
        for (b, second) in &lives {
            if a < b && first.first <= second.last && second.first <= first.last {
                return (*a, *b);
            }
        }
    }
    panic!("some pass reads one shared image and writes another")
}

#[test]
fn two_live_images_at_one_place_of_the_heap_are_found() {
    for plan in plans(Options::default()) {
        let (a, b) = alive_together(&plan);
        let mut broken = plan.clone();
        broken.images[a].offset = broken.images[b].offset;
        let reported = faults(&broken, "two images overlap");
        let names = plan.image_names();
        assert_reports(&reported, &[&format!("`{}`", names[a]), &format!("`{}`", names[b]), "in the heap where"]);
    }
}

#[test]
fn two_live_images_in_one_pooled_texture_are_found() {
    for plan in plans(Options { alias: Alias::Pool, ..Options::default() }) {
        let (a, b) = alive_together(&plan);
        let mut broken = plan.clone();
        broken.images[a].slot = broken.images[b].slot;
        assert_reports(&faults(&broken, "two images share"), &["in the pool where"]);
    }
}

#[test]
fn an_offset_without_alignment_or_beyond_the_heap_is_found() {
    let plan = plans(Options::default()).next().expect("there is a plan");
    let image = plan.images.iter().position(|image| image.offset.is_some()).expect("an image is placed");
    let mut crooked = plan.clone();
    crooked.images[image].offset = crooked.images[image].offset.map(|offset| offset + 4);
    assert_reports(&faults(&crooked, "an offset is not aligned"), &["is not a multiple of"]);
    let mut outside = plan.clone();
    outside.images[image].offset = Some(plan.memory.placed);
    assert_reports(&faults(&outside, "an image is outside"), &["beyond the heap"]);
}

/// A pass and a later one that reads what it writes, the first in the batch before the second.
fn neighbors(plan: &Plan) -> Option<(usize, usize, usize)> {
    plan.batches.windows(2).enumerate().find_map(|(batch, pair)| {
        let reads = |reader: usize, writer: usize| {
            let writes = plan.passes[writer].pass.writes();
            plan.passes[reader].pass.reads().iter().any(|resource| writes.contains(resource))
        };
        let pairs =
            pair[0].passes.clone().flat_map(|writer| pair[1].passes.clone().map(move |reader| (writer, reader)));
        pairs
            .into_iter()
            .find(|(writer, reader)| reads(*reader, *writer))
            .map(|(writer, reader)| (batch, writer, reader))
    })
}

#[test]
fn two_exchanged_passes_are_found() {
    for plan in plans(Options::default()) {
        let (_, writer, reader) = neighbors(&plan).expect("some batch needs the one before");
        let mut broken = plan.clone();
        broken.passes.swap(writer, reader);
        let reported = faults(&broken, "a read comes before its write");
        let name = &plan.pass_names()[reader];
        assert!(
            reported.contains(&format!("pass `{name}` reads")) || reported.contains("recorded before it"),
            "{reported}"
        );
    }
}

#[test]
fn two_dependent_batches_joined_into_one_are_found() {
    for plan in plans(Options::default()) {
        let (batch, ..) = neighbors(&plan).expect("some batch needs the one before");
        let mut broken = plan.clone();
        let second = broken.batches.remove(batch + 1);
        broken.batches[batch].passes.end = second.passes.end;
        broken.batches[batch].transitions.extend(second.transitions);
        broken.batches[batch].aliasing.extend(second.aliasing);
        for lifetime in broken.images.iter_mut().filter_map(|image| image.lifetime.as_mut()) {
            lifetime.first -= usize::from(lifetime.first > batch);
            lifetime.last -= usize::from(lifetime.last > batch);
        }
        assert_reports(&faults(&broken, "two batches became one"), &["of the same batch uses it"]);
    }
}

#[test]
fn a_pass_outside_of_all_batches_is_found() {
    let mut plan = plans(Options::default()).next().expect("there is a plan");
    let last = plan.batches.len() - 1;
    plan.batches[last].passes.end -= 1;
    assert_reports(&faults(&plan, "a pass is in no batch"), &["the batches end at pass"]);
}

#[test]
fn a_history_or_an_output_without_a_writer_is_found() {
    let plan = plans(Options { fuse: false, ..Options::default() }).find(|plan| past(plan).is_some());
    let plan = plan.expect("some graph has a history");
    let of = past(&plan).expect("it was found above");
    let writer = plan.work().position(|pass| pass.writes().contains(&of)).expect("histories are written");
    let mut broken = plan.clone();
    broken.passes[writer].pass = broken.passes[(writer + 1) % plan.passes.len()].pass.clone();
    assert_reports(&faults(&broken, "a history is not written"), &["is the past of", "is written by 0 passes"]);
    let mut broken = plan.clone();
    let unwritten = plan.inputs[0].1;
    broken.outputs[0].image = unwritten;
    assert_reports(&faults(&broken, "an output is not written"), &["no pass writes", "is the output"]);
}

fn past(plan: &Plan) -> Option<Resource> {
    let made = |of: ImageId| plan.image(of).origin == Origin::Transient;
    plan.images.iter().find_map(|image| match image.origin {
        Origin::Previous { of, .. } if made(of) => Some(Resource::Image(of)),
        _ => None,
    })
}

#[test]
fn wrong_figures_are_found() {
    let plan = plans(Options::default()).next().expect("there is a plan");
    let changes: [fn(&mut Plan); 4] = [
        |plan| plan.memory.lower_bound -= 1,
        |plan| plan.memory.placed += 1,
        |plan| plan.memory.pooled += 1,
        |plan| plan.memory.unshared -= 1,
    ];
    for change in changes {
        let mut broken = plan.clone();
        change(&mut broken);
        assert_reports(&faults(&broken, "a figure is wrong"), &["the plan states", "bytes for"]);
    }
    let mut broken = plan.clone();
    broken.memory.unaliased = plan.memory.unshared - 1;
    assert_reports(&faults(&broken, "a figure is wrong"), &["the plan stores", "that its nodes describe"]);
}

#[test]
fn uniforms_at_one_place_of_the_buffer_are_found() {
    let mut plan = plans(Options::default()).next().expect("there is a plan");
    plan.passes[1].uniform.extent_offset = plan.passes[0].uniform.extent_offset;
    assert_reports(&faults(&plan, "two uniforms overlap"), &["the uniforms of pass", "overlap"]);
}

#[test]
fn a_draw_of_a_compute_kernel_is_found() {
    let drawn = |mut plan: Plan| {
        let pass = plan.passes.iter_mut().find(|planned| !planned.pass.kind.is_drawable())?;
        pass.stage = Stage::Fragment;
        Some(plan)
    };
    let plan = plans(Options::default()).find_map(drawn).expect("some plan has a compute kernel");
    assert_reports(&faults(&plan, "a compute kernel is drawn"), &["is drawn, but it can only be dispatched"]);
}

#[test]
fn a_place_in_the_recording_that_two_passes_have_is_found() {
    let mut plan = plans(Options::default()).next().expect("there is a plan");
    plan.passes[1].recorded = plan.passes[0].recorded;
    assert_reports(&faults(&plan, "two passes are recorded at one place"), &["do not name every pass once"]);
}

/// The batches cover the passes in order, each once, and none is empty.
#[test]
fn a_batch_that_is_empty_or_does_not_begin_where_the_one_before_ends_is_found() {
    let changes: [fn(&mut Plan); 4] = [
        |plan| plan.batches[1].passes.start += 1,
        |plan| plan.batches[1].passes.start -= 1,
        |plan| {
            let mut empty = plan.batches[0].clone();
            empty.passes = empty.passes.end..empty.passes.end;
            plan.batches.insert(1, empty);
        },
        |plan| plan.batches[0].passes.start = 1,
    ];
    for plan in plans(Options::default()) {
        for change in changes {
            let mut broken = plan.clone();
            change(&mut broken);
            let reported = faults(&broken, "the batches do not cover the passes");
            assert_reports(&reported, &["batch", "but the batches before it end at pass"]);
        }
    }
}

/// A plan with its images in other places is checked in these.
#[test]
fn a_placement_that_differs_from_that_of_its_plan_is_checked_too() {
    for plan in plans(Options::default()) {
        let (a, b) = alive_together(&plan);
        let placed = PlacedPlan::new(Arc::new(plan));
        assert_eq!(verify_placed(&placed), Ok(()));
        let changes: [&dyn Fn(&mut PlacedPlan); 3] = [
            &|placed| placed.placement.offsets[a] = placed.placement.offsets[b],
            &|placed| placed.placement.offsets[a] = Some(placed.placement.heap),
            &|placed| placed.placement.aliasing.iter_mut().for_each(Vec::clear),
        ];
        for change in changes {
            let mut broken = placed.clone();
            change(&mut broken);
            assert!(verify_placed(&broken).is_err_and(|faults| !faults.is_empty()));
            assert_eq!(verify(&broken.plan), Ok(()), "the plan itself is right");
        }
    }
}
