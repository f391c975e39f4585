//! The bind groups and attachments for one choice of host images, on any thread.

use std::sync::Arc;

use afterimage_graph::node::ImageId;
use afterimage_plan::{PlanOutput, Stage};
use wgpu::{TextureFormat, TextureView};

use super::explicit_transitions::ExplicitTransitions;
use super::frame::Frame;
use super::host_images::{check_apart, check_encoding, check_input, check_output, must_be_drawn};
use super::host_set::{HostSet, Run};
use super::loaded::Loaded;
use super::prepare::{PlanCompiler, PreviousPlan};
use super::residency::ImageBinding;
use crate::GpuError;
use crate::pipelines::Built;
use crate::platform::scoped;

impl PlanCompiler {
    /// The set for these views, with the format of each output that is drawn. What names only views that the last set
    /// has, too, is taken from there: that is of the same formats.
    pub(super) fn make_set(
        &self,
        loaded: &Loaded,
        (views, drawn): (Vec<TextureView>, Vec<Option<TextureFormat>>),
        last: Option<&HostSet>,
    ) -> Result<HostSet, GpuError> {
        let mut made = 0;
        let mut runs = Vec::with_capacity(loaded.passes.len());
        for (index, own) in loaded.runs.iter().enumerate() {
            let known = own.as_ref().or(last.map(|last| &last.runs[index]));
            runs.push(match (known, own.is_none().then_some(last).flatten()) {
                (Some(known), None) => known.clone(),
                (Some(known), Some(last)) => match renewal(loaded, index, last, &views) {
                    Renewal::None => known.clone(),
                    Renewal::Attachments => Arc::new(self.with_attachments(loaded, index, known, &views)),
                    Renewal::All => {
                        made += 1;
                        Arc::new(self.binder.run(loaded, index, known.built.clone(), &views))
                    }
                },
                (None, _) => {
                    made += 1;
                    Arc::new(self.binder.run(loaded, index, self.built(loaded, index, &drawn)?, &views))
                }
            });
        }
        let explicit_transitions = match last {
            Some(last) => last.explicit_transitions.clone(),
            None => {
                let is_drawn = runs.iter().map(|run| run.built.pipeline.stage() != Stage::Compute);
                let known = &loaded.explicit_transitions;
                match is_drawn.clone().eq(known.is_drawn.iter().copied()) {
                    true => known.clone(),
                    false => Arc::new(ExplicitTransitions::new(&loaded.plan, &loaded.residency, is_drawn.collect())),
                }
            }
        };
        Ok(HostSet { views, drawn, runs, explicit_transitions, made })
    }

    /// The set for these views, of which passes only draw into those that the last set has not: see
    /// [`needs_no_device`]. It is made of a set of the same formats that nobody needs any more.
    pub(super) fn renew_set(
        &self,
        loaded: &Loaded,
        views: Vec<TextureView>,
        last: &HostSet,
        mut set: HostSet,
    ) -> HostSet {
        // Passes that name no view of the host are the same in all sets.
        for index in (0..loaded.passes.len()).filter(|index| loaded.runs[*index].is_none()) {
            let known = &last.runs[index];
            set.runs[index] = match renewal(loaded, index, last, &views) {
                Renewal::None => known.clone(),
                _ => Arc::new(self.with_attachments(loaded, index, known, &views)),
            };
        }
        set.explicit_transitions.clone_from(&last.explicit_transitions);
        (set.views, set.made) = (views, 0);
        set
    }

    /// A pass that draws into other views.
    fn with_attachments(&self, loaded: &Loaded, index: usize, known: &Run, views: &[TextureView]) -> Run {
        let Run { built, groups, attachments: _ } = known;
        let attachments = self.binder.attachments(loaded, index, built, views);
        Run { built: built.clone(), groups: groups.clone(), attachments }
    }

