//! The pixels of a PNG as strips of rows that are packed on all cores. Each strip is a block of deflate that ends at a
//! byte, so that they follow each other in one stream; where they begin depends on the size of the picture alone.

use std::io::Write;

use png::chunk::IDAT;
use png::{EncodingError, Writer};
use rayon::prelude::*;

/// Bytes of a strip before it is packed, at most, unless a row has more.
const STRIP_BYTES: usize = 1 << 18;

/// Rows from the top to the bottom.
pub(super) struct Strips {
    /// Codes of a row.
    row: usize,
    channels: usize,
    bits: u32,
    /// The row above the waiting ones: zeros above the first.
    above: Vec<u16>,
    /// Rows that do not fill a strip yet.
    waiting: Vec<u16>,
    /// The last packed strip; it is written with what may follow it, as one chunk.
    chunk: Vec<u8>,
    /// The two sums of Adler-32 so far.
    sums: [u64; 2],
}

/// A strip in the stream.
struct Packed {
    blocks: Vec<u8>,
    /// Bytes of the filtered rows, and their Adler-32.
    bytes: usize,
    checksum: u32,
}

/// Deflate with a window of 32 KiB (RFC 1950).
const HEAD: [u8; 2] = [0x78, 0x01];

/// The modulus of Adler-32 (RFC 1950).
const ADLER: u64 = 65521;

impl Strips {
    pub(super) fn new(width: u32, channels: usize, bits: u32) -> Self {
        let row = width as usize * channels;
        Self { row, channels, bits, above: vec![0; row], waiting: Vec::new(), chunk: HEAD.to_vec(), sums: [1, 0] }
    }

    /// Writes the strips that these rows fill.
    pub(super) fn write<W: Write>(&mut self, to: &mut Writer<W>, codes: Vec<u16>) -> Result<(), EncodingError> {
        match self.waiting.is_empty() {
            true => self.waiting = codes,
            false => self.waiting.extend(codes),
        }
        let strip = self.strip();
        self.pack(to, self.waiting.len() / strip * strip)
    }

    pub(super) fn finish<W: Write>(mut self, to: &mut Writer<W>) -> Result<(), EncodingError> {
        self.pack(to, self.waiting.len())?;
        // An empty block that is the last one.
        self.chunk.extend([0x03, 0x00]);
        self.chunk.extend(&(self.sums[1] << 16 | self.sums[0]).to_be_bytes()[4..]);
        to.write_chunk(IDAT, &self.chunk)
    }

    fn bytes(&self) -> usize {
        self.bits as usize / 8
    }

    fn to_bytes(&self, codes: &[u16]) -> Vec<u8> {
        match self.bits {
            8 => codes.iter().map(|code| *code as u8).collect(),
            _ => codes.iter().flat_map(|code| code.to_be_bytes()).collect(),
        }
    }

    fn strip(&self) -> usize {
        (STRIP_BYTES / (self.row * self.bytes())).max(1) * self.row
    }

    /// Packs the first of the waiting codes.
    fn pack<W: Write>(&mut self, to: &mut Writer<W>, codes: usize) -> Result<(), EncodingError> {
        if codes == 0 {
            return Ok(());
        }
        let (strip, row) = (self.strip(), self.row);
        let strips = self.waiting[..codes].par_chunks(strip).enumerate().map(|(index, codes)| {
            let above = match index {
                0 => &self.above,
                _ => &self.waiting[index * strip - row..index * strip],
            };
            packed(&self.filtered(codes, above))
        });
        for Packed { blocks, bytes, checksum } in strips.collect::<Vec<_>>() {
            if self.chunk.len() > HEAD.len() {
                to.write_chunk(IDAT, &self.chunk)?;
                self.chunk.clear();
            }
            self.chunk.extend(blocks);
            // The sums of a strip begin at 1 and 0, too.
            let [low, high] = [u64::from(checksum & 0xffff), u64::from(checksum >> 16)];
            let before = self.sums[0] + ADLER - 1;
            self.sums = [(before + low) % ADLER, (self.sums[1] + high + before % ADLER * bytes as u64) % ADLER];
        }
        self.above.copy_from_slice(&self.waiting[codes - row..codes]);
        self.waiting.drain(..codes);
        Ok(())
    }

