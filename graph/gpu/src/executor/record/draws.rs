//! Commands of draws: full-screen ones of kernel functions, and those of drawing passes.

use afterimage_graph::node::{BufferId, ColorAttachment, DrawContents, DrawRange, Drawing, Draws, Geometry, Load};
use wgpu::{CommandEncoder, RenderPass, RenderPipeline};

use crate::executor::host_draw::{HostDraw, host_node};
use crate::executor::loaded::LoadedPlan;
use crate::executor::record::FrameCommands;
use crate::executor::rectangle::color_pass_in;
use crate::layout::Pipeline;

impl FrameCommands<'_> {
    /// Records a full-screen draw, whose result is one image.
    pub(super) fn record_full_screen(&self, pipeline: &RenderPipeline, index: usize, encoder: &mut CommandEncoder) {
        let [view] = self.groups.passes[index].attachments(self.ring_index) else {
            panic!("a full-screen draw has one attachment")
        };
        let label = self.loaded.label(index).or(Some("afterimage"));
        let mut pass = color_pass_in(encoder, label, view, self.loaded.scissor(index));
        self.bind_pipeline(pipeline, index, &mut pass);
        pass.draw(0..3, 0..1);
    }

    /// Records a drawing pass: its geometry, or what the host draws.
    pub(super) fn record_drawing(&self, index: usize, encoder: &mut CommandEncoder, draws: &mut [HostDraw<'_>]) {
        let (loaded, bound) = (self.loaded, &self.groups.passes[index]);
        let planned = &loaded.plan.passes[index];
        let drawing = planned.pass.drawing().expect("the plan draws in this pass");
        let views = bound.attachments(self.ring_index);
        let mut pass = begin(drawing, views, &planned.stores, loaded.label(index), encoder);
        if let (DrawContents::Geometry(geometry), Pipeline::Drawing(pipeline)) =
            (&drawing.contents, &bound.built.pipeline)
        {
            self.bind_pipeline(pipeline, index, &mut pass);
            draw(loaded, geometry, &mut pass);
        }
        if let Some(node) = host_node(&planned.pass) {
            let host = draws.iter_mut().find(|draw| draw.node == node).expect("each pass of the host has its draws");
            (host.fill)(&mut pass);
        }
    }

    /// Sets the pipeline of a draw, its bind group and the frame constants.
    fn bind_pipeline(&self, pipeline: &RenderPipeline, index: usize, pass: &mut RenderPass<'_>) {
        let loaded = self.loaded;
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, self.groups.passes[index].group(self.ring_index), loaded.frame_offset(index));
        if loaded.passes[index].immediate {
            pass.set_immediates(0, self.constants.bytes(loaded.uses_uninitialized(index)));
        }
    }
}

fn begin<'e>(
    drawing: &Drawing,
    views: &[wgpu::TextureView],
    stores: &[bool],
    label: Option<&str>,
    encoder: &'e mut CommandEncoder,
) -> RenderPass<'e> {
    let store = |at: usize| if stores[at] { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
    let color = |(at, color): (usize, &ColorAttachment)| {
        let load = match color.load {
            Load::Clear([r, g, b, a]) => wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
            Load::Keep => wgpu::LoadOp::Load,
        };
        Some(wgpu::RenderPassColorAttachment {
            view: &views[at],
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: store(at) },
        })
    };
    let colors: Vec<_> = drawing.colors.iter().enumerate().map(color).collect();
    let depth = drawing.depth.map(|depth| {
        let at = colors.len();
        let load = match depth.test.load {
            Load::Clear(value) => wgpu::LoadOp::Clear(value),
            Load::Keep => wgpu::LoadOp::Load,
        };
        wgpu::RenderPassDepthStencilAttachment {
            view: &views[at],
            depth_ops: Some(wgpu::Operations { load, store: store(at) }),
            stencil_ops: None,
        }
    });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: label.or(Some("afterimage")),
        color_attachments: &colors,
        depth_stencil_attachment: depth,
        ..Default::default()
    })
}

fn draw(loaded: &LoadedPlan, geometry: &Geometry, pass: &mut RenderPass<'_>) {
    let buffer = |buffer: BufferId| &loaded.residency.buffers[buffer.0 as usize];
    for (slot, vertices) in geometry.vertices.iter().enumerate() {
        pass.set_vertex_buffer(slot as u32, buffer(vertices.buffer).slice(..));
    }
    if let Some(indices) = geometry.indices {
        pass.set_index_buffer(buffer(indices).slice(..), wgpu::IndexFormat::Uint32);
    }
    match (&geometry.draws, geometry.indices.is_some()) {
        (Draws::Ranges(ranges), has_indices) => {
            for DrawRange { first, count, base_vertex, first_instance, instances } in ranges {
                let (drawn, instances) = (*first..first + count, *first_instance..first_instance + instances);
                if has_indices {
                    pass.draw_indexed(drawn, *base_vertex, instances);
                } else {
                    pass.draw(drawn, instances);
                }
            }
        }
        (Draws::Indirect(draws), true) => {
            pass.multi_draw_indexed_indirect(buffer(draws.buffer), draws.offset, draws.ranges);
        }
        (Draws::Indirect(draws), false) => {
            pass.multi_draw_indirect(buffer(draws.buffer), draws.offset, draws.ranges);
        }
    }
}
