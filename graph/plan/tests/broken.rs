//! Faults put into plans, and the words that `verify` has for each of them.

use std::sync::Arc;

use afterimage_generators::Recipe;
use afterimage_graph::check::Facts;
use afterimage_graph::image::Format;
use afterimage_graph::node::{Arg, Argument, ImageId, Origin, PassResult, Resource};
use afterimage_plan::{Alias, Lifetime, Options, PlacedPlan, Plan, Requirement, Slot, verify, verify_placed};

use super::support::{all_formats, checked, plan_images, plan_of};

/// A change that breaks the places of a plan.
type BreakPlaced = fn(&mut PlacedPlan);

fn plan(alias: Alias) -> Plan {
    let recipe = Recipe { seed: 3, nodes: 40, histories: 3, off: 5 };
    plan_of(recipe, Options { alias, ..Options::default() }).expect("the graph can be planned")
}

fn assert_reports(plan: &Plan, told: &str) {
    let faults = verify(plan).expect_err(told);
    assert!(faults.iter().any(|fault| fault.to_string().contains(told)), "{told}: {faults:?}");
}

/// An image that shares memory.
fn shared(plan: &Plan) -> usize {
    plan.images.iter().position(|image| image.offset.is_some()).expect("images share memory")
}

#[test]
fn places_and_lives_of_images_that_are_wrong_are_named() {
    let plan = plan(Alias::Placed);
    assert_eq!(verify(&plan), Ok(()));
    let (at, input, names) = (shared(&plan), plan.inputs[0].1.0 as usize, plan.image_names());
    let with = |change: &dyn Fn(&mut Plan), told: &str| {
        let mut broken = plan.clone();
        change(&mut broken);
        assert_reports(&broken, told);
    };
    let (name, given) = (&names[at], &names[input]);
    let stated = plan.images[at].lifetime.expect("it is in use");
    let longer = Lifetime { last: stated.last + 1, ..stated };
    let lives = format!("`{name}` lives {:?}, but the plan says {:?}", Some(stated), Some(longer));
    with(&|plan| plan.images[at].lifetime = Some(longer), &lives);
    with(&|plan| plan.images[at].lifetime = None, "but the plan says None");
    let without = format!("`{name}` is a transient without a place in the shared memory");
    with(&|plan| plan.images[at].offset = None, &without);
    with(&|plan| plan.images[at].slot = None, &without);
    with(&|plan| plan.images[at].requirement = None, &without);
    let other = format!("`{given}` is not a transient of this frame, but has a place in the shared memory");
    with(&|plan| plan.images[input].slot = Some(0), &other);
    with(&|plan| plan.images[input].offset = Some(0), &other);
    with(&|plan| plan.images[input].requirement = Some(Requirement { bytes: 1, alignment: 1 }), &other);
    let slot = plan.images[at].slot.expect("it has one");
    let description = format!("`{name}` is in slot {slot}, whose texture has another description");
    let narrow = Slot { desc: plan.images[at].desc.format(Format::R16Float) };
    with(&|plan| plan.memory.slots[slot as usize] = narrow, &description);
    with(&|plan| plan.images[at].slot = Some(999), "is in slot 999, whose texture has another description");
    let Requirement { bytes, .. } = plan.images[at].requirement.expect("it shares memory");
    let (offset, heap) = (plan.images[at].offset.expect("it is placed"), plan.memory.placed);
    let beyond = format!("`{name}` ends at {}, beyond the heap of {heap}", heap + bytes);
    with(&|plan| plan.images[at].offset = Some(heap), &beyond);
    let crooked = format!("`{name}` lies at {}, which is not a multiple of 65536", offset + 3);
    with(&|plan| plan.images[at].offset = Some(offset + 3), &crooked);
    let mut alone = super::broken::plan(Alias::None);
    assert_eq!(verify(&alone), Ok(()));
    let held: Vec<usize> = (0..alone.images.len()).filter(|image| alone.images[*image].slot.is_some()).collect();
    alone.images[held[1]].slot = alone.images[held[0]].slot;
    assert_reports(&alone, "shares a texture with `");
}

