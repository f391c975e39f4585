//! Explicit transitions of textures before a batch, where the barriers that wgpu adds for dispatches are missing or
//! late.
//!
//! wgpu puts a barrier before a dispatch that uses an image in another way than the frame did before; the first use of
//! an image in a frame records its state and waits for nothing. Two cases are left. Images that several passes of a
//! batch read must change before the batch, or the second pass would wait for the first. And wgpu does not know that a
//! texture aliases another, so before its first write the device must wait for the passes that used the memory. A
//! barrier waits for all dispatches before it, so where the batch begins with one anyway, none is added: each
//! transition costs the host as much as half a dispatch, and a barrier of its own.

use afterimage_graph::node::{ImageId, Origin, Resource};
use afterimage_plan::{AliasingBarrier, Batch, Plan, Use};
use wgpu::{TextureUsages, TextureUses, TextureView};

use crate::executor::loaded::residency::Residency;

/// The explicit transitions of a plan.
pub(crate) struct ExplicitTransitions {
    /// For each pass, whether it draws.
    pub(crate) is_drawn: Vec<bool>,
    /// For each pass the images that change before it, and their new states; none for most.
    of_passes: Vec<Vec<(ImageId, TextureUses)>>,
}

impl ExplicitTransitions {
    pub(crate) fn new(plan: &Plan, residency: &Residency, is_drawn: Vec<bool>) -> Self {
        let of_passes =
            explicit_transitions(plan, &residency.placement.aliasing, &is_drawn, residency.placed.is_some());
        Self { is_drawn, of_passes }
    }

    /// The transitions before a pass: views of the images in that ring index, and their new states. `views` are those
    /// of the host.
    pub(crate) fn before<'a>(
        &'a self,
        pass: usize,
        residency: &'a Residency,
        views: &'a [TextureView],
        ring_index: usize,
    ) -> impl ExactSizeIterator<Item = (&'a TextureView, TextureUses)> {
        self.of_passes[pass].iter().map(move |(image, state)| {
            let view = residency.view(*image, views, ring_index as u32);
            let storable = view.texture().usage().contains(TextureUsages::STORAGE_BINDING);
            (view, if storable { *state } else { TextureUses::RESOURCE })
        })
    }
}

/// For each pass the images that change before it, and their new states. `aliasing` are the aliasing barriers of each
/// batch, which count where the images lie in a heap.
fn explicit_transitions(
    plan: &Plan,
    aliasing: &[Vec<AliasingBarrier>],
    is_drawn: &[bool],
    has_heap: bool,
) -> Vec<Vec<(ImageId, TextureUses)>> {
    let mut transitions = vec![Vec::new(); plan.passes.len()];
    let mut finished = vec![false; plan.images.len()];
    for (batch, aliasing) in plan.batches.iter().zip(aliasing) {
        // A draw ends the compute pass of the dispatches before it. The next compute pass begins with the barriers of
        // all that follows, which are then missing there.
        let first = batch.passes.start;
        let is_dispatched = !is_drawn[..batch.passes.end].contains(&true);
        let made: Vec<ImageId> =
            images_to_read(plan, batch).filter(|(_, from)| from.writes()).map(|(i, _)| i).collect();
        let mut before = Vec::new();
        // Barriers of a pass that may not run are none to rely on.
        let may_not_run = !plan.runs_all_passes();
        if may_not_run || !is_dispatched || !all_read_by(plan, first, &made) {
            let read = images_to_read(plan, batch).filter(|_| batch.passes.len() > 1);
            before.extend(read.map(|(image, _)| (image, TextureUses::RESOURCE)));
        }
        if has_heap {
            let waits = is_dispatched && !may_not_run && !made.is_empty();
            let unordered = aliasing.iter().filter(|barrier| !(waits && were_read(barrier, &finished)));
            before.extend(unordered.map(|barrier| (barrier.image, TextureUses::STORAGE_WRITE_ONLY)));
        }
        transitions[first] = before;
        images_to_read(plan, batch).for_each(|(image, _)| finished[image.0 as usize] = true);
    }
    transitions
}

