//! The text of a pipeline with the user's unsaved changes, its stored file, and its last valid graph.

use std::ops::RangeInclusive;
use std::sync::Arc;

use afterimage_graph::check::{Change, Graph, Saver};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::{parse, without_mark};
use afterimage_graph::node::NodeKind;
use afterimage_graph::value::{FileValue, Value};

use super::project::ask_saver;
use super::{Changes, Checked, CompareWith, NamedFile, Project, Slot, Target, TextProject};
use crate::Problem;

/// The file was changed where the user has changed something, too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Conflict {
    /// Both texts were changed. This is the file's.
    Text(String),
    /// The values of these targets. The text of the file is already shown.
    Values(Vec<Target>),
}

/// The user's choice in a [`Conflict`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// The user's text or values stay, and the next save writes them.
    KeepMine,
    /// The file's text or values are shown. Undo goes back to the user's.
    TakeFile,
}

/// An open pipeline as text and values. It knows no device.
pub struct Editor {
    project: Box<dyn Project>,
    pub(super) changes: Changes,
    snapshots: [Option<Changes>; 2],
    checked: Option<Checked>,
    pub(super) conflict: Option<Conflict>,
    is_gone: bool,
    /// The text has errors. `checked` is that of an earlier text then.
    has_errors: bool,
}

impl Editor {
    pub(super) fn new(project: Box<dyn Project>) -> Self {
        let (changes, snapshots) = (Changes::default(), [None, None]);
        Self { project, changes, snapshots, checked: None, conflict: None, is_gone: false, has_errors: false }
    }

    pub fn project(&self) -> &dyn Project {
        &*self.project
    }

    /// The text that is shown, without the changed values.
    pub fn text(&self) -> &str {
        self.changes.text()
    }

    /// The tier that is shown.
    pub fn tier(&self) -> Option<&str> {
        self.changes.tier()
    }

    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// The result of the last check without errors, for the tier that is shown.
    pub fn checked(&self) -> Option<&Checked> {
        self.checked.as_ref()
    }

    /// The graph of the last text without errors.
    pub fn graph(&self) -> Option<&Arc<Graph>> {
        self.checked.as_ref().map(|checked| &checked.graph)
    }

    /// The tiers of the pipeline.
    pub fn tiers(&self) -> &[String] {
        self.checked.as_ref().map_or(&[], |checked| &checked.tiers)
    }

    /// The text has errors, and the graph is that of an earlier text.
    pub fn has_errors(&self) -> bool {
        self.has_errors
    }

    /// The value in the text.
    pub fn written(&self, target: &Target) -> Option<Value> {
        target.written(self.graph()?)
    }

    /// The present value of a parameter.
    pub fn value(&self, name: &str) -> Option<Value> {
        let target = Target::Parameter(name.to_owned());
        self.changes.get(&target).cloned().or_else(|| self.written(&target))
    }

    /// True for a node that neither the text nor the user has switched off.
    pub fn is_on(&self, node: &str) -> bool {
        let target = Target::Node(node.to_owned());
        self.changes.get(&target).cloned().or_else(|| self.written(&target)) == Some(Value::Bool(true))
    }

    /// The graph with the nodes that the user has switched.
    pub(super) fn present_graph(&self) -> Option<Graph> {
        Some(with_switches(self.graph()?, &self.changes))
    }

    /// Remembers the present text, tier and values.
    pub(super) fn take_snapshot(&mut self, slot: Slot) {
        self.snapshots[slot as usize] = Some(self.changes.snapshot());
    }

    /// The text, the tier and the values that were remembered.
    pub fn snapshot(&self, slot: Slot) -> Option<&Changes> {
        self.snapshots[slot as usize].as_ref()
    }

    /// The lines of the text, counted from 1, in which the file writes a node.
    pub fn lines_of(&self, node: &str) -> Option<RangeInclusive<usize>> {
        let document = parse(&self.project.name(), self.text()).ok()?;
        let span = document.nodes.iter().find(|entry| entry.name.value == node)?.span();
        let text = without_mark(self.text());
        let line = |at: usize| text[..at].matches('\n').count() + 1;
        Some(line(span.start)..=line(span.end))
    }