#[test]
fn barriers_that_change_something_twice_or_in_vain_are_named() {
    let plan = plan(Alias::Placed);
    let (names, last) = (plan.image_names(), plan.batches.len() - 1);
    let first = plan.batches[0].transitions[0];
    let name = |resource: Resource| resource.image().map(|image| names[image.0 as usize].clone()).expect("an image");
    let mut twice = plan.clone();
    twice.batches[0].transitions.push(first);
    assert_reports(&twice, &format!("two barriers before batch 0 change `{}`", name(first.resource)));
    let mut vain = plan.clone();
    let used = |pass: usize| plan.passes[pass].pass.resources().any(|resource| resource == first.resource);
    assert!(!plan.batches[last].passes.clone().any(used), "the last batch uses other images");
    vain.batches[last].transitions.push(first);
    let told = format!("a barrier before batch {last} changes `{}`, which is not used there", name(first.resource));
    assert_reports(&vain, &told);
    let mut exported = plan.clone();
    exported.exports.push(plan.exports[0]);
    assert_reports(&exported, "two barriers before the end of the frame change `");
}

#[test]
fn what_is_written_that_is_not_made_here_and_lists_of_another_length_are_named() {
    let plan = plan(Alias::Placed);
    let input = plan.inputs[0].1;
    let writer = plan.work().position(|pass| pass.function_result().is_some()).expect("functions make images");
    let mut broken = plan.clone();
    broken.passes[writer].pass.results[0].image = input;
    let name = &plan.image_names()[input.0 as usize];
    assert_reports(&broken, &format!("` writes `{name}`, which is not made in this frame"));
    let placed = PlacedPlan::new(Arc::new(plan));
    let (images, batches) = (placed.plan.images.len(), placed.plan.batches.len());
    let changes: [(BreakPlaced, String); 2] = [
        (
            |placed| placed.placement.offsets.truncate(placed.plan.images.len() - 1),
            format!("the plan has {} offsets where it needs {images}", images - 1),
        ),
        (
            |placed| placed.placement.aliasing.push(Vec::new()),
            format!("the plan has {} batches of aliasing barriers where it needs {batches}", batches + 1),
        ),
    ];
    for (change, told) in changes {
        let mut broken = placed.clone();
        change(&mut broken);
        let faults = verify_placed(&broken).expect_err(&told);
        assert!(faults.iter().any(|fault| fault.to_string() == told), "{told}: {faults:?}");
    }
}

/// A baked LUT is evaluated in the first frame only, so nothing of a frame may be in it.
#[test]
fn a_lut_that_depends_on_the_frame_is_named() {
    let graph = checked(
        r#"Pipeline(inputs: { "in": Exposed }, nodes: { "out": ToneMap(source: "in", bake: Auto),
            "b": Vignette(source: "out", amount: 0.5) }, outputs: { "out": "out", "b": "b" })"#,
    );
    let plan = plan_images(&graph, Format::Rgba16Float, Facts::default(), all_formats(), Options::default());
    assert_eq!(verify(&plan), Ok(()));
    let fill = (0..plan.passes.len()).find(|pass| plan.runs_on_change(*pass)).expect("a pass evaluates the LUT");
    let (input, given) = (plan.inputs[0].1, plan.image_names()[plan.inputs[0].1.0 as usize].clone());
    let transient = plan.images.iter().position(|image| image.origin == Origin::Transient).expect("one is made");
    let changed = |value: Arg| {
        let mut broken = plan.clone();
        broken.passes[fill].pass.kernels[0].args.push(Argument { name: "more".into(), value });
        broken
    };
    let name = &plan.pass_names()[fill];
    assert_reports(&changed(Arg::Frame), &format!("pass `{name}` evaluates a LUT from numbers of the frame"));
    let from = format!("pass `{name}` evaluates a LUT from `{given}`, which may change in every frame");
    assert_reports(&changed(Arg::Pixel(input)), &from);
    let mut broken = plan.clone();
    broken.passes[fill].pass.results.push(PassResult { kernel: 0, image: ImageId(transient as u32) });
    let writes = format!("evaluates a LUT and writes `{}`, which", plan.image_names()[transient]);
    assert_reports(&broken, &writes);
}
