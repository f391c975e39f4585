//! The writer of EXR files.

use std::io::SeekFrom;

use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, enumerate_ordered_header_block_indices};
use glam::Mat3;

use super::explain;
use super::pack::{Content, Parts, head};
use super::write::{finish_attributes, part_of, picture_names};
use crate::codec::encoding::{RowWriter, Sink};
use crate::codec::limits::check_sides;
use crate::codec::{CodecError, Encoding, Metadata, Pixels, Samples};

/// The writer of an EXR.
pub(crate) struct ExrRows {
    to: Box<dyn Sink>,
    width: u32,
    parts: Parts,
    conversion: Option<Mat3>,
    /// The blocks of the picture that are not written yet, from the bottom to the top.
    blocks: Vec<(usize, BlockIndex)>,
    /// Rows that do not fill a block yet, and the index of the first of them.
    waiting: Pixels,
    first_row: usize,
    /// The positions of the table of offsets and of the next block.
    table: u64,
    end: u64,
    /// The table of each part.
    offsets: Vec<Vec<u64>>,
}

impl ExrRows {
    /// Writes the head of a file with one part. Returns sentences about attributes that are left out, too.
    pub(crate) fn new(
        to: Box<dyn Sink>,
        size: (u32, u32),
        meta: Option<&Metadata>,
        encoding: &Encoding,
    ) -> Result<(Self, Vec<String>), CodecError> {
        check_sides((size.0.into(), size.1.into()))?;
        let default = Metadata::of_size(size.0, size.1);
        let meta = meta.unwrap_or(&default);
        let (mut header, columns) = part_of(size, meta, encoding, &picture_names(), Vec::new(), true);
        let notes = finish_attributes(&mut header, meta);
        let parts = Parts { headers: vec![header], picture: 0, columns, preserved: Vec::new() };
        Ok((Self::of_parts(to, size.0, parts, encoding.conversion())?, notes))
    }

    /// Writes the head of a file with these parts.
    pub(super) fn of_parts(
        mut to: Box<dyn Sink>,
        width: u32,
        parts: Parts,
        conversion: Option<Mat3>,
    ) -> Result<Self, CodecError> {
        let blocks = enumerate_ordered_header_block_indices(&parts.headers);
        let mut blocks: Vec<_> = blocks.filter(|(_, block)| block.layer == parts.picture).collect();
        blocks.reverse();
        let head = head(&parts.headers)?;
        let offsets: Vec<Vec<u64>> = parts.headers.iter().map(|header| vec![0; header.chunk_count]).collect();
        let (table, count) = (head.len() as u64, offsets.iter().map(Vec::len).sum::<usize>());
        let written = to.write_all(&head).and_then(|()| to.write_all(&vec![0; 8 * count]));
        written.map_err(|error| CodecError::writing(&error))?;
        let (waiting, end) = (Pixels::Half(Vec::new()), table + 8 * count as u64);
        Ok(Self { to, width, parts, conversion, blocks, waiting, first_row: 0, table, end, offsets })
    }

    /// Writes the blocks that these samples complete. Returns the number of samples in them.
    fn write_blocks(&mut self, samples: Samples<'_>) -> Result<usize, CodecError> {
        let row = 4 * self.width as usize;
        let end = self.first_row + samples.len() / row;
        let last = |block: &BlockIndex| block.pixel_position.1 + block.pixel_size.1;
        let incomplete = self.blocks.iter().rposition(|(_, block)| last(block) > end).map_or(0, |index| index + 1);
        let mut complete = self.blocks.split_off(incomplete);
        complete.reverse();
        let Some(next) = complete.last().map(|(_, block)| last(block)) else { return Ok(0) };
        let content = Content {
            width: self.width,
            samples,
            first_row: self.first_row,
            conversion: self.conversion,
            parts: &self.parts,
        };
        for (index, chunk) in content.chunks(complete)? {
            self.write_chunk(index, &chunk)?;
        }
        let written = (next - self.first_row) * row;
        self.first_row = next;
        Ok(written)
    }

    /// Writes a chunk that has this index in the table of its part.
    pub(super) fn write_chunk(&mut self, index: usize, chunk: &Chunk) -> Result<(), CodecError> {
        let mut bytes = Vec::new();
        chunk.write(&mut bytes, self.parts.headers.len()).map_err(|error| explain(&error))?;
        self.to.write_all(&bytes).map_err(|error| CodecError::writing(&error))?;
        self.offsets[chunk.layer_index][index] = self.end;
        self.end += bytes.len() as u64;
        Ok(())
    }
}

impl RowWriter for ExrRows {
    fn write(&mut self, rows: Samples<'_>) -> Result<(), CodecError> {
        if self.waiting.is_empty() {
            let written = self.write_blocks(rows)?;
            self.waiting = rows.rest(written);
            return Ok(());
        }
        let mut waiting = std::mem::replace(&mut self.waiting, Pixels::Half(Vec::new()));
        match (&mut waiting, rows.rest(0)) {
            (Pixels::Half(waiting), Pixels::Half(rows)) => waiting.extend(rows),
            (Pixels::Float(waiting), Pixels::Float(rows)) => waiting.extend(rows),
            _ => panic!("the rows of a picture have one type"),
        }
        let written = self.write_blocks(Samples::from(&waiting))?;
        match &mut waiting {
            Pixels::Half(waiting) => drop(waiting.drain(..written)),
            Pixels::Float(waiting) => drop(waiting.drain(..written)),
        }
        self.waiting = waiting;
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), CodecError> {
        assert!(self.blocks.is_empty(), "rows are missing");
        let table: Vec<u8> = self.offsets.iter().flatten().flat_map(|offset| offset.to_le_bytes()).collect();
        let written = self.to.seek(SeekFrom::Start(self.table)).and_then(|_| self.to.write_all(&table));
        written.and_then(|()| self.to.flush()).map_err(|error| CodecError::writing(&error))
    }
}
