//! Blocks to pixels: the rows of each block are interleaved, and pasted into place.

use std::collections::BTreeSet;
use std::io::{Read, Seek};
use std::ops::Range;

use exr::block::chunk::Chunk;
use exr::block::reader::Reader;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{IntegerBounds, SampleType};
use exr::meta::header::Header;
use half::f16;
use rayon::prelude::*;

use super::blocks::{missing_blocks, read_batches, unpack};
use super::select::Choice;
use crate::codec::codes::Colors;
use crate::codec::limits::zeroed;
use crate::codec::{CodecError, guarded};

/// The channels to read, and their place in the display window.
pub(super) struct Placement {
    pub(super) choice: Choice,
    pub(super) display: IntegerBounds,
    pub(super) data: IntegerBounds,
    /// The meaning of the numbers; `None` for those that stay as they are.
    pub(super) colors: Option<Colors>,
}

/// A number of the picture: half or float.
pub(super) trait Sample: Copy + Send + Sync + bytemuck::Zeroable {
    const ZERO: Self;
    const ONE: Self;
    fn from_half(value: f16) -> Self;
    fn from_float(value: f32) -> Self;
    fn to_float(self) -> f32;
}

impl Sample for f16 {
    const ZERO: Self = f16::ZERO;
    const ONE: Self = f16::ONE;
    fn from_half(value: f16) -> Self {
        value
    }
    fn from_float(value: f32) -> Self {
        f16::from_f32(value)
    }
    fn to_float(self) -> f32 {
        self.to_f32()
    }
}

impl Sample for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    fn from_half(value: f16) -> Self {
        value.to_f32()
    }
    fn from_float(value: f32) -> Self {
        value
    }
    fn to_float(self) -> f32 {
        self
    }
}

/// Interleaved RGBA rows of one block, cropped to the display window.
struct Piece<T> {
    block: Vec2<usize>,
    x: usize,
    y: usize,
    width: usize,
    values: Vec<T>,
}

/// Decodes the largest level of the chosen channels into the display window.
pub(super) fn decode_blocks<T: Sample, R: Read + Seek>(
    reader: Reader<R>,
    placement: &Placement,
) -> Result<Vec<T>, CodecError> {
    let (width, height) = (placement.display.size.0, placement.display.size.1);
    let mut picture = zeroed::<T>(width * height * 4)?;
    let block_bytes = reader.headers()[placement.choice.part].max_block_byte_size();
    let mut seen = BTreeSet::new();
    let is_shown = |block: &BlockIndex, level: Vec2<usize>| level == Vec2(0, 0) && placement.shows(block);
    let expected = read_batches(reader, block_bytes, is_shown, |batch, meta| {
        let pieces = batch.into_par_iter().map(|chunk| guarded(|| placement.decode_chunk(chunk, meta)));
        let mut pieces: Vec<Piece<T>> = pieces.collect::<Result<_, _>>()?;
        seen.extend(pieces.iter().map(|piece| (piece.block.0, piece.block.1)));
        pieces.sort_by_key(|piece| (piece.y, piece.x));
        paste_all(&mut picture, width, &pieces);
        Ok(())
    })?;
    // A table that points twice at one block would leave a hole elsewhere.
    if seen.len() == expected { Ok(picture) } else { Err(missing_blocks()) }
}

/// Puts pieces, sorted by their rows, into place: on all cores if those that begin in one row are a row of tiles.
fn paste_all<T: Sample>(picture: &mut [T], width: usize, pieces: &[Piece<T>]) {
    let groups: Vec<&[Piece<T>]> = pieces.chunk_by(|one, other| one.y == other.y).collect();
    match bands(picture, width, &groups) {
        Some(bands) => bands.into_par_iter().zip(groups).for_each(|(band, group)| {
            let rows = band.par_chunks_exact_mut(width * 4).enumerate();
            rows.for_each(|(row, to)| group.iter().for_each(|piece| piece.paste(row, to)));
        }),
        None => {
            for piece in pieces {
                let rows = picture[piece.y * width * 4..].chunks_exact_mut(width * 4).enumerate();
                rows.take(piece.height()).for_each(|(row, to)| piece.paste(row, to));
            }
        }
    }
}

/// The rows of the picture for each group of pieces; `None` unless all pieces of a group have as many rows, and each
/// group begins after the one before.
fn bands<'p, T: Copy>(picture: &'p mut [T], width: usize, groups: &[&[Piece<T>]]) -> Option<Vec<&'p mut [T]>> {
    let (mut rest, mut at) = (picture, 0);
    let mut bands = Vec::with_capacity(groups.len());
    for group in groups {
        let (first, rows) = (group[0].y, group[0].height());
        let is_even = group.iter().all(|piece| piece.height() == rows);
        let (_, after) = rest.split_at_mut_checked(first.checked_sub(at).filter(|_| is_even)? * width * 4)?;
        let (band, after) = after.split_at_mut_checked(rows * width * 4)?;
        bands.push(band);
        (rest, at) = (after, first + rows);
    }
    Some(bands)
}

impl<T: Copy> Piece<T> {
    fn height(&self) -> usize {
        self.values.len() / (4 * self.width).max(1)
    }

    /// Puts one of its rows into that row of the picture.
    fn paste(&self, row: usize, to: &mut [T]) {
        let length = self.width * 4;
        to[self.x * 4..][..length].copy_from_slice(&self.values[row * length..][..length]);
    }
}

