//! State of the viewer without a window: an open pipeline, its images, the user's changes, and time.

mod changes;
mod clock;
mod comparison;
mod editor;
mod fault_count;
mod frame_images;
mod graph_edits;
mod image_files;
mod images;
mod inspector;
mod instance;
mod instances;
mod project;
mod white;

use afterimage_gpu::{Gpu, GpuError, KernelFaults, wgpu};
use afterimage_graph::check::{Fact, ParameterId};
use afterimage_graph::node::PortType;
use afterimage_graph::value::Value;

pub use changes::{Changes, Restored, Target};
pub use clock::PlayClock;
pub use comparison::{CompareWith, Slot};
pub use editor::{Conflict, Editor, Resolution};
pub use frame_images::FrameImages;
pub use image_files::{Files, HaveChanged, InputData, InputFile, ReadFrame};
pub(crate) use images::SCENE_NAME;
pub use images::{Images, Scene};
pub(crate) use inspector::belongs;
pub use inspector::{InspectedImage, InspectedWire, Inspector};
pub use instance::{Moment, PipelineInstance, PlanPreset};
pub use project::{Checked, NamedFile, Project, Store, TextProject};
pub(crate) use white::balances_white;

use crate::Problem;
use instances::Instances;

/// A pipeline that is open in the viewer. It applies each change of the [`Editor`] to the pipelines that render.
pub struct Model {
    editor: Editor,
    instances: Instances,
    images: Images,
    /// The images of the last frame.
    frame_images: FrameImages,
    clock: PlayClock,
    /// Errors of the newest text, or of the last frame. The last good picture stays.
    problem: Option<Problem>,
    /// The picture does not show the latest changes yet.
    is_stale: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rendered {
    New,
    /// Nothing has changed, so nothing was rendered.
    Same,
    /// The previous pictures stay: see [`Model::problem`].
    Failed,
    /// Nothing yet: the window is shown first, because the first plan may compile for seconds.
    Later,
}

impl Model {
    /// Opens a pipeline on a device.
    pub fn new(gpu: &Gpu, project: Box<dyn Project>, images: Images) -> Self {
        let mut model = Self {
            editor: Editor::new(project),
            instances: Instances::new(gpu),
            images,
            frame_images: FrameImages::default(),
            clock: PlayClock::default(),
            problem: None,
            is_stale: true,
        };
        model.load();
        model
    }

    pub fn gpu(&self) -> &Gpu {
        &self.instances.gpu
    }

    /// The text and the values.
    pub fn editor(&self) -> &Editor {
        &self.editor
    }

    /// Errors of the newest text, or of the last frame.
    pub fn problem(&self) -> Option<&Problem> {
        self.problem.as_ref()
    }

    /// Faults of functions of kinds in folders, counted once for each plan.
    pub fn kernel_faults(&self) -> &[KernelFaults] {
        self.instances.faults.found()
    }

    /// The pipeline that is shown, once its text was without errors.
    pub fn shown(&self) -> Option<&PipelineInstance> {
        self.instances.shown.as_ref()
    }

    pub fn clock(&mut self) -> &mut PlayClock {
        &mut self.clock
    }

    /// The reason for which the plan that runs skips a node.
    pub fn skip_reason(&self, node: &str) -> Option<&str> {
        let skipped = &self.shown()?.plan()?.savings.skipped;
        Some(&skipped.iter().find(|skipped| skipped.node == node)?.why)
    }

