//! The samples of a frame of video, and the signals of red, green and blue (ITU-T H.273, 8.3).

use rayon::prelude::*;

/// The samples of a frame: three planes of full size. Those of RGB are green, blue and red.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// 8, or 10, 12 or 16, which take two bytes, the lower one first.
    pub(crate) bits: u32,
    pub(crate) is_rgb: bool,
    /// True for the narrow range: of 8-bit codes, 16 is black and 235 is white.
    pub(crate) is_narrow: bool,
}

/// The weights of red and blue in luma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weights {
    pub(crate) red: f32,
    pub(crate) blue: f32,
}

impl Weights {
    pub(crate) const BT601: Self = Self { red: 0.299, blue: 0.114 };
    pub(crate) const BT709: Self = Self { red: 0.2126, blue: 0.0722 };
    pub(crate) const BT2020: Self = Self { red: 0.2627, blue: 0.0593 };
    pub(crate) const SMPTE240: Self = Self { red: 0.212, blue: 0.087 };

    fn green(self) -> f32 {
        1.0 - self.red - self.blue
    }
}

/// Pixels that a thread converts at a time.
const GROUP: usize = 1 << 14;

impl Layout {
    fn bytes(self) -> usize {
        if self.bits > 8 { 2 } else { 1 }
    }

    /// Bytes of a frame of so many pixels.
    pub(crate) fn frame_bytes(self, pixels: usize) -> usize {
        3 * pixels * self.bytes()
    }

    /// The name of the format of samples for `ffmpeg`.
    pub(crate) fn name(self) -> String {
        let base = if self.is_rgb { "gbrp" } else { "yuv444p" };
        if self.bits > 8 { format!("{base}{}le", self.bits) } else { base.to_owned() }
    }

    /// The code of the format of samples in a stream of raw frames.
    pub(crate) fn code(self) -> [u8; 4] {
        [if self.is_rgb { b'G' } else { b'Y' }, b'3', 0, self.bits as u8]
    }

    /// The codes of black and of a step from black to white, in luma or RGB.
    fn luma(self) -> (f32, f32) {
        let unit = (1_u32 << (self.bits - 8)) as f32;
        if self.is_narrow { (16.0 * unit, 219.0 * unit) } else { (0.0, self.last()) }
    }

    /// The code of gray, and twice the step from it to the end of the range, in color differences.
    fn chroma(self) -> (f32, f32) {
        let unit = (1_u32 << (self.bits - 8)) as f32;
        (128.0 * unit, if self.is_narrow { 224.0 * unit } else { self.last() })
    }

    fn last(self) -> f32 {
        ((1_u32 << self.bits) - 1) as f32
    }

    /// The signals of red, green and blue of the codes of a pixel.
    pub(crate) fn rgb(self, codes: [f32; 3], weights: Weights) -> [f32; 3] {
        let ((black, white), (gray, span)) = (self.luma(), self.chroma());
        if self.is_rgb {
            let [green, blue, red] = codes.map(|code| (code - black) / white);
            return [red, green, blue];
        }
        let (luma, cb, cr) = ((codes[0] - black) / white, (codes[1] - gray) / span, (codes[2] - gray) / span);
        let red = luma + 2.0 * (1.0 - weights.red) * cr;
        let blue = luma + 2.0 * (1.0 - weights.blue) * cb;
        [red, (luma - weights.red * red - weights.blue * blue) / weights.green(), blue]
    }

    /// The signals of a frame, with an alpha of 1. `finish` goes over pixels that are ready.
    pub(crate) fn signals(self, frame: &[u8], weights: Weights, finish: impl Fn(&mut [f32]) + Sync) -> Vec<f32> {
        let plane = frame.len() / 3;
        let mut pixels = vec![1.0; 4 * plane / self.bytes()];
        let code = |plane_index: usize, pixel: usize| {
            let at = plane_index * plane + pixel * self.bytes();
            f32::from(if self.bits > 8 { u16::from_le_bytes([frame[at], frame[at + 1]]) } else { frame[at].into() })
        };
        pixels.par_chunks_mut(4 * GROUP).enumerate().for_each(|(group, out)| {
            for (pixel, out) in (group * GROUP..).zip(out.as_chunks_mut::<4>().0) {
                out[..3].copy_from_slice(&self.rgb([0, 1, 2].map(|plane| code(plane, pixel)), weights));
            }
            finish(out);
        });
        pixels
    }

