//! Passes and which of them read and write what, kept up to date while passes are joined. Each pass keeps its number.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::PlanBuilder;
use crate::topological::stable_order;
use afterimage_graph::node::{Arg, ImageId, KernelCall, Pass, PassKind, Resource};

/// The passes of a plan while they are being joined.
pub(crate) struct PassGraph {
    passes: Vec<Option<Pass>>,
    readers: BTreeMap<Resource, BTreeSet<usize>>,
    writers: BTreeMap<Resource, BTreeSet<usize>>,
    /// Images that several passes write: drawing passes, one over the other or level by level.
    redrawn: BTreeSet<ImageId>,
    kept: BTreeSet<ImageId>,
    outputs: BTreeSet<ImageId>,
}

impl PassGraph {
    /// Takes the passes out of a builder.
    pub(crate) fn new(builder: &mut PlanBuilder) -> Self {
        let kept = builder.kept();
        let outputs = builder.outputs.iter().map(|output| output.image).collect();
        let passes = std::mem::take(&mut builder.recording.passes);
        let redrawn = redrawn(&passes);
        let (readers, writers) = (BTreeMap::new(), BTreeMap::new());
        let mut graph = Self { passes: Vec::new(), readers, writers, redrawn, kept, outputs };
        for (number, pass) in passes.into_iter().enumerate() {
            graph.passes.push(None);
            graph.put(number, pass);
        }
        graph
    }

    /// Number of slots: of the passes that are left, and of those that are part of others now.
    pub(crate) fn len(&self) -> usize {
        self.passes.len()
    }

    /// The pass of that number, if it is there.
    pub(crate) fn get(&self, number: usize) -> Option<&Pass> {
        self.passes[number].as_ref()
    }

    /// The pass of that number and its result, if it consists of kernel functions and may run later.
    pub(crate) fn function_pass(&self, number: usize) -> Option<(&Pass, ImageId)> {
        let pass = self.get(number)?;
        Some((pass, pass.function_result()?)).filter(|_| !self.is_pinned(number))
    }

    /// Returns whether a pass reads an image that a later pass draws into again, so that it must not run later.
    pub(crate) fn is_pinned(&self, number: usize) -> bool {
        let reads = self.get(number).filter(|_| !self.redrawn.is_empty()).map(Pass::reads).unwrap_or_default();
        let is_redrawn = |resource: &Resource| resource.image().is_some_and(|image| self.redrawn.contains(&image));
        reads.into_iter().filter(is_redrawn).any(|resource| self.writers(resource).any(|writer| writer > number))
    }

    pub(crate) fn take(&mut self, number: usize) -> Option<Pass> {
        let pass = self.passes[number].take()?;
        self.users_of(&pass, |users| users.remove(&number));
        Some(pass)
    }

    /// Puts a pass at a number that is free.
    pub(crate) fn put(&mut self, number: usize, pass: Pass) {
        self.users_of(&pass, |users| users.insert(number));
        self.passes[number] = Some(pass);
    }

    /// Changes the readers of everything that a pass reads, and the writers of everything that it writes.
    fn users_of(&mut self, pass: &Pass, change: impl Fn(&mut BTreeSet<usize>) -> bool) {
        for (users, resources) in [(&mut self.readers, pass.reads()), (&mut self.writers, pass.writes())] {
            resources.into_iter().for_each(|resource| _ = change(users.entry(resource).or_default()));
        }
    }

    /// The passes that read something, in ascending order.
    pub(crate) fn readers(&self, resource: Resource) -> impl Iterator<Item = usize> + '_ {
        self.readers.get(&resource).into_iter().flatten().copied()
    }

    /// The passes that write something, in ascending order.
    pub(crate) fn writers(&self, resource: Resource) -> impl Iterator<Item = usize> + '_ {
        self.writers.get(&resource).into_iter().flatten().copied()
    }

    /// Returns whether an image outlives the frame or leaves it.
    pub(crate) fn is_kept(&self, image: ImageId) -> bool {
        self.kept.contains(&image)
    }

    /// Returns whether an image is an output, which the host may need as a draw target: only passes of functions can
    /// draw.
    pub(crate) fn is_output(&self, image: ImageId) -> bool {
        self.outputs.contains(&image)
    }

    /// Gives the passes back, each after those that it waits for, and otherwise in the order of their numbers.
    pub(crate) fn finish(mut self, builder: &mut PlanBuilder) {
        let before: Vec<BTreeSet<usize>> = (0..self.len()).map(|number| self.before(number)).collect();
        let order = stable_order(&before);
        assert_eq!(order.len(), self.len(), "joining passes makes no cycle");
        builder.recording.passes = order.into_iter().filter_map(|number| self.passes[number].take()).collect();
    }

    /// The passes that must come before a pass: those that write what it reads, and, for buffers and images that are
    /// written in place, every earlier one that uses what it writes.
    pub(crate) fn before(&self, number: usize) -> BTreeSet<usize> {
        let Some(pass) = self.get(number) else { return BTreeSet::new() };
        let in_place = |resource: Resource| resource.image().is_none_or(|image| self.redrawn.contains(&image));
        let is_before = |resource: Resource, other: usize| !in_place(resource) || other < number;
        let writers = pass.resources().flat_map(|r| self.writers(r).filter(move |other| is_before(r, *other)));
        let changed = pass.writes().into_iter().filter(|resource| in_place(*resource));
        let readers = changed.flat_map(|resource| self.readers(resource).filter(|other| *other < number));
        writers.chain(readers).filter(|other| *other != number).collect()
    }
}

/// The images that several of these passes write.
fn redrawn(passes: &[Pass]) -> BTreeSet<ImageId> {
    let (mut once, mut again) = (BTreeSet::new(), BTreeSet::new());
    for image in passes.iter().flat_map(Pass::writes).filter_map(Resource::image) {
        if !once.insert(image) {
            again.insert(image);
        }
    }
    again
}

/// Returns whether recomputing the pass for each reader costs less than storing its result: it is short and reads one
/// pixel of one image.
pub(super) fn is_cheap(pass: &Pass) -> bool {
    let pixels = pass.args().filter(|arg| matches!(arg, Arg::Pixel(_))).count();
    let is_short = pass.kind == PassKind::Point && pass.kernels.len() <= 2 && pixels <= 1;
    is_short && !pass.kernels.iter().any(KernelCall::is_heavy)
}
