//! White: the parameters at which a color of the picture is gray.

use afterimage_graph::check::GraphNode;

use super::{Model, Target};

/// Any gray.
const GRAY: [f64; 3] = [0.18; 3];

/// True for a node that can balance white.
pub(crate) fn balances_white(node: &GraphNode) -> bool {
    node.instance.values_for_gray(GRAY).is_some()
}

impl Model {
    /// Sets the parameters of a node at which a color at its first input, linear Rec.709, leaves as gray, in one step
    /// of undo. Returns false if the node has none for this color.
    pub fn make_gray(&mut self, node: &str, color: [f64; 3]) -> bool {
        let found = self.editor.graph().and_then(|graph| graph.node(node)?.1.instance.values_for_gray(color));
        let Some(values) = found else { return false };
        let named = values.into_iter().map(|(name, value)| (Target::Parameter(format!("{node}.{name}")), value));
        let values = named.map(|(target, value)| {
            let is_written = self.editor.written(&target).as_ref() == Some(&value);
            (target, (!is_written).then_some(value))
        });
        let values: Vec<_> = values.collect();
        self.editor.changes.set_together(values.clone());
        for (target, _) in values {
            if let Err(problem) = self.apply(&target) {
                self.problem = Some(problem);
            }
        }
        true
    }
}