    /// The set for the images of the frame before, if they suit the plan: the first frame of a plan has the same, or
    /// most of them.
    pub(super) fn set_ahead(&self, loaded: &Loaded, before: &PreviousPlan) -> Option<HostSet> {
        let [inputs, outputs] = [&before.inputs, &before.outputs]
            .map(|views| views.iter().map(|(name, view)| (name.as_str(), view)).collect::<Vec<_>>());
        let frame = Frame { inputs: &inputs, outputs: &outputs, ..Frame::default() };
        let views = chosen_views(loaded, &frame, None).ok()?;
        let format = |(output, view): (&PlanOutput, &TextureView)| {
            let is_drawn = must_be_drawn(&loaded.plan, output.image, view.texture());
            let known = || before.drawn.iter().find(|(name, _)| *name == output.name).map(|(_, format)| *format);
            let format = if is_drawn { Some(known()?) } else { None };
            check_encoding(output, format).ok()?;
            Some(format)
        };
        let drawn = loaded.plan.outputs.iter().zip(&views[loaded.plan.inputs.len()..]).map(format);
        let drawn = drawn.collect::<Option<Vec<_>>>()?;
        // The host may have dropped an image meanwhile: then the frame has another one.
        let make = || self.make_set(loaded, (views, drawn), None);
        scoped(&self.device, "the images of the frame before", make).ok()
    }

    /// The pipeline of a pass: the planned one, or the one that draws into the host's image.
    fn built(&self, loaded: &Loaded, index: usize, drawn: &[Option<TextureFormat>]) -> Result<Built, GpuError> {
        let pass = &loaded.passes[index];
        match pass.writes_image.and_then(|image| attachment_of_host(loaded, image, drawn)) {
            None => Ok(pass.built.clone()),
            Some(format) => match loaded.drawn.iter().find(|(at, known, _)| (*at, *known) == (index, format)) {
                Some((_, _, built)) => Ok(built.clone()),
                None => self.pipelines.drawing(&self.device, (&loaded.plan, index, pass), format),
            },
        }
    }
}

/// What a pass needs for other views of the host.
enum Renewal {
    None,
    /// Its bind group names none of them, but it draws into one.
    Attachments,
    All,
}

fn renewal(loaded: &Loaded, index: usize, last: &HostSet, views: &[TextureView]) -> Renewal {
    let (named, stage) = (&loaded.host_views[index], last.runs[index].built.pipeline.stage());
    let is_new = |view: &usize| last.views[*view] != views[*view];
    match (named.in_group(stage).any(is_new), named.attached(stage).iter().any(is_new)) {
        (true, _) => Renewal::All,
        (false, true) => Renewal::Attachments,
        (false, false) => Renewal::None,
    }
}

/// Whether the set for other views than those of the last set is made without a call of the device that can fail.
pub(super) fn needs_no_device(loaded: &Loaded, last: &HostSet, views: &[TextureView]) -> bool {
    (0..loaded.passes.len()).filter(|index| loaded.runs[*index].is_none()).all(|index| {
        match renewal(loaded, index, last, views) {
            Renewal::None => true,
            // A drawing pass makes views of levels.
            Renewal::Attachments => last.runs[index].built.pipeline.stage() == Stage::Fragment,
            Renewal::All => false,
        }
    })
}

/// The view of that name.
pub(super) fn named<'a>(views: &[(&str, &'a TextureView)], name: &str) -> Option<&'a TextureView> {
    views.iter().find(|(known, _)| *known == name).map(|(_, view)| *view)
}

/// Where an output goes: to the host's image, or to ours.
pub(super) fn output_view<'a>(loaded: &'a Loaded, output: &PlanOutput, frame: &Frame<'a>) -> Option<&'a TextureView> {
    named(frame.outputs, &output.name).or_else(|| match &loaded.residency.bindings[output.image.0 as usize] {
        ImageBinding::Output(_, stored) => Some(&stored.view),
        _ => None,
    })
}

/// The views of all inputs, then of all outputs; ours where the host gives none. Those of the last set suit the plan.
pub(super) fn chosen_views(
    loaded: &Loaded,
    frame: &Frame<'_>,
    last: Option<&HostSet>,
) -> Result<Vec<TextureView>, GpuError> {
    let plan = &loaded.plan;
    let mut views = Vec::with_capacity(plan.inputs.len() + plan.outputs.len());
    let is_checked = |at: usize, view: &TextureView| last.is_some_and(|last| last.views[at] == *view);
    for (name, image) in &plan.inputs {
        let view = named(frame.inputs, name).ok_or_else(|| GpuError::MissingInput(name.clone()))?;
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

/// The attachment's format if the image is an output that is drawn into the host's.
fn attachment_of_host(loaded: &Loaded, image: ImageId, drawn: &[Option<TextureFormat>]) -> Option<TextureFormat> {
    let ImageBinding::Output(index, _) = &loaded.residency.bindings[image.0 as usize] else { return None };
    drawn[*index]
}
