//! The bind groups of a loaded plan, on any thread.

use std::sync::Arc;

use afterimage_graph::node::ImageId;
use afterimage_plan::Stage;
use wgpu::{TextureFormat, TextureView};

use crate::error::GpuError;
use crate::executor::bind::binder::Binder;
use crate::executor::bind::depth_view::{depth_view, has_stencil};
use crate::executor::bind::formats::HostFormats;
use crate::executor::bind::host_images::{check_encoding, must_be_drawn};
use crate::executor::bind::views::choose_views;
use crate::executor::frame::{Frame, view_of};
use crate::executor::loaded::LoadedPlan;
use crate::executor::loaded::bind_groups::{BindGroups, BoundPass};
use crate::executor::loaded::explicit_transitions::ExplicitTransitions;
use crate::executor::loaded::previous::PreviousPlan;
use crate::executor::loaded::residency::ImageBinding;
use crate::pipelines::{Built, Pipelines};
use crate::platform::{scoped, watched};

/// Makes the bind groups of a loaded plan.
pub(crate) struct BindGroupBuilder<'a> {
    pub(crate) binder: &'a Binder,
    pub(crate) pipelines: &'a Pipelines,
    pub(crate) loaded: &'a LoadedPlan,
}

/// The changes of a pass for other views of the host.
enum Renewal {
    None,
    /// None is in its bind group, but one is an attachment.
    Attachments,
    All,
}

