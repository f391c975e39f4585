//! Rows and chunks to the bytes of an EXR file.
//!
//! Equal pictures give equal bytes: blocks are compressed on all cores but written in order, and
//! the attributes, which the `exr` crate takes from a hash map, are sorted by name afterwards.

use std::borrow::Cow;
use std::io::Cursor;

use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::Error;
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::{Compression, IntegerBounds, LevelMode, SampleType, TileDescription};
use exr::meta::header::Header;
use glam::Mat3;
use half::f16;
use rayon::prelude::*;

use super::attributes::{Head, LONG_NAMES};
use super::explain;
use crate::codec::chromaticities::convert;
use crate::codec::{CodecError, ErrorKind, Samples};
use afterimage_base::panics::catch_panic;

/// The parts of a file, of which one has the picture.
pub(super) struct Parts {
    pub(super) headers: Vec<Header>,
    /// The index of the part with the picture.
    pub(super) picture: usize,
    /// The source of each channel of that part.
    pub(super) columns: Vec<Column>,
    /// Preserved channels of that part: for each row, channel after channel.
    pub(super) preserved: Vec<u8>,
}

pub(super) struct Content<'p> {
    pub(super) width: u32,
    /// Rows of the picture, from `first_row` on.
    pub(super) samples: Samples<'p>,
    pub(super) first_row: usize,
    /// To the primaries of the file.
    pub(super) conversion: Option<Mat3>,
    pub(super) parts: &'p Parts,
}

/// The source of a channel.
#[derive(Clone, Copy, Debug)]
pub(super) enum Column {
    /// Red, green, blue or alpha of the picture.
    Picture(usize),
    /// Bytes of the preserved rows.
    Preserved { start: usize, length: usize },
}

/// The bytes of a file before its table of offsets.
pub(super) fn head(headers: &[Header]) -> Result<Vec<u8>, CodecError> {
    let mut bytes = Vec::new();
    let packed = catch_panic(|| {
        let mut file = Cursor::new(&mut bytes);
        // The chunks are written elsewhere.
        exr::block::write(&mut file, headers.iter().cloned().collect(), false, |_, _| Err(Error::Aborted))
    });
    match packed.map_err(|panic| ours(&panic))? {
        Ok(()) | Err(Error::Aborted) => {}
        Err(error) => return Err(explain(&error)),
    }
    let mut head = Head::read(&*bytes).map_err(|error| CodecError::writing(&error))?;
    head.parts.iter_mut().for_each(|part| part.sort_by(|a, b| a.name.cmp(&b.name)));
    if head.has_long_names() {
        // The `exr` crate sets it for names of attributes alone.
        head.version |= LONG_NAMES;
    }
    Ok(head.to_bytes())
}

fn ours(panic: &str) -> CodecError {
    CodecError::new(ErrorKind::Machine, format!("packing the EXR failed: {panic}"))
}

impl Content<'_> {
    /// Packs blocks, whose rows are all here, on all cores.
    pub(super) fn chunks(&self, blocks: Vec<(usize, BlockIndex)>) -> Result<Vec<(usize, Chunk)>, CodecError> {
        let Parts { headers, picture, .. } = self.parts;
        let header = &headers[*picture];
        let chunks = blocks.into_par_iter().map(|(number, index)| {
            let data = self.block(&index);
            // A block that would grow is stored as it is.
            let chunk = catch_panic(|| match b44_grows(header, index.pixel_size) {
                true => unpacked(header, index, data),
                false => UncompressedBlock { index, data }.compress_to_chunk(headers),
            });
            let chunk = chunk.map_err(|panic| ours(&panic))?;
            chunk.map(|chunk| (number, chunk)).map_err(|error| explain(&error))
        });
        chunks.collect()
    }

    /// The rows of one block, each row channel after channel.
    fn block(&self, block: &BlockIndex) -> Vec<u8> {
        let Parts { headers, picture, columns, preserved } = self.parts;
        let channels = &headers[*picture].channels;
        let (first, rows) = (block.pixel_position.1, block.pixel_size.1);
        let length = |column: &Column| if let Column::Preserved { length, .. } = column { *length } else { 0 };
        let stride: usize = columns.iter().map(length).sum();
        let mut bytes = Vec::with_capacity(rows * block.pixel_size.0 * channels.bytes_per_pixel);
        for y in first..first + rows {
            let row = self.row(y);
            for (channel, column) in channels.list.iter().zip(columns) {
                match *column {
                    Column::Picture(slot) => row.channel(slot, channel.sample_type, &mut bytes),
                    Column::Preserved { start, length } => {
                        bytes.extend_from_slice(&preserved[y * stride + start..][..length]);
                    }
                }
            }
        }
        bytes
    }

    fn row(&self, y: usize) -> Row<'_> {
        let (length, y) = (self.width as usize * 4, y - self.first_row);
        let range = y * length..(y + 1) * length;
        match (self.samples, self.conversion) {
            (Samples::Half(values), None) => return Row::Half(&values[range]),
            (Samples::Float(values), None) => return Row::Float(Cow::Borrowed(&values[range])),
            _ => {}
        }
        let mut scratch = vec![0.0; length];
        let mut values = self.samples.row(range, &mut scratch).to_vec();
        if let Some(matrix) = self.conversion {
            for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
                [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
            }
        }
        Row::Float(Cow::Owned(values))
    }
}

