//! Parameters that change while a plan runs: their new uniforms, without a new plan.

use std::collections::BTreeMap;

use afterimage_graph::check::Graph;
use afterimage_graph::node::{InputValues, KernelOrigin, NodeInstance, Recording, Replay};

use crate::plan::Plan;
use crate::record::{record_node, replay_node};
use crate::record_context::{FrameContext, NodeContext};
use crate::request::PlanRequest;

/// The nodes of a plan whose parameters change while it runs: they can be recorded again for new uniforms.
///
/// A node is recorded alone, with the images that arrived at it in the plan. Only its uniforms may then differ.
#[derive(Clone, Debug)]
pub struct DynamicNodes {
    frame: FrameContext,
    nodes: BTreeMap<usize, DynamicNode>,
    /// Nodes whose outputs equal their fallbacks at the values that they have had so far: what arrives, and of each
    /// output whether its fallback replaces it.
    identities: BTreeMap<usize, (InputValues, Vec<bool>)>,
    /// Images and buffers that nodes read. Each recording appends to it, and is removed again.
    recording: Recording,
}

#[derive(Clone, Debug)]
struct DynamicNode {
    context: NodeContext,
    replay: Replay,
    /// For each kernel the places of its uniform in the buffer: none if it is culled.
    places: Vec<Vec<u64>>,
}

/// A node records other passes at its new values, so they need a new plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeedsPlan;

/// The data for recording the dynamic nodes again, until the plan is finished and the places of their uniforms are
/// known.
pub(crate) struct DynamicRecords {
    contexts: BTreeMap<usize, NodeContext>,
    identities: BTreeMap<usize, (InputValues, Vec<bool>)>,
    recording: Recording,
}

impl DynamicRecords {
    /// Copies the images and buffers of a recording that no stage has changed yet. `identities` are nodes with outputs
    /// that equal their fallbacks.
    pub(crate) fn new(
        contexts: BTreeMap<usize, NodeContext>,
        identities: BTreeMap<usize, (InputValues, Vec<bool>)>,
        recorded: &Recording,
    ) -> Self {
        let mut recording = Recording::default();
        if !contexts.is_empty() {
            recording.images.clone_from(&recorded.images);
            recording.buffers.clone_from(&recorded.buffers);
        }
        Self { contexts, identities, recording }
    }

    /// The nodes, with the places of their uniforms in the finished plan.
    pub(crate) fn into_nodes(mut self, graph: &Graph, request: &PlanRequest<'_>, plan: &Plan) -> DynamicNodes {
        let frame = FrameContext::new(request);
        let mut nodes = BTreeMap::new();
        for (index, context) in self.contexts {
            let before = [self.recording.images.len(), self.recording.buffers.len()];
            record_node(&frame, &graph.nodes[index].instance, &context, &mut self.recording);
            let replay = Replay::new(&mut self.recording, before);
            self.recording.computed.clear();
            let places = (0..replay.kernels())
                .map(|kernel| plan.uniform_places(KernelOrigin::Node { node: index, kernel }))
                .collect();
            nodes.insert(index, DynamicNode { context, replay, places });
        }
        DynamicNodes { frame, nodes, identities: self.identities, recording: self.recording }
    }
}

impl DynamicNodes {
    /// Calls `write` with an offset in the plan's uniform buffer and bytes for each uniform of a node at its present
    /// values. A node that the plan does not run has none.
    ///
    /// # Errors
    /// The node records other passes than those of the plan. Nothing is written.
    pub fn uniforms(
        &mut self,
        index: usize,
        instance: &NodeInstance,
        write: &mut dyn FnMut(u64, &[u8]),
    ) -> Result<(), NeedsPlan> {
        if let Some((inputs, replaced)) = self.identities.get(&index) {
            let outputs = instance.kind().outputs().iter().zip(replaced).filter(|(_, replaced)| **replaced);
            if outputs.into_iter().any(|(output, _)| !instance.identity_of(&output.name, inputs)) {
                return Err(NeedsPlan);
            }
        }
        let Some(node) = self.nodes.get_mut(&index) else { return Ok(()) };
        replay_node(&self.frame, instance, &node.context, &mut self.recording, &mut node.replay);
        // Other values may compute other texels. To clear a map that is empty takes longer than to ask.
        if !self.recording.computed.is_empty() {
            self.recording.computed.clear();
        }
        let uniforms = node.replay.finish(&mut self.recording).ok_or(NeedsPlan)?;
        for (bytes, places) in uniforms.iter().zip(&node.places) {
            places.iter().for_each(|place| write(*place, bytes));
        }
        Ok(())
    }
}