    /// Rows after the filter of PNG (third edition, 9.2) whose numbers have the smallest sum, each row with its own.
    fn filtered(&self, codes: &[u16], above: &[u16]) -> Vec<u8> {
        let mut above = self.to_bytes(above);
        let texel = self.channels * self.bytes();
        let mut filtered = Vec::with_capacity(codes.len() * self.bytes() + codes.len() / self.row);
        let (mut best, mut tried) = (vec![0; above.len()], vec![0; above.len()]);
        for row in codes.chunks_exact(self.row) {
            let row = self.to_bytes(row);
            let mut chosen = (u64::MAX, 0);
            for filter in 0..FILTERS {
                let sum = apply(filter, &row, &above, texel, &mut tried);
                if sum < chosen.0 {
                    chosen = (sum, filter);
                    std::mem::swap(&mut best, &mut tried);
                }
            }
            filtered.push(chosen.1);
            filtered.extend_from_slice(&best);
            above = row;
        }
        filtered
    }
}

/// None, Sub, Up, Average and Paeth.
const FILTERS: u8 = 5;

/// Filters a row; the sum of the magnitudes.
fn apply(filter: u8, row: &[u8], above: &[u8], texel: usize, to: &mut [u8]) -> u64 {
    match filter {
        0 => to.copy_from_slice(row),
        1 => subtract(row, above, texel, to, |left, _, _| left),
        2 => subtract(row, above, texel, to, |_, up, _| up),
        3 => subtract(row, above, texel, to, |left, up, _| ((u16::from(left) + u16::from(up)) / 2) as u8),
        _ => subtract(row, above, texel, to, paeth),
    }
    to.chunks(256)
        .map(|part| u64::from(part.iter().map(|code| u32::from(code.cast_signed().unsigned_abs())).sum::<u32>()))
        .sum()
}

/// Subtracts from each byte what follows from the bytes left of it, above it, and above that one.
fn subtract(row: &[u8], above: &[u8], texel: usize, to: &mut [u8], predict: impl Fn(u8, u8, u8) -> u8) {
    let (first, rest) = to.split_at_mut(texel);
    for ((to, code), up) in first.iter_mut().zip(row).zip(above) {
        *to = code.wrapping_sub(predict(0, *up, 0));
    }
    let (left, up, corner) = (row, &above[texel..], above);
    for ((((to, code), left), up), corner) in rest.iter_mut().zip(&row[texel..]).zip(left).zip(up).zip(corner) {
        *to = code.wrapping_sub(predict(*left, *up, *corner));
    }
}

fn paeth(left: u8, up: u8, corner: u8) -> u8 {
    let [a, b, c] = [left, up, corner].map(i16::from);
    let [to_left, to_up, to_corner] = [(b - c).abs(), (a - c).abs(), (a + b - 2 * c).abs()];
    match to_left <= to_up && to_left <= to_corner {
        true => left,
        false if to_up <= to_corner => up,
        false => corner,
    }
}

/// Packs filtered rows into blocks of deflate that end at a byte, of which none is marked as the last.
fn packed(filtered: &[u8]) -> Packed {
    let mut blocks = fdeflate::compress_to_vec(filtered);
    let checksum = blocks.split_off(blocks.len() - 4);
    let checksum = u32::from_be_bytes(checksum.try_into().expect("a stream ends with four bytes of Adler-32"));
    // What is before the only block; and that block is not the last one.
    blocks.drain(..2);
    blocks[0] &= !1;
    // The symbol that ends a block of fdeflate ends with a one, and the zeros after it fill the last byte. With three
    // of them an empty stored block begins there, which ends at a byte.
    if blocks.last().is_some_and(|last| last.leading_zeros() < 3) {
        blocks.push(0);
    }
    blocks.extend([0x00, 0x00, 0xff, 0xff]);
    if blocks.len() > filtered.len() {
        blocks.clear();
        for part in filtered.chunks(usize::from(u16::MAX)) {
            let length = part.len() as u16;
            blocks.push(0);
            blocks.extend([length, !length].map(u16::to_le_bytes).as_flattened());
            blocks.extend_from_slice(part);
        }
    }
    Packed { blocks, bytes: filtered.len(), checksum }
}
