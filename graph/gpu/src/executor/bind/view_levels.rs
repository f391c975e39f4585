//! The mip levels of the host's views. wgpu has no query for them, so they are stated or found by trial.

use wgpu::{Device, Extent3d, TextureDimension, TextureFormat, TextureUsages, TextureView};

use crate::error::GpuError;
use crate::executor::frame::{Frame, size_of_level};
use crate::platform::{caught, watched};

/// Views whose levels are remembered: a chain of them.
const MAX_VIEWS: usize = 32;

/// The levels of views of textures with several.
#[derive(Default)]
pub(crate) struct ViewLevels(Vec<(TextureView, u32)>);

impl ViewLevels {
    /// The first mip level of each view of a frame whose texture has several.
    ///
    /// # Errors
    /// It is not known, or the texture has no such level.
    pub(crate) fn of<'f>(&mut self, device: &Device, frame: &Frame<'f>) -> Result<Vec<(&'f str, u32)>, GpuError> {
        let mut levels = Vec::new();
        for (name, view) in frame.views() {
            let count = view.texture().mip_level_count();
            let unfit = |why: String| GpuError::unfit(name, why);
            match frame.stated_level(name) {
                Some(level) if level < count => levels.push((name, level)),
                Some(level) => return Err(unfit(format!("the level {level} is stated, and its texture has {count}"))),
                None if count == 1 => {}
                None => levels.push((name, self.find(device, view).ok_or_else(|| {
                    unfit(format!(
                        "its texture has {count} levels, and which one its view begins with is not known: state it, \
                         `levels: &[(\"{name}\", 0)]` in `Frame`"
                    ))
                })?)),
            }
        }
        Ok(levels)
    }

    fn find(&mut self, device: &Device, view: &TextureView) -> Option<u32> {
        if let Some((_, level)) = self.0.iter().find(|(known, _)| known == view) {
            return Some(*level);
        }
        let texture = view.texture();
        let can_be_tried = cfg!(not(target_family = "wasm"))
            && texture.usage().contains(TextureUsages::RENDER_ATTACHMENT)
            && texture.dimension() == TextureDimension::D2;
        let mut levels = (0..texture.mip_level_count()).filter(|_| can_be_tried);
        let level = levels.find(|level| has_level(device, view, *level).is_ok())?;
        if self.0.len() == MAX_VIEWS {
            self.0.remove(0);
        }
        self.0.push((view.clone(), level));
        Some(level)
    }
}

/// Records an empty draw into the view and a texture of the size of that level, without submitting it: the device
/// refuses attachments of different sizes.
fn has_level(device: &Device, view: &TextureView, level: u32) -> Result<(), GpuError> {
    let what = "the level of a view";
    watched(device, what, || {
        let size = size_of_level(view.texture(), level);
        let beside = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(what),
            size: Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: view.texture().sample_count(),
            dimension: TextureDimension::D2,
            format: TextureFormat::R8Unorm,
            usage: TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let beside = beside.create_view(&Default::default());
        let color = |view| {
            let ops = wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        let format = view.texture().format();
        let is_depth = format.is_depth_stencil_format();
        let colors = [color(&beside), color(view)];
        let load = || wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: format.has_depth_aspect().then(load),
            stencil_ops: format
                .has_stencil_aspect()
                .then_some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(what),
            color_attachments: if is_depth { &colors[..1] } else { &colors },
            depth_stencil_attachment: is_depth.then_some(depth),
            ..Default::default()
        }));
        caught(what, || drop(encoder.finish()))
    })
}
