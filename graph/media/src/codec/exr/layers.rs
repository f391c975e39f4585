//! Channels and parts of an EXR file besides its picture. They are written unchanged beside a new
//! picture.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use afterimage_base::color::{Chromaticities, Transfer};
use exr::block::chunk::Chunk;
use exr::block::reader::Reader;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::math::Vec2;
use exr::meta::attribute::Text;
use exr::meta::header::{Header, LayerAttributes};
use rayon::prelude::*;

use super::attributes::remove_unwritable;
use super::blocks::{missing_blocks, read_batches, unpack};
use super::colors::file_colors;
use super::label::is_cryptomatte;
use super::pack::Parts;
use super::read::{Opened, open};
use super::rows::ExrRows;
use super::select::{Choice, choose, color_channels};
use super::write::{finish_attributes, part_of, picture_names};
use super::{explain, text};
use crate::codec::encoding::{Buffer, Image, RowWriter as _};
use crate::codec::limits::{check_size, zeroed};
use crate::codec::{CodecError, Encoding, Metadata, ReadOptions, guarded};

/// Files round their chromaticities, so primaries that differ by less count as equal.
const TOLERANCE: f64 = 1e-3;

/// Encodes a picture that replaces the one of `original`, whose other channels and parts are preserved. Returns the
/// file, and sentences about what is left out.
pub(crate) fn encode_beside(
    image: Image<'_>,
    encoding: &Encoding,
    original: impl Read + Seek,
    layer: Option<&str>,
    reading: &ReadOptions,
) -> Result<(Vec<u8>, Vec<String>), CodecError> {
    let Image { size, samples, meta, .. } = image;
    check_size((size.0.into(), size.1.into()), u64::from(encoding.bits / 8))?;
    let default = Metadata::of_size(size.0, size.1);
    let meta = meta.unwrap_or(&default);
    let Opened { reader, headers: old } = open(original)?;
    let PreservedLayers { part, channels, parts, primaries, mut notes } =
        PreservedLayers::of(&old, size, encoding, layer, reading)?;
    let encoding = &Encoding { primaries, ..*encoding };
    let is_alone = channels.is_empty() && parts.is_empty();
    let names = match is_alone {
        true => picture_names(),
        false => choose(&old, layer).map(|choice| written_names(&old[part], &choice))?,
    };
    let list = channels.iter().map(|&channel| old[part].channels.list[channel].clone()).collect();
    let (mut header, columns) = part_of(size, meta, encoding, &names, list, parts.is_empty());
    keep_attributes(&old[part].own_attributes, &mut header.own_attributes, !channels.is_empty());
    notes.extend(finish_attributes(&mut header, meta));
    let bytes: usize = channels.iter().map(|&c| old[part].channels.list[c].sample_type.bytes_per_sample()).sum();
    let needed = bytes as u64 * u64::from(size.0) * u64::from(size.1);
    reading.budget.check((size.0.into(), size.1.into()), 4, needed)?;
    let mut rest =
        Rest { part, parts: &parts, channels: &channels, rows: zeroed(needed as usize)?, chunks: Vec::new() };
    if !is_alone {
        rest.read(reader)?;
    }
    let (preserved, mut chunks) = (rest.rows, rest.chunks);
    let order: Vec<usize> = (0..old.len()).filter(|index| *index == part || parts.contains(index)).collect();
    let place = |old: usize| order.iter().position(|index| *index == old).expect("only kept parts are read");
    chunks.iter_mut().for_each(|(_, chunk)| chunk.layer_index = place(chunk.layer_index));
    let mut headers = Vec::new();
    for &index in &order {
        let mut new = if index == part { header.clone() } else { old[index].clone() };
        new.shared_attributes = header.shared_attributes.clone();
        notes.extend(remove_unwritable(&mut new));
        headers.push(new);
    }
    let file = Buffer::default();
    let parts = Parts { headers, picture: place(part), columns, preserved };
    let mut rows = ExrRows::of_parts(Box::new(file.clone()), size.0, parts, encoding.conversion())?;
    rows.write(samples)?;
    for (index, chunk) in &chunks {
        rows.write_chunk(*index, chunk)?;
    }
    Box::new(rows).finish()?;
    Ok((file.into_bytes(), notes))
}

/// Sentences about the channels and parts besides the picture, with the reason why they are left out.
pub(crate) fn left_out(original: impl Read + Seek, layer: Option<&str>, why: &str) -> Result<Vec<String>, CodecError> {
    let Opened { headers, .. } = open(original)?;
    let mut kept = PreservedLayers::all(&headers, &choose(&headers, layer)?);
    kept.leave_out(&headers, |_, _| true, why);
    Ok(kept.notes)
}