    /// The conflict that the user has to resolve before anything can be saved.
    pub fn conflict(&self) -> Option<&Conflict> {
        self.conflict.as_ref()
    }

    /// True if the text and all values are in the file.
    pub fn is_saved(&self) -> bool {
        self.changes.is_empty() && !self.is_gone
    }

    /// The text with all changed values in it. While the text has errors, it is the text alone.
    pub fn text_with_changes(&self) -> String {
        self.with_values(None).unwrap_or_else(|_| self.text().to_owned())
    }

    /// The files that the pipeline names and that are in memory alone.
    pub fn files_in_memory(&self) -> Vec<NamedFile> {
        self.project.files_in_memory(self.text())
    }

    /// Reads the text for the first time.
    pub(super) fn load(&mut self) -> Result<(), Problem> {
        let text = self.project.read().map_err(Problem::Pipeline)?;
        let text = text.ok_or_else(|| Problem::message(format!("there is no file `{}`", self.project.name())))?;
        self.changes = Changes::new(&text);
        Ok(())
    }

    /// Reads the stored text; `None` if the file was deleted.
    pub(super) fn read(&mut self) -> Result<Option<String>, Problem> {
        let read = self.project.read();
        self.is_gone = matches!(read, Ok(None));
        read.map_err(Problem::Pipeline)
    }

    /// True if the stored text or a file that it names has changed since the last call.
    pub(super) fn has_file_changed(&mut self) -> bool {
        self.project.has_changed()
    }

    /// Checks the text. An error leaves the last valid graph.
    pub(super) fn check(&mut self) -> Result<(), Problem> {
        let checked = self.project.check(self.changes.text(), self.changes.tier());
        self.has_errors = checked.is_err();
        self.checked = Some(checked.map_err(Problem::Pipeline)?);
        Ok(())
    }

    /// Takes over another text of the file and checks it. `None` if the user has changed the text, too: a conflict.
    pub(super) fn follow_text(&mut self, text: String) -> Option<Result<(), Problem>> {
        if self.changes.is_text_changed() && text != self.changes.text() {
            self.conflict = Some(Conflict::Text(text));
            return None;
        }
        Some(self.take_text(&text))
    }

    /// Shows the text of the file. Values that were changed in it and by the user are a conflict.
    pub(super) fn take_text(&mut self, text: &str) -> Result<(), Problem> {
        let before = self.graph().cloned();
        self.changes.set_written(text);
        let checked = self.check();
        let (Some(before), Some(now)) = (before, self.graph().cloned()) else { return checked };
        let mut conflicting = Vec::new();
        let values: Vec<(Target, Value)> =
            self.changes.iter().map(|(target, value)| (target.clone(), value.clone())).collect();
        for (target, value) in values {
            let written = target.written(&now);
            if written.as_ref() == Some(&value) {
                self.changes.forget(&target);
            } else if written != target.written(&before) {
                conflicting.push(target);
            }
        }
        self.conflict = (!conflicting.is_empty()).then_some(Conflict::Values(conflicting));
        checked
    }

    /// A value of a file with the content of the file.
    pub(super) fn with_bytes(&self, value: Value) -> Result<Value, Problem> {
        match value {
            Value::File(file) if file.bytes.is_none() && !file.path.is_empty() => {
                let bytes = self.project.file(&file.path);
                let bytes = bytes.map_err(|why| Problem::message(format!("`{}`: {why}", file.path)))?;
                Ok(Value::File(FileValue { bytes: Some(bytes.into()), ..file }))
            }
            other => Ok(other),
        }
    }

