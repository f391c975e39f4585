//! The host's views for the inputs and outputs of a plan; ours for outputs that the host gives none for.

use afterimage_plan::PlanOutput;
use wgpu::TextureView;

use crate::error::GpuError;
use crate::executor::bind::host_images::{check_apart, check_input, check_output};
use crate::executor::frame::{Frame, view_of};
use crate::executor::loaded::LoadedPlan;
use crate::executor::loaded::bind_groups::BindGroups;

/// The index of the bind groups that were made for exactly this frame's host images.
pub(crate) fn cached_groups(loaded: &LoadedPlan, frame: &Frame<'_>) -> Option<usize> {
    let inputs = loaded.plan.inputs.iter().filter_map(|(name, _)| view_of(frame.inputs, name));
    let outputs = loaded.plan.outputs.iter().filter_map(|output| output_view(loaded, output, frame));
    loaded.bind_groups.find(inputs.chain(outputs), |groups| has_same_views(loaded, groups, frame))
}

fn has_same_views(loaded: &LoadedPlan, groups: &BindGroups, frame: &Frame<'_>) -> bool {
    let (inputs, outputs) = groups.views.split_at(loaded.plan.inputs.len());
    let mut inputs = loaded.plan.inputs.iter().zip(inputs);
    let mut outputs = loaded.plan.outputs.iter().zip(outputs);
    inputs.all(|((name, _), view)| view_of(frame.inputs, name) == Some(view))
        && outputs.all(|(output, view)| output_view(loaded, output, frame) == Some(view))
}

/// The destination of an output: the host's image, or ours.
fn output_view<'a>(loaded: &'a LoadedPlan, output: &PlanOutput, frame: &Frame<'a>) -> Option<&'a TextureView> {
    view_of(frame.outputs, &output.name).or_else(|| loaded.residency.own_output(output.image))
}

/// Replaces `views` by those of all inputs, then of all outputs. Those of the last frame are not checked again.
///
/// # Errors
/// A view is missing or does not fit the plan.
pub(crate) fn choose_views(
    loaded: &LoadedPlan,
    frame: &Frame<'_>,
    last: Option<&BindGroups>,
    views: &mut Vec<TextureView>,
) -> Result<(), GpuError> {
    let plan = &loaded.plan;
    views.clear();
    views.reserve_exact(plan.inputs.len() + plan.outputs.len());
    for (name, image) in &plan.inputs {
        let view = view_of(frame.inputs, name).ok_or_else(|| GpuError::MissingInput(name.clone()))?;
        if last.is_none_or(|last| last.views[views.len()] != *view) {
            check_input(plan, name, *image, view, frame.size_of(name, view))?;
        }
        views.push(view.clone());
    }
    for output in &plan.outputs {
        let view = output_view(loaded, output, frame).expect("the planner gives each output an image of its own");
        if last.is_none_or(|last| last.views[views.len()] != *view) {
            check_output(plan, output, view, frame.size_of(&output.name, view))?;
        }
        views.push(view.clone());
    }
    check_apart(plan, views)
}
