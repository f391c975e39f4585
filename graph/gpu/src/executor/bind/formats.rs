//! The formats of the host's views.

use afterimage_plan::PlanOutput;
use wgpu::{Device, Texture, TextureFormat, TextureUsages, TextureView};

use crate::error::GpuError;
use crate::full_screen::color_pass;
use crate::platform::{caught, watched};

/// Kinds of textures whose formats are remembered: a host has few.
const MAX_KINDS: usize = 16;

/// The key of the format of a view. wgpu has no query for it, so it is found by trial.
#[derive(Clone, Copy, PartialEq)]
struct TextureKind {
    format: TextureFormat,
    /// The format of the view, if the host states it.
    stated: Option<TextureFormat>,
    usage: TextureUsages,
    samples: u32,
    levels: u32,
    layers: u32,
}

impl TextureKind {
    fn of(texture: &Texture) -> Self {
        Self {
            format: texture.format(),
            stated: None,
            usage: texture.usage(),
            samples: texture.sample_count(),
            levels: texture.mip_level_count(),
            layers: texture.depth_or_array_layers(),
        }
    }
}

/// The formats of the host's views that passes draw to.
#[derive(Default)]
pub(crate) struct HostFormats {
    known: Vec<(TextureKind, TextureFormat)>,
    /// Outputs that the last frame drew, and in which format: the next plan will, too.
    last: Vec<(String, TextureFormat)>,
}

impl HostFormats {
    /// Outputs that the last frame drew, and in which format.
    pub(crate) fn last(&self) -> &[(String, TextureFormat)] {
        &self.last
    }

    /// Remembers the formats of this frame; `None` for an output that a pass stores to.
    pub(crate) fn set_last(&mut self, outputs: &[PlanOutput], formats: &[Option<TextureFormat>]) {
        let drawn = outputs.iter().zip(formats).filter_map(|(output, format)| Some((&output.name, (*format)?)));
        if !drawn.clone().eq(self.last.iter().map(|(name, format)| (name, *format))) {
            self.last = drawn.map(|(name, format)| (name.clone(), format)).collect();
        }
    }

    /// The format of a view that is drawn to: the stated one, or else the texture's own or the same with or without
    /// sRGB, which is common for swap chains.
    ///
    /// # Errors
    /// The view cannot be drawn to.
    pub(crate) fn of_view(
        &mut self,
        device: &Device,
        port: &str,
        view: &TextureView,
        stated: Option<TextureFormat>,
    ) -> Result<TextureFormat, GpuError> {
        let kind = TextureKind { stated, ..TextureKind::of(view.texture()) };
        if let Some((_, format)) = self.known.iter().find(|(known, _)| *known == kind) {
            return Ok(*format);
        }
        let attempt = |format| draw_nothing(device, port, view, format);
        let other = if stated.is_some() { None } else { other_encoding(kind.format) };
        let first = stated.unwrap_or(kind.format);
        let format = match (attempt(first), other) {
            (Ok(()), _) => first,
            (Err(_), Some(other)) if attempt(other).is_ok() => other,
            (Err(refused), _) => return Err(refused),
        };
        if self.known.len() == MAX_KINDS {
            self.known.remove(0);
        }
        self.known.push((kind, format));
        Ok(format)
    }
}

fn other_encoding(format: TextureFormat) -> Option<TextureFormat> {
    [format.add_srgb_suffix(), format.remove_srgb_suffix()].into_iter().find(|other| *other != format)
}

/// Records an empty draw into the view without submitting it: the device reports whether it is valid.
fn draw_nothing(device: &Device, port: &str, view: &TextureView, format: TextureFormat) -> Result<(), GpuError> {
    let what = format!("the image given for `{port}`");
    watched(device, &what, || {
        let bundle = device.create_render_bundle_encoder(&wgpu::RenderBundleEncoderDescriptor {
            color_formats: &[Some(format)],
            sample_count: 1,
            ..Default::default()
        });
        let bundle = bundle.finish(&Default::default());
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = color_pass(&mut encoder, None, view, wgpu::LoadOp::Load);
        pass.execute_bundles([&bundle]);
        drop(pass);
        caught(&what, || drop(encoder.finish()))
    })
}
