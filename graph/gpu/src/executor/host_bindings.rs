//! The host's views: their formats, levels and bind groups.

use super::bind::formats::HostFormats;
use super::bind::host_images::check_names;
use super::bind::view_levels::ViewLevels;
use super::bind::views::cached_groups;
use super::frame::Frame;
use super::load::PlanCompiler;
use super::loaded::Loaded;
use crate::error::GpuError;

/// Binds the host's views to the passes of plans.
#[derive(Default)]
pub(crate) struct HostBindings {
    pub(crate) formats: HostFormats,
    pub(crate) levels: ViewLevels,
    /// The number of passes for which the last frame has made bind groups.
    pub(crate) made: usize,
    /// The last frame has the views of the frame before.
    pub(crate) is_same: bool,
}

impl HostBindings {
    /// Binds the views of a frame. Returns the index of the bind groups, which come from the cache or are new.
    pub(crate) fn bind(
        &mut self,
        compiler: &PlanCompiler,
        loaded: &mut Loaded,
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