    /// The frame of signals, which are limited to 0 to 1.
    pub(crate) fn frame(self, pixels: &[[f32; 4]], weights: Weights) -> Vec<u8> {
        let mut frame = vec![0; self.frame_bytes(pixels.len())];
        let plane = frame.len() / 3;
        let ((black, white), (gray, span)) = (self.luma(), self.chroma());
        for (index, plane) in frame.chunks_mut(plane.max(1)).enumerate() {
            plane.par_chunks_mut(self.bytes() * GROUP).zip(pixels.par_chunks(GROUP)).for_each(|(out, pixels)| {
                for (out, [r, g, b, _]) in out.chunks_mut(self.bytes()).zip(pixels) {
                    // NaN becomes 0.
                    let [r, g, b] = [r, g, b].map(|x| if *x > 0.0 { x.min(1.0) } else { 0.0 });
                    let luma = weights.red * r + weights.green() * g + weights.blue * b;
                    let code = match (self.is_rgb, index) {
                        (true, _) => black + white * [g, b, r][index],
                        (false, 0) => black + white * luma,
                        (false, 1) => gray + span * (b - luma) / (2.0 * (1.0 - weights.blue)),
                        (false, _) => gray + span * (r - luma) / (2.0 * (1.0 - weights.red)),
                    };
                    let code = code.round().min(self.last()) as u16;
                    out.copy_from_slice(&code.to_le_bytes()[..out.len()]);
                }
            });
        }
        frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes of ITU-R BT.709 and BT.2100: black, white, and the primaries.
    #[test]
    fn codes_are_those_of_the_recommendations() {
        let layout = Layout { bits: 10, is_rgb: false, is_narrow: true };
        let codes = |pixel: [f32; 3], weights: Weights| {
            let frame = layout.frame(&[[pixel[0], pixel[1], pixel[2], 1.0]], weights);
            [0, 2, 4].map(|at| u16::from_le_bytes([frame[at], frame[at + 1]]))
        };
        assert_eq!(codes([0.0; 3], Weights::BT709), [64, 512, 512]);
        assert_eq!(codes([1.0; 3], Weights::BT709), [940, 512, 512]);
        // BT.709 bars of 100 %.
        assert_eq!(codes([1.0, 1.0, 0.0], Weights::BT709), [877, 64, 553]);
        assert_eq!(codes([1.0, 0.0, 0.0], Weights::BT709), [250, 409, 960]);
        assert_eq!(codes([0.0, 0.0, 1.0], Weights::BT709), [127, 960, 471]);
        assert_eq!(codes([1.0, 0.0, 0.0], Weights::BT2020), [294, 387, 960]);
        assert_eq!(codes([f32::NAN, 2.0, -1.0], Weights::BT709), codes([0.0, 1.0, 0.0], Weights::BT709));
    }

    #[test]
    fn signals_come_back_within_the_step_of_their_codes() {
        let pixels: Vec<[f32; 4]> = (0..40_000)
            .map(|index| [7, 11, 13].map(|prime| (index * prime % 1009) as f32 / 1008.0))
            .map(|[r, g, b]| [r, g, b, 1.0])
            .collect();
        for bits in [8, 10, 12, 16] {
            for (is_rgb, is_narrow) in [(true, false), (true, true), (false, true), (false, false)] {
                let layout = Layout { bits, is_rgb, is_narrow };
                let frame = layout.frame(&pixels, Weights::BT2020);
                assert_eq!(frame.len(), layout.frame_bytes(pixels.len()));
                let read = layout.signals(&frame, Weights::BT2020, |_| {});
                let pairs = read.iter().zip(pixels.as_flattened());
                let error = pairs.map(|(read, exact)| (read - exact).abs()).fold(0.0, f32::max);
                let step = 1.0 / (219 << (bits - 8)) as f32;
                assert!(error < 1.5 * step, "{layout:?}: {error} of {step}");
            }
        }
    }
}
