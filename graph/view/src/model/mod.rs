//! What the viewer shows, without a window: a pipeline, what feeds it, what is changed in it, and when.

mod chain;
mod chains;
mod changes;
mod clock;
mod compare_with;
mod comparison;
mod conflict;
mod fault_count;
mod files;
mod frame;
mod frame_images;
mod images;
mod inactive;
mod inspect;
mod measure;
mod project;
mod reading;
mod savings;
mod tap;

use std::cell::{RefCell, RefMut};
use std::sync::Arc;

use afterimage::host::Watch;
use afterimage_gpu::{Gpu, GpuError, KernelFaults};
use afterimage_graph::check::{Fact, Facts, Graph, ParameterId};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::Claim;
use afterimage_graph::value::{FileValue, Value};

pub use chain::{Chain, Moment, Purpose};
pub use changes::{Changes, Restored, Target};
pub use clock::PlayClock;
pub use compare_with::CompareWith;
pub use conflict::{Conflict, Resolution};
pub use files::{Files, HaveChanged, ReadFrame};
pub use frame::Rendered;
pub use frame_images::FrameImages;
pub use images::{Images, Scene};
pub use project::{Checked, NamedFile, Project, Store, TextProject, saved};
pub use savings::{Saving, Savings, SavingsTotal};
pub use tap::{Tap, TapImage};

use crate::Problem;
use chains::Chains;
use fault_count::FaultCount;
use inactive::InactiveCache;

/// A pipeline that is open in the viewer.
pub struct Model {
    gpu: Gpu,
    project: Box<dyn Project>,
    /// The graph as the file has it, for the present tier.
    graph: Option<Arc<Graph>>,
    warnings: Diagnostics,
    tiers: Vec<String>,
    claims: Vec<(String, Claim)>,
    facts: Facts,
    /// The facts that the pipeline declares, with their meanings.
    fact_meanings: Vec<(String, String)>,
    changes: Changes,
    conflict: Option<Conflict>,
    /// Whether the file of the pipeline was there and is gone.
    is_gone: bool,
    /// Whether the last check of the text has found errors.
    has_errors: bool,
    /// Why the newest text, or a frame, cannot be shown. The last good picture stays.
    problem: Option<Problem>,
    images: Images,
    /// The images of the last frame.
    fed: FrameImages,
    clock: PlayClock,
    chains: Chains,
    faults: FaultCount,
    savings: Option<Savings>,
    inactive: RefCell<InactiveCache>,
    tap: Option<Tap>,
    /// The table or value that the tap reads.
    watched: Option<Watch>,
    /// Whether the values at every node are asked for.
    probes: bool,
    /// Whether the picture no longer suits what is set.
    is_stale: bool,
}

impl Model {
    /// Opens a pipeline on a device.
    pub fn new(gpu: &Gpu, project: Box<dyn Project>, images: Images) -> Self {
        let mut model = Self {
            gpu: gpu.clone(),
            project,
            graph: None,
            warnings: Diagnostics::default(),
            tiers: Vec::new(),
            claims: Vec::new(),
            facts: Facts::default(),
            fact_meanings: Vec::new(),
            changes: Changes::default(),
            conflict: None,
            is_gone: false,
            has_errors: false,
            problem: None,
            images,
            fed: FrameImages::default(),
            clock: PlayClock::default(),
            chains: Chains::default(),
            faults: FaultCount::default(),
            savings: None,
            inactive: RefCell::default(),
            tap: None,
            watched: None,
            probes: false,
            is_stale: true,
        };
        model.load();
        model
    }

    pub fn project(&self) -> &dyn Project {
        &*self.project
    }

    /// The graph as the file has it, if it ever was without errors.
    pub fn graph(&self) -> Option<&Arc<Graph>> {
        self.graph.as_ref()
    }

    /// The warnings of the last check.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// What functions of kinds in folders do wrong in the picture, counted once for each plan.
    pub fn kernel_faults(&self) -> &[KernelFaults] {
        self.faults.found()
    }

