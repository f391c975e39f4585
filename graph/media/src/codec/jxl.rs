//! JPEG XL to linear Rec.709, with the feature `jxl`.

use std::io::{BufRead, Seek};

use afterimage_base::color::{Chromaticities, Decimal, Transfer};
use jxl::api::{
    AlphaMode, Event, ExtraChannel, JxlBitDepth, JxlColorEncoding, JxlColorProfile, JxlDecoder, JxlDecoderOptions,
    JxlOutputBuffer, JxlParallelRunner, JxlParallelRunnerFun, JxlPixelFormat, JxlPrimaries, JxlTransferFunction,
    JxlWhitePoint, ProfileLevel,
};
use jxl::error::Error;
use rayon::prelude::*;

use crate::codec::codes::{Alpha, Colors};
use crate::codec::limits::{MAX_BYTES, read_all, too_large, zeroed};
use crate::codec::{CodecError, ColorSpace, Description, ErrorKind, Picture, ReadOptions, icc};

/// Decodes the first frame to linear color. Straight alpha is multiplied into it, unless `options` keep it apart.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let bytes = read_all(reader, options.budget.0)?;
    let mut input = &*bytes;
    let mut file = Stream::open(&mut input, options.budget.0)?;
    let (width, height) = file.size();
    let pixels = width as usize * height as usize;
    // The decoder has at most as many numbers again of each channel.
    let channels = 4 + file.extra_channels() as u64;
    let extra = bytes.len() as u64 + 8 * channels * pixels as u64;
    options.budget.check((width.into(), height.into()), 4, extra)?;
    let colors = file.colors(options.space)?;
    let mut values: Vec<f32> = zeroed(4 * pixels)?;
    file.read(&mut input, &mut values)?;
    let alpha = match (file.has_alpha(), options.premultiplied) {
        (false, _) => Alpha::None,
        (true, true) => Alpha::Premultiply,
        (true, false) => Alpha::Apart,
    };
    colors.into_picture(values, [width, height], alpha, None)
}

pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let bytes = read_all(reader, MAX_BYTES)?;
    let file = Stream::open(&mut &*bytes, MAX_BYTES)?;
    let colors = file.colors(None)?;
    let info = file.decoder.basic_info().expect("the header was read");
    let samples = match info.bit_depth {
        JxlBitDepth::Float { bits_per_sample: 17.., .. } => "float",
        JxlBitDepth::Float { .. } => "half",
        JxlBitDepth::Int { bits_per_sample: 0..=8 } => "8 bits",
        JxlBitDepth::Int { .. } => "16 bits",
    };
    let compression = if info.uses_original_profile { "modular" } else { "lossy" };
    let names: &[&str] = if file.has_alpha() { &["R", "G", "B", "A"] } else { &["R", "G", "B"] };
    Ok(colors.describe(Description::of_picture("JPEG XL", file.size(), names, samples, compression)))
}

/// A file whose header was read.
struct Stream {
    decoder: JxlDecoder,
}

impl Stream {
    fn open(input: &mut &[u8], budget: u64) -> Result<Self, CodecError> {
        let mut options = JxlDecoderOptions::default();
        options.alpha_mode = AlphaMode::Unpremultiplied;
        options.max_profile_level = ProfileLevel::Main10;
        options.high_precision = true;
        options.sample_limit = Some(usize::try_from(budget / 4).unwrap_or(usize::MAX));
        let mut decoder = JxlDecoder::new(options);
        loop {
            match decoder.process(input, None, None).map_err(|error| explain(&error))? {
                Event::BasicInfo => break,
                Event::NeedMoreInput { .. } => return Err(CodecError::cut_short()),
                _ => return Err(CodecError::broken("it has no header")),
            }
        }
        let mut file = Self { decoder };
        let format = JxlPixelFormat::rgba_f32(file.extra_channels());
        file.decoder.set_pixel_format(format).map_err(|error| explain(&error))?;
        if file.is_any_extra(|kind| kind == ExtraChannel::Black) {
            return Err(CodecError::new(ErrorKind::Unsupported, "this JPEG XL is for a printer (CMYK)")
                .hint("save it again in RGB"));
        }
        Ok(file)
    }

