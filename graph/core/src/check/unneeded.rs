//! Warnings about unused entries; errors would be in the way of a file in the making.

use super::Source;
use super::draft::{DraftGraph, Feed};
use super::reports::Reports;
use afterimage_base::diagnostic::{Diagnostic, quote};

impl DraftGraph {
    /// Warns of nodes that no output needs and of inputs that nothing reads, in the checked file only.
    pub(super) fn report_unneeded(&self, reports: &mut Reports) {
        // With a node missing, everything before it would look unneeded.
        if reports.diagnostics.has_errors() {
            return;
        }
        let needed = self.needed();
        let file = self.scopes[0].name.location.file.clone();
        let read: Vec<bool> = self.read_nodes();
        let unneeded = self.nodes.iter().enumerate().filter(|(node, draft)| !needed[*node] && draft.scope == 0);
        let nodes = unneeded.filter(|(_, draft)| draft.name.location.file == file).map(|(node, draft)| {
            let name = quote(&draft.name.value);
            let message = if read[node] { format!("no output needs {name}") } else { format!("nobody reads {name}") };
            Diagnostic::warning("unneeded-node", message)
                .at(&draft.name.location, "")
                .help("the node is left out of every plan")
        });
        let mut warnings: Vec<Diagnostic> = nodes.collect();
        warnings.extend(self.unneeded_inputs());
        warnings.into_iter().for_each(|warning| reports.push(warning));
    }

    fn sources(&self) -> impl Iterator<Item = Source> + '_ {
        let of_outputs = self.outputs.iter().filter_map(|(_, wire)| wire.as_ref()?.source);
        let of_nodes = self.nodes.iter().flat_map(|draft| draft.wires.iter().flatten().filter_map(|wire| wire.source));
        of_outputs.chain(of_nodes).chain(self.sources_elsewhere.iter().copied())
    }

    fn read_nodes(&self) -> Vec<bool> {
        let mut read = vec![false; self.nodes.len()];
        for source in self.sources() {
            if let Source::Node { node, .. } = source {
                read[node] = true;
            }
        }
        read
    }

    /// The nodes that an output needs, in this frame or a later one, in this tier or another one.
    fn needed(&self) -> Vec<bool> {
        let mut needed = vec![false; self.nodes.len()];
        let mut waiting: Vec<Source> = self.outputs.iter().filter_map(|(_, wire)| wire.as_ref()?.source).collect();
        waiting.extend(&self.sources_elsewhere);
        while let Some(source) = waiting.pop() {
            if let Source::Node { node, .. } = source
                && !std::mem::replace(&mut needed[node], true)
            {
                waiting.extend(self.nodes[node].wires.iter().flatten().filter_map(|wire| wire.source));
            }
        }
        needed
    }

    fn unneeded_inputs(&self) -> Vec<Diagnostic> {
        let read: Vec<usize> =
            self.sources().filter_map(|s| if let Source::Input(i) = s { Some(i) } else { None }).collect();
        // An input may also be wired to an inner pipeline that does not read it.
        let handed = |name: &str| {
            let feeds =
                self.scopes.iter().skip(1).filter(|scope| scope.parent == Some(0)).flat_map(|scope| &scope.inputs);
            feeds.into_iter().any(|(_, feed)| matches!(feed, Feed::Wire(wire) if wire.value == name))
        };
        let inputs = self.scopes[0].inputs.iter().enumerate();
        let unread = inputs.filter(|(index, (input, _))| !read.contains(index) && !handed(&input.name.value));
        let own = unread.filter(|(_, (input, _))| input.name.location.file == self.scopes[0].name.location.file);
        own.map(|(_, (input, _))| {
            let message = format!("nothing reads the input {}", quote(&input.name.value));
            Diagnostic::warning("unread-input", message)
                .at(&input.name.location, "")
                .help("the host would have to give it for nothing")
        })
        .collect()
    }
}
