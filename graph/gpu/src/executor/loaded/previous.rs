//! The plan in use, as the next one sees it.

use std::sync::Arc;

use afterimage_graph::node::ImageId;
use afterimage_plan::Plan;
use wgpu::TextureFormat;

use crate::executor::loaded::NamedView;
use crate::executor::loaded::residency::Residency;

/// The parts of the plan in use that the next plan can reuse.
#[derive(Clone, Default)]
pub(crate) struct PreviousPlan {
    pub(crate) plan: Option<(Arc<Plan>, Arc<Residency>)>,
    /// Outputs that are drawn into the host's images, and in which format.
    pub(crate) drawn: Vec<(String, TextureFormat)>,
    /// The host's images in the last frame, by the names of inputs and of outputs.
    pub(crate) inputs: Vec<NamedView>,
    pub(crate) outputs: Vec<NamedView>,
}

impl PreviousPlan {
    /// The format in which the host's image makes the pass that writes this image draw.
    pub(crate) fn format_of(&self, plan: &Plan, image: Option<ImageId>) -> Option<TextureFormat> {
        let output = plan.outputs.iter().find(|output| Some(output.image) == image)?;
        self.drawn.iter().find(|(name, _)| *name == output.name).map(|(_, format)| *format)
    }
}
