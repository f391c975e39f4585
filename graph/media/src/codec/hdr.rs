//! Radiance `.hdr`: eight bits for each color and a shared exponent.

use std::io::{BufRead, Cursor, Read as _, Seek};

use afterimage_base::color::{Chromaticities, Colorimetry};
use image::codecs::hdr::{HdrDecoder, HdrMetadata};
use image::{ImageDecoder, ImageError};

use crate::codec::chromaticities::{convert, to_rec709};
use crate::codec::limits::{MAX_HDR_HEADER, filled, zeroed};
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, ColorSpace, Description, ErrorKind, Picture, Pixels, ReadOptions};

/// Decodes a Radiance file to 32-bit floats with alpha 1. `PRIMARIES` is applied. `EXPOSURE` and `COLORCORR` are
/// divided out, the products of all their lines, so that the values are the radiance that the file states. Rows and
/// pixels may run in any direction.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let (header, orientation, reader) = header(reader)?;
    // Strict mode accepts only one of the two signatures.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(header).chain(reader)).map_err(explain)?;
    let (width, height) = decoder.dimensions();
    // The decoder's three floats a pixel are there until all are copied, and a picture until it is turned.
    let turned = if orientation == Orientation::UPRIGHT { 0 } else { 16 };
    options.budget.check((width.into(), height.into()), 4, u64::from(width) * u64::from(height) * (12 + turned))?;
    let meta = decoder.metadata();
    let mut bytes = zeroed(width as usize * height as usize * 12)?;
    decoder.read_image(&mut bytes).map_err(explain)?;
    let mut picture = Picture::new(width, height, Pixels::Float(rgba(&bytes)?));
    if orientation != Orientation::UPRIGHT {
        drop(bytes);
        picture = orientation.upright(picture);
    }
    apply(&meta, options.space, &mut picture);
    Ok(picture)
}

/// The header as the decoder knows it, the directions of rows and pixels, and the reader at the first pixel. Lines may
/// end as those of Windows do.
///
/// # Errors
/// A header that is too long or cut short.
fn header<R: BufRead>(mut reader: R) -> Result<(Vec<u8>, Orientation, R), CodecError> {
    let mut header = Vec::new();
    let mut is_size = false;
    loop {
        let start = header.len();
        let most = MAX_HDR_HEADER - start as u64;
        let read = reader.by_ref().take(most).read_until(b'\n', &mut header);
        read.map_err(|error| CodecError::reading(&error))?;
        if header[start..].last() != Some(&b'\n') {
            let is_long = header.len() as u64 >= MAX_HDR_HEADER;
            return Err(if is_long { CodecError::broken("its header is too long") } else { CodecError::cut_short() });
        }
        header.pop();
        if header[start..].last() == Some(&b'\r') {
            header.pop();
        }
        if is_size {
            let line = String::from_utf8_lossy(&header[start..]).into_owned();
            let mut orientation = Orientation::UPRIGHT;
            if let [rows, height, pixels, width] = *line.split_whitespace().collect::<Vec<_>>()
                && let Some(stated) = Orientation::of_axes(rows, pixels)
            {
                orientation = stated;
                header.truncate(start);
                header.extend(format!("-Y {height} +X {width}").into_bytes());
            }
            header.push(b'\n');
            return Ok((header, orientation, reader));
        }
        is_size = header.len() == start;
        header.push(b'\n');
    }
}

pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let (header, orientation, reader) = header(reader)?;
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(header).chain(reader)).map_err(explain)?;
    let (width, height) = decoder.dimensions();
    let stated = stated_primaries(&decoder.metadata());
    let size = orientation.size(width, height);
    Ok(Description {
        color: Some(Colorimetry::linear(stated.unwrap_or(Chromaticities::REC709))),
        stated_by: stated.map(|_| "PRIMARIES"),
        ..Description::of_picture("Radiance HDR", size, &["R", "G", "B"], "RGBE", "runs")
    })
}

fn rgba(rgb: &[u8]) -> Result<Vec<f32>, CodecError> {
    let mut values = filled(rgb.len() / 3, 1.0_f32)?;
    let (pixels, _) = rgb.as_chunks::<12>();
    for (out, bytes) in values.as_chunks_mut::<4>().0.iter_mut().zip(pixels) {
        let (numbers, _) = bytes.as_chunks::<4>();
        for (value, number) in out.iter_mut().zip(numbers) {
            *value = f32::from_ne_bytes(*number);
        }
    }
    Ok(values)
}

fn apply(meta: &HdrMetadata, space: Option<ColorSpace>, picture: &mut Picture) {
    // Radiance stores height / width, EXR width / height.
    if let Some(aspect) = meta.pixel_aspect_ratio.filter(|a| (1e-6..=1e6).contains(a)) {
        picture.meta.image.pixel_aspect = 1.0 / aspect;
    }
    divide(meta, picture);
    // Some programs write eight zeros instead of primaries.
    let stated = space.map(|space| space.primaries).or_else(|| stated_primaries(meta));
    picture.stated = stated.map(Colorimetry::linear);
    let matrix = stated.and_then(|stated| to_rec709(&stated));
    if let (Some(matrix), Pixels::Float(values)) = (matrix, &mut picture.pixels) {
        let matrix = matrix.as_mat3();
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
        }
    }
}

/// Divides by `EXPOSURE` and `COLORCORR`. A divisor that no camera or program has is ignored, with a note.
fn divide(meta: &HdrMetadata, picture: &mut Picture) {
    let exposure = meta.exposure.unwrap_or(1.0);
    let (red, green, blue) = meta.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let divisors = [red * exposure, green * exposure, blue * exposure];
    if !divisors.iter().all(|divisor| (1e-12..=1e12).contains(divisor)) {
        picture.notes.push("`EXPOSURE` or `COLORCORR` of its header is no usable number and is not applied".to_owned());
    } else if let (true, Pixels::Float(values)) = (divisors != [1.0; 3], &mut picture.pixels) {
        for pixel in values.as_chunks_mut::<4>().0 {
            pixel.iter_mut().zip(divisors).for_each(|(value, divisor)| *value /= divisor);
        }
    }
}

fn stated_primaries(meta: &HdrMetadata) -> Option<Chromaticities> {
    let (_, text) = meta.custom_attributes.iter().find(|(name, _)| name == "PRIMARIES")?;
    let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    Chromaticities::from_numbers(numbers.try_into().ok()?)
}

fn explain(error: ImageError) -> CodecError {
    match error {
        ImageError::IoError(error) => CodecError::reading(&error),
        ImageError::Unsupported(what) => {
            CodecError::new(ErrorKind::Unsupported, format!("this Radiance file cannot be read: {what}"))
                .hint("save it again as RGBE, or as EXR")
        }
        other => CodecError::broken(other),
    }
}