    /// Why the newest text, or the last frame, cannot be shown.
    pub fn problem(&self) -> Option<&Problem> {
        self.problem.as_ref()
    }

    /// Whether a parameter does nothing at the present values of its node.
    pub fn is_inactive(&self, parameter: ParameterId) -> bool {
        self.updated_inactive(parameter.node).is_inactive(parameter)
    }

    /// Why a parameter does nothing, as a sentence.
    pub fn inactive_reason(&self, parameter: ParameterId) -> Option<String> {
        self.updated_inactive(parameter.node).reason(parameter)
    }

    fn updated_inactive(&self, node: usize) -> RefMut<'_, InactiveCache> {
        let mut cache = self.inactive.borrow_mut();
        if let Some(graph) = &self.graph {
            cache.update(graph, node, &self.changes, self.images.size());
        }
        cache
    }

    /// The tiers of the pipeline.
    pub fn tiers(&self) -> &[String] {
        &self.tiers
    }

    /// What the text claims of tiers.
    pub fn claims(&self) -> &[(String, Claim)] {
        &self.claims
    }

    /// The tier that is shown.
    pub fn tier(&self) -> Option<&str> {
        self.changes.tier()
    }

    /// Shows a tier; `None` is the pipeline without one.
    pub fn set_tier(&mut self, tier: Option<String>) {
        if self.changes.tier() != tier.as_deref() {
            self.changes.set_tier(tier);
            self.reload();
        }
    }

    /// The fact of that name, if it is known.
    pub fn fact(&self, name: &str) -> Option<Fact> {
        self.facts.get(name)
    }

    /// What a fact means, as the pipeline declares it.
    pub fn fact_meaning(&self, name: &str) -> Option<&str> {
        let (_, meaning) = self.fact_meanings.iter().find(|(known, _)| known == name)?;
        Some(meaning)
    }

    /// Sets a fact that `when` conditions test; `None` makes it unknown.
    pub fn set_fact(&mut self, name: &str, fact: Option<Fact>) {
        match fact {
            Some(fact) => self.facts.set(name, fact),
            None => self.facts.unset(name),
        }
        self.chains.set_facts(&self.facts);
        (self.is_stale, self.savings) = (true, None);
    }

    /// The text that is shown, without the changed values.
    pub fn text(&self) -> &str {
        self.changes.text()
    }

    /// What the user has changed.
    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// The present value of a parameter.
    pub fn value(&self, name: &str) -> Option<Value> {
        let target = Target::Parameter(name.to_owned());
        self.changes.get(&target).cloned().or_else(|| self.written(&target))
    }

    /// The value in the text.
    pub fn written(&self, target: &Target) -> Option<Value> {
        target.written(self.graph.as_deref()?)
    }

    /// Whether a node runs, as far as the file and the user state.
    pub fn is_on(&self, node: &str) -> bool {
        match self.changes.get(&Target::Node(node.to_owned())) {
            Some(value) => *value == Value::Bool(true),
            None => self.graph.as_ref().and_then(|graph| graph.node(node)).is_some_and(|(_, node)| !node.off),
        }
    }

    /// Changes a parameter or switches a node; `None` goes back to the file. A value that the node refuses is a
    /// problem, and changes nothing.
    pub fn set(&mut self, target: &Target, value: Option<Value>) {
        let before = self.changes.get(target).cloned();
        let value = match value.map(|value| self.with_bytes(value)).transpose() {
            Ok(value) => value.filter(|value| self.written(target).as_ref() != Some(value)),
            Err(why) => return self.problem = Some(Problem::message(why)),
        };
        self.changes.set(target, value);
        if let Err(problem) = self.apply(target) {
            self.changes.set(target, before);
            self.problem = Some(problem);
        }
    }

    /// A file with its content.
    fn with_bytes(&self, value: Value) -> Result<Value, String> {
        match value {
            Value::File(file) if file.bytes.is_none() && !file.path.is_empty() => {
                let bytes = self.project.file(&file.path).map_err(|why| format!("`{}`: {why}", file.path))?;
                Ok(Value::File(FileValue { bytes: Some(bytes.into()), ..file }))
            }
            other => Ok(other),
        }
    }

    /// The change that was under way is finished: the next one is another step of undo.
    pub fn release(&mut self) {
        self.changes.release();
    }

    /// Takes the last change of the text or of a value back.
    pub fn undo(&mut self) {
        if let Some(restored) = self.changes.undo() {
            self.apply_restored(restored);
        }
    }

    /// Makes the change again that was taken back last.
    pub fn redo(&mut self) {
        if let Some(restored) = self.changes.redo() {
            self.apply_restored(restored);
        }
    }

    fn apply_restored(&mut self, restored: Restored) {
        match restored {
            Restored::Text => {
                self.reload();
                if self.has_errors {
                    // The graph of the last good text has the restored values.
                    self.apply_graph();
                }
                self.chains.reset_values(&self.changes);
            }
            Restored::Values(targets) => {
                for target in targets {
                    if let Err(problem) = self.apply(&target) {
                        self.problem = Some(problem);
                    }
                }
            }
        }
    }

    /// Makes a change hold in what renders.
    fn apply(&mut self, target: &Target) -> Result<(), Problem> {
        self.forget_problem();
        self.is_stale = true;
        match target {
            Target::Node(_) => self.apply_graph(),
            Target::Parameter(name) => {
                let Some(value) = self.value(name) else { return Ok(()) };
                self.savings = None;
                self.chains.set(name, &value)?;
            }
        }
        Ok(())
    }

    /// The graph with the nodes that the user has switched.
    fn present_graph(&self) -> Option<Graph> {
        let mut graph = Graph::clone(self.graph.as_ref()?);
        for (target, value) in self.changes.iter() {
            let Target::Node(name) = target else { continue };
            if let Some((index, _)) = graph.node(name) {
                graph.nodes[index].off = *value == Value::Bool(false);
            }
        }
        Some(graph)
    }

    /// Brings the graph into everything that renders.
    fn apply_graph(&mut self) {
        let Some(graph) = self.present_graph() else { return };
        self.chains.set_graph(&self.gpu, &graph, &self.facts);
        self.savings = None;
        self.renew_compared();
        self.is_stale = true;
    }

    /// What feeds the pipeline.
    pub fn images(&mut self) -> &mut Images {
        self.is_stale = true;
        &mut self.images
    }

    /// The number of frames of a sequence, and how many there are in a second.
    pub fn images_length(&self) -> Option<(usize, f64)> {
        self.images.length()
    }

    /// Feeds the pipeline with other images.
    pub fn set_images(&mut self, images: Images) {
        self.images = images;
        self.forget_problem();
        self.clock.seek(0.0);
        (self.is_stale, self.savings) = (true, None);
    }

    /// A frame went well; what is wrong with the text is wrong still.
    fn forget_problem(&mut self) {
        self.problem.take_if(|problem| !matches!(problem, Problem::Pipeline(_)));
    }

    pub fn clock(&mut self) -> &mut PlayClock {
        &mut self.clock
    }

    /// The pipeline that is shown, once it was without errors.
    pub fn shown(&self) -> Option<&Chain> {
        self.chains.shown.as_ref()
    }

    /// Whether the device still works. If it is lost, that is the problem.
    pub fn has_device(&mut self) -> bool {
        let is_lost = matches!(self.gpu.check_device(), Err(GpuError::DeviceLost { .. }));
        if is_lost {
            self.problem = Some(Problem::DeviceLost);
        }
        !is_lost
    }

    /// Recreates all GPU resources on a new device. Histories start again.
    ///
    /// # Errors
    /// The images cannot be made on it.
    pub fn rebuild(&mut self, gpu: &Gpu) -> Result<(), Problem> {
        self.gpu = gpu.clone();
        self.images.rebuild(gpu)?;
        self.chains.rebuild(gpu);
        (self.problem, self.savings, self.fed) = (None, None, FrameImages::default());
        self.clock.cut();
        Ok(())
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }
}
