//! Bind groups: a loaded plan with the images that the host gives for a frame.

use afterimage_graph::node::ImageId;
use afterimage_plan::PlanOutput;
use wgpu::TextureView;

use super::Executor;
use super::frame::Frame;
use super::host_images::{Formats, check_encoding, check_names, must_be_drawn};
use super::host_set::HostSet;
use super::loaded::Loaded;
use super::sets::{chosen_views, named, needs_no_device, output_view};
use crate::GpuError;
use crate::platform::{scoped, watched};

impl Executor {
    /// The bind groups for this frame's host images: remembered, or made.
    pub(super) fn host_set(&mut self, frame: &Frame<'_>) -> Result<usize, GpuError> {
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        check_names(&loaded.plan, frame)?;
        let known = loaded.sets.find(frame_views(loaded, frame), |set| same_views(loaded, set, frame));
        if let Some(known) = known {
            loaded.sets.use_again(known);
            self.runs_made = 0;
            return Ok(loaded.sets.len() - 1);
        }
        let oldest = loaded.sets.remove_oldest_if_full();
        let set = self.new_set(frame, oldest)?;
        self.runs_made = set.made;
        let loaded = self.loaded.as_mut().expect("it was there above");
        loaded.sets.add(set);
        Ok(loaded.sets.len() - 1)
    }

    /// The set for this frame's host images. It may be made of the oldest, which is not remembered any more.
    fn new_set(&mut self, frame: &Frame<'_>, oldest: Option<HostSet>) -> Result<HostSet, GpuError> {
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        let (compiler, what) = (&self.compiler, "the images of the host");
        let views = chosen_views(loaded, frame, loaded.sets.last())?;
        let drawn = drawn(&compiler.device, &mut self.formats, (loaded, frame), &views)?;
        let set = match loaded.sets.last() {
            // A swap chain has new views in every frame: most of the last set is as good as new.
            Some(last) if last.drawn == drawn && needs_no_device(loaded, last, &views) => match oldest {
                Some(oldest) if oldest.drawn == drawn => compiler.renew_set(loaded, views, last, oldest),
                _ => compiler.make_set(loaded, (views, drawn), Some(last))?,
            },
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

/// The views of all inputs and outputs that the frame has.
fn frame_views<'f>(loaded: &'f Loaded, frame: &Frame<'f>) -> impl Iterator<Item = &'f TextureView> {
    let inputs = loaded.plan.inputs.iter().filter_map(|(name, _)| named(frame.inputs, name));
    inputs.chain(loaded.plan.outputs.iter().filter_map(|output| output_view(loaded, output, frame)))
}

/// Whether a set was made for exactly these host images.
fn same_views(loaded: &Loaded, set: &HostSet, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = set.views.split_at(loaded.plan.inputs.len());
    let same_input = |((name, _), view): (&(String, ImageId), &TextureView)| named(frame.inputs, name) == Some(view);
    let same_output = |(output, view): (&PlanOutput, &TextureView)| output_view(loaded, output, frame) == Some(view);
    loaded.plan.inputs.iter().zip(inputs).all(same_input) && loaded.plan.outputs.iter().zip(outputs).all(same_output)
}
