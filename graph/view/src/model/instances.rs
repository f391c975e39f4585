//! All pipelines that render for a model.

use afterimage_gpu::{Gpu, wgpu};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::value::Value;

use super::fault_count::FaultCount;
use super::{Changes, CompareWith, FrameImages, Images, Inspector, Moment, PipelineInstance, PlanPreset};
use crate::Problem;

/// The pipelines on the device. All but the compared one have the present graph and its values.
pub(super) struct Instances {
    pub(super) gpu: Gpu,
    facts: Facts,
    pub(super) shown: Option<PipelineInstance>,
    pub(super) inspector: Inspector,
    pub(super) faults: FaultCount,
    pub(super) compared: Option<(CompareWith, PipelineInstance)>,
}

impl Instances {
    pub(super) fn new(gpu: &Gpu) -> Self {
        Self {
            gpu: gpu.clone(),
            facts: Facts::default(),
            shown: None,
            inspector: Inspector::default(),
            faults: FaultCount::default(),
            compared: None,
        }
    }

    fn of_present_graph(&mut self) -> impl Iterator<Item = &mut PipelineInstance> {
        self.shown.iter_mut().chain(self.inspector.instances()).chain(self.faults.instance())
    }

    pub(super) fn facts(&self) -> &Facts {
        &self.facts
    }

    /// Creates the instances that the inspector reads, and drops those that nothing reads.
    pub(super) fn update_inspector(&mut self, graph: Option<&Graph>, changes: &Changes) {
        for (preset, is_needed) in self.inspector.needs() {
            if self.inspector.instance(preset).is_some() != is_needed {
                let instance = graph.filter(|_| is_needed).map(|graph| self.create(graph, preset, changes));
                *self.inspector.instance(preset) = instance;
            }
        }
    }

    pub(super) fn compare(&mut self, other: CompareWith, graph: &Graph, changes: &Changes) {
        let preset = if other == CompareWith::Reference { PlanPreset::Reference } else { PlanPreset::Show };
        let instance = self.create(graph, preset, changes);
        self.compared = Some((other, instance));
    }

    fn create(&self, graph: &Graph, preset: PlanPreset, changes: &Changes) -> PipelineInstance {
        let mut instance = PipelineInstance::new(&self.gpu, graph.clone(), self.facts.clone(), preset);
        instance.set_changes(changes);
        instance
    }

    pub(super) fn set_graph(&mut self, graph: &Graph) {
        if self.shown.is_none() {
            let facts = self.facts.clone();
            self.shown = Some(PipelineInstance::new(&self.gpu, graph.clone(), facts, PlanPreset::Show));
        }
        self.of_present_graph().for_each(|instance| instance.change(graph.clone()));
    }

    pub(super) fn set_facts(&mut self, facts: Facts) {
        self.of_present_graph().for_each(|instance| instance.post().set_facts(facts.clone()));
        self.facts = facts;
    }

    pub(super) fn set(&mut self, name: &str, value: &Value) -> Result<(), Problem> {
        let mut result = Ok(());
        for instance in self.of_present_graph() {
            result = result.and(instance.set(name, value));
        }
        result
    }

    /// Sets all parameters to the values of the graph, and then to those of the user.
    pub(super) fn reset_values(&mut self, changes: &Changes) {
        for instance in self.of_present_graph() {
            instance.forget_values();
            instance.set_changes(changes);
        }
    }

    pub(super) fn rebuild(&mut self, gpu: &Gpu) {
        self.gpu = gpu.clone();
        self.of_present_graph().for_each(|instance| instance.rebuild(gpu));
        if let Some((_, instance)) = &mut self.compared {
            instance.rebuild(gpu);
        }
    }

    /// True if another frame must be recorded although nothing is changed: for a new plan, or for faults.
    pub(super) fn is_busy(&self) -> bool {
        let is_changing = |instance: &PipelineInstance| instance.is_changing();
        self.shown.as_ref().is_some_and(is_changing)
            || self.inspector.stored().is_some_and(is_changing)
            || self.faults.is_busy()
    }

    /// Records a frame of all pipelines. Returns the images of the shown one.
    pub(super) fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        images: &mut Images,
        moment: Moment,
    ) -> Result<FrameImages, Problem> {
        let Some(shown) = &mut self.shown else { return Ok(FrameImages::default()) };
        if let Some((_, compared)) = &self.compared {
            images.require(&compared.graph().inputs)?;
        }
        let frame_images = images.at(moment, &shown.graph().inputs, encoder)?;
        shown.frame(encoder, &frame_images, moment)?;
        for instance in self.inspector.instances() {
            instance.frame(encoder, &frame_images, moment)?;
        }
        if let Some((_, compared)) = &mut self.compared {
            let images = images.again(&compared.graph().inputs)?;
            compared.frame(encoder, &images, moment)?;
        }
        self.faults.record(&self.gpu, encoder, shown, &frame_images)?;
        Ok(frame_images)
    }
}
