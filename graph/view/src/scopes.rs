//! Scopes: histogram, waveform and vectorscope of a coarse grid of the picture.

use afterimage_graph::color::rec709_luminance;

/// Columns of a histogram and of a waveform.
pub const COLUMNS: usize = 256;
/// Rows of a waveform, and both sides of a vectorscope.
pub const ROWS: usize = 128;
/// The lowest and the highest stop of a histogram of linear color, from middle gray.
pub const STOPS: (f32, f32) = (-10.0, 10.0);
const GRAY: f32 = 0.18;

#[derive(Clone, Debug, PartialEq)]
pub struct Scopes {
    /// Pixels of each channel in steps: of codes for an encoded image, of stops for a linear one.
    pub histogram: [Vec<u32>; 3],
    /// For each column of the picture, from left to right, how many pixels have each brightness, from bottom to top;
    /// row by row.
    pub waveform: Vec<u32>,
    /// Number of pixels with each pair of color differences, row by row, neutral in the middle.
    pub vectors: Vec<u32>,
    /// The least and the largest finite number of the color channels.
    pub range: (f32, f32),
    /// The part of the pixels that has a channel at or over 1, and the part that has none over 0.
    pub clipped: [f32; 2],
    /// The number of pixels of the picture with NaN or infinities.
    pub faults: u64,
}

impl Scopes {
    /// The scopes of a grid of `width` columns, whose alpha is the number of pixels with NaN or infinities around
    /// each place. `is_linear` is false for encoded values.
    pub fn of(pixels: &[[f32; 4]], width: usize, is_linear: bool) -> Self {
        let mut scopes = Self {
            histogram: std::array::from_fn(|_| vec![0; COLUMNS]),
            waveform: vec![0; COLUMNS * ROWS],
            vectors: vec![0; ROWS * ROWS],
            range: range(pixels),
            clipped: clipped(pixels),
            faults: pixels.iter().map(|pixel| pixel[3] as u64).sum(),
        };
        for (index, pixel) in pixels.iter().enumerate() {
            scopes.count(index % width.max(1), width, pixel, is_linear);
        }
        scopes
    }

    fn count(&mut self, column: usize, width: usize, pixel: &[f32; 4], is_linear: bool) {
        for (channel, histogram) in self.histogram.iter_mut().enumerate() {
            if let Some(place) = place(level(pixel[channel], is_linear), COLUMNS) {
                histogram[place] += 1;
            }
        }
        let [red, green, blue, _] = *pixel;
        let luma = rec709_luminance([red, green, blue]);
        if let Some(row) = place(level(luma, is_linear), ROWS) {
            self.waveform[(ROWS - 1 - row) * COLUMNS + column * COLUMNS / width.max(1)] += 1;
        }
        // Differences of signals: linear values are roughly encoded first.
        let signal = |x: f32| if is_linear { x.clamp(0.0, 1.0).sqrt() } else { x };
        let signals = [red, green, blue].map(signal);
        let luma = rec709_luminance(signals);
        let (blue, red) = ((signals[2] - luma) / 1.8556, (signals[0] - luma) / 1.5748);
        if let (Some(x), Some(y)) = (place(blue + 0.5, ROWS), place(0.5 - red, ROWS)) {
            self.vectors[y * ROWS + x] += 1;
        }
    }
}

/// The position of a number between the ends of a scope, as 0 to 1.
fn level(number: f32, is_linear: bool) -> f32 {
    if !is_linear {
        return number;
    }
    let stops = (number.max(f32::MIN_POSITIVE) / GRAY).log2();
    (stops - STOPS.0) / (STOPS.1 - STOPS.0)
}

/// The step of a level; those beyond an end count at the end. `None` for NaN.
fn place(level: f32, steps: usize) -> Option<usize> {
    (!level.is_nan()).then(|| ((level * steps as f32) as isize).clamp(0, steps as isize - 1) as usize)
}

/// The least and the largest finite number of the color channels.
pub(crate) fn range(pixels: &[[f32; 4]]) -> (f32, f32) {
    let finite = pixels.iter().flat_map(|pixel| &pixel[..3]).filter(|number| number.is_finite());
    let (low, high) = finite.fold((f32::MAX, f32::MIN), |(low, high), number| (low.min(*number), high.max(*number)));
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

fn clipped(pixels: &[[f32; 4]]) -> [f32; 2] {
    let part =
        |is: fn(&[f32; 4]) -> bool| pixels.iter().filter(|pixel| is(pixel)).count() as f32 / pixels.len().max(1) as f32;
    [part(|pixel| pixel[..3].iter().any(|x| *x >= 1.0)), part(|pixel| pixel[..3].iter().all(|x| *x <= 0.0))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_counted_in_stops_from_middle_gray_and_signals_in_codes() {
        let pixels = [[0.18, 0.36, 0.09, 0.0]];
        let linear = Scopes::of(&pixels, 1, true);
        let peak = |channel: usize| linear.histogram[channel].iter().position(|count| *count == 1);
        // 256 columns for 20 stops: 12.8 for each.
        assert_eq!([peak(0), peak(1), peak(2)], [Some(128), Some(140), Some(115)]);
        let signal = Scopes::of(&[[0.5, 1.0, -1.0, 1.0]], 1, false);
        let peak = |channel: usize| signal.histogram[channel].iter().position(|count| *count == 1);
        assert_eq!([peak(0), peak(1), peak(2)], [Some(128), Some(255), Some(0)]);
    }

    #[test]
    fn a_waveform_keeps_columns_and_a_vectorscope_has_gray_in_the_middle() {
        let scopes = Scopes::of(&[[0.25; 4], [0.75; 4]], 2, false);
        let lit: Vec<usize> =
            scopes.waveform.iter().enumerate().filter(|(_, count)| **count > 0).map(|(index, _)| index).collect();
        assert_eq!(lit, [(ROWS - 1 - 96) * COLUMNS + 128, (ROWS - 1 - 32) * COLUMNS]);
        assert_eq!(scopes.vectors[ROWS / 2 * ROWS + ROWS / 2], 2);
    }

    #[test]
    fn nan_and_infinite_pixels_count_nowhere_or_at_the_end() {
        let scopes = Scopes::of(&[[f32::NAN, f32::INFINITY, 0.5, 7.0]], 1, false);
        assert_eq!(scopes.histogram[0].iter().sum::<u32>(), 0);
        assert_eq!((scopes.histogram[1][COLUMNS - 1], scopes.range, scopes.faults), (1, (0.5, 0.5), 7));
    }
}