    /// The declared condition for which a parameter has no effect at present, as a sentence.
    pub fn inactive_reason(&self, parameter: ParameterId) -> Option<String> {
        let graph = self.editor.graph()?;
        let node = &graph.nodes[parameter.node];
        let value = |index| self.editor.value(&graph.parameter_name(ParameterId { index, ..parameter }));
        let values = (0..node.kind().params().len()).map(value).collect::<Option<Vec<_>>>()?;
        let is_wired = |input: &str| {
            let mut ports = node.kind().inputs().iter().zip(&node.wires);
            ports.any(|(port, wire)| port.name == input && wire.is_some())
        };
        let unmet = node.kind().unmet_condition(&values, parameter.index, is_wired)?;
        Some(format!("Has an effect only while {unmet}."))
    }
}

impl Model {
    /// Opens another pipeline; the images stay. Unsaved changes are lost.
    pub fn open(&mut self, project: Box<dyn Project>) {
        self.editor = Editor::new(project);
        self.instances = Instances::new(&self.instances.gpu);
        self.clock.cut();
        self.load();
    }

    fn load(&mut self) {
        match self.editor.load() {
            Ok(()) => self.reload(),
            Err(problem) => self.problem = Some(problem),
        }
    }

    /// Checks the text again. If it has errors, the last good pipeline continues to render.
    pub fn reload(&mut self) {
        let checked = self.editor.check();
        self.apply_checked(checked);
    }

    fn apply_checked(&mut self, checked: Result<(), Problem>) {
        self.problem = checked.err();
        if self.problem.is_none() {
            self.apply_graph();
        }
    }

    /// Reads the pipeline and the images again if their files have changed. Returns true if those of the pipeline have.
    /// `typed` is a text that the user is typing and that [`edit`](Self::edit) has not got yet: it counts as changed.
    pub fn follow_files(&mut self, typed: Option<&str>) -> bool {
        match self.images.follow() {
            Ok(true) => {
                self.forget_problem();
                self.is_stale = true;
            }
            Ok(false) => {}
            Err(problem) => self.problem = Some(problem),
        }
        if !self.editor.has_file_changed() {
            return false;
        }
        if let Some(typed) = typed {
            self.edit(typed);
        }
        match self.editor.read() {
            Ok(Some(text)) if text == self.editor.changes.written() => self.reload(),
            Ok(Some(text)) => self.follow_text(text),
            Ok(None) => {
                let gone = Problem::message(format!("the file `{}` is gone", self.editor.project().name()));
                self.problem = Some(gone.hint("a save writes it again"));
            }
            Err(problem) => self.problem = Some(problem),
        }
        true
    }

    fn follow_text(&mut self, text: String) {
        if let Some(checked) = self.editor.follow_text(text) {
            self.apply_checked(checked);
        }
    }

    /// Resolves the conflict, if there is one.
    pub fn resolve(&mut self, resolution: Resolution) {
        match (self.editor.conflict.take(), resolution) {
            (Some(Conflict::Text(text)), Resolution::KeepMine) => self.editor.changes.set_written(&text),
            (Some(Conflict::Text(text)), Resolution::TakeFile) => {
                self.editor.changes.edit(&text);
                let checked = self.editor.take_text(&text);
                self.apply_checked(checked);
            }
            (Some(Conflict::Values(targets)), Resolution::TakeFile) => {
                self.editor.changes.revert(&targets);
                self.apply_graph();
                self.instances.reset_values(&self.editor.changes);
            }
            (Some(Conflict::Values(_)), Resolution::KeepMine) | (None, _) => {}
        }
    }

    /// Replaces the text, without writing it.
    pub fn edit(&mut self, text: &str) {
        self.editor.changes.edit(text);
        self.reload();
    }

    /// Shows a tier; `None` is the pipeline without one.
    pub fn set_tier(&mut self, tier: Option<String>) {
        if self.editor.tier() != tier.as_deref() {
            self.editor.changes.set_tier(tier);
            self.reload();
        }
    }

