//! The swap chain of the window.

use std::sync::Arc;

use afterimage_gpu::Gpu;
use afterimage_gpu::wgpu::{self, SurfaceColorSpace};
use winit::window::Window;

use crate::Problem;
use crate::render::{DRAWN, SDR_WHITE, Screen};

/// The color spaces of HDR screens, the best first, and the formats that they come with.
const SPACES: [(SurfaceColorSpace, wgpu::TextureFormat); 5] = [
    (SurfaceColorSpace::ExtendedSrgbLinear, wgpu::TextureFormat::Rgba16Float),
    (SurfaceColorSpace::ExtendedDisplayP3, wgpu::TextureFormat::Rgba16Float),
    (SurfaceColorSpace::ExtendedSrgb, wgpu::TextureFormat::Rgba16Float),
    (SurfaceColorSpace::Bt2100Pq, wgpu::TextureFormat::Rgb10a2Unorm),
    (SurfaceColorSpace::Bt2100Hlg, wgpu::TextureFormat::Rgb10a2Unorm),
];
/// The peak of an HDR screen that does not state it, in cd/m2.
const PEAK: f64 = 1000.0;

/// The swap chain, and how it is configured.
pub(super) struct Surface {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    /// The conversion for an HDR screen.
    screen: Option<Screen>,
    /// The peak luminance of the screen, where 1 is SDR white; `None` without HDR.
    headroom: Option<f32>,
    /// The surface must be configured before the next frame.
    is_stale: bool,
}

impl Surface {
    /// Opens a device, and a swap chain on it.
    pub(super) fn open(window: &Arc<Window>, adapter: Option<&str>) -> Result<(Gpu, Self), Problem> {
        let display = Box::new(window.clone());
        let mut descriptor = wgpu::InstanceDescriptor::new_with_display_handle(display);
        descriptor.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(descriptor);
        let no_swap_chain =
            |error: &dyn std::fmt::Display| Problem::message(format!("the window has no swap chain: {error}"));
        let surface = instance.create_surface(window.clone()).map_err(|error| no_swap_chain(&error))?;
        let gpu = pollster::block_on(Gpu::open_on(&instance, adapter))?;
        let size = window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let config = surface.get_default_config(&gpu.adapter, width, height).ok_or_else(|| {
            Problem::message(format!("`{}` cannot draw into this window", gpu.name()))
                .hint("name another adapter with `--adapter`")
        })?;
        // The user interface and encoded pictures are encoded by themselves.
        let format = config.format.remove_srgb_suffix();
        let config = wgpu::SurfaceConfiguration { format, desired_maximum_frame_latency: 1, ..config };
        let mut opened = Self { surface, config, screen: None, headroom: None, is_stale: true };
        opened.use_hdr(&gpu);
        Ok((gpu, opened))
    }

    /// Uses a color space for HDR, if the screen is one.
    fn use_hdr(&mut self, gpu: &Gpu) {
        let info = self.surface.display_hdr_info(&gpu.adapter);
        let is_hdr = info.coarse.and_then(|coarse| coarse.high_dynamic_range) == Some(true);
        let headroom = info.tone_map_headroom().filter(|headroom| *headroom > 1.0);
        let capabilities = self.surface.get_capabilities(&gpu.adapter);
        let found = SPACES.into_iter().find(|(space, format)| {
            space.to_color_spaces().is_some_and(|space| capabilities.color_spaces(*format).contains(space))
        });
        let Some((space, format)) = found.filter(|_| is_hdr || headroom.is_some()) else { return };
        let white = info.luminance.and_then(|luminance| luminance.sdr_white_nits).map_or(SDR_WHITE, f64::from);
        (self.config.format, self.config.color_space) = (format, space);
        self.screen = Some(Screen::new(gpu, format, space, white));
        self.headroom = Some(headroom.unwrap_or((PEAK / white) as f32));
    }

    /// The format that the viewer draws in.
    pub(super) fn format(&self) -> wgpu::TextureFormat {
        if self.screen.is_some() { DRAWN } else { self.config.format }
    }

    /// The peak luminance of the screen, where 1 is SDR white; `None` without HDR.
    pub(super) fn headroom(&self) -> Option<f32> {
        self.headroom
    }

    /// Draws a frame into a texture of the swap chain, by way of the conversion for an HDR screen.
    pub(super) fn draw<T>(
        &mut self,
        texture: &wgpu::Texture,
        draw: impl FnOnce(&wgpu::TextureView) -> T,
        gpu: &Gpu,
    ) -> T {
        let view = texture.create_view(&Default::default());
        let Some(screen) = &mut self.screen else { return draw(&view) };
        let drawn = screen.drawn([texture.width(), texture.height()]);
        let result = draw(&drawn);
        let mut encoder = gpu.encoder();
        screen.convert(&mut encoder, &drawn, &view);
        gpu.queue.submit([encoder.finish()]);
        result
    }

    /// The window has another size; a side of 0 is a window that is minimized.
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
