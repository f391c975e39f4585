//! Coefficients to samples, and samples to pixels (ITU-T T.81, A.3.3, and JFIF).

use std::f64::consts::PI;

use rayon::prelude::*;

use super::scan::Component;
use super::segments::ColorModel;
use crate::codec::CodecError;
use crate::codec::limits::zeroed;

/// The samples of a component.
pub(super) struct Plane {
    samples: Vec<u8>,
    /// Samples from one row to the next.
    stride: usize,
    size: [usize; 2],
    /// Pixels of a sample, across and down.
    scale: [usize; 2],
}

impl Plane {
    /// # Errors
    /// No memory.
    pub(super) fn new(component: Component, max_sampling: [usize; 2]) -> Result<Self, CodecError> {
        let stride = 8 * component.blocks[0];
        let mut samples = zeroed::<u8>(64 * component.number_of_blocks())?;
        let table = component.quantization.unwrap_or([1; 64]).map(f32::from);
        let basis = basis();
        let rows = samples.par_chunks_exact_mut(8 * stride).zip(component.coefficients.par_chunks_exact(stride / 8));
        rows.for_each(|(rows, blocks)| {
            for (x, block) in blocks.iter().enumerate() {
                let samples = inverse_dct(block, &table, &basis);
                for (row, samples) in rows.chunks_exact_mut(stride).zip(samples) {
                    row[8 * x..][..8].copy_from_slice(&samples);
                }
            }
        });
        let scale = [0, 1].map(|axis| max_sampling[axis] / component.sampling[axis]);
        Ok(Self { samples, stride, size: component.size, scale })
    }

    fn row(&self, y: usize) -> &[u8] {
        &self.samples[y.min(self.size[1] - 1) * self.stride..][..self.size[0]]
    }

    /// A row in full resolution. Halved components are smoothed as libjpeg does: a pixel has three quarters of the
    /// nearest sample and one quarter of the next; all others are repeated.
    fn pixels(&self, y: usize, out: &mut [u8]) {
        let [across, down] = self.scale;
        let nearest = self.row(y / down);
        let smooths_rows = down == 2 && across <= 2 && (across == 1 || self.size[0] > 2);
        let smooths_columns = across == 2 && down <= 2 && self.size[0] > 2;
        let next = if !smooths_rows {
            nearest
        } else if y.is_multiple_of(2) {
            self.row((y / 2).saturating_sub(1))
        } else {
            self.row(y / 2 + 1)
        };
        // Sixteenths of a code, or quarters where only one direction is smoothed.
        let column = |x: usize| {
            let [nearest, next] = [nearest[x], next[x]].map(u32::from);
            if smooths_rows { 3 * nearest + next } else { nearest }
        };
        let last = self.size[0] - 1;
        if !smooths_columns {
            for (x, pixel) in out.iter_mut().enumerate() {
                let sum = column((x / across).min(last));
                *pixel = (if smooths_rows { (sum + 1 + y as u32 % 2) >> 2 } else { sum }) as u8;
            }
            return;
        }
        let shift = if smooths_rows { 4 } else { 2 };
        for (x, pixel) in out.iter_mut().enumerate() {
            let at = x / 2;
            let beside = if x % 2 == 0 { at.saturating_sub(1) } else { (at + 1).min(last) };
            // Ties are rounded up and down in turn.
            let half = if smooths_rows { 8 - x as u32 % 2 } else { 1 + x as u32 % 2 };
            *pixel = ((3 * column(at) + column(beside) + half) >> shift) as u8;
        }
    }
}

/// The cosines of the transform: by frequency, and then by place.
fn basis() -> [[f32; 8]; 8] {
    let scale = |frequency: usize| if frequency == 0 { 0.125_f64.sqrt() } else { 0.5 };
    let cosine = |frequency: usize, at: usize| ((2 * at + 1) as f64 * frequency as f64 * PI / 16.0).cos();
    std::array::from_fn(|frequency| std::array::from_fn(|at| (scale(frequency) * cosine(frequency, at)) as f32))
}

fn inverse_dct(block: &[i16; 64], table: &[f32; 64], basis: &[[f32; 8]; 8]) -> [[u8; 8]; 8] {
    if block[1..].iter().all(|coefficient| *coefficient == 0) {
        return [[code(f32::from(block[0]) * table[0] / 8.0); 8]; 8];
    }
    // Along rows, for each vertical frequency.
    let mut half = [[0.0_f32; 8]; 8];
    for (v, row) in half.iter_mut().enumerate() {
        for (u, cosines) in basis.iter().enumerate() {
            let coefficient = f32::from(block[8 * v + u]) * table[8 * v + u];
            if coefficient != 0.0 {
                row.iter_mut().zip(cosines).for_each(|(sum, cosine)| *sum += coefficient * cosine);
            }
        }
    }
    std::array::from_fn(|y| {
        let mut sums = [0.0_f32; 8];
        for (v, row) in half.iter().enumerate() {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += basis[v][y] * value);
        }
        sums.map(code)
    })
}

fn code(sample: f32) -> u8 {
    (sample + 128.5).floor().clamp(0.0, 255.0) as u8
}

/// The pixels of all planes: gray, RGB, or CMYK as the file has it.
///
/// # Errors
/// No memory.
pub(super) fn interleaved(
    planes: &[Plane],
    model: ColorModel,
    [width, height]: [usize; 2],
) -> Result<Vec<u8>, CodecError> {
    let channels = planes.len();
    let mut pixels = zeroed::<u8>(width * height * channels)?;
    pixels.par_chunks_exact_mut(width * channels).enumerate().for_each_init(
        || vec![0; width],
        |row, (y, out)| {
            for (channel, plane) in planes.iter().enumerate() {
                plane.pixels(y, row);
                out.iter_mut().skip(channel).step_by(channels).zip(&*row).for_each(|(code, sample)| *code = *sample);
            }
            if matches!(model, ColorModel::YCbCr | ColorModel::Ycck) {
                out.chunks_exact_mut(channels).for_each(to_rgb);
            }
        },
    );
    Ok(pixels)
}

/// YCbCr to RGB (JFIF), in 16 bits behind the point.
fn to_rgb(pixel: &mut [u8]) {
    let [y, blue, red] = [i32::from(pixel[0]), i32::from(pixel[1]) - 128, i32::from(pixel[2]) - 128];
    let code = |sum: i32| (y + ((sum + 0x8000) >> 16)).clamp(0, 255) as u8;
    let rgb = [code(91881 * red), code(-22554 * blue - 46802 * red), code(116_130 * blue)];
    pixel[..3].copy_from_slice(&rgb);
}
