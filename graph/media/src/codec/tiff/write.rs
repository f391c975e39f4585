//! Pixels to TIFF 6.0: little-endian strips, deflated.

use std::io::SeekFrom;

use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use crate::codec::encoding::{Image, RowWriter, Sink};
use crate::codec::limits::check_sides;
use crate::codec::quantize::{Premultiplied, Quantizer};
use crate::codec::{Alpha, CodecError, Encoding, ErrorKind, Metadata, Samples, icc};

/// Rows of a strip.
const ROWS: usize = 64;

/// Bits of the samples that are floats.
pub(crate) const FLOAT_BITS: u32 = 32;

/// The writer of a TIFF. Codes of 8 and 16 bits have straight alpha, and floats have alpha that is multiplied into the
/// color.
pub(crate) struct TiffRows {
    to: Box<dyn Sink>,
    size: (u32, u32),
    quantizer: Quantizer,
    profile: Option<Vec<u8>>,
    /// Samples that wait for a strip to be full.
    waiting: Vec<u8>,
    /// Where each strip is, and its length.
    strips: Vec<(u32, u32)>,
    at: u64,
}

impl TiffRows {
    pub(crate) fn new(mut to: Box<dyn Sink>, size: (u32, u32), encoding: &Encoding) -> Result<Self, CodecError> {
        check_sides((size.0.into(), size.1.into()))?;
        let profile = encoding.color.map(|color| {
            icc::write(&color).ok_or_else(|| {
                CodecError::new(ErrorKind::Unsupported, "no TIFF states PQ or HLG")
                    .hint("write a PNG of 16 bits, or an EXR")
            })
        });
        let quantizer = Quantizer {
            bits: encoding.bits,
            dither: encoding.dither.filter(|_| encoding.bits == 8),
            channels: if encoding.alpha == Alpha::Keep { 4 } else { 3 },
            first_row: 0,
            premultiplied: encoding.premultiplied.then(|| Premultiplied::new(encoding.color)),
        };
        // The place of the directory is written at the end.
        to.write_all(b"II*\0\0\0\0\0").map_err(|error| CodecError::writing(&error))?;
        Ok(Self { to, size, quantizer, profile: profile.transpose()?, waiting: Vec::new(), strips: Vec::new(), at: 8 })
    }

    fn is_float(&self) -> bool {
        self.quantizer.bits == FLOAT_BITS
    }

    fn row_bytes(&self) -> usize {
        self.size.0 as usize * self.quantizer.channels * self.quantizer.bits as usize / 8
    }

    /// The samples of rows as bytes.
    fn bytes(&mut self, samples: Samples<'_>) -> Result<Vec<u8>, CodecError> {
        if !self.is_float() {
            let codes = self.quantizer.next_codes(self.size.0, samples)?;
            return Ok(match self.quantizer.bits {
                8 => codes.iter().map(|code| *code as u8).collect(),
                _ => codes.iter().flat_map(|code| code.to_le_bytes()).collect(),
            });
        }
        let floats = match samples {
            Samples::Float(values) => values.to_vec(),
            Samples::Half(values) => values.to_f32_vec(),
            Samples::Byte(codes) => codes.iter().map(|code| f32::from(*code) / 255.0).collect(),
        };
        let channels = self.quantizer.channels;
        let pixels = floats.as_chunks::<4>().0.iter();
        Ok(pixels.flat_map(|pixel| pixel[..channels].to_vec()).flat_map(f32::to_le_bytes).collect())
    }

    /// Writes the strips of the first of the bytes that wait.
    fn pack(&mut self, bytes: usize) -> Result<(), CodecError> {
        let (strip, row) = (ROWS * self.row_bytes(), self.row_bytes());
        let (channels, bits) = (self.quantizer.channels, self.quantizer.bits);
        let packed: Vec<Vec<u8>> = self.waiting[..bytes]
            .par_chunks(strip)
            .map(|strip| fdeflate::compress_to_vec(&predicted(strip, row, channels, bits)))
            .collect();
        for strip in packed {
            let place = u32::try_from(self.at).ok().zip(u32::try_from(strip.len()).ok());
            self.strips.push(place.ok_or_else(|| {
                CodecError::new(ErrorKind::TooLarge, "a TIFF has at most 4 GiB").hint("write an EXR or a PNG")
            })?);
            self.to.write_all(&strip).map_err(|error| CodecError::writing(&error))?;
            self.at += strip.len() as u64;
        }
        self.waiting.drain(..bytes);
        Ok(())
    }