/// Channels and parts of a file that are preserved beside a new picture.
struct PreservedLayers {
    /// The part with the picture.
    part: usize,
    /// Its channels that are no part of the picture.
    channels: Vec<usize>,
    parts: Vec<usize>,
    /// The primaries of the new file.
    primaries: Option<Chromaticities>,
    /// Sentences about what is left out, and why.
    notes: Vec<String>,
}

impl PreservedLayers {
    /// All that is no part of the picture.
    fn all(headers: &[Header], choice: &Choice) -> Self {
        let part = choice.part;
        // Data is read by the pipeline and not replaced by its result.
        let is_replaced = |channel: &usize| choice.is_color && choice.slots.contains(&Some(*channel));
        let channels = (0..headers[part].channels.list.len()).filter(|channel| !is_replaced(channel)).collect();
        let parts = (0..headers.len()).filter(|index| *index != part).collect();
        Self { part, channels, parts, primaries: None, notes: Vec::new() }
    }

    fn of(
        headers: &[Header],
        size: (u32, u32),
        encoding: &Encoding,
        layer: Option<&str>,
        reading: &ReadOptions,
    ) -> Result<Self, CodecError> {
        let choice = choose(headers, layer)?;
        let (part, header) = (choice.part, &headers[choice.part]);
        let mut kept = Self { primaries: encoding.primaries, ..Self::all(headers, &choice) };
        let data = header.data_window();
        let window = if reading.data_window { data } else { header.shared_attributes.display_window };
        if window.size != Vec2(size.0 as usize, size.1 as usize) {
            kept.leave_out(headers, |_, _| true, "the picture has another size");
        } else if window != data {
            kept.leave_out(headers, |_, _| true, "the file has pixels of a part of its window only, or beside it");
        }
        let names = written_names(header, &choice);
        let is_taken =
            |index: usize, channel: usize| index == part && names.contains(&headers[index].channels.list[channel].name);
        kept.leave_out(headers, is_taken, "the picture has channels of that name");
        kept.choose_primaries(headers, encoding, reading)?;
        let mut packed = kept.channels.iter().map(|channel| header.channels.list[*channel].sample_type);
        if packed.any(|samples| !encoding.compression.is_lossless_for(samples)) {
            kept.notes.push(format!("the compression {} changes channels that are kept", encoding.compression.name()));
        }
        Ok(kept)
    }

    /// Preserved color layers keep their values, so the file keeps its primaries; otherwise they are left out.
    fn choose_primaries(
        &mut self,
        headers: &[Header],
        encoding: &Encoding,
        reading: &ReadOptions,
    ) -> Result<(), CodecError> {
        let colors: Vec<Vec<usize>> = headers.iter().map(color_channels).collect();
        let has_colors = self.parts.iter().any(|part| !colors[*part].is_empty())
            || self.channels.iter().any(|channel| colors[self.part].contains(channel));
        if encoding.color.is_none() || !has_colors {
            return Ok(());
        }
        let header = &headers[self.part];
        let (own, transfer) = match reading.space {
            Some(space) => (space.primaries, Transfer::Linear),
            None => file_colors(header)?.unwrap_or((Chromaticities::REC709, Transfer::Linear)),
        };
        if transfer != Transfer::Linear {
            let why = "their numbers are encoded, and those of the output are light";
            self.leave_out(headers, |part, channel| colors[part].contains(&channel), why);
            return Ok(());
        }
        match self.primaries {
            // The file that states colors that are not known does not state others now.
            None if own == Chromaticities::REC709 && encoding.color.is_some_and(|color| color.primaries == own) => {}
            None => self.primaries = Some(own),
            Some(asked) if asked.close_to(&own, TOLERANCE) => {}
            Some(_) => {
                let why = "they are light in the primaries of the input, and the output has others";
                self.leave_out(headers, |part, channel| colors[part].contains(&channel), why);
            }
        }
        Ok(())
    }

    /// Leaves channels out, and other parts with such a channel.
    fn leave_out(&mut self, headers: &[Header], is_out: impl Fn(usize, usize) -> bool, why: &str) {
        let mut out = Vec::new();
        let part = self.part;
        let name = |part: usize, channel: usize| format!("`{}`", text(&headers[part].channels.list[channel].name));
        self.channels.retain(|channel| {
            out.extend(is_out(part, *channel).then(|| name(part, *channel)));
            !is_out(part, *channel)
        });
        self.parts.retain(|&part| {
            let leaves = (0..headers[part].channels.list.len()).any(|channel| is_out(part, channel));
            let title = headers[part].own_attributes.layer_name.as_ref().map_or_else(String::new, text);
            out.extend(leaves.then(|| format!("part `{title}`")));
            !leaves
        });
        if !out.is_empty() {
            self.notes.push(format!("left out: {}; {why}", shortened(&out)));
        }
    }
}

/// Some of the names, and how many there are more.
fn shortened(names: &[String]) -> String {
    const ENOUGH: usize = 12;
    match names.len().checked_sub(ENOUGH + 1) {
        None => names.join(", "),
        Some(more) => format!("{} and {} more", names[..ENOUGH].join(", "), more + 1),
    }
}

