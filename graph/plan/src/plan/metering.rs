//! Meters: the part of the state that follows from what frames measure, each alone.

use std::collections::BTreeSet;

use afterimage_graph::node::{BufferId, BufferLife, Resource};

use super::Plan;

/// The passes of meters. Frames can be measured in any order; from what they have measured, the state at any frame
/// follows without their images.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metering {
    /// Passes that measure a frame, in the order of the plan. They read nothing of other frames.
    pub measuring: Vec<usize>,
    /// The buffers of measurements.
    pub measured: Vec<BufferId>,
    /// Passes that make the state of the next frame from what is measured and the state before, and from nothing else;
    /// in the order of the plan.
    pub integrating: Vec<usize>,
    /// The buffers of that state.
    pub state: Vec<BufferId>,
}

impl Plan {
    /// The meters, without those that measure what earlier frames have left: their state follows from all images only.
    pub fn metering(&self) -> Metering {
        let writes_state = |pass: &usize| self.written_buffers(*pass).any(|buffer| self.outlives_frames(buffer));
        let mut integrating: Vec<usize> = (0..self.passes.len()).filter(writes_state).collect();
        // A pass that falls out may take the state away that another one reads.
        loop {
            let metering = self.metering_of(&integrating);
            if metering.integrating.len() == integrating.len() {
                return metering;
            }
            integrating = metering.integrating;
        }
    }

    /// The meters if these passes make the state; those are left out that need more than it and what is measured.
    fn metering_of(&self, candidates: &[usize]) -> Metering {
        let mut state: BTreeSet<BufferId> = candidates.iter().flat_map(|pass| self.written_buffers(*pass)).collect();
        for pass in (0..self.passes.len()).filter(|pass| !candidates.contains(pass)) {
            for buffer in self.written_buffers(pass) {
                state.remove(&buffer);
            }
        }
        let (mut measuring, mut measured) = (BTreeSet::new(), BTreeSet::new());
        let mut integrating = Vec::new();
        for &pass in candidates {
            let Some(read) = self.measured_by(pass, &state) else { continue };
            integrating.push(pass);
            for (buffer, passes) in read {
                measured.insert(buffer);
                measuring.extend(passes);
            }
        }
        Metering {
            measuring: measuring.into_iter().collect(),
            measured: measured.into_iter().collect(),
            integrating,
            state: state.into_iter().collect(),
        }
    }

    /// The buffers that a pass reads besides the state, with the passes that measure them. `None` if the pass needs or
    /// writes anything else.
    fn measured_by(&self, index: usize, state: &BTreeSet<BufferId>) -> Option<Vec<(BufferId, BTreeSet<usize>)>> {
        let pass = &self.passes[index].pass;
        let is_of_state = |resource| matches!(resource, Resource::Buffer(buffer) if state.contains(&buffer));
        if pass.args().any(|arg| arg.block().is_some()) || !pass.writes().into_iter().all(is_of_state) {
            return None;
        }
        let mut measured = Vec::new();
        for resource in pass.reads() {
            let Resource::Buffer(buffer) = resource else { return None };
            let is_constant = matches!(self.buffers[buffer.0 as usize].life, BufferLife::Constant(_));
            if !is_constant && !state.contains(&buffer) {
                measured.push((buffer, self.passes_of_this_frame(buffer, index)?));
            }
        }
        Some(measured)
    }

    /// The passes that make a buffer for the pass of that index. `None` if something of an earlier frame is needed, or
    /// if the buffer is written again later.
    fn passes_of_this_frame(&self, buffer: BufferId, reader: usize) -> Option<BTreeSet<usize>> {
        let mut needed = BTreeSet::from([Resource::Buffer(buffer)]);
        let mut passes = BTreeSet::new();
        for (index, planned) in self.passes.iter().enumerate().rev() {
            if planned.pass.writes().iter().any(|written| needed.contains(written)) {
                if index > reader {
                    return None;
                }
                passes.insert(index);
                needed.extend(planned.pass.reads());
            }
        }
        let lasting = self.lasting_resources();
        let is_of_the_past = |resource: &Resource| lasting.contains(resource) || self.is_of_earlier_frame(*resource);
        (!needed.iter().any(is_of_the_past)).then_some(passes)
    }

    fn written_buffers(&self, pass: usize) -> impl Iterator<Item = BufferId> + use<> {
        let written = self.passes[pass].pass.writes().into_iter();
        written.filter_map(|resource| match resource {
            Resource::Buffer(buffer) => Some(buffer),
            Resource::Image(_) => None,
        })
    }

    fn outlives_frames(&self, buffer: BufferId) -> bool {
        self.buffers[buffer.0 as usize].life == BufferLife::Persistent
    }
}
