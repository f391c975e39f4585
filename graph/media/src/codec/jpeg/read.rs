//! JPEG to linear Rec.709, in halves.

use std::io::{BufRead, Seek};

use afterimage_base::color::Colorimetry;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZByteIoError;
use zune_jpeg::zune_core::colorspace::ColorSpace as Channels;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::codec::codes::{Codes, Colors};
use crate::codec::limits::zeroed;
use crate::codec::orientation::Orientation;
use crate::codec::{
    ChannelDescription, CodecError, ColorSpace, Description, ErrorKind, PartDescription, Picture, PictureChannels,
    ReadOptions, Window, icc,
};

/// The start of a JPEG: the first marker, and the beginning of the second.
pub(crate) const MAGIC: [u8; 3] = *b"\xff\xd8\xff";

/// The most passes of a progressive file; usual ones have ten.
const MAX_SCANS: usize = 100;

/// Decodes a JPEG to linear light. An ICC profile is applied if it is a matrix with a known curve; otherwise, and
/// without one, the colors are sRGB. The orientation of EXIF is applied.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let (mut decoder, header) = open(reader)?;
    let Header { width, height, channels, profile, orientation } = header;
    let colors = colors(profile.as_deref(), options.space);
    let pixels = width as usize * height as usize;
    // Codes, the coefficients of a progressive file, and a picture that is to be turned.
    let extra = (pixels * (channels * 3 + if orientation.is_some() { 8 } else { 0 })) as u64;
    options.budget.check((width.into(), height.into()), colors.bytes_of_sample(false), extra)?;
    let mut bytes = zeroed(pixels * channels)?;
    decoder.decode_into(&mut bytes).map_err(explain)?;
    let codes = Codes { bytes, is_wide: false, channels, pixels };
    codes.into_picture([width, height], colors, orientation)
}

/// What stands before the pixels.
pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let (_, Header { width, height, channels, profile, orientation }) = open(reader)?;
    let mut colors = colors(profile.as_deref(), None);
    let (width, height) = orientation.map_or((width, height), |orientation| orientation.size(width, height));
    colors.notes.extend(orientation.map(Orientation::note));
    let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
    let window = Window::of_size(width, height);
    let part = PartDescription {
        name: None,
        display: window,
        data: window,
        channels: names.iter().map(|name| ChannelDescription { name: (*name).to_owned(), samples: "8 bits" }).collect(),
        compression: "JPEG".to_owned(),
        tiles: None,
    };
    Ok(Description {
        format: "JPEG",
        parts: vec![part],
        picture: Some(PictureChannels { part: 0, channels: names.iter().map(|name| (*name).to_owned()).collect() }),
        color: Some(colors.stated.unwrap_or(Colorimetry::SRGB)),
        stated_by: colors.stated.map(|_| "ICC profile"),
        notes: colors.notes,
    })
}

struct Header {
    width: u32,
    height: u32,
    /// 1 for gray, 3 for RGB.
    channels: usize,
    profile: Option<Vec<u8>>,
    orientation: Option<Orientation>,
}

/// A decoder after the headers. It refuses files that end early, and makes gray or RGB.
fn open<R: BufRead + Seek>(reader: R) -> Result<(JpegDecoder<R>, Header), CodecError> {
    let most = usize::from(u16::MAX);
    let options = DecoderOptions::default().set_max_width(most).set_max_height(most).set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(reader, options.jpeg_set_max_scans(MAX_SCANS));
    decoder.decode_headers().map_err(explain)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    let (out, channels) = match decoder.input_colorspace() {
        Some(Channels::Luma) => (Channels::Luma, 1),
        Some(Channels::YCbCr | Channels::RGB) => (Channels::RGB, 3),
        _ => {
            let what = "this JPEG is for a printer (CMYK)";
            return Err(CodecError::new(ErrorKind::Unsupported, what).hint("save it again in RGB"));
        }
    };
    let options = decoder.options().jpeg_set_out_colorspace(out);
    decoder.set_options(options);
    let (profile, orientation) = (decoder.icc_profile(), decoder.exif().and_then(|exif| Orientation::of_exif(exif)));
    let header = Header { width: width as u32, height: height as u32, channels, profile, orientation };
    Ok((decoder, header))
}

fn colors(profile: Option<&[u8]>, space: Option<ColorSpace>) -> Colors {
    let mut notes = Vec::new();
    let stated = match (space, profile) {
        (Some(space), _) => Some((space.primaries, space.transfer)),
        (None, Some(profile)) => icc::read_or_note(profile, &mut notes),
        (None, None) => None,
    };
    Colors::new(stated, None, notes)
}

fn explain(error: DecodeErrors) -> CodecError {
    match error {
        DecodeErrors::FormatStatic("Premature end of buffer")
        | DecodeErrors::ExhaustedData
        | DecodeErrors::IoErrors(ZByteIoError::NotEnoughBytes(..)) => CodecError::cut_short(),
        DecodeErrors::IoErrors(ZByteIoError::StdIoError(error)) => CodecError::reading(&error),
        DecodeErrors::Unsupported(what) => {
            CodecError::new(ErrorKind::Unsupported, format!("this JPEG cannot be read: {what:?}"))
                .hint("save it again as a usual JPEG of 8 bits, or as PNG")
        }
        other => CodecError::broken(format!("{other:?}")),
    }
}
