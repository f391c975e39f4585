//! From the file's header to a picture.

use std::io::{Read, Seek, SeekFrom};

use afterimage_base::color::{Chromaticities, Colorimetry, Cones, Decimal, Xy};
use exr::block::reader::Reader;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{Chromaticities as ExrChromaticities, IntegerBounds, SampleType};
use exr::meta::header::Header;

use super::decode::{BATCH_BYTES, Placement, decode_blocks};
use super::label::named_primaries;
use super::select::{Choice, choose};
use super::{explain, unsupported};
use crate::codec::chromaticities::to_rec709;
use crate::codec::limits::{MAX_BLOCK_BYTES, MAX_EXR_HEADER, MAX_SIDE, too_large};
use crate::codec::metered::Metered;
use crate::codec::{CodecError, Metadata, Picture, Pixels, ReadOptions};

/// Decodes the chosen layer of an EXR file: its data window, or placed in its display window.
pub(crate) fn decode(
    reader: impl Read + Seek,
    layer: Option<&str>,
    options: &ReadOptions,
) -> Result<Picture, CodecError> {
    let reader = open(reader)?;
    let choice = choose(reader.headers(), layer)?;
    let header = reader.headers()[choice.part].clone();
    let primaries = match options.space.filter(|_| has_primaries(&choice)) {
        Some(space) => Some(space.primaries),
        None => stated_primaries(&header, &choice)?,
    };
    let color = primaries.as_ref().and_then(to_rec709).map(|matrix| matrix.as_mat3());
    let data = header.data_window();
    let whole = if options.data_window { data } else { header.shared_attributes.display_window };
    let display = options.rows.map_or(whole, |rows| part(whole, rows));
    let pixel_type = pixel_type(&header, &choice);
    let sample_bytes = if pixel_type == SampleType::F16 { 2 } else { 4 };
    options.budget.check((display.size.0 as u64, display.size.1 as u64), sample_bytes, working_bytes(&header))?;
    let placement = Placement { choice, display, data, color };
    let pixels = match pixel_type {
        SampleType::F16 => Pixels::Half(decode_blocks(reader, &placement)?),
        _ => Pixels::Float(decode_blocks(reader, &placement)?),
    };
    let (width, height) = (display.size.0 as u32, display.size.1 as u32);
    let notes = notes(&header, &placement.choice, whole);
    let mut meta = metadata(&header, &choice, primaries.as_ref());
    meta.data_size = options.data_window.then_some((width, whole.size.1 as u32));
    let stated = primaries.map(|primaries| stated_color(&header, primaries));
    Ok(Picture { width, height, pixels, meta, stated, notes })
}

/// These rows of a window, or those of them that it has, and the first at least.
fn part(window: IntegerBounds, [first, count]: [u32; 2]) -> IntegerBounds {
    let rows = window.size.1;
    let first = (first as usize).min(rows.saturating_sub(1));
    let position = Vec2(window.position.0, window.position.1.saturating_add(first as i32));
    IntegerBounds { position, size: Vec2(window.size.0, (count as usize).clamp(1, (rows - first).max(1))) }
}

