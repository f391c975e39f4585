//! Bind groups: a loaded plan with the images that the host gives for a frame.

use std::sync::Arc;

use afterimage_graph::node::ImageId;
use afterimage_plan::{PlanOutput, Stage};
use wgpu::TextureView;

use super::Executor;
use super::explicit_transitions::ExplicitTransitions;
use super::frame::Frame;
use super::host_images::{Formats, check_apart, check_encoding, check_input, check_names, check_output, must_be_drawn};
use super::loaded::{HostSet, Loaded};
use super::prepare::PlanCompiler;
use super::residency::ImageBinding;
use crate::GpuError;
use crate::pipelines::Built;
use crate::platform::{scoped, watched};

/// How many choices of host images are remembered: the images of a few swap chains.
const MOST_SETS: usize = 16;

impl Executor {
    /// The bind groups for this frame's host images: remembered, or made.
    pub(super) fn host_set(&mut self, frame: &Frame<'_>) -> Result<usize, GpuError> {
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        check_names(&loaded.plan, frame)?;
        let known = loaded.sets.iter().position(|set| same_views(loaded, set, frame));
        let set = match known {
            Some(_) => None,
            None => Some(self.new_set(frame)?),
        };
        let loaded = self.loaded.as_mut().expect("it was there above");
        self.runs_made = set.as_ref().map_or(0, |set| set.made);
        match (known, set) {
            // The set used last is at the end.
            (Some(known), _) => loaded.sets[known..].rotate_left(1),
            (None, set) => {
                loaded.sets.drain(..(loaded.sets.len() + 1).saturating_sub(MOST_SETS));
                loaded.sets.extend(set);
            }
        }
        Ok(loaded.sets.len() - 1)
    }

    fn new_set(&mut self, frame: &Frame<'_>) -> Result<HostSet, GpuError> {
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        let (device, what) = (&self.compiler.device, "the images of the host");
        let views = chosen_views(loaded, frame)?;
        let drawn = drawn(device, &mut self.formats, (loaded, frame), &views)?;
        let set = match loaded.sets.last() {
            // A swap chain has new views in every frame: most of the last set is as good as new.
            Some(last) if last.drawn == drawn => {
                scoped(device, what, || self.make_set(loaded, views, &drawn, Some(last)))?
            }
            // The device was there when the plan was prepared.
            None if loaded.is_watched => scoped(device, what, || self.make_set(loaded, views, &drawn, None))?,
            _ => watched(device, what, || self.make_set(loaded, views, &drawn, None))?,
        };
        let names = loaded.plan.outputs.iter().map(|output| &output.name).zip(drawn);
        let now: Vec<_> = names.filter_map(|(name, format)| Some((name, format?))).collect();
        // Frames without images of the host, as those of a fade, say nothing of its formats.
        let says = !frame.outputs.is_empty();
        if says && !now.iter().copied().eq(self.drawn.iter().map(|(name, format)| (name, *format))) {
            self.drawn = now.into_iter().map(|(name, format)| (name.clone(), format)).collect();
        }
        Ok(set)
    }

    /// The set for these views. What names only views that the last set has, too, is taken from there.
    fn make_set(
        &self,
        loaded: &Loaded,
        views: Vec<TextureView>,
        drawn: &Drawn,
        last: Option<&HostSet>,
    ) -> Result<HostSet, GpuError> {
        let mut made = 0;
        let mut run = |index: usize| match (&loaded.runs[index], last) {
            (Some(run), _) => Ok(run.clone()),
            (None, Some(last)) if !names_new(loaded, index, (&last.views, &views)) => Ok(last.runs[index].clone()),
            _ => {
                made += 1;
                let built = last.map(|last| Ok(last.runs[index].built.clone()));
                let built = built.unwrap_or_else(|| self.built(loaded, index, drawn))?;
                Ok(Arc::new(self.compiler.binder.run(loaded, index, built, &views)))
            }
        };
        let runs = (0..loaded.passes.len()).map(&mut run).collect::<Result<Vec<_>, GpuError>>()?;
        let is_drawn = runs.iter().map(|run| run.built.pipeline.stage() != Stage::Compute);
        let explicit_transitions = match last.map_or(&loaded.explicit_transitions, |last| &last.explicit_transitions) {
            known if is_drawn.clone().eq(known.is_drawn.iter().copied()) => known.clone(),
            _ => Arc::new(ExplicitTransitions::new(&loaded.plan, &loaded.residency, is_drawn.collect())),
        };
        Ok(HostSet { views, drawn: drawn.to_vec(), runs, explicit_transitions, made })
    }

