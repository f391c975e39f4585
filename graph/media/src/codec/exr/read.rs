//! Reads the headers of an EXR file, and decodes a layer to a picture.

use std::io::{Read, Seek, SeekFrom};

use afterimage_base::color::{Chromaticities, Transfer, Xy};
use exr::block::reader::Reader;
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{IntegerBounds, SampleType};
use exr::meta::header::{Header, standard_names};

use super::attributes::{Head, is_window, keep_bytes};
use super::blocks::BATCH_BYTES;
use super::colors::{adapted, color_note, stated_color, stated_colors, to_attribute};
use super::decode::{Placement, decode_blocks};
use super::label::{Interop, interop, is_data};
use super::select::{Choice, choose, chosen_layer};
use super::{explain, subsampled};
use crate::codec::chromaticities::adopted_white;
use crate::codec::codes::Colors;
use crate::codec::limits::{MAX_BLOCK_BYTES, MAX_EXR_HEADER, MAX_SIDE, too_large};
use crate::codec::metered::Metered;
use crate::codec::{CodecError, Metadata, Picture, Pixels, ReadOptions};

/// Decodes the chosen layer of an EXR file: its data window, or placed in its display window.
pub(crate) fn decode(
    reader: impl Read + Seek,
    layer: Option<&str>,
    options: &ReadOptions,
) -> Result<Picture, CodecError> {
    let Opened { reader, headers } = open(reader)?;
    let choice = choose(&headers, layer)?;
    let header = &headers[choice.part];
    let colors = match options.space.filter(|_| choice.is_rgb()) {
        Some(space) => Some((space.primaries, Transfer::Linear)),
        None => stated_colors(header, &choice)?,
    };
    let primaries = colors.map(|(primaries, _)| primaries);
    let colors = colors.map(|colors| Colors::new(Some(colors), None));
    let data = header.data_window();
    let whole = if options.data_window { data } else { header.shared_attributes.display_window };
    let display = options.rows.map_or(whole, |rows| part(whole, rows));
    let pixel_type = pixel_type(header, &choice);
    let sample_bytes = if pixel_type == SampleType::F16 { 2 } else { 4 };
    options.budget.check((display.size.0 as u64, display.size.1 as u64), sample_bytes, working_bytes(header))?;
    let stated = colors.as_ref().and_then(|colors| colors.stated).map(|color| stated_color(header, color));
    let placement = Placement { choice, display, data, colors };
    let pixels = match pixel_type {
        SampleType::F16 => Pixels::Half(decode_blocks(reader, &placement)?),
        _ => Pixels::Float(decode_blocks(reader, &placement)?),
    };
    let (width, height) = (display.size.0 as u32, display.size.1 as u32);
    let mut notes = notes(&headers, &choice, layer, whole);
    let mut meta = metadata(header, &choice, primaries.as_ref());
    if options.space.is_none() {
        notes.extend(color_note(header, &choice));
        let is_known = matches!(interop(header), None | Some(Interop::Space(..)));
        meta.has_unknown_colors = !choice.is_color || choice.is_rgb() && !is_known;
    }
    meta.data_size = options.data_window.then_some((width, whole.size.1 as u32));
    Ok(Picture { width, height, pixels, meta, stated, notes })
}

/// These rows of a window, or those of them that it has, and the first at least.
fn part(window: IntegerBounds, [first, count]: [u32; 2]) -> IntegerBounds {
    let rows = window.size.1;
    let first = (first as usize).min(rows.saturating_sub(1));
    let position = Vec2(window.position.0, window.position.1.saturating_add(first as i32));
    IntegerBounds { position, size: Vec2(window.size.0, (count as usize).clamp(1, (rows - first).max(1))) }
}

/// A file whose headers are read.
pub(super) struct Opened<R> {
    pub(super) reader: Reader<Metered<R>>,
    /// The headers of all parts, with the attributes as they are stored.
    pub(super) headers: Vec<Header>,
}

/// Reads the headers and refuses what would exhaust memory later.
pub(super) fn open<R: Read + Seek>(mut reader: R) -> Result<Opened<R>, CodecError> {
    let failed = |error| CodecError::reading(&error);
    let length = reader.seek(SeekFrom::End(0)).map_err(failed)?;
    reader.rewind().map_err(failed)?;
    // What cannot be read here is reported by the decoder, which says more.
    let head = Head::read(reader.by_ref().take(MAX_EXR_HEADER));
    reader.rewind().map_err(failed)?;
    let (reader, allowance) = Metered::new(reader, MAX_EXR_HEADER);
    let reader = exr::block::read(reader, false).map_err(|error| explain_header(&error, head.as_ref().ok()))?;
    let head = head.map_err(failed)?;
    allowance.lift();
    let mut headers = reader.headers().to_vec();
    for (part, header) in headers.iter_mut().enumerate() {
        check_header(header)?;
        check_windows(&head, part)?;
        keep_bytes(header, head.parts.get(part).map_or(&[], Vec::as_slice));
    }
    // The headers are followed by a table with the offset of each block, in eight bytes.
    let blocks: u64 = headers.iter().map(|header| header.chunk_count as u64).sum();
    if blocks.saturating_mul(8) > length {
        return Err(CodecError::cut_short());
    }
    Ok(Opened { reader, headers })
}

