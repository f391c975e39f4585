//! The swap chain of the window.

use std::sync::Arc;

use afterimage_gpu::{Gpu, wgpu};
use winit::window::Window;

use crate::Problem;

/// The swap chain, and how it is configured.
pub(super) struct Surface {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    /// Whether the configuration is to be given to the device before the next frame.
    is_stale: bool,
}

impl Surface {
    /// Opens a device, and a swap chain on it.
    pub(super) fn open(window: &Arc<Window>, adapter: Option<&str>) -> Result<(Gpu, Self), Problem> {
        let display = Box::new(window.clone());
        let mut descriptor = wgpu::InstanceDescriptor::new_with_display_handle(display);
        descriptor.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(descriptor);
        let said = |error: &dyn std::fmt::Display| Problem::said(format!("the window has no swap chain: {error}"));
        let surface = instance.create_surface(window.clone()).map_err(|error| said(&error))?;
        let gpu = pollster::block_on(Gpu::open_on(&instance, adapter))?;
        let size = window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let config = surface.get_default_config(&gpu.adapter, width, height).ok_or_else(|| {
            Problem::said(format!("`{}` cannot draw into this window", gpu.name()))
                .hint("name another adapter with `--adapter`")
        })?;
        // The user interface and encoded pictures are encoded by themselves.
        let format = config.format.remove_srgb_suffix();
        let config = wgpu::SurfaceConfiguration { format, desired_maximum_frame_latency: 1, ..config };
        Ok((gpu, Self { surface, config, is_stale: true }))
    }

    pub(super) fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// The window has another size; a side of 0 is a window that is minimised.
    pub(super) fn resize(&mut self, size: [u32; 2]) {
        (self.config.width, self.config.height, self.is_stale) = (size[0], size[1], true);
    }

    /// The texture of the next frame; `None` while nothing can be seen.
    pub(super) fn next(&mut self, gpu: &Gpu) -> Option<wgpu::SurfaceTexture> {
        if self.config.width == 0 || self.config.height == 0 {
            return None;
        }
        if std::mem::take(&mut self.is_stale) {
            self.surface.configure(&gpu.device, &self.config);
        }
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) => Some(texture),
            wgpu::CurrentSurfaceTexture::Suboptimal(texture) => {
                self.is_stale = true;
                Some(texture)
            }
            wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Lost => {
                self.is_stale = true;
                None
            }
            _ => None,
        }
    }
}
