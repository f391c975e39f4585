//! The errors of a pipeline beyond the [limits](super::limits).

use super::Condition;
use super::draft::DraftGraph;
use super::expand::Expansion;
use super::limits::{MAX_CONDITION, MAX_FACTS, MAX_INPUTS, MAX_NAME, MAX_NODES, MAX_OUTPUTS, MAX_TIERS, MAX_USUAL};
use super::reports::Reports;
use crate::document::Document;
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned};

impl Expansion<'_> {
    /// Returns whether the number of nodes permits one more.
    pub(super) fn has_room(&mut self, location: &Location) -> bool {
        let has_room = self.drafted.nodes.len() + self.drafted.scopes.len() <= MAX_NODES;
        if !has_room {
            let message = format!("the pipeline has more than {MAX_NODES} nodes");
            let error = Diagnostic::error("too-many-nodes", message).at(location, "the first one too many");
            self.fields
                .reports
                .push_limit(error.help("look for a pipeline that uses others which use others, each of them twice"));
        }
        has_room
    }

    /// Reports the sections of a document that have too many entries.
    pub(super) fn report_long_sections(&mut self, document: &Document) {
        let input = document.inputs.get(MAX_INPUTS).map(|input| &input.name);
        let output = document.outputs.get(MAX_OUTPUTS).map(|output| &output.name);
        let tier = document.tiers.get(MAX_TIERS).map(|(name, _)| name);
        let fact = document.facts.iter().flatten().nth(MAX_FACTS).map(|(name, _)| name);
        let usual = document.usual.get(MAX_USUAL).map(|(name, _)| name);
        let sections: [(&'static str, _, _, _); 5] = [
            ("too-many-inputs", input, MAX_INPUTS, "inputs"),
            ("too-many-outputs", output, MAX_OUTPUTS, "outputs"),
            ("too-many-tiers", tier, MAX_TIERS, "tiers"),
            ("too-many-facts", fact, MAX_FACTS, "facts"),
            ("too-many-usual", usual, MAX_USUAL, "usual parameters"),
        ];
        for (code, first, most, what) in sections {
            let Some(first) = first else { continue };
            let message = format!("the pipeline has more than {most} {what}");
            self.fields
                .reports
                .push_limit(Diagnostic::error(code, message).at(&first.location, "the first one too many"));
        }
    }

    /// Returns whether a name inside of a scope is short enough.
    pub(super) fn is_short(&mut self, scope: usize, name: &Spanned<String>) -> bool {
        let outer: usize = self.drafted.scopes_around(scope).map(|scope| scope.name.value.len() + 1).sum();
        // The top has no name.
        let bytes = name.value.len() + outer - 1;
        if bytes > MAX_NAME {
            let message = format!("the name has {bytes} bytes with those of the pipelines around it");
            let error = Diagnostic::error("long-name", message).at(&name.location, "");
            self.fields.reports.push(error.help(format!("a name has at most {MAX_NAME} bytes")));
        }
        bytes <= MAX_NAME
    }
}

impl DraftGraph {
    /// Reports nodes whose condition is too long once it is joined with those of the pipelines around.
    pub(super) fn report_long_conditions(&self, reports: &mut Reports) {
        let mut outer: Vec<usize> = Vec::with_capacity(self.scopes.len());
        for scope in &self.scopes {
            let around = scope.parent.map_or(0, |parent| outer[parent]);
            outer.push(around + scope.when.as_ref().map_or(0, |when| when.to_string().len()));
        }
        let bytes = |when: &Condition| when.to_string().len();
        let long = self.nodes.iter().find(|draft| {
            let own = draft.when.as_ref().map_or(0, bytes);
            own + outer[draft.scope] > MAX_CONDITION
        });
        if let Some(draft) = long {
            let message = format!("the condition of a node has more than {MAX_CONDITION} bytes");
            let error = Diagnostic::error("long-condition", message).at(&draft.kind_location, "this node");
            let help = "those of the pipelines around it count, too: let the host tell one fact in place of many";
            reports.push_limit(error.help(help));
        }
    }
}
