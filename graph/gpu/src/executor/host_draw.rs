//! Draws that a host records into passes of a plan.

use std::ops::Range;

use afterimage_graph::image::Size;
use afterimage_graph::node::{DrawContents, Pass};
use afterimage_plan::{Plan, PlannedPass};
use wgpu::{RenderPass, TextureFormat};

use crate::error::GpuError;
use crate::texture_format::texture_format;

/// Draws of a host in a pass of a plan: see `afterimage::Post::encode_drawing`.
pub struct HostDraw<'a> {
    /// The name of the node.
    pub node: &'a str,
    /// Records the draws. The pass has its attachments, which are those of [`DrawTargets`], and nothing else is set.
    pub fill: &'a mut dyn FnMut(&mut RenderPass<'_>),
}

/// The attachments of a pass that a host fills: what its pipelines are made for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawTargets {
    /// Pixels across and down.
    pub size: Size,
    /// The formats of the attachments for color.
    pub colors: Vec<TextureFormat>,
    /// The format of the attachment for depth.
    pub depth: Option<TextureFormat>,
    /// Samples in each pixel.
    pub samples: u32,
}

impl DrawTargets {
    /// The attachments of a node's pass; `None` if the plan has no such pass for the host.
    pub(crate) fn of(plan: &Plan, node: &str) -> Option<Self> {
        let pass = plan.work().find(|pass| host_node(pass) == Some(node))?;
        let drawing = pass.drawing()?;
        let first = drawing.targets().next()?;
        let format = |image| texture_format(plan.image(image).desc.format);
        let desc = plan.image(first.image).desc;
        Some(Self {
            size: desc.level(first.level).size,
            colors: drawing.colors.iter().map(|color| format(color.target.image)).collect(),
            depth: drawing.depth.map(|depth| format(depth.target.image)),
            samples: desc.samples,
        })
    }
}

/// The node whose host fills a pass; `None` for other passes.
pub(crate) fn host_node(pass: &Pass) -> Option<&str> {
    pass.drawing().filter(|drawing| drawing.contents == DrawContents::Host)?;
    pass.nodes.first().map(String::as_str)
}

/// True if the host fills passes of a plan.
pub fn has_host_draws(plan: &Plan) -> bool {
    plan.work().any(|pass| host_node(pass).is_some())
}

/// Each pass that the host fills has its draws.
pub(crate) fn check_filled(plan: &Plan, passes: Range<usize>, draws: &[HostDraw<'_>]) -> Result<(), GpuError> {
    let is_filled = |node: &str| draws.iter().any(|draw| draw.node == node);
    let nodes = plan.passes[passes].iter().filter_map(|PlannedPass { pass, .. }| host_node(pass));
    match nodes.into_iter().find(|node| !is_filled(node)) {
        None => Ok(()),
        Some(node) => Err(GpuError::MissingDraw(node.to_owned())),
    }
}