    /// The pipeline of a pass: the planned one, or the one that draws into the host's image.
    fn built(&self, loaded: &Loaded, index: usize, drawn: &Drawn) -> Result<Built, GpuError> {
        let pass = &loaded.passes[index];
        match pass.writes_image.and_then(|image| attachment_of_host(loaded, image, drawn)) {
            None => Ok(pass.built.clone()),
            Some(format) => match loaded.drawn.iter().find(|(at, known, _)| (*at, *known) == (index, format)) {
                Some((_, _, built)) => Ok(built.clone()),
                None => {
                    let PlanCompiler { pipelines, device, .. } = &self.compiler;
                    pipelines.drawing(device, (&loaded.plan, index, pass), format)
                }
            },
        }
    }
}

/// For each output the format in which the host's image for it is drawn; `None` for one that is stored to.
type Drawn = [Option<wgpu::TextureFormat>];

fn drawn(
    device: &wgpu::Device,
    formats: &mut Formats,
    (loaded, frame): (&Loaded, &Frame<'_>),
    views: &[TextureView],
) -> Result<Vec<Option<wgpu::TextureFormat>>, GpuError> {
    let outputs = loaded.plan.outputs.iter().zip(&views[loaded.plan.inputs.len()..]);
    let format = |(output, view): (&PlanOutput, &TextureView)| -> Result<_, GpuError> {
        let is_drawn = must_be_drawn(&loaded.plan, output.image, view.texture());
        // What is stated is the format of the host's view, not of ours.
        let stated = frame.stated_format(&output.name).filter(|_| named(frame.outputs, &output.name).is_some());
        let format = is_drawn.then(|| formats.of(device, (&output.name, view), stated)).transpose()?;
        check_encoding(output, format)?;
        Ok(format)
    };
    outputs.map(format).collect()
}

/// Whether a pass names an image of the host whose view is another one now.
fn names_new(loaded: &Loaded, pass: usize, (last, views): (&[TextureView], &[TextureView])) -> bool {
    loaded.host_views[pass].iter().any(|view| last[*view] != views[*view])
}

/// The view of that name.
pub(super) fn named<'a>(views: &[(&str, &'a TextureView)], name: &str) -> Option<&'a TextureView> {
    views.iter().find(|(known, _)| *known == name).map(|(_, view)| *view)
}

/// Whether a set was made for exactly these host images.
fn same_views(loaded: &Loaded, set: &HostSet, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = set.views.split_at(loaded.plan.inputs.len());
    let same_input = |((name, _), view): (&(String, ImageId), &TextureView)| named(frame.inputs, name) == Some(view);
    let same_output = |(output, view): (&PlanOutput, &TextureView)| output_view(loaded, output, frame) == Some(view);
    loaded.plan.inputs.iter().zip(inputs).all(same_input) && loaded.plan.outputs.iter().zip(outputs).all(same_output)
}

/// Where an output goes: to the host's image, or to ours.
fn output_view<'a>(loaded: &'a Loaded, output: &PlanOutput, frame: &Frame<'a>) -> Option<&'a TextureView> {
    named(frame.outputs, &output.name).or_else(|| match &loaded.residency.bindings[output.image.0 as usize] {
        ImageBinding::Output(_, stored) => Some(&stored.view),
        _ => None,
    })
}

/// The views of all inputs, then of all outputs; ours where the host gives none.
fn chosen_views(loaded: &Loaded, frame: &Frame<'_>) -> Result<Vec<TextureView>, GpuError> {
    let plan = &loaded.plan;
    let mut views = Vec::with_capacity(plan.inputs.len() + plan.outputs.len());
    for (name, image) in &plan.inputs {
        let view = named(frame.inputs, name).ok_or_else(|| GpuError::MissingInput(name.clone()))?;
        check_input(plan, name, *image, view)?;
        views.push(view.clone());
    }
    for output in &plan.outputs {
        let view = output_view(loaded, output, frame).expect("the planner gives each output an image of its own");
        check_output(plan, &output.name, output.image, view)?;
        views.push(view.clone());
    }
    check_apart(plan, &views)?;
    Ok(views)
}

/// The attachment's format if the image is an output that is drawn into the host's.
fn attachment_of_host(loaded: &Loaded, image: ImageId, drawn: &Drawn) -> Option<wgpu::TextureFormat> {
    let ImageBinding::Output(index, _) = &loaded.residency.bindings[image.0 as usize] else { return None };
    drawn[*index]
}
