//! One channel of a picture, and its convolution.

use rayon::prelude::*;

#[derive(Clone)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) data: Vec<f32>,
}

impl Plane {
    pub(super) fn new(width: usize, data: Vec<f32>) -> Self {
        Self { width, data }
    }

    /// Convolves rows with `across` and then columns with `down`; beyond an edge the pixels of the edge are repeated.
    ///
    /// Kernels have an odd length and are given as they are laid over the picture, left to right and top to bottom.
    pub(super) fn convolved(&self, across: &[f32], down: &[f32]) -> Self {
        self.along_rows(across).along_columns(down)
    }

    fn along_rows(&self, kernel: &[f32]) -> Self {
        let (width, radius) = (self.width, kernel.len() / 2);
        let mut data = vec![0.0; self.data.len()];
        data.par_chunks_mut(width).zip(self.data.par_chunks(width)).for_each(|(to, from)| {
            let mut padded = vec![from[0]; radius];
            padded.extend_from_slice(from);
            padded.resize(width + 2 * radius, from[width - 1]);
            for (x, to) in to.iter_mut().enumerate() {
                *to = padded[x..].iter().zip(kernel).map(|(value, weight)| value * weight).sum();
            }
        });
        Self { width, data }
    }

    fn along_columns(&self, kernel: &[f32]) -> Self {
        let (width, radius) = (self.width, kernel.len() / 2);
        let height = self.data.len() / width;
        let mut data = vec![0.0; self.data.len()];
        data.par_chunks_mut(width).enumerate().for_each(|(y, to)| {
            for (tap, weight) in kernel.iter().enumerate() {
                let row = (y + tap).saturating_sub(radius).min(height - 1);
                let from = &self.data[row * width..][..width];
                to.iter_mut().zip(from).for_each(|(to, value)| *to += value * weight);
            }
        });
        Self { width, data }
    }
}

/// Samples of a Gaussian of that deviation, their sum 1.
pub(super) fn gaussian(deviation: f64, radius: usize) -> Vec<f32> {
    let weights: Vec<f64> = offsets(radius).map(|x| (-x * x / (2.0 * deviation * deviation)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| (weight / sum) as f32).collect()
}

/// The places of a kernel's samples, in pixels from its middle.
pub(super) fn offsets(radius: usize) -> impl Iterator<Item = f64> {
    (0..=2 * radius).map(move |at| at as f64 - radius as f64)
}