/// The error of a header; it names the channel or the attribute if that is known.
fn explain_header(error: &Error, head: Option<&Head>) -> CodecError {
    let known = match error {
        Error::Invalid(what) | Error::NotSupported(what) if what.contains("sampling") => {
            subsampled(&head.map(Head::subsampled).unwrap_or_default())
        }
        Error::Invalid(_) => head.and_then(Head::fault).map(CodecError::broken),
        _ => None,
    };
    known.unwrap_or_else(|| explain(error))
}

/// Reads the headers of a file that was written, and reports what another reader would refuse.
pub(crate) fn check(mut reader: impl Read + Seek) -> Result<(), CodecError> {
    let head = Head::read(reader.by_ref().take(MAX_EXR_HEADER)).map_err(|error| CodecError::reading(&error))?;
    reader.rewind().map_err(|error| CodecError::reading(&error))?;
    open(reader)?;
    head.fault().map_or(Ok(()), |fault| Err(CodecError::broken(fault)))
}

/// The decoder takes a window whose corners are swapped for the window between them.
fn check_windows(head: &Head, part: usize) -> Result<(), CodecError> {
    for (name, what) in [(standard_names::DISPLAY_WINDOW, "display"), (standard_names::DATA_WINDOW, "data")] {
        if head.value(part, name).is_some_and(|window| !is_window(window)) {
            return Err(CodecError::broken(format!("its {what} window is empty or inverted")));
        }
    }
    Ok(())
}

fn check_header(header: &Header) -> Result<(), CodecError> {
    let (width, height) = (header.layer_size.0 as u64, header.layer_size.1 as u64);
    if width == 0 || height == 0 {
        return Err(CodecError::broken("a data window is empty"));
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(too_large(format!("a data window has {width}×{height} pixels"))
            .hint(format!("a side may have at most {MAX_SIDE} pixels")));
    }
    let block = block_bytes(header);
    if block > MAX_BLOCK_BYTES {
        return Err(too_large(format!("one of its blocks takes {} MiB", block >> 20))
            .hint(format!("a block may take at most {} MiB", MAX_BLOCK_BYTES >> 20)));
    }
    Ok(())
}

/// Width and height of the largest block.
fn block_size(header: &Header) -> (u64, u64) {
    match header.blocks {
        BlockDescription::Tiles(tiles) => (tiles.tile_size.0 as u64, tiles.tile_size.1 as u64),
        BlockDescription::ScanLines => (header.layer_size.0 as u64, header.compression.scan_lines_per_block() as u64),
    }
}

/// Bytes of the largest block, all channels together.
fn block_bytes(header: &Header) -> u64 {
    let (width, height) = block_size(header);
    (header.channels.bytes_per_pixel as u64).saturating_mul(width).saturating_mul(height)
}

/// Bytes that the blocks of a batch take while they are decoded: as stored, as the decompressor leaves them, and as
/// samples.
pub(super) fn working_bytes(header: &Header) -> u64 {
    3 * block_bytes(header).max(BATCH_BYTES as u64)
}

/// Half where every chosen channel is half; float can hold all else.
fn pixel_type(header: &Header, choice: &Choice) -> SampleType {
    let mut chosen = choice.slots.iter().flatten();
    let all_half = chosen.all(|&slot| header.channels.list[slot].sample_type == SampleType::F16);
    if all_half { SampleType::F16 } else { SampleType::F32 }
}

/// The attributes of the file, as they hold for pixels that [`decode`] has converted to Rec.709.
fn metadata(header: &Header, choice: &Choice, primaries: Option<&Chromaticities>) -> Metadata {
    let mut image = header.shared_attributes.clone();
    if is_data(header) {
        image.chromaticities = None;
    } else if choice.is_color && image.chromaticities.is_some() {
        image.chromaticities = Some(to_attribute(&Chromaticities::REC709));
    }
    let mut layer = header.own_attributes.clone();
    if let Some(primaries) = primaries {
        layer.adopted_neutral = layer.adopted_neutral.and_then(|xy| adapted(xy, adopted_white(primaries), Xy::D65));
    }
    let block_rows = u32::try_from(block_size(header).1).ok();
    Metadata { image, layer, data_size: None, block_rows, has_unknown_colors: false }
}

/// Sentences about the layer that is read, and about what the picture, which is this window, lacks of the file.
pub(super) fn notes(headers: &[Header], choice: &Choice, layer: Option<&str>, window: IntegerBounds) -> Vec<String> {
    let header = &headers[choice.part];
    let mut notes: Vec<String> = chosen_layer(headers).filter(|_| layer.is_none()).into_iter().collect();
    if !contains(window, header.data_window()) {
        notes.push("pixels outside the display window are left out".to_owned());
    }
    let mut chosen = choice.slots.iter().flatten();
    if chosen.any(|&slot| header.channels.list[slot].sample_type == SampleType::U32) {
        notes.push("integers beyond 16777216 lose their last digits as 32-bit floats".to_owned());
    }
    notes
}

fn contains(outer: IntegerBounds, inner: IntegerBounds) -> bool {
    let (inner_end, outer_end) = (inner.end(), outer.end());
    let begins_inside = inner.position.0 >= outer.position.0 && inner.position.1 >= outer.position.1;
    begins_inside && inner_end.0 <= outer_end.0 && inner_end.1 <= outer_end.1
}
