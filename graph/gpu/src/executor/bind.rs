//! Bind groups: a loaded plan with the images that the host gives for a frame.

use afterimage_graph::node::ImageId;
use afterimage_plan::PlanOutput;
use wgpu::TextureView;

use super::Executor;
use super::frame::Frame;
use super::host_images::{Formats, check_encoding, check_names, must_be_drawn};
use super::loaded::{HostSet, Loaded};
use super::sets::{chosen_views, named, needs_no_device, output_view};
use crate::GpuError;
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
        let (compiler, what) = (&self.compiler, "the images of the host");
        let views = chosen_views(loaded, frame, loaded.sets.last())?;
        let drawn = drawn(&compiler.device, &mut self.formats, (loaded, frame), &views)?;
        let set = match loaded.sets.last() {
            // A swap chain has new views in every frame: most of the last set is as good as new.
            Some(last) if last.drawn == drawn && needs_no_device(loaded, last, &views) => {
                compiler.make_set(loaded, (views, drawn), Some(last))?
            }
            Some(last) if last.drawn == drawn => {
                scoped(&compiler.device, what, || compiler.make_set(loaded, (views, drawn), Some(last)))?
            }
            // The device was there when the plan was prepared.
            None if loaded.is_watched => {
                scoped(&compiler.device, what, || compiler.make_set(loaded, (views, drawn), None))?
            }
            _ => watched(&compiler.device, what, || compiler.make_set(loaded, (views, drawn), None))?,
        };
        let names = loaded.plan.outputs.iter().map(|output| &output.name).zip(&set.drawn);
        let now = names.filter_map(|(name, format)| Some((name, (*format)?)));
        // Frames without images of the host, as those of a fade, say nothing of its formats.
        let says = !frame.outputs.is_empty();
        if says && !now.clone().eq(self.drawn.iter().map(|(name, format)| (name, *format))) {
            self.drawn = now.map(|(name, format)| (name.clone(), format)).collect();
        }
        Ok(set)
    }
}

/// For each output the format in which the host's image for it is drawn; `None` for one that is stored to.
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

/// Whether a set was made for exactly these host images.
fn same_views(loaded: &Loaded, set: &HostSet, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = set.views.split_at(loaded.plan.inputs.len());
    let same_input = |((name, _), view): (&(String, ImageId), &TextureView)| named(frame.inputs, name) == Some(view);
    let same_output = |(output, view): (&PlanOutput, &TextureView)| output_view(loaded, output, frame) == Some(view);
    loaded.plan.inputs.iter().zip(inputs).all(same_input) && loaded.plan.outputs.iter().zip(outputs).all(same_output)
}
