//! A picture scaled into a frame of another size.

use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use crate::codec::{Picture, Pixels};

impl Picture {
    /// This picture scaled into `width` x `height` pixels: as large as fits with its aspect ratio, in the middle, and
    /// transparent black around it. The filter is a tent as wide as two pixels of the coarser grid.
    pub fn fitted(&self, width: u32, height: u32) -> Self {
        let scale = (f64::from(width) / f64::from(self.width)).min(f64::from(height) / f64::from(self.height));
        let (inner_width, inner_height) = (side(self.width, scale).min(width), side(self.height, scale).min(height));
        let [inner_width, inner_height, width, height] = [inner_width, inner_height, width, height].map(|n| n as usize);
        let scaled = self.resampled(inner_width, inner_height);
        let (left, top) = ((width - inner_width) / 2, (height - inner_height) / 2);
        let mut out = vec![[0.0_f32; 4]; width * height];
        for (row, pixels) in scaled.chunks_exact(inner_width).enumerate() {
            out[(top + row) * width + left..][..inner_width].copy_from_slice(pixels);
        }
        self.with_pixels(width as u32, height as u32, out)
    }

    /// This picture with sides that are `share` of its own, with the same filter.
    pub fn scaled_by(&self, share: f64) -> Self {
        self.scaled(side(self.width, share), side(self.height, share))
    }

    /// This picture in `width` x `height` pixels, whatever its aspect ratio, with the same filter.
    pub fn scaled(&self, width: u32, height: u32) -> Self {
        self.with_pixels(width, height, self.resampled(width as usize, height as usize))
    }

    fn resampled(&self, width: usize, height: usize) -> Vec<[f32; 4]> {
        let values = self.pixels.to_f32();
        let narrow = scale_rows(values.as_chunks::<4>().0, self.width as usize, width);
        scale_columns(&narrow, width, height)
    }

    /// The attributes and notes of this picture, with other pixels of the same type.
    fn with_pixels(&self, width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Self {
        let floats = pixels.into_flattened();
        let pixels = match self.pixels {
            Pixels::Half(_) => {
                let mut halves = vec![f16::ZERO; floats.len()];
                halves.convert_from_f32_slice(&floats);
                Pixels::Half(halves)
            }
            Pixels::Float(_) => Pixels::Float(floats),
        };
        let scaled = Self::new(width, height, pixels);
        Self { meta: self.meta.clone(), stated: self.stated, notes: self.notes.clone(), ..scaled }
    }
}

/// A share of a side; never 0.
fn side(pixels: u32, share: f64) -> u32 {
    (f64::from(pixels) * share).round().max(1.0) as u32
}

/// The source samples of one target sample: the index of the first, and their weights.
type Tap = (usize, Vec<f32>);

/// A tent around the center of each sample of the grid of `to` samples, over that of `from`.
fn taps(from: usize, to: usize) -> Vec<Tap> {
    let ratio = from as f64 / to as f64;
    let radius = ratio.max(1.0);
    let tap = |index: usize| {
        let center = (index as f64 + 0.5) * ratio;
        let first = (center - radius).floor().max(0.0) as usize;
        let last = ((center + radius).ceil() as usize).min(from);
        let weight = |at: usize| (1.0 - (at as f64 + 0.5 - center).abs() / radius).max(0.0);
        let sum: f64 = (first..last).map(weight).sum();
        (first, (first..last).map(|at| (weight(at) / sum) as f32).collect())
    };
    (0..to).map(tap).collect()
}

fn scale_rows(pixels: &[[f32; 4]], width: usize, to: usize) -> Vec<[f32; 4]> {
    let taps = taps(width, to);
    let rows = pixels.par_chunks_exact(width);
    rows.flat_map_iter(|row| taps.iter().map(|(first, weights)| weighted(weights, row[*first..].iter()))).collect()
}

fn scale_columns(pixels: &[[f32; 4]], width: usize, to: usize) -> Vec<[f32; 4]> {
    let taps = taps(pixels.len() / width, to);
    let row = |(first, weights): &Tap| {
        let (first, weights) = (*first, weights.clone());
        (0..width).map(move |x| weighted(&weights, pixels[first * width + x..].iter().step_by(width)))
    };
    taps.par_iter().flat_map_iter(row).collect()
}

/// Samples of weight 0 are skipped, because they may be infinite.
fn weighted<'p>(weights: &[f32], samples: impl Iterator<Item = &'p [f32; 4]>) -> [f32; 4] {
    let mut sum = [0.0; 4];
    for (weight, sample) in weights.iter().zip(samples).filter(|(weight, _)| **weight > 0.0) {
        sum.iter_mut().zip(sample).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}