    /// Writes the text with all changed values in it, where everything else stays as it is, or into a new tier of it,
    /// which is shown from then on. A text with errors is written as it is, and the values stay changes. Returns the
    /// place of the text, for people.
    ///
    /// # Errors
    /// The file was changed, too, and the user has to choose; it cannot be read, and is not replaced; the values cannot
    /// be written; or the project has no place. Nothing is written then.
    pub fn save(&mut self, new_tier: Option<&str>) -> Result<String, Problem> {
        // The file may have changed since it was looked at last. One that is gone is written again.
        if let Some(text) = self.editor.read()?
            && text != self.editor.changes.written()
        {
            self.follow_text(text);
        }
        if self.editor.conflict.is_some() {
            return Err(Problem::message("the file was changed by another program, too")
                .hint("choose whether yours or the file's is kept, and save again"));
        }
        let place = self.editor.write(new_tier)?;
        self.reload_saved();
        Ok(place)
    }

    /// The same into another place, where the pipeline is from then on; the history stays.
    ///
    /// # Errors
    /// The values or the text cannot be written. The pipeline stays where it was then.
    pub fn save_as(&mut self, project: Box<dyn Project>, new_tier: Option<&str>) -> Result<String, Problem> {
        let place = self.editor.write_into(project, new_tier)?;
        self.reload_saved();
        Ok(place)
    }

    fn reload_saved(&mut self) {
        self.reload();
        self.instances.reset_values(&self.editor.changes);
    }

    /// Changes a parameter or switches a node; `None` goes back to the file. A value that the node refuses is a
    /// problem, and changes nothing.
    pub fn set(&mut self, target: &Target, value: Option<Value>) {
        let before = self.editor.changes.get(target).cloned();
        let value = match value.map(|value| self.editor.with_bytes(value)).transpose() {
            Ok(value) => value.filter(|value| self.editor.written(target).as_ref() != Some(value)),
            Err(problem) => return self.problem = Some(problem),
        };
        self.editor.changes.set(target, value);
        if let Err(problem) = self.apply(target) {
            self.editor.changes.set(target, before);
            self.problem = Some(problem);
        }
    }

    /// The change that was under way is finished: the next one is another step of undo.
    pub fn release(&mut self) {
        self.editor.changes.release();
    }

    /// Takes the last change of the text or of a value back.
    pub fn undo(&mut self) {
        let restored = self.editor.changes.undo();
        self.apply_restored(restored);
    }

    /// Remembers the present text, tier and values. A comparison with the snapshot before it ends.
    pub fn take_snapshot(&mut self, slot: Slot) {
        self.editor.take_snapshot(slot);
        if self.compared() == Some(&CompareWith::Snapshot(slot)) {
            self.set_compared(None);
        }
    }

    /// Goes back to a snapshot, in one step of undo. Returns false without one.
    pub fn go_to_snapshot(&mut self, slot: Slot) -> bool {
        let Some(snapshot) = self.editor.snapshot(slot).map(Changes::snapshot) else { return false };
        self.editor.changes.go_to(&snapshot);
        self.apply_restored(Some(Restored::Text));
        true
    }

    /// Makes the change again that was taken back last.
    pub fn redo(&mut self) {
        let restored = self.editor.changes.redo();
        self.apply_restored(restored);
    }

    fn apply_restored(&mut self, restored: Option<Restored>) {
        match restored {
            Some(Restored::Text) => {
                self.reload();
                if self.editor.has_errors() {
                    // The graph of the last good text has the restored values.
                    self.apply_graph();
                }
                self.instances.reset_values(&self.editor.changes);
            }
            Some(Restored::Values(targets)) => {
                for target in targets {
                    if let Err(problem) = self.apply(&target) {
                        self.problem = Some(problem);
                    }
                }
            }
            None => {}
        }
    }

    /// Applies a changed value to the pipelines.
    fn apply(&mut self, target: &Target) -> Result<(), Problem> {
        self.forget_problem();
        self.is_stale = true;
        match target {
            Target::Node(_) => self.apply_graph(),
            Target::Parameter(name) => {
                let Some(value) = self.editor.value(name) else { return Ok(()) };
                self.instances.set(name, &value)?;
            }
        }
        Ok(())
    }

