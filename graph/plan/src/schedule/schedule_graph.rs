//! The graph that is scheduled: dependencies of passes, and the images that live between them.

use crate::plan::{PlannedImage, ScheduledPass};
use crate::topological::transposed;
use afterimage_graph::node::Resource;

/// Passes by their places in the recording, and their dependencies.
#[derive(Clone, Debug)]
pub(crate) struct ScheduleGraph {
    /// For each pass, those that it waits for, in ascending order.
    pub(crate) before: Vec<Vec<usize>>,
    /// For each pass, those that wait for it, in ascending order.
    pub(crate) after: Vec<Vec<usize>>,
    /// For each pass, the items that must live while it runs.
    pub(crate) uses: Vec<Vec<usize>>,
    /// Images that take part in the sharing of memory.
    pub(crate) items: Vec<Item>,
}

/// An image that takes part in the sharing of memory.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub(crate) bytes: u64,
    /// The passes that use it, in the order of recording: the first one makes it.
    pub(crate) users: Vec<usize>,
}

/// The passes that used a resource last.
#[derive(Clone, Default)]
struct LastUse {
    writer: Option<usize>,
    readers: Vec<usize>,
}

impl ScheduleGraph {
    /// A pass waits for the writer of what it reads, and a writer waits for all that read or wrote before. In every
    /// order that respects this, the passes compute what they do in the order of recording.
    pub(crate) fn new(passes: &[ScheduledPass], planned: &[PlannedImage], buffers: usize) -> Self {
        let count = passes.len();
        let images = planned.len();
        let place = |resource: &Resource| match resource {
            Resource::Image(image) => image.0 as usize,
            Resource::Buffer(buffer) => images + buffer.0 as usize,
        };
        let mut last_uses = vec![LastUse::default(); images + buffers];
        let mut users: Vec<Vec<usize>> = vec![Vec::new(); images];
        let mut before = vec![Vec::new(); count];
        for (index, ScheduledPass { pass, .. }) in passes.iter().enumerate() {
            let (reads, writes) = (pass.reads(), pass.writes());
            for image in reads.iter().chain(&writes).map(place).filter(|at| *at < images) {
                if users[image].last() != Some(&index) {
                    users[image].push(index);
                }
            }
            before[index] = waits_for(&mut last_uses, index, reads.iter().map(place), writes.iter().map(place));
        }
        let mut graph = Self { after: transposed(&before), before, uses: vec![Vec::new(); count], items: Vec::new() };
        for (users, image) in users.into_iter().zip(planned) {
            if let Some(requirement) = image.requirement.filter(|_| !users.is_empty()) {
                users.iter().for_each(|pass| graph.uses[*pass].push(graph.items.len()));
                graph.items.push(Item { bytes: requirement.bytes, users });
            }
        }
        graph
    }

    /// The same, with time running backwards.
    pub(crate) fn reversed(&self) -> Self {
        Self { before: self.after.clone(), after: self.before.clone(), ..self.clone() }
    }

    pub(crate) fn len(&self) -> usize {
        self.before.len()
    }

    /// The most bytes that live at once if each pass runs by itself, in this order.
    pub(crate) fn peak(&self, order: &[usize]) -> u64 {
        let mut batches = order.iter().map(std::slice::from_ref);
        self.peak_of_batches(&mut batches)
    }

    /// The most bytes that live at once if the passes of a batch run together.
    pub(crate) fn peak_of_batches(&self, batches: &mut dyn Iterator<Item = &[usize]>) -> u64 {
        let mut left: Vec<usize> = self.items.iter().map(|item| item.users.len()).collect();
        let (mut live, mut peak) = (0, 0);
        for batch in batches {
            let mut freed = 0;
            for item in batch.iter().flat_map(|pass| &self.uses[*pass]) {
                let Item { bytes, users } = &self.items[*item];
                if left[*item] == users.len() {
                    live += bytes;
                }
                left[*item] -= 1;
                if left[*item] == 0 {
                    freed += bytes;
                }
            }
            peak = peak.max(live);
            live -= freed;
        }
        peak
    }
}

fn waits_for(
    last_uses: &mut [LastUse],
    index: usize,
    reads: impl Iterator<Item = usize>,
    writes: impl Iterator<Item = usize>,
) -> Vec<usize> {
    let mut waits = Vec::new();
    for at in reads {
        waits.extend(last_uses[at].writer);
        last_uses[at].readers.push(index);
    }
    for at in writes {
        waits.extend(last_uses[at].writer.replace(index));
        waits.append(&mut last_uses[at].readers);
    }
    waits.sort_unstable();
    waits.dedup();
    waits.retain(|pass| *pass != index);
    waits
}
