//! Frames of AV1, and the signals of red, green and blue.

use rayon::prelude::*;
use re_rav1d::dav1d::pixel::YUVRange;
use re_rav1d::dav1d::{Decoder, Picture, PixelLayout, PlanarImageComponent, Plane as Samples, Settings};

use super::container::Coding;
use crate::codec::CodecError;
use crate::codec::signals::{Layout, Weights};

/// A decoded frame.
pub(super) struct Frame {
    picture: Picture,
    size: (u32, u32),
    bits: u32,
}

/// A plane of a frame.
struct Plane {
    samples: Samples,
    stride: usize,
    is_wide: bool,
    /// The last column and row.
    last: (usize, usize),
    /// True if it has half the columns, and half the rows.
    is_halved: (bool, bool),
}

impl Frame {
    /// Decodes the first frame of AV1 data, which must have this size.
    pub(super) fn decode(data: &[u8], size: (u32, u32)) -> Result<Self, CodecError> {
        let mut settings = Settings::new();
        // This thread alone, whose panics are caught: the decoder would wait for another one.
        settings.set_n_threads(1);
        settings.set_max_frame_delay(1);
        settings.set_all_layers(false);
        settings.set_frame_size_limit(size.0.saturating_mul(size.1));
        let mut decoder = Decoder::with_settings(&settings).map_err(|_| broken())?;
        let picture = decoder
            .send_data(data.to_vec(), None, None, None)
            .and_then(|()| decoder.get_picture())
            .map_err(|_| broken())?;
        if (picture.width(), picture.height()) != size {
            return Err(CodecError::broken("its picture has another size than its header says"));
        }
        let bits = picture.bits_per_component().map_or(8, |bits| bits.0 as u32);
        Ok(Self { picture, size, bits })
    }

    /// The code points in the header of the frame.
    pub(super) fn coding(&self) -> Coding {
        Coding {
            primaries: self.picture.color_primaries() as u8,
            transfer: self.picture.transfer_characteristic() as u8,
            matrix: self.picture.matrix_coefficients() as u8,
            is_full: self.is_full(),
        }
    }

    fn is_full(&self) -> bool {
        self.picture.color_range() == YUVRange::Full
    }

    /// True if there is luma only.
    pub(super) fn is_gray(&self) -> bool {
        self.picture.pixel_layout() == PixelLayout::I400
    }

    fn plane(&self, component: PlanarImageComponent) -> Plane {
        let is_halved = match (component, self.picture.pixel_layout()) {
            (PlanarImageComponent::Y, _) | (_, PixelLayout::I444 | PixelLayout::I400) => (false, false),
            (_, PixelLayout::I422) => (true, false),
            (_, PixelLayout::I420) => (true, true),
        };
        let last = |side: u32, is_halved: bool| (if is_halved { side.div_ceil(2) } else { side }) as usize - 1;
        Plane {
            samples: self.picture.plane(component),
            stride: self.picture.stride(component) as usize,
            is_wide: self.bits > 8,
            last: (last(self.size.0, is_halved.0), last(self.size.1, is_halved.1)),
            is_halved,
        }
    }

    /// Writes the signals of red, green and blue, which are limited to 0 to 1, and an alpha of 1.
    pub(super) fn write_signals(&self, coding: Coding, pixels: &mut [f32]) -> Result<(), CodecError> {
        let weights = coding.weights()?;
        let is_gray = self.is_gray();
        let layout = Layout { bits: self.bits, is_rgb: weights.is_none() && !is_gray, is_narrow: !coding.is_full };
        if layout.is_rgb && self.picture.pixel_layout() != PixelLayout::I444 {
            return Err(CodecError::broken("its planes of red and blue have another size than that of green"));
        }
        let luma = self.plane(PlanarImageComponent::Y);
        let colors = (!is_gray).then(|| [PlanarImageComponent::U, PlanarImageComponent::V].map(|at| self.plane(at)));
        // Without planes of color their codes are those of gray.
        let gray = (1_u32 << (self.bits - 1)) as f32;
        pixels.par_chunks_mut(4 * self.size.0 as usize).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let [first, second] = colors.as_ref().map_or([gray; 2], |colors| [0, 1].map(|at| colors[at].at(x, y)));
                let codes = [luma.at(x, y), first, second];
                let signals = layout.rgb(codes, weights.unwrap_or(Weights::BT709)).map(|signal| signal.clamp(0.0, 1.0));
                let [red, green, blue] = signals;
                *pixel = [red, green, blue, 1.0];
            }
        });
        Ok(())
    }

    /// Writes the luma as alpha.
    pub(super) fn write_alpha(&self, pixels: &mut [f32]) {
        let layout = Layout { bits: self.bits, is_rgb: true, is_narrow: !self.is_full() };
        let luma = self.plane(PlanarImageComponent::Y);
        pixels.par_chunks_mut(4 * self.size.0 as usize).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                pixel[3] = layout.rgb([luma.at(x, y); 3], Weights::BT709)[0].clamp(0.0, 1.0);
            }
        });
    }
}

impl Plane {
    fn code(&self, x: usize, y: usize) -> f32 {
        let at = y * self.stride;
        f32::from(if self.is_wide {
            u16::from_ne_bytes([self.samples[at + 2 * x], self.samples[at + 2 * x + 1]])
        } else {
            self.samples[at + x].into()
        })
    }

    /// The code at a pixel. Samples of halved planes lie in the middle of their pixels, as libavif takes them.
    fn at(&self, x: usize, y: usize) -> f32 {
        let sides = |at: usize, is_halved: bool, last: usize| {
            if !is_halved {
                return (at, at);
            }
            let near = (at / 2).min(last);
            (near, if at % 2 == 0 { near.saturating_sub(1) } else { (near + 1).min(last) })
        };
        let (near_x, far_x) = sides(x, self.is_halved.0, self.last.0);
        let (near_y, far_y) = sides(y, self.is_halved.1, self.last.1);
        let row = |y: usize| 0.75 * self.code(near_x, y) + 0.25 * self.code(far_x, y);
        0.75 * row(near_y) + 0.25 * row(far_y)
    }
}

fn broken() -> CodecError {
    CodecError::broken("its AV1 data cannot be decoded")
}