impl Placement {
    /// Columns and rows of the block that lie inside the display window, counted in the block.
    fn visible(&self, block: &BlockIndex) -> (Range<usize>, Range<usize>) {
        let span = |display: (i32, usize), data: i32, at: usize, size: usize| {
            let start = i64::from(data) + at as i64;
            let first = (i64::from(display.0) - start).clamp(0, size as i64);
            let last = (i64::from(display.0) + display.1 as i64 - start).clamp(first, size as i64);
            first as usize..last as usize
        };
        let (position, size) = (self.display.position, self.display.size);
        let (at, block_size) = (block.pixel_position, block.pixel_size);
        (
            span((position.0, size.0), self.data.position.0, at.0, block_size.0),
            span((position.1, size.1), self.data.position.1, at.1, block_size.1),
        )
    }

    fn shows(&self, block: &BlockIndex) -> bool {
        let (columns, rows) = self.visible(block);
        block.layer == self.choice.part && !columns.is_empty() && !rows.is_empty()
    }

    fn decode_chunk<T: Sample>(&self, chunk: Chunk, meta: &MetaData) -> Result<Piece<T>, CodecError> {
        let block = unpack(chunk, meta)?;
        if block.index.level != Vec2(0, 0) || !self.shows(&block.index) {
            return Err(missing_blocks());
        }
        Ok(self.interleave(&meta.headers[self.choice.part], &block))
    }

    fn interleave<T: Sample>(&self, header: &Header, block: &UncompressedBlock) -> Piece<T> {
        let (columns, rows) = self.visible(&block.index);
        let width = columns.len();
        let mut values = [T::ZERO, T::ZERO, T::ZERO, T::ONE].repeat(width * rows.len());
        let line = block.index.pixel_size.0 * header.channels.bytes_per_pixel;
        for (slot, channel) in self.choice.slots.iter().enumerate() {
            let Some(channel) = *channel else { continue };
            let before: usize = header.channels.list[..channel].iter().map(|c| c.sample_type.bytes_per_sample()).sum();
            let sample_type = header.channels.list[channel].sample_type;
            let size = sample_type.bytes_per_sample();
            let start = block.index.pixel_size.0 * before;
            for (row, out) in rows.clone().zip(values.chunks_exact_mut(width * 4)) {
                let from = row * line + start;
                let bytes = &block.data[from + columns.start * size..from + columns.end * size];
                spread(bytes, sample_type, &mut out[slot..]);
            }
        }
        if let Some(colors) = &self.colors {
            to_rec709(colors, &mut values);
        }
        let at = |data: i32, block: usize, skip: usize, display: i32| {
            (i64::from(data) + (block + skip) as i64 - i64::from(display)) as usize
        };
        let (position, display) = (self.data.position, self.display.position);
        let x = at(position.0, block.index.pixel_position.0, columns.start, display.0);
        let y = at(position.1, block.index.pixel_position.1, rows.start, display.1);
        Piece { block: block.index.pixel_position, x, y, width, values }
    }
}

/// Writes a row of samples to every fourth place.
fn spread<T: Sample>(bytes: &[u8], sample_type: SampleType, out: &mut [T]) {
    let places = out.iter_mut().step_by(4);
    let (halves, _) = bytes.as_chunks::<2>();
    let (words, _) = bytes.as_chunks::<4>();
    match sample_type {
        SampleType::F16 => {
            places.zip(halves).for_each(|(o, b)| *o = T::from_half(f16::from_ne_bytes(*b)));
        }
        SampleType::F32 => {
            places.zip(words).for_each(|(o, b)| *o = T::from_float(f32::from_ne_bytes(*b)));
        }
        SampleType::U32 => {
            places.zip(words).for_each(|(o, b)| *o = T::from_float(u32::from_ne_bytes(*b) as f32));
        }
    }
}

fn to_rec709<T: Sample>(colors: &Colors, values: &mut [T]) {
    if colors.is_linear_rec709() {
        return;
    }
    let mut floats = Vec::new();
    for part in values.chunks_mut(4096) {
        floats.clear();
        floats.extend(part.iter().map(|value| value.to_float()));
        colors.decode(&mut floats);
        for (pixel, rgba) in part.as_chunks_mut::<4>().0.iter_mut().zip(floats.as_chunks::<4>().0) {
            for slot in 0..3 {
                pixel[slot] = T::from_float(rgba[slot]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::codec::exr::read::{Opened, open};
    use crate::codec::{Budget, Encoding, ErrorKind, Picture, Pixels, decode, encode};

    /// Chunks are decoded on threads of a pool, where the guard around the whole file does not reach.
    #[test]
    fn a_panic_in_a_chunk_is_an_error_of_the_file() {
        let picture = Picture::new(4, 4, Pixels::Half(vec![f16::ONE; 64]));
        let file = encode(&picture, &Encoding::EXR).expect("it can be written");
        assert!(decode(Cursor::new(&file), None, Budget(1 << 30)).is_ok());
        let Opened { reader, headers } = open(Cursor::new(&file)).expect("the headers are valid");
        let header = &headers[0];
        let (display, data) = (header.shared_attributes.display_window, header.data_window());
        // No file has a channel of this number.
        let choice = Choice { part: 0, slots: [Some(99), None, None, None], is_color: false };
        let placement = Placement { choice, display, data, colors: None };
        let error = decode_blocks::<f16, _>(reader, &placement).expect_err("the channel is not there");
        assert_eq!(error.kind, ErrorKind::Broken);
    }
}
