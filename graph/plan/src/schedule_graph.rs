//! What an order is made from: which pass waits for which, and which images live between them.

use crate::Requirement;
use afterimage_graph::node::{Recording, Resource};

/// Passes by their places in the recording, and what ties them together.
#[derive(Clone, Debug)]
pub(crate) struct ScheduleGraph {
    /// For each pass, those that it waits for, in ascending order.
    pub(crate) before: Vec<Vec<usize>>,
    /// For each pass, those that wait for it, in ascending order.
    pub(crate) after: Vec<Vec<usize>>,
    /// For each pass, the items that must live while it runs.
    pub(crate) touches: Vec<Vec<usize>>,
    /// Images that take part in the sharing of memory.
    pub(crate) items: Vec<Item>,
}

/// An image that takes part in the sharing of memory.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    /// Its bytes.
    pub(crate) bytes: u64,
    /// The passes that touch it, in the order of recording: the first one makes it.
    pub(crate) users: Vec<usize>,
}

/// Who touched a resource last.
#[derive(Clone, Default)]
struct Touched {
    writer: Option<usize>,
    readers: Vec<usize>,
}

impl ScheduleGraph {
    /// A pass waits for the writer of what it reads, and whoever writes waits for all who read or wrote before: what the passes do in the
    /// order of recording is what they do in every order that keeps to this.
    pub(crate) fn new(recording: &Recording, requirements: &[Option<Requirement>]) -> Self {
        let count = recording.passes.len();
        let images = recording.images.len();
        let place = |resource: &Resource| match resource {
            Resource::Image(image) => image.0 as usize,
            Resource::Buffer(buffer) => images + buffer.0 as usize,
        };
        let mut touched = vec![Touched::default(); images + recording.buffers.len()];
        let mut users: Vec<Vec<usize>> = vec![Vec::new(); images];
        let mut before = vec![Vec::new(); count];
        for (index, pass) in recording.passes.iter().enumerate() {
            let (reads, writes) = (pass.reads(), pass.writes());
            for image in reads.iter().chain(&writes).map(place).filter(|at| *at < images) {
                if users[image].last() != Some(&index) {
                    users[image].push(index);
                }
            }
            before[index] = waits_for(&mut touched, index, reads.iter().map(place), writes.iter().map(place));
        }
        let mut flow = Self { after: transposed(&before), before, touches: vec![Vec::new(); count], items: Vec::new() };
        for (users, requirement) in users.into_iter().zip(requirements) {
            if let Some(requirement) = requirement.filter(|_| !users.is_empty()) {
                users.iter().for_each(|pass| flow.touches[*pass].push(flow.items.len()));
                flow.items.push(Item { bytes: requirement.bytes, users });
            }
        }
        flow
    }

    /// The same, with time running backwards.
    pub(crate) fn reversed(&self) -> Self {
        Self { before: self.after.clone(), after: self.before.clone(), ..self.clone() }
    }

    /// How many passes there are.
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
            for item in batch.iter().flat_map(|pass| &self.touches[*pass]) {
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
    touched: &mut [Touched],
    index: usize,
    reads: impl Iterator<Item = usize>,
    writes: impl Iterator<Item = usize>,
) -> Vec<usize> {
    let mut waits = Vec::new();
    for at in reads {
        waits.extend(touched[at].writer);
        touched[at].readers.push(index);
    }
    for at in writes {
        waits.extend(touched[at].writer.replace(index));
        waits.append(&mut touched[at].readers);
    }
    waits.sort_unstable();
    waits.dedup();
    waits.retain(|pass| *pass != index);
    waits
}

fn transposed(before: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut after = vec![Vec::new(); before.len()];
    for (index, waits) in before.iter().enumerate() {
        waits.iter().for_each(|pass| after[*pass].push(index));
    }
    after
}