/// The images that begin to be read in the batch, and their use before. Retained ones are none of them: most frames do
/// not write them, and then no barrier waits.
fn images_to_read(plan: &Plan, batch: &Batch) -> impl Iterator<Item = (ImageId, Use)> {
    let read = batch.transitions.iter().filter(|transition| transition.to == Use::Read);
    let images = read.filter_map(|transition| Some((transition.resource.image()?, transition.from)));
    images.filter(|(image, _)| plan.image(*image).origin != Origin::Retained)
}

/// True if one pass reads all of these images: then its own barrier is enough.
fn all_read_by(plan: &Plan, pass: usize, images: &[ImageId]) -> bool {
    let reads = plan.passes[pass].pass.reads();
    images.iter().all(|image| reads.contains(&Resource::Image(*image)))
}

/// True if the images that used the memory before were read after they were written: only then is it enough to wait,
/// without a barrier for their writes.
fn were_read(barrier: &AliasingBarrier, finished: &[bool]) -> bool {
    barrier.owners.iter().all(|owner| finished[owner.0 as usize])
}

#[cfg(test)]
mod tests {
    use afterimage_base::caps::Caps;
    use afterimage_base::image::{Format, ImageDesc, Size};
    use afterimage_graph::check::{CheckOptions, Facts, check};
    use afterimage_graph::document::parse;
    use afterimage_graph::node::{ImageId, NodeKind, Registry};
    use afterimage_graph::prelude::*;
    use afterimage_plan::{AliasingBarrier, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan};
    use wgpu::TextureUses;

    use super::explicit_transitions;

