//! Encoded pixels to the codes of a file: the only place where files are rounded and dithered.

use afterimage_base::color::{Colorimetry, Decimal, Transfer, hlg_gamma};
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use crate::codec::limits::zeroed;
use crate::codec::{CodecError, Pixels};

/// Interleaved RGBA of an image to be written. Encoded ones are numbers in [0, 1] after the transfer function, or codes
/// of eight bits.
#[derive(Debug, Clone, Copy)]
pub enum Samples<'a> {
    /// 16-bit floats.
    Half(&'a [f16]),
    /// 32-bit floats.
    Float(&'a [f32]),
    /// Codes 0 to 255. They are rounded already, so no dither applies.
    Byte(&'a [u8]),
}

impl<'a> From<&'a Pixels> for Samples<'a> {
    fn from(pixels: &'a Pixels) -> Self {
        match pixels {
            Pixels::Half(values) => Self::Half(values),
            Pixels::Float(values) => Self::Float(values),
        }
    }
}

impl Samples<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Half(values) => values.len(),
            Self::Float(values) => values.len(),
            Self::Byte(values) => values.len(),
        }
    }

    /// The samples from this one on; codes as floats.
    pub(crate) fn rest(&self, first: usize) -> Pixels {
        match self {
            Self::Half(values) => Pixels::Half(values[first..].to_vec()),
            Self::Float(values) => Pixels::Float(values[first..].to_vec()),
            Self::Byte(codes) => Pixels::Float(codes[first..].iter().map(|code| f32::from(*code) / 255.0).collect()),
        }
    }

    /// One row as floats, in `scratch`.
    pub(crate) fn row<'s>(&'s self, row: std::ops::Range<usize>, scratch: &'s mut [f32]) -> &'s [f32] {
        match self {
            Self::Float(values) => return &values[row],
            Self::Half(values) => values[row].convert_to_f32_slice(scratch),
            Self::Byte(codes) => {
                scratch.iter_mut().zip(&codes[row]).for_each(|(value, code)| *value = f32::from(*code) / 255.0);
            }
        }
        scratch
    }

    /// True if a pixel has an alpha that is not 1 after rounding to that number of bits.
    pub(crate) fn has_alpha(&self, bits: u32) -> bool {
        let last = last_code(bits);
        self.any(|pixel| nearest(pixel[3], last) != last)
    }

    /// True if there is such a pixel.
    pub(crate) fn any(&self, is_one: impl Fn([f32; 4]) -> bool + Sync) -> bool {
        match self {
            Self::Half(values) => values.as_chunks::<4>().0.par_iter().any(|pixel| is_one(pixel.map(f16::to_f32))),
            Self::Float(values) => values.as_chunks::<4>().0.par_iter().any(|pixel| is_one(*pixel)),
            Self::Byte(codes) => {
                codes.as_chunks::<4>().0.par_iter().any(|pixel| is_one(pixel.map(|code| f32::from(code) / 255.0)))
            }
        }
    }
}

/// The conversion of numbers to codes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantizer {
    /// Bits of a code, 1 to 16.
    pub(crate) bits: u32,
    /// Seed of the noise; `None` rounds to the nearest code. Alpha is never dithered.
    pub(crate) dither: Option<u32>,
    /// 3 for RGB, 4 for RGBA.
    pub(crate) channels: usize,
    /// The index of the next row in the image.
    pub(crate) first_row: u32,
    /// The colorimetry of premultiplied color, which becomes straight where alpha is written; `None` leaves colors as
    /// they are.
    pub(crate) premultiplied: Option<Premultiplied>,
}

/// Color that was multiplied by its alpha while it was linear, before it was encoded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Premultiplied {
    transfer: Transfer,
    /// HLG encodes scene-linear values, which are those of the display to this power.
    power: f64,
}

impl Premultiplied {
    /// Color with this colorimetry; linear if there is none.
    pub(crate) fn new(color: Option<Colorimetry>) -> Self {
        let transfer = color.map_or(Transfer::Linear, |color| color.transfer);
        let peak = color.and_then(|color| color.peak_nits).map_or(1000.0, Decimal::get);
        Self { transfer, power: if transfer == Transfer::Hlg { 1.0 / hlg_gamma(peak) } else { 1.0 } }
    }

    /// True if the straight color of a pixel is clipped: it would be brighter than white by a code, or has no alpha.
    pub(crate) fn is_cut(self, [r, g, b, alpha]: [f32; 4], bits: u32) -> bool {
        let last = last_code(bits);
        let brightest = r.max(g).max(b);
        if nearest(alpha, last) == 0.0 {
            return nearest(brightest, last) > 0.0;
        }
        let light = self.transfer.to_light(brightest.into()) / f64::from(alpha.min(1.0)).powf(self.power);
        alpha < 1.0 && light > 1.0 + 1.0 / f64::from(alpha * last)
    }

    /// The color that gives this one when it is multiplied by alpha: the straight color of a PNG. Color without alpha
    /// is black. Light beyond what alpha holds is cut, as straight color cannot be brighter than white.
    fn straight(self, [r, g, b, alpha]: [f32; 4], last: f32) -> [f32; 4] {
        if nearest(alpha, last) == 0.0 {
            return [0.0, 0.0, 0.0, alpha];
        }
        if alpha.is_nan() || alpha >= 1.0 {
            return [r, g, b, alpha];
        }
        let scale = f64::from(alpha).powf(self.power);
        let [r, g, b] =
            [r, g, b].map(|signal| self.transfer.to_signal(self.transfer.to_light(signal.into()) / scale) as f32);
        [r, g, b, alpha]
    }
}

