//! Making bind groups and attachments, on any thread.

use std::sync::Arc;

use afterimage_graph::node::ImageId;
use afterimage_plan::Stage;
use wgpu::{TextureFormat, TextureView};

use crate::error::GpuError;
use crate::executor::bind::bind_groups::{BindGroups, BoundPass};
use crate::executor::bind::chosen_views;
use crate::executor::bind::host_images::{check_encoding, must_be_drawn};
use crate::executor::frame::Frame;
use crate::executor::load::loaded::Loaded;
use crate::executor::load::residency::ImageBinding;
use crate::executor::load::{PlanCompiler, PreviousPlan};
use crate::executor::record::explicit_transitions::ExplicitTransitions;
use crate::pipelines::Built;
use crate::platform::scoped;

impl PlanCompiler {
    /// The bind groups for these views, with the format of each output that is drawn. Passes whose views are also those
    /// of `last`, which has the same formats, are taken from there.
    pub(super) fn bind(
        &self,
        loaded: &Loaded,
        views: Vec<TextureView>,
        drawn: Vec<Option<TextureFormat>>,
        last: Option<&BindGroups>,
    ) -> Result<BindGroups, GpuError> {
        let mut made = 0;
        let mut passes = Vec::with_capacity(loaded.passes.len());
        for (index, bound) in loaded.bound.iter().enumerate() {
            passes.push(match (bound, last) {
                (Some(bound), _) => bound.clone(),
                (None, Some(last)) => {
                    let known = &last.passes[index];
                    match renewal(loaded, index, last, &views) {
                        Renewal::None => known.clone(),
                        Renewal::Attachments => Arc::new(self.with_attachments(loaded, index, known, &views)),
                        Renewal::All => {
                            made += 1;
                            Arc::new(self.binder.bind_pass(loaded, index, known.built.clone(), &views))
                        }
                    }
                }
                (None, None) => {
                    made += 1;
                    let built = self.built(loaded, index, &drawn)?;
                    Arc::new(self.binder.bind_pass(loaded, index, built, &views))
                }
            });
        }
        let explicit_transitions = match last {
            Some(last) => last.explicit_transitions.clone(),
            None => {
                let is_drawn = passes.iter().map(|bound| bound.built.pipeline.stage() != Stage::Compute);
                let planned = &loaded.explicit_transitions;
                match is_drawn.clone().eq(planned.is_drawn.iter().copied()) {
                    true => planned.clone(),
                    false => Arc::new(ExplicitTransitions::new(&loaded.plan, &loaded.residency, is_drawn.collect())),
                }
            }
        };
        Ok(BindGroups { views, drawn, passes, explicit_transitions, made })
    }

    /// As [`bind`](Self::bind) where only attachments differ from those of `last` (see [`needs_no_device`]), in the
    /// memory of `evicted`, which has the same formats.
    pub(super) fn rebind(
        &self,
        loaded: &Loaded,
        views: Vec<TextureView>,
        last: &BindGroups,
        mut evicted: BindGroups,
    ) -> BindGroups {
        for (index, bound) in loaded.bound.iter().enumerate() {
            // Passes without a view of the host are the same for all.
            if bound.is_none() {
                let known = &last.passes[index];
                evicted.passes[index] = match renewal(loaded, index, last, &views) {
                    Renewal::None => known.clone(),
                    _ => Arc::new(self.with_attachments(loaded, index, known, &views)),
                };
            }
        }
        evicted.explicit_transitions.clone_from(&last.explicit_transitions);
        (evicted.views, evicted.made) = (views, 0);
        evicted
    }

    /// A pass with other attachments.
    fn with_attachments(&self, loaded: &Loaded, index: usize, known: &BoundPass, views: &[TextureView]) -> BoundPass {
        let BoundPass { built, groups, attachments: _ } = known;
        let attachments = self.binder.attachments(loaded, index, built, views);
        BoundPass { built: built.clone(), groups: groups.clone(), attachments }
    }

    /// The bind groups for the host's images of the frame before, if they fit the plan: the first frame of a plan has
    /// the same, or most of them.
    pub(in crate::executor) fn bind_ahead(&self, loaded: &Loaded, before: &PreviousPlan) -> Option<BindGroups> {
        let [inputs, outputs] = [&before.inputs, &before.outputs]
            .map(|views| views.iter().map(|(name, view)| (name.as_str(), view)).collect::<Vec<_>>());
        let frame = Frame { inputs: &inputs, outputs: &outputs, ..Frame::default() };
        let views = chosen_views(loaded, &frame, None).ok()?;
        let mut drawn = Vec::with_capacity(loaded.plan.outputs.len());
        for (output, view) in loaded.plan.outputs.iter().zip(&views[loaded.plan.inputs.len()..]) {
            let mut format = None;
            if must_be_drawn(&loaded.plan, output.image, view.texture()) {
                format = Some(before.drawn.iter().find(|(name, _)| *name == output.name)?.1);
            }
            check_encoding(output, format).ok()?;
            drawn.push(format);
        }
        // The host may have dropped an image meanwhile: then the frame has another one.
        scoped(&self.device, "the images of the frame before", || self.bind(loaded, views, drawn, None)).ok()
    }

    /// The pipeline of a pass: the planned one, or the one that draws into the host's image.
    fn built(&self, loaded: &Loaded, index: usize, drawn: &[Option<TextureFormat>]) -> Result<Built, GpuError> {
        let pass = &loaded.passes[index];
        match pass.writes_image.and_then(|image| attachment_of_host(loaded, image, drawn)) {
            None => Ok(pass.built.clone()),
            Some(format) => match loaded.drawn.iter().find(|(at, known, _)| (*at, *known) == (index, format)) {
                Some((_, _, built)) => Ok(built.clone()),
                None => self.pipelines.drawing(&self.device, &loaded.plan, index, pass, format),
            },
        }
    }
}

/// What a pass needs for other views of the host.
enum Renewal {
    None,
    /// None is in its bind group, but one is an attachment.
    Attachments,
    All,
}

fn renewal(loaded: &Loaded, index: usize, last: &BindGroups, views: &[TextureView]) -> Renewal {
    let (named, stage) = (&loaded.host_views[index], last.passes[index].built.pipeline.stage());
    let is_new = |view: &usize| last.views[*view] != views[*view];
    match (named.in_group(stage).any(is_new), named.attached(stage).iter().any(is_new)) {
        (true, _) => Renewal::All,
        (false, true) => Renewal::Attachments,
        (false, false) => Renewal::None,
    }
}

/// Whether bind groups for other views than the last frame's need no call of the device that can fail.
pub(super) fn needs_no_device(loaded: &Loaded, last: &BindGroups, views: &[TextureView]) -> bool {
    (0..loaded.passes.len()).filter(|index| loaded.bound[*index].is_none()).all(|index| {
        match renewal(loaded, index, last, views) {
            Renewal::None => true,
            // A drawing pass makes views of levels.
            Renewal::Attachments => last.passes[index].built.pipeline.stage() == Stage::Fragment,
            Renewal::All => false,
        }
    })
}

/// The attachment's format if the image is an output that is drawn into the host's.
fn attachment_of_host(loaded: &Loaded, image: ImageId, drawn: &[Option<TextureFormat>]) -> Option<TextureFormat> {
    let ImageBinding::Output(index, _) = &loaded.residency.bindings[image.0 as usize] else { return None };
    drawn[*index]
}
