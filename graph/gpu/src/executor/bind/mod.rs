//! Bind groups for the images that the host gives for a frame.

pub(crate) mod bind_groups;
pub(crate) mod binder;
pub(crate) mod cache;
pub(crate) mod formats;
pub(crate) mod host_images;
mod make;

use afterimage_graph::node::ImageId;
use afterimage_plan::{Plan, PlanOutput};
use wgpu::{Device, TextureFormat, TextureView};

use crate::error::GpuError;
use crate::executor::Executor;
use crate::executor::frame::{Frame, view_of};
use crate::executor::load::loaded::Loaded;
use crate::executor::load::residency::ImageBinding;
use crate::platform::{scoped, watched};
use bind_groups::BindGroups;
use formats::HostFormats;
use host_images::{check_apart, check_encoding, check_input, check_names, check_output, must_be_drawn};
use make::needs_no_device;

impl Executor {
    /// The index of the bind groups for this frame's host images: from the cache, or new.
    pub(super) fn bind(&mut self, frame: &Frame<'_>) -> Result<usize, GpuError> {
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        check_names(&loaded.plan, frame)?;
        let cached = loaded.bind_groups.find(frame_views(loaded, frame), |groups| same_views(loaded, groups, frame));
        if let Some(index) = cached {
            loaded.bind_groups.use_again(index);
            self.passes_bound = 0;
            return Ok(loaded.bind_groups.len() - 1);
        }
        let oldest = loaded.bind_groups.remove_oldest_if_full();
        let groups = self.make_bind_groups(frame, oldest)?;
        self.passes_bound = groups.made;
        let loaded = self.loaded.as_mut().expect("it was there above");
        loaded.bind_groups.add(groups);
        Ok(loaded.bind_groups.len() - 1)
    }

    /// New bind groups for this frame's host images, which may reuse those that the cache has evicted.
    fn make_bind_groups(&mut self, frame: &Frame<'_>, evicted: Option<BindGroups>) -> Result<BindGroups, GpuError> {
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        let (compiler, device, what) = (&self.compiler, &self.compiler.device, "the images of the host");
        let last = loaded.bind_groups.last();
        let views = chosen_views(loaded, frame, last)?;
        let drawn = drawn_formats(device, &mut self.formats, &loaded.plan, frame, &views)?;
        let groups = match last {
            // A swap chain has new views in every frame: most of the last frame's bind groups stay.
            Some(last) if last.drawn == drawn && needs_no_device(loaded, last, &views) => match evicted {
                Some(evicted) if evicted.drawn == drawn => compiler.rebind(loaded, views, last, evicted),
                _ => compiler.bind(loaded, views, drawn, Some(last))?,
            },
            Some(last) if last.drawn == drawn => {
                scoped(device, what, || compiler.bind(loaded, views, drawn, Some(last)))?
            }
            // The device was there when the plan was prepared.
            None if loaded.is_watched => scoped(device, what, || compiler.bind(loaded, views, drawn, None))?,
            _ => watched(device, what, || compiler.bind(loaded, views, drawn, None))?,
        };
        // The formats of the host are unknown in frames without its images, as those of a fade.
        if !frame.outputs.is_empty() {
            self.formats.set_last(&loaded.plan.outputs, &groups.drawn);
        }
        Ok(groups)
    }
}

/// For each output the format in which the host's image for it is drawn; `None` for one that is stored to.
fn drawn_formats(
    device: &Device,
    formats: &mut HostFormats,
    plan: &Plan,
    frame: &Frame<'_>,
    views: &[TextureView],
) -> Result<Vec<Option<TextureFormat>>, GpuError> {
    let mut drawn = Vec::with_capacity(plan.outputs.len());
    for (output, view) in plan.outputs.iter().zip(&views[plan.inputs.len()..]) {
        let mut format = None;
        if must_be_drawn(plan, output.image, view.texture()) {
            // The stated format is that of the host's view, not of ours.
            let stated = frame.stated_format(&output.name).filter(|_| view_of(frame.outputs, &output.name).is_some());
            format = Some(formats.of_view(device, &output.name, view, stated)?);
        }
        check_encoding(output, format)?;
        drawn.push(format);
    }
    Ok(drawn)
}

/// The views of all inputs and outputs that the frame has.
fn frame_views<'f>(loaded: &'f Loaded, frame: &Frame<'f>) -> impl Iterator<Item = &'f TextureView> {
    let inputs = loaded.plan.inputs.iter().filter_map(|(name, _)| view_of(frame.inputs, name));
    inputs.chain(loaded.plan.outputs.iter().filter_map(|output| output_view(loaded, output, frame)))
}

/// Whether bind groups were made for exactly these host images.
fn same_views(loaded: &Loaded, groups: &BindGroups, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = groups.views.split_at(loaded.plan.inputs.len());
    let same_input = |((name, _), view): (&(String, ImageId), &TextureView)| view_of(frame.inputs, name) == Some(view);
    let same_output = |(output, view): (&PlanOutput, &TextureView)| output_view(loaded, output, frame) == Some(view);
    loaded.plan.inputs.iter().zip(inputs).all(same_input) && loaded.plan.outputs.iter().zip(outputs).all(same_output)
}

/// The destination of an output: the host's image, or ours.
fn output_view<'a>(loaded: &'a Loaded, output: &PlanOutput, frame: &Frame<'a>) -> Option<&'a TextureView> {
    view_of(frame.outputs, &output.name).or_else(|| match &loaded.residency.bindings[output.image.0 as usize] {
        ImageBinding::Output(_, stored) => Some(&stored.view),
        _ => None,
    })
}

/// The views of all inputs, then of all outputs; ours where the host gives none. Those of the last frame are not
/// checked again.
fn chosen_views(loaded: &Loaded, frame: &Frame<'_>, last: Option<&BindGroups>) -> Result<Vec<TextureView>, GpuError> {
    let plan = &loaded.plan;
    let mut views = Vec::with_capacity(plan.inputs.len() + plan.outputs.len());
    let is_checked = |at: usize, view: &TextureView| last.is_some_and(|last| last.views[at] == *view);
    for (name, image) in &plan.inputs {
        let view = view_of(frame.inputs, name).ok_or_else(|| GpuError::MissingInput(name.clone()))?;
        if !is_checked(views.len(), view) {
            check_input(plan, name, *image, view)?;
        }
        views.push(view.clone());
    }
    for output in &plan.outputs {
        let view = output_view(loaded, output, frame).expect("the planner gives each output an image of its own");
        if !is_checked(views.len(), view) {
            check_output(plan, &output.name, output.image, view)?;
        }
        views.push(view.clone());
    }
    check_apart(plan, &views)?;
    Ok(views)
}