impl Quantizer {
    /// The codes of the next rows of this width.
    pub(crate) fn next_codes(&mut self, width: u32, rows: Samples<'_>) -> Result<Vec<u16>, CodecError> {
        let height = (rows.len() / 4 / width as usize) as u32;
        let codes = self.codes((width, height), rows)?;
        self.first_row += height;
        Ok(codes)
    }

    /// The codes of rows of `size`, without gaps.
    pub(crate) fn codes(self, size: (u32, u32), pixels: Samples<'_>) -> Result<Vec<u16>, CodecError> {
        let (width, height) = (size.0 as usize, size.1 as usize);
        assert_eq!(pixels.len(), width * height * 4, "four numbers for a pixel");
        let dither = self.dither.filter(|_| !matches!(pixels, Samples::Byte(_)));
        let mut codes = zeroed::<u16>(width * height * self.channels)?;
        let rows = codes.par_chunks_exact_mut(width * self.channels).enumerate();
        rows.for_each_init(
            || vec![0.0; width * 4],
            |scratch, (y, out)| {
                let row = pixels.row(y * width * 4..(y + 1) * width * 4, scratch);
                match dither {
                    Some(seed) => self.dithered_row(row, self.first_row + y as u32, seed, out),
                    None => self.rounded_row(row, out),
                }
            },
        );
        Ok(codes)
    }

    fn rounded_row(self, row: &[f32], out: &mut [u16]) {
        let last = last_code(self.bits);
        for (pixel, out) in row.as_chunks::<4>().0.iter().zip(out.chunks_exact_mut(self.channels)) {
            let pixel = self.written(*pixel);
            out.iter_mut().zip(pixel).for_each(|(code, value)| *code = nearest(value, last) as u16);
        }
    }

    /// The channels of a pixel as the file stores them.
    fn written(self, pixel: [f32; 4]) -> [f32; 4] {
        match self.premultiplied {
            Some(color) if self.channels == 4 => color.straight(pixel, last_code(self.bits)),
            _ => pixel,
        }
    }

    fn dithered_row(self, row: &[f32], y: u32, seed: u32, out: &mut [u16]) {
        let last = last_code(self.bits);
        for ((x, pixel), out) in (0..).zip(row.as_chunks::<4>().0).zip(out.chunks_exact_mut(self.channels)) {
            let pixel = self.written(*pixel);
            for ((code, value), random) in out.iter_mut().zip(pixel).zip(hash3([x, y, seed])) {
                *code = dithered(value, last, random) as u16;
            }
            if let Some(alpha) = out.get_mut(3) {
                *alpha = nearest(pixel[3], last) as u16;
            }
        }
    }
}

fn last_code(bits: u32) -> f32 {
    ((1_u32 << bits) - 1) as f32
}

/// The nearest code up to `last`. NaN passes, and casting to an integer makes it 0.
fn nearest(value: f32, last: f32) -> f32 {
    (value.clamp(0.0, 1.0) * last + 0.5).floor()
}

/// A code with the noise of the node `Dither`: triangular, one code to either side, so that neither the mean nor the
/// variance of the error depends on the value. It fades to one code's width of uniform noise at the ends, so that solid
/// black and solid white stay solid. `random` holds two 16-bit numbers.
pub(crate) fn dithered(value: f32, last: f32, random: u32) -> f32 {
    let centered = |bits: u32| bits as f32 / 65536.0 - 0.5;
    let code = value.clamp(0.0, 1.0) * last;
    let inside = (code.min(last - code) * 2.0).clamp(0.0, 1.0);
    let noise = centered(random >> 16) + inside * centered(random & 0xffff);
    (code + noise + 0.5).floor().clamp(0.0, last)
}

/// PCG3D (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020), as in `shaders/lib/noise.wgsl`.
fn hash3(seed: [u32; 3]) -> [u32; 3] {
    let [mut x, mut y, mut z] = seed.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |x: &mut u32, y: &mut u32, z: &mut u32| {
        *x = x.wrapping_add(y.wrapping_mul(*z));
        *y = y.wrapping_add(z.wrapping_mul(*x));
        *z = z.wrapping_add(x.wrapping_mul(*y));
    };
    mix(&mut x, &mut y, &mut z);
    [x, y, z] = [x, y, z].map(|v| v ^ (v >> 16));
    mix(&mut x, &mut y, &mut z);
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::{dithered, hash3};

    /// The numbers of PCG3D by another program.
    #[test]
    fn the_vectors_of_the_hash() {
        assert_eq!(hash3([0, 0, 0]), [0x9baf_d7c6, 0xa8e8_8a6b, 0x3f15_482c]);
        assert_eq!(hash3([1, 2, 3]), [0xfa9f_79a6, 0x48f2_f44c, 0x596f_5ab1]);
    }

    #[test]
    fn the_vectors_of_the_dither() {
        // Value, two uniform numbers, code.
        let table = [
            (0.0, 0.9, 0.9, 0),
            (0.0, 0.1, 0.1, 0),
            (1.0, 0.9, 0.9, 255),
            (1.0, 0.1, 0.1, 255),
            (0.5, 0.5, 0.5, 128),
            (0.5, 0.99, 0.99, 128),
            (0.5, 0.01, 0.01, 127),
            (0.040_392_157, 0.2, 0.9, 10),
            (f32::INFINITY, 0.1, 0.1, 255),
            (-5.0, 0.9, 0.9, 0),
        ];
        for (value, u1, u2, code) in table {
            let [high, low] = [u1, u2].map(|u: f64| (u * 65536.0) as u32);
            assert_eq!(dithered(value, 255.0, high << 16 | low), code as f32, "{value} {u1} {u2}");
        }
    }
}