impl BindGroupBuilder<'_> {
    /// The bind groups for a frame's host images, in the memory of those that the cache has evicted.
    ///
    /// # Errors
    /// An image does not fit the plan, or the device refuses it.
    pub(crate) fn for_frame(
        &self,
        frame: &Frame<'_>,
        formats: &mut HostFormats,
        evicted: Option<BindGroups>,
    ) -> Result<BindGroups, GpuError> {
        let (loaded, device, what) = (self.loaded, &self.binder.device, "the images of the host");
        let last = loaded.bind_groups.last();
        let mut groups = evicted.unwrap_or_else(|| BindGroups::new(loaded.explicit_transitions.clone()));
        choose_views(loaded, frame, last, &mut groups.views)?;
        self.choose_bound_views(frame, &mut groups, last);
        self.choose_formats(frame, formats, &mut groups)?;
        match last.filter(|last| last.drawn == groups.drawn) {
            // A swap chain has new views in every frame: most of the last frame's bind groups stay.
            Some(last) if self.needs_no_device(&groups, last) => self.renew(&mut groups, last),
            Some(last) => scoped(device, what, || {
                self.renew(&mut groups, last);
                Ok::<(), GpuError>(())
            })?,
            // The device was there when the plan was prepared.
            None if loaded.is_watched => scoped(device, what, || self.make(&mut groups))?,
            None => watched(device, what, || self.make(&mut groups))?,
        }
        // The formats of the host are unknown in frames without its images, as those of a fade.
        if !frame.outputs.is_empty() {
            formats.set_last(&loaded.plan.outputs, &groups.drawn);
        }
        Ok(groups)
    }

    /// The bind groups for the host's images of the frame before, if they fit the plan: the first frame of a plan has
    /// the same, or most of them.
    pub(crate) fn ahead(&self, before: &PreviousPlan) -> Option<BindGroups> {
        let loaded = self.loaded;
        let [inputs, outputs] = [&before.inputs, &before.outputs]
            .map(|views| views.iter().map(|(name, view)| (name.as_str(), view)).collect::<Vec<_>>());
        let frame = Frame { inputs: &inputs, outputs: &outputs, ..Frame::default() };
        let mut groups = BindGroups::new(loaded.explicit_transitions.clone());
        choose_views(loaded, &frame, None, &mut groups.views).ok()?;
        self.choose_bound_views(&frame, &mut groups, None);
        for (output, view) in loaded.plan.outputs.iter().zip(&groups.views[loaded.plan.inputs.len()..]) {
            let mut format = None;
            if must_be_drawn(&loaded.plan, output.image, view.texture()) {
                format = Some(before.drawn.iter().find(|(name, _)| *name == output.name)?.1);
            }
            check_encoding(output, format, view.texture().format()).ok()?;
            groups.drawn.push(format);
        }
        // The host may have dropped an image meanwhile: then the frame has another one.
        scoped(&self.binder.device, "the images of the frame before", || self.make(&mut groups)).ok()?;
        Some(groups)
    }

    /// Chooses the views that passes bind. Those of the last frame stay.
    fn choose_bound_views(&self, frame: &Frame<'_>, groups: &mut BindGroups, last: Option<&BindGroups>) {
        let plan = &self.loaded.plan;
        let names = plan.inputs.iter().map(|(name, _)| name).chain(plan.outputs.iter().map(|output| &output.name));
        groups.bound_views.clear();
        for (index, (view, name)) in groups.views.iter().zip(names).enumerate() {
            groups.bound_views.push(match last {
                _ if !has_stencil(view.texture().format()) => view.clone(),
                Some(last) if last.views[index] == *view => last.bound_views[index].clone(),
                _ => depth_view(&self.binder.device, view, frame.stated_level(name).unwrap_or(0)),
            });
        }
    }

    /// Chooses for each output the format in which the host's image for it is drawn; `None` for one that is stored to.
    fn choose_formats(
        &self,
        frame: &Frame<'_>,
        formats: &mut HostFormats,
        groups: &mut BindGroups,
    ) -> Result<(), GpuError> {
        let plan = &self.loaded.plan;
        groups.drawn.clear();
        for (output, view) in plan.outputs.iter().zip(&groups.views[plan.inputs.len()..]) {
            let mut format = None;
            if must_be_drawn(plan, output.image, view.texture()) {
                // The stated format is that of the host's view, not of ours.
                let is_hosts = view_of(frame.outputs, &output.name).is_some();
                let stated = frame.stated_format(&output.name).filter(|_| is_hosts);
                format = Some(formats.of_view(&self.binder.device, &output.name, view, stated)?);
            }
            check_encoding(output, format, view.texture().format())?;
            groups.drawn.push(format);
        }
        Ok(())
    }

    /// Makes the bind groups of all passes for the views and formats in `groups`.
    fn make(&self, groups: &mut BindGroups) -> Result<(), GpuError> {
        let loaded = self.loaded;
        groups.made = 0;
        groups.passes.clear();
        for (index, bound) in loaded.bound.iter().enumerate() {
            groups.passes.push(match bound {
                Some(bound) => bound.clone(),
                None => {
                    groups.made += 1;
                    let built = self.built(index, &groups.drawn)?;
                    Arc::new(self.binder.bind_pass(loaded, index, built, &groups.bound_views))
                }
            });
        }
        let is_drawn = groups.passes.iter().map(|bound| bound.built.pipeline.stage() != Stage::Compute);
        let planned = &loaded.explicit_transitions;
        groups.explicit_transitions = match is_drawn.clone().eq(planned.is_drawn.iter().copied()) {
            true => planned.clone(),
            false => Arc::new(ExplicitTransitions::new(&loaded.plan, &loaded.residency, is_drawn.collect())),
        };
        Ok(())
    }

    /// Makes the bind groups that differ from those of the last frame, which has the same formats.
    fn renew(&self, groups: &mut BindGroups, last: &BindGroups) {
        let loaded = self.loaded;
        groups.made = 0;
        groups.explicit_transitions.clone_from(&last.explicit_transitions);
        if groups.passes.is_empty() {
            groups.passes.clone_from(&last.passes);
        }
        for (index, bound) in loaded.bound.iter().enumerate() {
            // Passes without a view of the host are the same for all.
            if bound.is_some() {
                continue;
            }
            let (known, views) = (&last.passes[index], &groups.bound_views);
            match self.renewal(index, &groups.views, last) {
                Renewal::None => groups.passes[index].clone_from(known),
                Renewal::Attachments => {
                    let pass = writable(&mut groups.passes[index], known);
                    pass.built.clone_from(&known.built);
                    pass.groups.clone_from(&known.groups);
                    self.binder.attach(loaded, index, views, pass);
                }
                Renewal::All => {
                    groups.made += 1;
                    let pass = writable(&mut groups.passes[index], known);
                    pass.built.clone_from(&known.built);
                    self.binder.bind(loaded, index, views, pass);
                    self.binder.attach(loaded, index, views, pass);
                }
            }
        }
    }

    fn renewal(&self, index: usize, views: &[TextureView], last: &BindGroups) -> Renewal {
        let (host_views, stage) = (&self.loaded.host_views[index], last.passes[index].built.pipeline.stage());
        let is_new = |view: &usize| last.views[*view] != views[*view];
        match (host_views.in_group(stage).any(is_new), host_views.attached(stage).iter().any(is_new)) {
            (true, _) => Renewal::All,
            (false, true) => Renewal::Attachments,
            (false, false) => Renewal::None,
        }
    }

    /// True if bind groups for other views than the last frame's need no call of the device that can fail.
    fn needs_no_device(&self, groups: &BindGroups, last: &BindGroups) -> bool {
        let mut unbound = (0..self.loaded.passes.len()).filter(|index| self.loaded.bound[*index].is_none());
        unbound.all(|index| match self.renewal(index, &groups.views, last) {
            Renewal::None => true,
            // A drawing pass makes views of levels.
            Renewal::Attachments => last.passes[index].built.pipeline.stage() == Stage::Fragment,
            Renewal::All => false,
        })
    }

    /// The pipeline of a pass: the planned one, or the one that draws into the host's image.
    fn built(&self, index: usize, drawn: &[Option<TextureFormat>]) -> Result<Built, GpuError> {
        let (loaded, pass) = (self.loaded, &self.loaded.passes[index]);
        match pass.writes_image.and_then(|image| attachment_of_host(loaded, image, drawn)) {
            None => Ok(pass.built.clone()),
            Some(format) => match loaded.drawn.iter().find(|(at, known, _)| (*at, *known) == (index, format)) {
                Some((_, _, built)) => Ok(built.clone()),
                None => self.pipelines.drawing(&self.binder.device, &loaded.plan, index, &pass.composed, format),
            },
        }
    }
}

/// A bound pass that no other bind groups share; a copy of `known` if they do.
fn writable<'a>(pass: &'a mut Arc<BoundPass>, known: &BoundPass) -> &'a mut BoundPass {
    if Arc::get_mut(pass).is_none() {
        *pass = Arc::new(known.clone());
    }
    Arc::get_mut(pass).expect("it is not shared")
}

/// The attachment's format if the image is an output that is drawn into the host's.
fn attachment_of_host(loaded: &LoadedPlan, image: ImageId, drawn: &[Option<TextureFormat>]) -> Option<TextureFormat> {
    let ImageBinding::Output(index, _) = &loaded.residency.bindings[image.0 as usize] else { return None };
    drawn[*index]
}