/// The names of red, green, blue and alpha of the new picture: those of the old one, or such names in its layer.
fn written_names(header: &Header, choice: &Choice) -> [Text; 4] {
    let name = |channel: usize| header.channels.list[channel].name.clone();
    let first = choice.slots.iter().flatten().next().map(|channel| name(*channel)).unwrap_or_default();
    let dot = first.as_slice().iter().rposition(|byte| *byte == b'.');
    let layer = dot.map_or(&[][..], |dot| &first.as_slice()[..=dot]);
    let mut names = picture_names().map(|name| Text::from_slice_unchecked(&[layer, name.as_slice()].concat()));
    if choice.is_rgb() {
        for (new, old) in names.iter_mut().zip(choice.slots) {
            new.clone_from(&old.map_or_else(|| new.clone(), name));
        }
    }
    names
}

/// The attributes that belong to the place of the part in its file, and to its channels if there are other ones.
fn keep_attributes(old: &LayerAttributes, new: &mut LayerAttributes, has_channels: bool) {
    new.layer_name.clone_from(&old.layer_name);
    new.view_name.clone_from(&old.view_name);
    new.multi_view_names.clone_from(&old.multi_view_names);
    let manifests = old.other.iter().filter(|(name, _)| has_channels && is_cryptomatte(&text(name)));
    new.other.extend(manifests.map(|(name, value)| (name.clone(), value.clone())));
}

/// The pixels that are kept.
struct Rest<'a> {
    part: usize,
    parts: &'a [usize],
    channels: &'a [usize],
    /// The channels of the picture's part: for each row, channel after channel.
    rows: Vec<u8>,
    /// The other parts as they are stored: chunks, and their places in the table of offsets.
    chunks: Vec<(usize, Chunk)>,
}

impl Rest<'_> {
    fn read<R: Read + Seek>(&mut self, reader: Reader<R>) -> Result<(), CodecError> {
        let places: Vec<_> = reader.headers().iter().map(places).collect();
        let (part, parts, has_channels) = (self.part, self.parts, !self.channels.is_empty());
        let is_kept = |block: &BlockIndex, level: Vec2<usize>| {
            has_channels && block.layer == part && level == Vec2(0, 0) || parts.contains(&block.layer)
        };
        let (block_bytes, mut found) = (reader.headers()[part].max_block_byte_size(), 0);
        let expected = read_batches(reader, block_bytes, is_kept, |batch, meta| {
            found += batch.len();
            let (unpacked, stored): (Vec<_>, Vec<_>) = batch.into_iter().partition(|chunk| chunk.layer_index == part);
            for chunk in stored {
                let header = &meta.headers[chunk.layer_index];
                let tile = header.get_block_data_indices(&chunk.compressed_block).map_err(|error| explain(&error))?;
                let place = places[chunk.layer_index].get(&key(tile.level_index, tile.tile_index)).copied();
                self.chunks.push((place.ok_or_else(missing_blocks)?, chunk));
            }
            let blocks = unpacked.into_par_iter().map(|chunk| guarded(|| unpack(chunk, meta)));
            for block in blocks.collect::<Result<Vec<_>, _>>()? {
                self.place(&meta.headers[part], &block);
            }
            Ok(())
        })?;
        if found == expected { Ok(()) } else { Err(missing_blocks()) }
    }

    fn place(&mut self, header: &Header, block: &UncompressedBlock) {
        let size = |channel: usize| header.channels.list[channel].sample_type.bytes_per_sample();
        let (at, extent) = (block.index.pixel_position, block.index.pixel_size);
        let stride = self.channels.iter().map(|channel| size(*channel)).sum::<usize>() * header.layer_size.0;
        let line = header.channels.bytes_per_pixel * extent.0;
        let mut start = 0;
        for &channel in self.channels {
            let before = (0..channel).map(size).sum::<usize>() * extent.0;
            for row in 0..extent.1 {
                let bytes = &block.data[row * line + before..][..extent.0 * size(channel)];
                let to = (at.1 + row) * stride + start + at.0 * size(channel);
                self.rows[to..to + bytes.len()].copy_from_slice(bytes);
            }
            start += header.layer_size.0 * size(channel);
        }
    }
}

/// A block by its level and its place there, both down and across.
type Key = [usize; 4];

fn key(level: Vec2<usize>, tile: Vec2<usize>) -> Key {
    [level.1, level.0, tile.1, tile.0]
}

/// The place of each block in the table of offsets.
fn places(header: &Header) -> BTreeMap<Key, usize> {
    let blocks = header.blocks_increasing_y_order().enumerate();
    blocks.map(|(index, tile)| (key(tile.location.level_index, tile.location.tile_index), index)).collect()
}