    /// The graph of another picture, to compare the shown one with, and the changed values that it has.
    pub(super) fn graph_to_compare(&mut self, other: &CompareWith) -> Result<(Graph, Changes), Problem> {
        let no_pipeline = || Problem::message("there is no pipeline to compare with");
        let (checked, changes) = match other {
            CompareWith::Written if !self.changes.is_text_changed() => {
                let graph = self.graph().ok_or_else(no_pipeline)?;
                return Ok((Graph::clone(graph), Changes::default()));
            }
            CompareWith::Written => {
                (self.project.check(self.changes.written(), self.changes.tier()), Changes::default())
            }
            CompareWith::Snapshot(slot) => {
                let snapshot = self.snapshot(*slot).ok_or_else(no_pipeline)?.snapshot();
                (self.project.check(snapshot.text(), snapshot.tier()), snapshot)
            }
            CompareWith::Reference => {
                return Ok((self.present_graph().ok_or_else(no_pipeline)?, self.changes.snapshot()));
            }
            CompareWith::Tier(tier) => {
                (self.project.check(self.changes.text(), tier.as_deref()), self.changes.snapshot())
            }
            CompareWith::Pipeline(name) => {
                let mut project = TextProject::built_in(name).ok_or_else(no_pipeline)?;
                let text = project.text().to_owned();
                (project.check(&text, None), Changes::default())
            }
        };
        Ok((with_switches(&checked.map_err(Problem::Pipeline)?.graph, &changes), changes))
    }

    /// Writes the text with all changed values in it. Returns the place, for people.
    pub(super) fn write(&mut self, new_tier: Option<&str>) -> Result<String, Problem> {
        let text = self.text_to_save(new_tier)?;
        let place = self.project.write(&text).map_err(Problem::message)?;
        self.note_saved(&text, new_tier);
        Ok(place)
    }

    /// The same into another project, in which the pipeline is from then on.
    pub(super) fn write_into(
        &mut self,
        mut project: Box<dyn Project>,
        new_tier: Option<&str>,
    ) -> Result<String, Problem> {
        let text = self.text_to_save(new_tier)?;
        let place = project.write(&text).map_err(Problem::message)?;
        (self.project, self.conflict) = (project, None);
        self.note_saved(&text, new_tier);
        Ok(place)
    }

    /// A text with errors is saved without the changed values.
    fn text_to_save(&self, new_tier: Option<&str>) -> Result<String, Problem> {
        match self.has_errors && new_tier.is_none() {
            true => Ok(self.text().to_owned()),
            false => self.with_values(new_tier),
        }
    }

    fn with_values(&self, new_tier: Option<&str>) -> Result<String, Problem> {
        let values: Vec<Change> = self.changes.iter().map(|(target, value)| target.change(value)).collect();
        self.ask(|saver| match new_tier {
            None => saver.save(self.tier(), &values),
            Some(new) => saver.save_as_tier(new, self.tier(), &values),
        })
    }

    /// The answer of what writes changes and edits into the text.
    pub(super) fn ask<T>(&self, ask: impl FnOnce(&Saver<'_>) -> Result<T, Diagnostics>) -> Result<T, Problem> {
        ask_saver(&*self.project, self.text(), ask).map_err(Problem::Pipeline)
    }

    /// All kinds of nodes.
    pub(super) fn kinds(&self) -> Result<Vec<NodeKind>, Problem> {
        let empty = "Pipeline(inputs: {}, nodes: {}, outputs: {})";
        let kinds = ask_saver(&*self.project, empty, |saver| Ok(saver.kinds().cloned().collect()));
        kinds.map_err(Problem::Pipeline)
    }

    fn note_saved(&mut self, text: &str, new_tier: Option<&str>) {
        self.is_gone = false;
        if self.has_errors && new_tier.is_none() {
            return self.changes.save_text();
        }
        let tier = new_tier.or(self.tier()).map(str::to_owned);
        self.changes.save(text, tier);
    }
}

/// A graph with the nodes that are switched by changes.
fn with_switches(graph: &Graph, changes: &Changes) -> Graph {
    let mut graph = graph.clone();
    for (target, value) in changes.iter() {
        let Target::Node(name) = target else { continue };
        if let Some((index, _)) = graph.node(name) {
            graph.nodes[index].off = *value == Value::Bool(false);
        }
    }
    graph
}
