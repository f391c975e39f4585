//! Culling: a node may record more passes than its present readers need, and its values may leave an input unread.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::builder::PlanBuilder;
use crate::plan::Skipped;
use afterimage_graph::node::{BufferId, BufferLife, ImageId, Origin, Recording, Resource};

/// Removes passes that write nothing which is read later, remembered or shown. What no needed pass reads of earlier
/// frames is not remembered.
///
/// Reading is what passes do, so no kind declares which inputs its values leave unread. New values of dynamic
/// parameters change no pass, and thus no reading.
pub(crate) fn cull(builder: &mut PlanBuilder) {
    let mut needs = Needs::new(&builder.recording);
    for output in &builder.outputs {
        needs.add(Resource::Image(output.image), usize::MAX);
    }
    needs.follow();
    let Needs { needed, read, .. } = needs;
    let names = |needed: bool, kept: &[bool]| -> BTreeSet<String> {
        let passes = builder.recording.passes.iter().zip(kept).filter(|(_, kept)| **kept == needed);
        passes.flat_map(|(pass, _)| &pass.nodes).cloned().collect()
    };
    let (gone, stay) = (names(false, &needed), names(true, &needed));
    let forgotten = forget(&mut builder.recording, &read);
    let skipped = gone.difference(&stay).cloned().chain(forgotten);
    builder
        .savings
        .skipped
        .extend(skipped.map(|node| Skipped { node, why: "no pass reads it at the present values".into() }));
    let mut needed = needed.into_iter();
    builder.recording.passes.retain(|_| needed.next().unwrap_or(true));
}

/// Lets images of earlier frames that no needed pass reads be images without a use; their names.
fn forget(recording: &mut Recording, read: &BTreeSet<ImageId>) -> Vec<String> {
    let mut names = Vec::new();
    for index in 0..recording.images.len() {
        let image = ImageId(index as u32);
        let Some(of) = recording.image(image).origin.previous_of().filter(|_| !read.contains(&image)) else { continue };
        // The past of a node that does not run is its own: that node is listed already.
        if of != image {
            names.push(format!("{}@previous", recording.image(of).label));
        }
        recording.images[index].origin = Origin::Transient;
    }
    names
}

/// The passes that are needed so far.
struct Needs<'a> {
    recording: &'a Recording,
    /// The passes that write each image and buffer and are not needed yet, in order.
    writers: BTreeMap<Resource, VecDeque<usize>>,
    needed: Vec<bool>,
    /// Needed passes whose reads have not been followed.
    open: Vec<usize>,
    /// The images of earlier frames that needed passes read.
    read: BTreeSet<ImageId>,
}

impl<'a> Needs<'a> {
    /// Without the outputs: the passes that write what persists.
    fn new(recording: &'a Recording) -> Self {
        let mut writers: BTreeMap<Resource, VecDeque<usize>> = BTreeMap::new();
        for (index, pass) in recording.passes.iter().enumerate() {
            for resource in pass.writes() {
                writers.entry(resource).or_default().push_back(index);
            }
        }
        let needed = vec![false; recording.passes.len()];
        let mut needs = Self { recording, writers, needed, open: Vec::new(), read: BTreeSet::new() };
        for (buffer, id) in recording.buffers.iter().zip(0..) {
            if buffer.life == BufferLife::Persistent {
                needs.add(Resource::Buffer(BufferId(id)), usize::MAX);
            }
        }
        needs
    }

    /// A resource is needed by a pass with this index: so are all passes before it that write the resource.
    fn add(&mut self, resource: Resource, reader: usize) {
        let Some(writers) = self.writers.get_mut(&resource) else { return };
        while let Some(writer) = writers.front().copied().filter(|writer| *writer < reader) {
            writers.pop_front();
            if !self.needed[writer] {
                self.needed[writer] = true;
                self.open.push(writer);
            }
        }
    }

    fn follow(&mut self) {
        while let Some(pass) = self.open.pop() {
            for resource in self.recording.passes[pass].reads() {
                self.add(resource, pass);
                let Resource::Image(image) = resource else { continue };
                let Some(of) = self.recording.image(image).origin.previous_of() else { continue };
                self.read.insert(image);
                self.add(Resource::Image(of), usize::MAX);
            }
        }
    }
}