    /// Applies the graph to the pipelines.
    fn apply_graph(&mut self) {
        let Some(graph) = self.editor.present_graph() else { return };
        self.instances.set_graph(&graph);
        self.update_inspector();
        let compared = self.compared().cloned();
        self.set_compared(compared);
    }

    /// A frame or a value went well; errors of the text remain.
    fn forget_problem(&mut self) {
        self.problem.take_if(|problem| !matches!(problem, Problem::Pipeline(_)));
    }
}

impl Model {
    /// The fact of that name, if it is known.
    pub fn fact(&self, name: &str) -> Option<Fact> {
        self.instances.facts().get(name)
    }

    /// Sets a fact that `when` conditions test; `None` makes it unknown.
    pub fn set_fact(&mut self, name: &str, fact: Option<Fact>) {
        let mut facts = self.instances.facts().clone();
        match fact {
            Some(fact) => facts.set(name, fact),
            None => facts.unset(name),
        }
        self.instances.set_facts(facts);
        self.is_stale = true;
    }

    /// The number of the shown frame: that of its file, or the frames since the start.
    pub fn frame_number(&self) -> u32 {
        self.images.frame_number().unwrap_or_else(|| self.clock.frame())
    }

    /// The number of frames of a sequence, and the frame rate.
    pub fn images_length(&self) -> Option<(usize, f64)> {
        self.images.length()
    }

    /// The images of the inputs.
    pub fn images(&self) -> &Images {
        &self.images
    }

    /// Gives an input a file, or takes it away; `None` is the first image that the pipeline needs. Without any file the
    /// built-in scene is shown.
    ///
    /// # Errors
    /// The file cannot be read, or the device cannot hold it. The one before stays then.
    pub fn set_input(&mut self, input: Option<&str>, file: Option<InputFile>) -> Result<(), Problem> {
        let inputs = self.editor.graph().map_or(Vec::new(), |graph| graph.inputs.clone());
        let length = self.images.length();
        self.images.set(&self.instances.gpu, input, file, &inputs)?;
        self.forget_problem();
        if self.images.length() == length {
            self.clock.cut();
        } else {
            self.clock.seek(0.0);
        }
        self.is_stale = true;
        Ok(())
    }

    /// Replaces the images of the inputs.
    pub fn set_images(&mut self, images: Images) {
        self.images = images;
        self.forget_problem();
        self.clock.seek(0.0);
        self.is_stale = true;
    }
}

impl Model {
    /// The picture that the shown one is compared with.
    pub fn compared(&self) -> Option<&CompareWith> {
        self.instances.compared.as_ref().map(|(other, _)| other)
    }

    /// That picture, and the pipeline that makes it.
    pub fn comparison(&self) -> Option<(&CompareWith, &PipelineInstance)> {
        self.instances.compared.as_ref().map(|(other, instance)| (other, instance))
    }

    /// The texture of that picture.
    pub fn compared_picture(&self) -> Option<&wgpu::Texture> {
        self.instances.compared.as_ref().and_then(|(_, instance)| instance.picture())
    }

    /// Renders another picture to compare the shown one with, or none. If it cannot be made, that is the problem.
    pub fn set_compared(&mut self, other: Option<CompareWith>) {
        self.instances.compared = None;
        self.is_stale = true;
        let Some(other) = other else { return };
        match self.editor.graph_to_compare(&other) {
            Ok((graph, changes)) => self.instances.compare(other, &graph, &changes),
            Err(problem) => self.problem = Some(problem),
        }
    }

    /// The wire that is shown, and the pipelines whose images are read.
    pub fn inspector(&self) -> &Inspector {
        &self.instances.inspector
    }