    /// Two blurs of two images of the host.
    fn two_blurs(options: Options) -> Plan {
        let text = r#"Pipeline(
            inputs: { "scene": Color, "small": Color },
            nodes: {
                "narrow": Gaussian(source: "scene", sigma: 2.0),
                "wide": Gaussian(source: "small", sigma: 5.0),
            },
            outputs: { "narrow": "narrow", "wide": "wide" },
        )"#;
        planned(text, &[], options)
    }

    fn planned(text: &str, kinds: &[NodeKind], options: Options) -> Plan {
        let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
        let registry = Registry::new(&[afterimage_nodes::ALL, kinds]).expect("no two kinds share a name");
        let graph = check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0;
        let size = Size::new(256, 144);
        let given = |size| HostImageDesc { desc: ImageDesc::new(size), finite: true };
        let request = PlanRequest {
            given: HostInputs {
                inputs: [("scene".into(), given(size)), ("small".into(), given(size.half()))].into(),
                ..HostInputs::none(size)
            },
            facts: Facts::default(),
            caps: Caps { storage: Format::ALL.into(), ..Caps::default() },
            options,
            dynamic: Default::default(),
            requirement: &Requirement::typical,
        };
        plan(&graph, &request).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The transitions before each pass, with the labels of their images.
    fn transitions(plan: &Plan, is_drawn: bool, has_heap: bool) -> Vec<Vec<(String, TextureUses)>> {
        let aliasing: Vec<_> = plan.batches.iter().map(|batch| batch.aliasing.clone()).collect();
        let named = |(image, state): &(ImageId, TextureUses)| (plan.image(*image).label.clone(), *state);
        let transitions = explicit_transitions(plan, &aliasing, &vec![is_drawn; plan.passes.len()], has_heap);
        transitions.iter().map(|before| before.iter().map(named).collect()).collect()
    }

    #[test]
    fn images_that_several_passes_of_a_batch_read_change_before_the_first_of_them() {
        let plan = two_blurs(Options { batches_first: true, ..Options::default() });
        assert_eq!(plan.batches.len(), 2, "{}", plan.to_text());
        let between: Vec<(String, TextureUses)> = plan.batches[1]
            .transitions
            .iter()
            .filter_map(|t| Some((plan.image(t.resource.image()?).label.clone(), TextureUses::RESOURCE)))
            .filter(|(label, _)| !plan.outputs.iter().any(|output| plan.image(output.image).label == *label))
            .collect();
        assert_eq!(between.len(), 2);
        assert_eq!(transitions(&plan, false, false), [vec![], vec![], between.clone(), vec![]]);
        // Draws of the first batch read the images of the host.
        let host = ["scene", "small"].map(|label| (label.to_owned(), TextureUses::RESOURCE)).to_vec();
        assert_eq!(transitions(&plan, true, false), [host, vec![], between, vec![]]);
    }

    #[test]
    fn an_image_that_takes_over_memory_waits_for_its_last_users_where_no_barrier_does() {
        let plan = two_blurs(Options { serial: true, ..Options::default() });
        let barriers: Vec<(usize, String)> = plan
            .batches
            .iter()
            .flat_map(|batch| batch.aliasing.iter().map(|b| (batch.passes.start, plan.image(b.image).label.clone())))
            .collect();
        let [(pass, label)] = barriers.as_slice() else { panic!("one image takes over: {barriers:?}") };
        let mut expected = vec![Vec::new(); plan.passes.len()];
        assert_eq!(transitions(&plan, false, false), expected, "images with textures of their own");
        expected[*pass] = vec![(label.clone(), TextureUses::STORAGE_WRITE_ONLY)];
        assert_eq!(transitions(&plan, false, true), expected);
    }

    static BOTH: Shader = Shader::new(
        "both",
        "@group(0) @binding(0) var source: texture_2d<f32>;
        @group(0) @binding(1) var result: texture_storage_2d<rgba16float, write>;
        @group(0) @binding(2) var beside: texture_storage_2d<rgba16float, write>;
        @compute @workgroup_size(8, 8)
        fn both(@builtin(global_invocation_id) id: vec3u) {
            let pixel = texel(source, vec2i(id.xy));
            textureStore(result, id.xy, pixel);
            textureStore(beside, id.xy, pixel);
        }",
    );

    node_kind! {
        /// Makes an image twice, of which one is not read.
        pub struct Both {}

        const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
        const OUTPUTS: &'static [Output] = &[
            Output::image("result", OutputState::same("source"), "The image.").or_input("source"),
            Output::image("beside", OutputState::same("source"), "The image.").or_input("source"),
        ];
    }

    impl Node for Both {
        fn record(&self, pass: &mut Recorder<'_>) {
            let source = pass.image("source");
            let desc = ImageDesc::new(pass.desc(source).size);
            let result = pass.output("result", desc);
            let beside = pass.output("beside", desc);
            let groups = desc.size.div_up(8);
            let call = pass.compute(&BOTH, "both").image("source", source).image("result", result);
            call.image("beside", beside).dispatch([groups.width, groups.height, 1]);
        }
    }

    /// Who takes the memory of an image that nobody has read must wait for its writes, which a wait for the passes
    /// before does not make visible.
    #[test]
    fn an_image_that_takes_over_memory_waits_for_writes_that_nobody_has_read() {
        let text = r#"Pipeline(
            inputs: { "scene": Color },
            nodes: { "both": Both(source: "scene"), "soft": Gaussian(source: "both", sigma: 2.0) },
            outputs: { "soft": "soft" },
        )"#;
        let plan = planned(text, &[NodeKind::of::<Both>()], Options::default());
        let barriers: Vec<(usize, &AliasingBarrier)> =
            plan.batches.iter().flat_map(|batch| batch.aliasing.iter().map(|b| (batch.passes.start, b))).collect();
        let [(pass, barrier)] = barriers.as_slice() else { panic!("one image takes over: {}", plan.to_text()) };
        let owners: Vec<&str> = barrier.owners.iter().map(|owner| plan.image(*owner).label.as_str()).collect();
        assert_eq!(owners, ["both.beside"]);
        assert_eq!(transitions(&plan, false, false)[*pass], []);
        let label = plan.image(barrier.image).label.clone();
        assert_eq!(transitions(&plan, false, true)[*pass], [(label, TextureUses::STORAGE_WRITE_ONLY)]);
    }
}