/// True if B44 may need more bytes for a block than it has: the `exr` crate has no room for them. It packs each half of
/// 4x4 pixels into 14 bytes, also where a block has fewer rows or columns.
fn b44_grows(header: &Header, size: Vec2<usize>) -> bool {
    let packed = |samples: SampleType| match samples {
        SampleType::F16 => size.0.div_ceil(4) * size.1.div_ceil(4) * 14,
        _ => size.area() * samples.bytes_per_sample(),
    };
    let all: usize = header.channels.list.iter().map(|channel| packed(channel.sample_type)).sum();
    matches!(header.compression, Compression::B44 | Compression::B44A)
        && all >= size.area() * header.channels.bytes_per_pixel
}

/// A chunk with the rows as they are, whatever the packing of the file.
fn unpacked(header: &Header, index: BlockIndex, data: Vec<u8>) -> Result<Chunk, Error> {
    // As a tile it may have several rows.
    let tile = TileDescription {
        tile_size: index.pixel_size,
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    };
    let plain = Header { blocks: BlockDescription::Tiles(tile), ..header.clone() };
    let section = IntegerBounds::from_dimensions(index.pixel_size);
    let bytes = Compression::Uncompressed.compress_image_section_to_le(&plain, data, section)?;
    let y_coordinate = index.pixel_position.1 as i32 + header.own_attributes.layer_position.1;
    let block = CompressedScanLineBlock { y_coordinate, compressed_pixels_le: bytes };
    Ok(Chunk { layer_index: index.layer, compressed_block: CompressedBlock::ScanLine(block) })
}

/// A row of the picture.
enum Row<'p> {
    Half(&'p [f16]),
    Float(Cow<'p, [f32]>),
}

impl Row<'_> {
    /// Appends one channel in this type.
    fn channel(&self, slot: usize, samples: SampleType, out: &mut Vec<u8>) {
        match (self, samples) {
            (Self::Half(values), SampleType::F16) => spread(values, slot, |value| value.to_ne_bytes(), out),
            (Self::Half(values), _) => spread(values, slot, |value| value.to_f32().to_ne_bytes(), out),
            (Self::Float(values), SampleType::F16) => spread(values, slot, |value| to_half(value).to_ne_bytes(), out),
            (Self::Float(values), _) => spread(values, slot, f32::to_ne_bytes, out),
        }
    }
}

fn spread<T: Copy, const N: usize>(row: &[T], slot: usize, to_bytes: impl Fn(T) -> [u8; N], out: &mut Vec<u8>) {
    out.extend(row[slot..].iter().step_by(4).flat_map(|&value| to_bytes(value)));
}

/// Converts to a half float; finite values beyond its range become its largest.
fn to_half(value: f32) -> f16 {
    if value.is_finite() { f16::from_f32(value.clamp(-65504.0, 65504.0)) } else { f16::from_f32(value) }
}
