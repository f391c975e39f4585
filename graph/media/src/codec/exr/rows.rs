//! An EXR file that is written from the top to the bottom.

use std::io::{Seek, SeekFrom, Write};

use exr::block::{BlockIndex, enumerate_ordered_header_block_indices};
use exr::meta::header::Header;
use glam::Mat3;

use super::explain;
use super::pack::{Column, Content, head};
use super::write::{ExrOptions, part_of, picture_names, settle};
use crate::codec::limits::check_sides;
use crate::codec::{CodecError, Metadata, Pixels};

/// An EXR file that is written from the top to the bottom, so that no more than some rows are in memory: the bytes of
/// [`encode_exr`](crate::encode_exr).
pub struct ExrRows<W: Write + Seek> {
    to: W,
    width: u32,
    headers: [Header; 1],
    columns: Vec<Column>,
    conversion: Option<Mat3>,
    /// The blocks that are not written yet, from the bottom to the top.
    blocks: Vec<(usize, BlockIndex)>,
    /// Rows that do not fill a block yet, and the first of them.
    waiting: Pixels,
    first_row: usize,
    /// Where the table of offsets is, and where the next block begins.
    table: u64,
    end: u64,
    offsets: Vec<u64>,
    notes: Vec<String>,
}

impl<W: Write + Seek> ExrRows<W> {
    /// Writes what comes before the rows of an EXR of `size`, whose file states what `meta` does.
    ///
    /// # Errors
    /// A side that is too long, and what writing to `to` reports.
    pub fn new(mut to: W, size: (u32, u32), meta: &Metadata, options: &ExrOptions) -> Result<Self, CodecError> {
        check_sides((size.0.into(), size.1.into()))?;
        let (mut header, columns) = part_of(size, meta, options, &picture_names(), Vec::new(), true);
        let notes = settle(&mut header, meta);
        let headers = [header];
        let mut blocks: Vec<_> = enumerate_ordered_header_block_indices(&headers).collect();
        blocks.reverse();
        let (head, offsets) = (head(&headers[0])?, vec![0; blocks.len()]);
        let table = head.len() as u64;
        let written = to.write_all(&head).and_then(|()| to.write_all(bytemuck::cast_slice(&offsets)));
        written.map_err(|error| CodecError::writing(&error))?;
        let (conversion, end) = (options.conversion(), table + 8 * offsets.len() as u64);
        let (width, waiting) = (size.0, Pixels::Half(Vec::new()));
        Ok(Self { to, width, headers, columns, conversion, blocks, waiting, first_row: 0, table, end, offsets, notes })
    }

    /// Sentences about attributes that are left out.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Writes the next rows: all of them halves, or all of them floats.
    ///
    /// # Errors
    /// What writing reports.
    ///
    /// # Panics
    /// If the rows before were of the other kind.
    pub fn write(&mut self, rows: Pixels) -> Result<(), CodecError> {
        match (&mut self.waiting, rows) {
            (waiting, rows) if waiting.is_empty() => *waiting = rows,
            (Pixels::Half(waiting), Pixels::Half(rows)) => waiting.extend(rows),
            (Pixels::Float(waiting), Pixels::Float(rows)) => waiting.extend(rows),
            _ => panic!("the rows of a picture have one type"),
        }
        let row = 4 * self.width as usize;
        let end = self.first_row + self.waiting.len() / row;
        let last = |block: &BlockIndex| block.pixel_position.1 + block.pixel_size.1;
        let kept = self.blocks.iter().rposition(|(_, block)| last(block) > end).map_or(0, |index| index + 1);
        let mut full = self.blocks.split_off(kept);
        full.reverse();
        let Some(next) = full.last().map(|(_, block)| last(block)) else { return Ok(()) };
        let (width, pixels, first_row, columns) = (self.width, &self.waiting, self.first_row, &self.columns);
        let (conversion, headers) = (self.conversion, &self.headers);
        let content = Content { width, pixels, first_row, conversion, headers, part: 0, columns, rows: &[] };
        for (number, chunk) in content.chunks(full)? {
            let mut bytes = Vec::new();
            chunk.write(&mut bytes, 1).map_err(|error| explain(&error))?;
            self.to.write_all(&bytes).map_err(|error| CodecError::writing(&error))?;
            self.offsets[number] = self.end;
            self.end += bytes.len() as u64;
        }
        let written = (next - self.first_row) * row;
        match &mut self.waiting {
            Pixels::Half(waiting) => drop(waiting.drain(..written)),
            Pixels::Float(waiting) => drop(waiting.drain(..written)),
        }
        self.first_row = next;
        Ok(())
    }

    /// Writes the table of offsets, after the last row.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish(mut self) -> Result<(), CodecError> {
        assert!(self.blocks.is_empty(), "rows are missing");
        let table: Vec<u8> = self.offsets.iter().flat_map(|offset| offset.to_le_bytes()).collect();
        let written = self.to.seek(SeekFrom::Start(self.table)).and_then(|_| self.to.write_all(&table));
        written.and_then(|()| self.to.flush()).map_err(|error| CodecError::writing(&error))
    }
}