/// Reads the headers and refuses what would exhaust memory later.
pub(super) fn open<R: Read + Seek>(mut reader: R) -> Result<Reader<Metered<R>>, CodecError> {
    let failed = |error| CodecError::reading(&error);
    let length = reader.seek(SeekFrom::End(0)).map_err(failed)?;
    reader.rewind().map_err(failed)?;
    let (reader, allowance) = Metered::new(reader, MAX_EXR_HEADER);
    let reader = exr::block::read(reader, false).map_err(|error| explain(&error))?;
    allowance.lift();
    for header in reader.headers() {
        check_header(header)?;
    }
    // The headers are followed by a table with the offset of each block, in eight bytes.
    let blocks: u64 = reader.headers().iter().map(|header| header.chunk_count as u64).sum();
    if blocks.saturating_mul(8) > length {
        return Err(CodecError::cut_short());
    }
    Ok(reader)
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

/// Whether the numbers depend on primaries: not those of gray and of data.
fn has_primaries(choice: &Choice) -> bool {
    choice.is_color && choice.slots[0] != choice.slots[1]
}

/// The primaries that the file states; `None` if it states none, and for gray and data, which need none.
pub(super) fn stated_primaries(header: &Header, choice: &Choice) -> Result<Option<Chromaticities>, CodecError> {
    if !has_primaries(choice) {
        return Ok(None);
    }
    file_primaries(header)
}

/// The primaries that the file states for all its layers of light.
pub(super) fn file_primaries(header: &Header) -> Result<Option<Chromaticities>, CodecError> {
    let Some(attribute) = header.shared_attributes.chromaticities else { return Ok(named_primaries(header)) };
    let primaries = from_attribute(&attribute).ok_or_else(|| {
        unsupported("its `chromaticities` attribute describes no color space")
            .hint("correct or remove that attribute; without it, Rec.709 is assumed")
    })?;
    Ok(Some(primaries))
}

fn from_attribute(attribute: &ExrChromaticities) -> Option<Chromaticities> {
    let points = [attribute.red, attribute.green, attribute.blue, attribute.white];
    let numbers: Vec<f64> = points.iter().flat_map(|xy| [xy.0.into(), xy.1.into()]).collect();
    Chromaticities::from_numbers(numbers.try_into().expect("four points have eight numbers"))
}

pub(super) fn to_attribute(primaries: &Chromaticities) -> ExrChromaticities {
    let [red, green, blue, white] = primaries.points().map(point);
    ExrChromaticities { red, green, blue, white }
}

pub(super) fn point(xy: Xy) -> Vec2<f32> {
    Vec2(xy.x.get() as f32, xy.y.get() as f32)
}

/// `whiteLuminance` and `adoptedNeutral` are stated only with the primaries that they belong to.
pub(super) fn stated_color(header: &Header, primaries: Chromaticities) -> Colorimetry {
    let own = &header.own_attributes;
    let white_nits = own.white_luminance.filter(|nits| (1e-6..=1e9).contains(nits)).map(Decimal::from);
    let adopted_white = own.adopted_neutral.map(|xy| Xy::from([xy.0, xy.1]));
    Colorimetry { white_nits, adopted_white, ..Colorimetry::linear(primaries) }
}

/// A chromaticity after the adaptation from one white to another, which the pixels undergo, too.
pub(super) fn adapted(xy: Vec2<f32>, from: Xy, to: Xy) -> Option<Vec2<f32>> {
    let adapt = Cones::Bradford.adaptation(from.to_xyz(), to.to_xyz());
    let at = adapt * Xy::from([xy.0, xy.1]).to_xyz();
    let sum = at.element_sum();
    at.is_finite().then(|| point(Xy::new(at.x / sum, at.y / sum)))
}

/// The attributes of the file, as they hold for pixels that [`decode`] has converted to Rec.709.
fn metadata(header: &Header, choice: &Choice, primaries: Option<&Chromaticities>) -> Metadata {
    let mut image = header.shared_attributes.clone();
    if choice.is_color && image.chromaticities.is_some() {
        image.chromaticities = Some(to_attribute(&Chromaticities::REC709));
    }
    let mut layer = header.own_attributes.clone();
    if let Some(primaries) = primaries {
        layer.adopted_neutral = layer.adopted_neutral.and_then(|xy| adapted(xy, primaries.white, Xy::D65));
    }
    Metadata { image, layer, data_size: None, block_rows: u32::try_from(block_size(header).1).ok() }
}

/// What the picture, which is this window, does not have of the file.
pub(super) fn notes(header: &Header, choice: &Choice, window: IntegerBounds) -> Vec<String> {
    let mut notes = Vec::new();
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