    fn size(&self) -> (u32, u32) {
        let (width, height) = self.decoder.basic_info().map_or((0, 0), |info| info.size);
        [width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX)).into()
    }

    fn extra_channels(&self) -> usize {
        self.decoder.basic_info().map_or(0, |info| info.extra_channels.len())
    }

    fn is_any_extra(&self, is_one: impl Fn(ExtraChannel) -> bool) -> bool {
        self.decoder.basic_info().is_some_and(|info| info.extra_channels.iter().any(|extra| is_one(extra.ec_type)))
    }

    fn has_alpha(&self) -> bool {
        self.is_any_extra(|kind| kind == ExtraChannel::Alpha)
    }

    /// Fills the four channels of each pixel of the first frame.
    fn read(&mut self, input: &mut &[u8], values: &mut [f32]) -> Result<(), CodecError> {
        let (width, height) = self.size();
        let mut buffers =
            [JxlOutputBuffer::new(bytemuck::cast_slice_mut(values), height as usize, 16 * width as usize)];
        loop {
            let event = self.decoder.process(input, Some(&mut buffers), Some(&mut Threads));
            match event.map_err(|error| explain(&error))? {
                Event::FrameComplete { .. } => return Ok(()),
                Event::NeedMoreInput { .. } => return Err(CodecError::cut_short()),
                Event::Complete => return Err(CodecError::broken("it has no picture")),
                Event::BasicInfo | Event::FrameHeader => {}
            }
        }
    }

    /// The colors of the numbers that are read.
    fn colors(&self, space: Option<ColorSpace>) -> Result<Colors, CodecError> {
        let info = self.decoder.basic_info().expect("the header was read");
        let peak = Some(f64::from(info.tone_mapping.intensity_target)).filter(|peak| *peak > 0.0);
        let mut notes = Vec::new();
        if info.animation.is_some() {
            notes.push("it is an animation; only its first frame is read".to_owned());
        }
        if self.is_any_extra(|kind| kind != ExtraChannel::Alpha) {
            notes.push("its channels besides color and alpha are left out".to_owned());
        }
        let is_gray = self.decoder.embedded_color_profile().is_some_and(|profile| profile.channels() == 1);
        let mut colors = match (space, self.decoder.output_color_profile()) {
            (Some(space), _) => Colors::new(Some((space.primaries, space.transfer)), None),
            (None, Some(JxlColorProfile::Simple(encoding))) => {
                Colors::new(of_encoding(encoding), peak).stated_by("color encoding")
            }
            (None, Some(JxlColorProfile::Icc(profile))) => match icc::read(profile, if is_gray { 1 } else { 3 }) {
                Ok(icc::Profile::Space(primaries, transfer)) => {
                    Colors::new(Some((primaries, transfer)), peak).stated_by("ICC profile")
                }
                Ok(profile) => Colors::of_profile(profile).stated_by("ICC profile"),
                Err(why) => {
                    notes.push(format!("its ICC profile is not applied: {why}"));
                    Colors::new(None, None)
                }
            },
            (None, None) => Colors::new(None, None),
        };
        colors.notes = notes;
        Ok(colors)
    }
}

/// The primaries and the transfer function of an encoding; `None` for one of no display.
fn of_encoding(encoding: &JxlColorEncoding) -> Option<(Chromaticities, Transfer)> {
    let (primaries, transfer) = match encoding {
        JxlColorEncoding::RgbColorSpace { white_point, primaries, transfer_function, .. } => {
            (of_primaries(primaries, white_point)?, transfer_function)
        }
        JxlColorEncoding::GrayscaleColorSpace { transfer_function, .. } => (Chromaticities::REC709, transfer_function),
        JxlColorEncoding::XYB { .. } => return None,
    };
    let transfer = match transfer {
        JxlTransferFunction::Linear => Transfer::Linear,
        // As that of a PNG, whose curve of cameras is read as that of displays.
        JxlTransferFunction::SRGB | JxlTransferFunction::BT709 => Transfer::Srgb,
        JxlTransferFunction::PQ => Transfer::Pq,
        JxlTransferFunction::HLG => Transfer::Hlg,
        JxlTransferFunction::DCI => Transfer::Gamma(Decimal::new(2.6)),
        // With seven digits in the file.
        JxlTransferFunction::Gamma(share) => Transfer::Gamma(Decimal::new((1e4 / f64::from(*share)).round() / 1e4)),
    };
    Some((primaries, transfer))
}

fn of_primaries(primaries: &JxlPrimaries, white: &JxlWhitePoint) -> Option<Chromaticities> {
    match (primaries, white) {
        (JxlPrimaries::SRGB, JxlWhitePoint::D65) => Some(Chromaticities::REC709),
        (JxlPrimaries::P3, JxlWhitePoint::D65) => Some(Chromaticities::DISPLAY_P3),
        (JxlPrimaries::BT2100, JxlWhitePoint::D65) => Some(Chromaticities::REC2020),
        _ => {
            let [red, green, blue] = primaries.to_xy_coords();
            let points = [red, green, blue, white.to_xy_coords()].map(|(x, y)| [x, y].map(f64::from));
            Chromaticities::from_numbers(points.as_flattened().try_into().ok()?)
        }
    }
}

/// The threads of this program.
struct Threads;

impl JxlParallelRunner for Threads {
    fn run(&mut self, count: usize, task: &JxlParallelRunnerFun<'_>) -> jxl::error::Result<()> {
        (0..count).into_par_iter().try_for_each(task)
    }

    fn num_threads(&self) -> usize {
        rayon::current_num_threads()
    }
}

fn explain(error: &Error) -> CodecError {
    match error {
        Error::ImageSizeTooLarge(..) | Error::LevelLimitExceeded { .. } => too_large(error.to_string()),
        Error::IOError(error) => CodecError::reading(error),
        error => CodecError::broken(error),
    }
}
