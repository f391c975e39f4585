//! ColorVideoVDP: the difference that is seen between two moving pictures on a display.
//!
//! Mantiuk, Hanji, Ashraf, Asano and Chapiro, "ColorVideoVDP: A visual difference predictor for image, video and
//! display distortions", ACM Transactions on Graphics 43(4), 2024. It sees contrasts, not the brightness around them.

use colorvideovdp::{Color, Cvvdp, DisplayModel, Geometry, Image, Options, Photometry};

use super::{Range, Shown};
use crate::LabError;

/// The quality of pictures without a visible difference, in JOD. At one less, three of four people prefer the
/// reference.
pub const NO_DIFFERENCE: f64 = 10.0;

/// A display, and how it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Its name in arguments and claims.
    pub name: &'static str,
    /// A sentence for a user.
    pub about: &'static str,
    /// The brightest color, in cd/m²; HDR pictures are clipped to it.
    pub peak: f64,
    /// The white of SDR pictures, in cd/m².
    pub white: f64,
    /// Black in a dark room, in cd/m².
    pub black: f64,
    /// Light on the display, in lux.
    pub ambient: f64,
    pub pixels_per_degree: f64,
}

/// The share of the light on it that a display reflects.
const REFLECTED: f64 = 0.005;
/// The least width and height that the metric takes.
const MIN_SIDE: usize = 4;

impl Display {
    /// `standard_4k` of ColorVideoVDP.
    pub const DESK: Self = Self {
        name: "desk",
        about: "An SDR monitor of 30 inches and 3840x2160 pixels in an office, two heights away: 200 cd/m2",
        peak: 200.0,
        white: 200.0,
        black: 0.2,
        ambient: 250.0,
        pixels_per_degree: 75.4,
    };
    /// `65inch_hdr_pq_1Knit` of ColorVideoVDP. White of SDR pictures is that of ITU-R BT.2408.
    pub const TV_HDR: Self = Self {
        name: "tv-hdr",
        about: "An HDR television of 65 inches and 3840x2160 pixels in a dim room, 2 meters away: 1000 cd/m2",
        peak: 1000.0,
        white: 203.0,
        black: 0.001,
        ambient: 5.0,
        pixels_per_degree: 92.2,
    };
    /// `standard_phone` of ColorVideoVDP.
    pub const PHONE: Self = Self {
        name: "phone",
        about: "A phone of 6 inches and 2400x1080 pixels in an office, 0.4 meters away: 500 cd/m2",
        peak: 500.0,
        white: 500.0,
        black: 0.05,
        ambient: 250.0,
        pixels_per_degree: 120.6,
    };
    pub const ALL: [Self; 3] = [Self::DESK, Self::TV_HDR, Self::PHONE];

    /// The display for pictures of a range where no other is named.
    pub fn of(range: Range) -> Self {
        match range {
            Range::Sdr => Self::DESK,
            Range::Hdr => Self::TV_HDR,
        }
    }

    /// The metric for pictures of a range.
    fn metric(&self, range: Range) -> colorvideovdp::Result<Cvvdp> {
        let peak = match range {
            Range::Sdr => self.white,
            Range::Hdr => self.peak,
        };
        let photometry = Photometry::new(peak, peak / self.black, self.ambient, REFLECTED, 1.0)?;
        // Only the pixels of a degree count, not how many there are.
        let geometry = Geometry::from_ppd([1, 1], self.pixels_per_degree)?;
        let model = DisplayModel::new(self.name, photometry, geometry, "sRGB")?;
        Cvvdp::new(model, Options::default().with_memory_limit_bytes(usize::MAX))
    }
}

/// The quality of a sequence in JOD: [`NO_DIFFERENCE`] or less, also below zero. A single frame is judged as a still,
/// more are judged as a video of that many frames per second.
///
/// # Errors
/// A video has a frame rate that is not above zero or is above 16384, or memory ends.
pub fn jod(reference: &[Shown], shown: &[Shown], fps: f32, display: &Display) -> Result<f64, LabError> {
    if reference.iter().zip(shown).all(|(reference, shown)| reference.pixels == shown.pixels) {
        return Ok(NO_DIFFERENCE);
    }
    let predicted = || -> colorvideovdp::Result<f64> {
        let [reference, other] =
            [reference, shown].map(|frames| frames.iter().map(image).collect::<Result<Vec<_>, _>>());
        let (reference, other, range) = (reference?, other?, shown[0].range);
        let color = match range {
            Range::Sdr => Color::Srgb,
            Range::Hdr => Color::Linear,
        };
        let metric = display.metric(range)?;
        let prediction = match (&*other, &*reference) {
            ([other], [reference]) => metric.predict_image(other, reference, color)?,
            (other, reference) => metric.predict_video(other, reference, fps, color)?,
        };
        Ok(f64::from(prediction.jod))
    };
    predicted().map_err(|error| LabError::request(format!("the frames cannot be judged as a video: {error}")))
}

/// The picture for the metric; the last rows and columns of a tiny one are repeated.
fn image(shown: &Shown) -> colorvideovdp::Result<Image> {
    let (width, height) = (shown.width.max(MIN_SIDE), shown.height.max(MIN_SIDE));
    let mut numbers = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        let row = &shown.pixels[y.min(shown.height - 1) * shown.width..][..shown.width];
        numbers.extend(row.as_flattened());
        for _ in shown.width..width {
            numbers.extend(row[shown.width - 1]);
        }
    }
    Image::new(width, height, 3, numbers)
}
