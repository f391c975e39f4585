//! A coarse grid of the picture's numbers, for the scopes.

use afterimage_gpu::wgpu;
use half::f16;

use super::device::{self, onto};
use super::picture::{GRID_FORMAT, Painter, Placement, Shown};
use super::readback::Readback;

/// Columns and rows of the grid. A row is a multiple of the alignment of copies.
pub const GRID: [u32; 2] = [256, 144];
/// Bytes of a texel of the grid.
const TEXEL: u32 = 8;

/// Reads a grid of the picture, a few frames late.
pub struct Grid {
    target: wgpu::Texture,
    pending: Option<Readback>,
}

impl Grid {
    /// A grid on a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = device::image(device, "grid of the scopes", GRID, GRID_FORMAT, usage);
        Self { target, pending: None }
    }

    /// Samples an image. Returns false while an earlier grid has not arrived yet.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        painter: &Painter,
        encoder: &mut wgpu::CommandEncoder,
        image: &wgpu::Texture,
        slice: u32,
    ) -> bool {
        if self.pending.is_some() {
            return false;
        }
        let mut placement: Placement = bytemuck::Zeroable::zeroed();
        placement.extent = GRID.map(|side| side as f32);
        placement.slice = slice;
        let drawn = painter.sampled(&Shown { image, other: None, placement });
        let view = self.target.create_view(&Default::default());
        let mut pass = onto(encoder, "grid of the scopes", &view);
        drawn.draw(&mut pass);
        drop(pass);
        let readback = Readback::new(device, u64::from(GRID[0] * GRID[1] * TEXEL));
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(GRID[0] * TEXEL),
            rows_per_image: Some(GRID[1]),
        };
        let to = wgpu::TexelCopyBufferInfo { buffer: &readback.buffer, layout };
        encoder.copy_texture_to_buffer(self.target.as_image_copy(), to, self.target.size());
        self.pending = Some(readback);
        true
    }

    /// Requests the grid that was sampled; call it after the commands are submitted.
    pub fn request(&mut self) {
        if let Some(readback) = &mut self.pending {
            readback.request();
        }
    }

    /// The numbers, row by row, once they have arrived; alpha is the number of texels with NaN or infinities around
    /// each, in all slices.
    pub fn take(&mut self) -> Option<Vec<[f32; 4]>> {
        let bytes = self.pending.as_ref()?.bytes()?;
        self.pending = None;
        let texels = bytes.chunks_exact(TEXEL as usize);
        Some(
            texels
                .map(|texel| {
                    let halves: [u16; 4] = bytemuck::pod_read_unaligned(texel);
                    halves.map(|bits| f16::from_bits(bits).to_f32())
                })
                .collect(),
        )
    }
}