    /// The directory, whose values are after it.
    fn directory(&self) -> Vec<u8> {
        let short =
            |values: &[u16]| (3_u16, values.len(), values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
        let long =
            |values: &[u32]| (4_u16, values.len(), values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
        let Quantizer { channels, bits, .. } = self.quantizer;
        let places: Vec<u32> = self.strips.iter().map(|(at, _)| *at).collect();
        let lengths: Vec<u32> = self.strips.iter().map(|(_, length)| *length).collect();
        let predictor = if self.is_float() { 1 } else { 2 };
        let mut entries = vec![
            (256_u16, long(&[self.size.0])),
            (257, long(&[self.size.1])),
            (258, short(&vec![bits as u16; channels])),
            // Deflate, RGB.
            (259, short(&[8])),
            (262, short(&[2])),
            (273, long(&places)),
            (277, short(&[channels as u16])),
            (278, long(&[ROWS as u32])),
            (279, long(&lengths)),
            (284, short(&[1])),
            (317, short(&[predictor])),
        ];
        if channels == 4 {
            // Multiplied into the color, or not.
            entries.push((338, short(&[if self.is_float() { 1 } else { 2 }])));
        }
        entries.push((339, short(&vec![if self.is_float() { 3 } else { 1 }; channels])));
        entries.extend(self.profile.as_ref().map(|profile| (34675, (7, profile.len(), profile.clone()))));
        let mut table = (entries.len() as u16).to_le_bytes().to_vec();
        let mut values = Vec::new();
        let start = self.at + 2 + 12 * entries.len() as u64 + 4;
        for (tag, (kind, count, mut bytes)) in entries {
            table.extend(tag.to_le_bytes());
            table.extend(kind.to_le_bytes());
            table.extend((count as u32).to_le_bytes());
            if bytes.len() <= 4 {
                bytes.resize(4, 0);
                table.extend(bytes);
            } else {
                table.extend(((start + values.len() as u64) as u32).to_le_bytes());
                bytes.resize(bytes.len().next_multiple_of(2), 0);
                values.extend(bytes);
            }
        }
        table.extend([0; 4]);
        table.extend(values);
        table
    }
}

impl RowWriter for TiffRows {
    fn write(&mut self, rows: Samples<'_>) -> Result<(), CodecError> {
        let bytes = self.bytes(rows)?;
        self.waiting.extend(bytes);
        let strip = ROWS * self.row_bytes();
        self.pack(self.waiting.len() / strip * strip)
    }

    fn finish(mut self: Box<Self>) -> Result<(), CodecError> {
        self.pack(self.waiting.len())?;
        if self.at % 2 == 1 {
            self.to.write_all(&[0]).map_err(|error| CodecError::writing(&error))?;
            self.at += 1;
        }
        let directory = self.directory();
        let Ok(place) = u32::try_from(self.at) else {
            return Err(CodecError::new(ErrorKind::TooLarge, "a TIFF has at most 4 GiB").hint("write an EXR or a PNG"));
        };
        let written = self.to.write_all(&directory).and_then(|()| self.to.seek(SeekFrom::Start(4)));
        let written = written.and_then(|_| self.to.write_all(&place.to_le_bytes())).and_then(|()| self.to.flush());
        written.map_err(|error| CodecError::writing(&error))
    }
}

/// Codes less those of the pixel to their left (TIFF 6.0, 14); floats as they are.
fn predicted(strip: &[u8], row: usize, channels: usize, bits: u32) -> Vec<u8> {
    let mut strip = strip.to_vec();
    for row in strip.chunks_mut(row) {
        match bits {
            8 => (channels..row.len()).rev().for_each(|at| row[at] = row[at].wrapping_sub(row[at - channels])),
            16 => {
                for at in (channels..row.len() / 2).rev() {
                    let code = |at: usize| u16::from_le_bytes([row[2 * at], row[2 * at + 1]]);
                    let difference = code(at).wrapping_sub(code(at - channels)).to_le_bytes();
                    row[2 * at..2 * at + 2].copy_from_slice(&difference);
                }
            }
            _ => {}
        }
    }
    strip
}

/// The writer of an image in memory, whose pixels determine alpha, and notes about what is left out.
pub(crate) fn writer_of_image(
    to: Box<dyn Sink>,
    Image { size, samples, meta, .. }: Image<'_>,
    encoding: &Encoding,
) -> Result<(Box<dyn RowWriter>, Vec<String>), CodecError> {
    let is_there = || samples.any(|[_, _, _, alpha]| alpha != 1.0);
    let alpha = match encoding.alpha {
        Alpha::WhereNeeded if encoding.bits != FLOAT_BITS => samples.has_alpha(encoding.bits),
        Alpha::WhereNeeded => is_there(),
        alpha => alpha == Alpha::Keep,
    };
    let alpha = if alpha { Alpha::Keep } else { Alpha::Drop };
    let notes = meta.and_then(Metadata::other_aspect).into_iter().collect();
    Ok((Box::new(TiffRows::new(to, size, &Encoding { alpha, ..*encoding })?), notes))
}