    /// Shows an intermediate image, table or value; `None` shows the output.
    pub fn inspect_wire(&mut self, wire: Option<InspectedWire>) {
        let checked = self.editor.checked();
        let ty = |wire: &InspectedWire| checked.and_then(|checked| checked.wire_type(&wire.wire));
        let buffer = wire.as_ref().filter(|wire| matches!(ty(wire), Some(PortType::Table | PortType::Value)));
        let shown = self.instances.shown.as_mut();
        let watch = buffer.and_then(|buffer| Some(shown?.post().watch(&buffer.wire)));
        (self.instances.inspector.watch, self.instances.inspector.wire) = (watch, wire);
        self.update_inspector();
    }

    /// The level of a pyramid that is shown, from 1, and the number of its levels.
    pub fn inspected_level(&self) -> Option<(usize, usize)> {
        let InspectedWire { wire, index, .. } = self.inspector().wire()?;
        if self.editor.checked()?.wire_type(wire) != Some(PortType::Pyramid) {
            return None;
        }
        let images = self.inspector().images(wire);
        let count = images.iter().take_while(|image| belongs(&image.name, wire) && !image.name.contains('@')).count();
        (*index < count).then_some((index + 1, count))
    }

    /// Stores the values at every node, and those of the reference, so that single pixels can be read.
    pub fn inspect_pixels(&mut self, on: bool) {
        if self.instances.inspector.reads_pixels != on {
            self.instances.inspector.reads_pixels = on;
            self.update_inspector();
        }
    }

    /// Stores the images of all wires, so that each can be shown.
    pub fn show_wires(&mut self, on: bool) {
        if self.instances.inspector.shows_wires != on {
            self.instances.inspector.shows_wires = on;
            self.update_inspector();
        }
    }

    fn update_inspector(&mut self) {
        self.instances.update_inspector(self.editor.present_graph().as_ref(), &self.editor.changes);
        self.is_stale = true;
    }

    /// The image of the inspected wire, once a frame has rendered it.
    pub fn inspected_image(&self) -> Option<(InspectedImage, wgpu::Texture)> {
        self.wire_image(self.inspector().wire()?)
    }

    /// The image of any wire, once a frame has rendered it with all images.
    pub(crate) fn wire_image(&self, wire: &InspectedWire) -> Option<(InspectedImage, wgpu::Texture)> {
        self.instances.inspector.image_of(wire, &self.frame_images)
    }

    /// The latest bytes of the inspected table or value: those of the shown picture itself.
    pub fn inspected_bytes(&mut self) -> Option<Vec<u8>> {
        let watch = self.instances.inspector.watch?;
        Some(self.instances.shown.as_mut()?.post().reading(watch).ok()??.bytes.clone())
    }
}

impl Model {
    /// Records the next frame, `elapsed` seconds after the last call, if time runs or something has changed.
    pub fn render(&mut self, encoder: &mut wgpu::CommandEncoder, elapsed: f64) -> Rendered {
        self.instances.faults.take(&self.instances.gpu);
        self.clock.set_length(self.images.length());
        let advanced = self.clock.advance(elapsed);
        let must_run = self.is_stale || self.instances.is_busy();
        if self.instances.shown.is_none() || advanced.is_none() && !must_run {
            return Rendered::Same;
        }
        let moment = advanced.unwrap_or_else(|| self.clock.again());
        let recorded = self.instances.record(encoder, &mut self.images, moment);
        self.is_stale = false;
        match recorded {
            Ok(images) => {
                self.frame_images = images;
                self.forget_problem();
                Rendered::New
            }
            Err(problem) => {
                self.problem = Some(problem);
                Rendered::Failed
            }
        }
    }

    /// The images of the last frame.
    pub fn frame_images(&self) -> &FrameImages {
        &self.frame_images
    }

    /// True while the device works. If it is lost, that is the problem.
    pub fn has_device(&mut self) -> bool {
        let is_lost = matches!(self.instances.gpu.check_device(), Err(GpuError::DeviceLost { .. }));
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
        self.images.rebuild(gpu)?;
        self.instances.rebuild(gpu);
        (self.problem, self.frame_images) = (None, FrameImages::default());
        self.clock.cut();
        Ok(())
    }
}
