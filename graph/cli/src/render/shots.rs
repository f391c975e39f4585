//! Where a sequence is cut into shots, found from its pictures.
//!
//! The picture is divided into nine parts, and each part has a histogram of its luminance in stops. The difference of
//! two frames is the share of pixels that would have to change their stop, as the mean of the parts: 0 for equal
//! frames, 1 for frames that have no stop in common anywhere.

use afterimage_media::{Picture, ReadOptions, Source, read_within, sequence};

use crate::failure::Failure;
use crate::progress::Bar;

/// Parts in both directions.
const PARTS: u32 = 3;
/// The stops that are distinguished, from the darkest.
const STOPS: usize = 18;
/// The lowest stop.
const LOWEST: f32 = -12.0;
/// Pixels in both directions that are looked at, at most.
const SAMPLES: u32 = 512;
/// The luminance of linear Rec.709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// The frames of a sequence whose difference from the frame before is at least `share`, and that difference.
///
/// # Errors
/// A frame cannot be read.
pub(super) fn detect(file: &str, options: ReadOptions, share: f32) -> Result<Vec<(u32, f32)>, Failure> {
    let (input, gaps) = sequence::Input::find_filled(file, None)?;
    let frames: Vec<(u32, Source)> = input
        .sources()
        .into_iter()
        .filter_map(|(frame, source)| Some((frame.filter(|frame| !gaps.contains(frame))?, source)))
        .collect();
    let bar = Bar::of_frames(frames.len() as u64);
    let mut cuts = Vec::new();
    let mut before: Option<Stops> = None;
    for (frame, source) in frames {
        let stops = Stops::of(&read_within(&source, options)?);
        let difference = before.map_or(0.0, |before| before.difference(&stops));
        if difference >= share {
            cuts.push((frame, difference));
        }
        before = Some(stops);
        bar.advance(&format!("frame {frame}"));
    }
    Ok(cuts)
}

/// For each part the share of its pixels in each stop.
struct Stops([[f32; STOPS]; (PARTS * PARTS) as usize]);

impl Stops {
    fn of(picture: &Picture) -> Self {
        let (width, height) = (picture.width, picture.height);
        let mut counts = [[0_u32; STOPS]; (PARTS * PARTS) as usize];
        for y in (0..height).step_by(height.div_ceil(SAMPLES) as usize) {
            for x in (0..width).step_by(width.div_ceil(SAMPLES) as usize) {
                let pixel = picture.pixel(x, y);
                let part = y * PARTS / height * PARTS + x * PARTS / width;
                counts[part as usize][stop(pixel)] += 1;
            }
        }
        Self(counts.map(|counts| {
            let all = counts.iter().sum::<u32>().max(1) as f32;
            counts.map(|count| count as f32 / all)
        }))
    }

    fn difference(&self, other: &Self) -> f32 {
        let pairs = self.0.as_flattened().iter().zip(other.0.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / (2 * PARTS * PARTS) as f32
    }
}

/// The stop of a pixel; that of black for what is dark, negative or no number.
fn stop(pixel: [f32; 4]) -> usize {
    let luminance: f32 = pixel.iter().zip(LUMINANCE).map(|(value, weight)| value * weight).sum();
    (luminance.log2() - LOWEST).clamp(0.0, (STOPS - 1) as f32) as usize
}

#[cfg(test)]
mod tests {
    use afterimage_media::Pixels;

    use super::*;

    fn picture(light: impl Fn(u32, u32) -> f32) -> Stops {
        let pixels = (0..60 * 60).flat_map(|at| [light(at % 60, at / 60); 4]);
        Stops::of(&Picture::new(60, 60, Pixels::Float(pixels.collect())))
    }

    #[test]
    fn the_difference_is_the_share_of_pixels_that_change() {
        let gray = picture(|_, _| 0.2);
        assert_eq!(gray.difference(&gray), 0.0);
        // A ninth of the picture becomes bright.
        let lamp = picture(|x, y| if x < 20 && y < 20 { 8.0 } else { 0.2 });
        assert!((gray.difference(&lamp) - 1.0 / 9.0).abs() < 1e-6);
        assert!((gray.difference(&picture(|_, _| 8.0)) - 1.0).abs() < 1e-6);
        // Half of each part, in another place.
        let stripes = |offset: u32| picture(move |x, _| if (x + offset) % 4 < 2 { 0.1 } else { 4.0 });
        assert!(stripes(0).difference(&stripes(2)) < 1e-6);
    }

    #[test]
    fn nothing_is_a_stop_as_black_is() {
        for value in [0.0, -1.0, f32::NAN, 1e-9] {
            assert_eq!(stop([value; 4]), 0, "{value}");
        }
        assert_eq!((stop([f32::INFINITY; 4]), stop([1.0; 4])), (STOPS - 1, 12));
    }
}
