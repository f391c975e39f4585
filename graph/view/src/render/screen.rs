//! HDR screens: conversion from the viewer's colors to the color space of the swap chain.
//!
//! The viewer draws sRGB signals that may leave 0 to 1: 1 is SDR white, and colors outside of Rec.709 have negative
//! numbers. A last pass converts them.

use afterimage_gpu::Gpu;
use afterimage_gpu::wgpu::{self, SurfaceColorSpace};
use afterimage_graph::color::{Chromaticities, hlg_gamma};
use bytemuck::{Pod, Zeroable};

use super::device::{full_screen, image, module, onto, uniform};

/// The luminance of SDR white in cd/m2 where the system does not state it: ITU-R BT.2408.
pub const SDR_WHITE: f64 = 203.0;
/// The luminance that 1 stands for in scRGB on Windows, in cd/m2.
const SCRGB_UNIT: f64 = 80.0;
/// The luminance that 1 stands for in PQ.
const PQ_UNIT: f64 = 10_000.0;
/// The nominal peak of HLG.
const HLG_PEAK: f64 = 1000.0;

#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Numbers {
    rows: [[f32; 4]; 3],
    encoding: u32,
    white: f32,
    gamma: f32,
    unused: f32,
}

impl Numbers {
    /// For a color space, where `white` is the luminance of SDR white in cd/m2, and `is_absolute` states whether 1 in
    /// scRGB is a luminance, as on Windows, and not SDR white.
    fn of(space: SurfaceColorSpace, white: f64, is_absolute: bool) -> Self {
        let (primaries, encoding, unit) = match space {
            SurfaceColorSpace::ExtendedSrgbLinear => {
                (Chromaticities::REC709, 0, if is_absolute { SCRGB_UNIT } else { white })
            }
            SurfaceColorSpace::DisplayP3 | SurfaceColorSpace::ExtendedDisplayP3 => {
                (Chromaticities::DISPLAY_P3, 1, white)
            }
            SurfaceColorSpace::Bt2100Pq => (Chromaticities::REC2020, 2, PQ_UNIT),
            SurfaceColorSpace::Bt2100Hlg => (Chromaticities::REC2020, 3, HLG_PEAK),
            _ => (Chromaticities::REC709, 1, white),
        };
        let rows = Chromaticities::REC709.conversion(&primaries).transpose().to_cols_array_2d();
        let row = |row: [f64; 3]| [row[0] as f32, row[1] as f32, row[2] as f32, 0.0];
        Self {
            rows: rows.map(row),
            encoding,
            white: (white / unit) as f32,
            gamma: hlg_gamma(HLG_PEAK) as f32,
            unused: 0.0,
        }
    }
}

/// The image that the viewer draws into, and its conversion.
pub struct Screen {
    device: wgpu::Device,
    pipeline: wgpu::RenderPipeline,
    numbers: wgpu::Buffer,
    drawn: Option<wgpu::Texture>,
}

/// The format that the viewer draws in for such a screen.
pub const DRAWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DRAWN_USAGES: wgpu::TextureUsages =
    wgpu::TextureUsages::RENDER_ATTACHMENT.union(wgpu::TextureUsages::TEXTURE_BINDING);

impl Screen {
    /// For swap chains of a format and a color space. `white` is the luminance of SDR white in cd/m2.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat, space: SurfaceColorSpace, white: f64) -> Self {
        let device = &gpu.device;
        let shader = module(device, "screen", &[include_str!("screen.wgsl")]);
        let pipeline = full_screen(device, None, &shader, "convert", format);
        let numbers = Numbers::of(space, white, cfg!(target_os = "windows"));
        Self { device: device.clone(), pipeline, numbers: uniform(gpu, "screen", &numbers), drawn: None }
    }

    /// The image that the viewer draws into, for a window of that size.
    pub fn drawn(&mut self, size: [u32; 2]) -> wgpu::TextureView {
        let fits = |texture: &wgpu::Texture| [texture.width(), texture.height()] == size;
        let texture = match self.drawn.take().filter(fits) {
            Some(texture) => texture,
            None => image(&self.device, "drawn", size, DRAWN, DRAWN_USAGES),
        };
        self.drawn.insert(texture).create_view(&Default::default())
    }

    /// Records the conversion of what was drawn.
    pub fn convert(&self, encoder: &mut wgpu::CommandEncoder, drawn: &wgpu::TextureView, to: &wgpu::TextureView) {
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("screen"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.numbers.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(drawn) },
            ],
        });
        let mut pass = onto(encoder, "screen", to);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}
