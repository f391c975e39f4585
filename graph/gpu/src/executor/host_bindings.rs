//! The host's views: their formats, levels and bind groups.

use afterimage_plan::{Plan, PlanOutput};
use wgpu::{Device, TextureFormat, TextureView};

use super::bind::formats::HostFormats;
use super::bind::host_images::{check_encoding, check_names};
use super::bind::view_levels::ViewLevels;
use super::bind::views::cached_groups;
use super::frame::Frame;
use super::load::PlanCompiler;
use super::loaded::LoadedPlan;
use crate::error::GpuError;
use crate::texture_format::texture_format;

/// Binds the host's views to the passes of plans.
#[derive(Default)]
pub struct HostBindings {
    pub(crate) formats: HostFormats,
    levels: ViewLevels,
    /// The number of passes for which the last frame has made bind groups.
    pub(crate) made: usize,
    /// The last frame has the views of the frame before.
    pub(crate) is_same: bool,
}

impl HostBindings {
    /// The mip levels of the views of a frame whose textures have several.
    ///
    /// # Errors
    /// One is not known, or its texture does not have it.
    pub fn levels<'f>(&mut self, device: &Device, frame: &Frame<'f>) -> Result<Vec<(&'f str, u32)>, GpuError> {
        self.levels.of(device, frame)
    }

    /// The format of the host's view for an output, as it is drawn to.
    ///
    /// # Errors
    /// It cannot be drawn to, or the device would encode it a second time.
    pub fn format_of(
        &mut self,
        device: &Device,
        output: &PlanOutput,
        view: &TextureView,
        frame: &Frame<'_>,
    ) -> Result<TextureFormat, GpuError> {
        let format = self.formats.of_view(device, &output.name, view, frame.stated_format(&output.name))?;
        check_encoding(output, Some(format), view.texture().format())?;
        Ok(format)
    }

    /// The format of the host's view for an output in the last frame that drew it; the planned one if a pass stores to
    /// the view.
    pub fn last_format(&self, plan: &Plan, output: &PlanOutput) -> TextureFormat {
        let drawn = self.formats.last().iter().find(|(name, _)| *name == output.name).map(|(_, format)| *format);
        drawn.unwrap_or_else(|| texture_format(plan.image(output.image).desc.format))
    }

    /// Binds the views of a frame. Returns the index of the bind groups, which come from the cache or are new.
    pub(crate) fn bind(
        &mut self,
        compiler: &PlanCompiler,
        loaded: &mut LoadedPlan,
        frame: &Frame<'_>,
    ) -> Result<usize, GpuError> {
        check_names(&loaded.plan, frame)?;
        self.made = 0;
        let cached = cached_groups(loaded, frame);
        self.is_same = cached.is_some_and(|index| index + 1 == loaded.bind_groups.len());
        if let Some(index) = cached {
            loaded.bind_groups.use_again(index);
        } else {
            let evicted = loaded.bind_groups.remove_oldest_if_full();
            let groups = compiler.bind_groups(loaded).for_frame(frame, &mut self.formats, evicted)?;
            self.made = groups.made;
            loaded.bind_groups.add(groups);
        }
        Ok(loaded.bind_groups.len() - 1)
    }
}
