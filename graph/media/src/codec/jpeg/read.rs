//! JPEG to linear Rec.709, in halves.

use std::io::{BufRead, Read as _, Seek};

use super::samples::{Plane, interleaved};
use super::scan::{self, Component, max_sampling};
use super::segments::{ColorModel, Frame, Segments};
use crate::codec::codes::{Alpha, Codes, Colors};
use crate::codec::limits::too_large;
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, ColorSpace, Description, ErrorKind, Picture, ReadOptions, icc};

/// Decodes a JPEG of eight bits, sequential or progressive, with any arrangement of scans, to linear color. An ICC
/// profile is applied; without one, the colors are sRGB. The orientation of EXIF is applied.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let file = whole(reader, options.budget.0)?;
    let segments = Segments::of(&file)?;
    let model = segments.color_model()?;
    let frame = &segments.frame;
    let size = [frame.width, frame.height].map(u32::from);
    let mut components = Component::all(frame)?;
    let colors = colors(&segments, model, options.space)?;
    let orientation = segments.exif.and_then(Orientation::of_exif);
    let pixels = usize::from(frame.width) * usize::from(frame.height);
    // Two bytes for each coefficient and one for each sample of whole blocks, the codes, and a picture that is turned.
    let blocks: usize = components.iter().map(Component::number_of_blocks).sum();
    let extra = file.len() + 3 * 64 * blocks + pixels * (components.len() + if orientation.is_some() { 8 } else { 0 });
    options.budget.check((size[0].into(), size[1].into()), colors.bytes_of_sample(8), extra as u64)?;
    scan::decode(frame, &segments.coding, &mut components)?;
    let most = max_sampling(frame);
    let planes = components.into_iter().map(|component| Plane::new(component, most));
    let planes = planes.collect::<Result<Vec<_>, _>>()?;
    let mut bytes = interleaved(&planes, model, size.map(|side| side as usize))?;
    drop(planes);
    if matches!(model, ColorModel::Cmyk | ColorModel::Ycck) {
        to_inks(&mut bytes, model, segments.adobe.is_some());
    }
    let codes = Codes { channels: segments.frame.components.len(), bytes, bits: 8, alpha: Alpha::None, pixels };
    codes.into_picture(size, colors, orientation)
}

/// Content of the segments before the pixels.
pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let file = whole(reader, u64::MAX)?;
    let segments = Segments::of(&file)?;
    let model = segments.color_model()?;
    let mut colors = colors(&segments, model, None)?;
    let Frame { width, height, .. } = segments.frame;
    let orientation = segments.exif.and_then(Orientation::of_exif);
    let size = orientation.unwrap_or(Orientation::UPRIGHT).size(width.into(), height.into());
    colors.notes.extend(orientation.map(Orientation::note));
    let names: &[&str] = match model {
        ColorModel::Gray => &["Y"],
        ColorModel::Rgb | ColorModel::YCbCr => &["R", "G", "B"],
        ColorModel::Cmyk | ColorModel::Ycck => &["C", "M", "Y", "K"],
    };
    Ok(colors.describe(Description::of_picture("JPEG", size, names, "8 bits", "JPEG")))
}

/// The bytes of a file that may have that many.
fn whole(reader: impl BufRead, most: u64) -> Result<Vec<u8>, CodecError> {
    let mut file = Vec::new();
    let read = reader.take(most.saturating_add(1)).read_to_end(&mut file);
    read.map_err(|error| CodecError::reading(&error))?;
    if file.len() as u64 > most { Err(too_large("its file is larger than the limit of `--memory`")) } else { Ok(file) }
}

fn colors(segments: &Segments<'_>, model: ColorModel, space: Option<ColorSpace>) -> Result<Colors, CodecError> {
    let mut notes = segments.notes();
    let is_printed = matches!(model, ColorModel::Cmyk | ColorModel::Ycck);
    let profile = match &segments.profile {
        Some(profile) if space.is_none() || is_printed => {
            let channels = segments.frame.components.len();
            let read = profile.as_deref().map_err(|()| icc::UNREADABLE).and_then(|bytes| icc::read(bytes, channels));
            read.map_err(|why| notes.push(format!("its ICC profile is not applied: {why}"))).ok()
        }
        _ => None,
    };
    if is_printed && profile.is_none() {
        let what = "this JPEG is for a printer (CMYK), without a profile that states its colors";
        return Err(CodecError::new(ErrorKind::Unsupported, what).hint("save it again in RGB"));
    }
    let mut colors = match profile {
        Some(profile) => Colors::of_profile(profile).stated_by("ICC profile"),
        None => Colors::new(space.map(|space| (space.primaries, space.transfer)), None),
    };
    colors.notes = notes;
    Ok(colors)
}

/// CMYK of libjpeg to inks, where 255 covers all. Adobe's numbers are inverted, and so are those that come from YCbCr.
fn to_inks(bytes: &mut [u8], model: ColorModel, is_adobe: bool) {
    let inverts = [is_adobe != (model == ColorModel::Ycck), is_adobe];
    for [colors @ .., black] in bytes.as_chunks_mut::<4>().0 {
        if inverts[0] {
            colors.iter_mut().for_each(|code| *code = 255 - *code);
        }
        if inverts[1] {
            *black = 255 - *black;
        }
    }
}
