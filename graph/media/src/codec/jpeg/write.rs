//! Encoded pixels to JPEG: eight bits, no alpha, SDR.

use std::cell::RefCell;
use std::io::{BufWriter, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use afterimage_base::color::Colorimetry;
use jpeg_encoder::{Encoder, EncodingError, ImageBuffer, JpegColorType, SamplingFactor, rgb_to_ycbcr};

use crate::codec::encoding::{RowWriter, Sink};
use crate::codec::limits::check_sides;
use crate::codec::quantize::Quantizer;
use crate::codec::{CodecError, Encoding, ErrorKind, Samples, icc};

/// The writer of a JPEG. A thread packs the rows, because the encoder asks for them.
pub(crate) struct JpegRows {
    rows: SyncSender<Vec<u8>>,
    packing: JoinHandle<Result<(), EncodingError>>,
    width: u32,
    quantizer: Quantizer,
}

impl JpegRows {
    pub(crate) fn new(to: Box<dyn Sink>, size: (u32, u32), encoding: &Encoding) -> Result<Self, CodecError> {
        let (width, height) = sides(size)?;
        let profile = encoding.color.map(profile).transpose()?;
        let quality = encoding.quality.clamp(1, 100);
        let (rows, from) = sync_channel(1);
        let waiting = RefCell::new(Waiting { from, first_row: 0, bytes: Vec::new() });
        let picture = Rows { width, height, waiting };
        let packing = move || {
            let mut to = BufWriter::new(to);
            let mut encoder = Encoder::new(&mut to, quality);
            encoder.set_sampling_factor(SamplingFactor::F_1_1);
            if let Some(profile) = profile {
                encoder.add_icc_profile(&profile)?;
            }
            encoder.encode_image(picture)?;
            to.flush().map_err(EncodingError::IoError)
        };
        let packing = std::thread::Builder::new().name("JPEG".to_owned()).spawn(packing);
        let packing = packing.map_err(|error| CodecError::new(ErrorKind::Machine, format!("no thread: {error}")))?;
        let quantizer = Quantizer { bits: 8, dither: encoding.dither, channels: 3, first_row: 0, premultiplied: None };
        Ok(Self { rows, packing, width: size.0, quantizer })
    }
}

impl RowWriter for JpegRows {
    fn write(&mut self, samples: Samples<'_>) -> Result<(), CodecError> {
        let codes = self.quantizer.next_codes(self.width, samples)?;
        // An encoder that is gone has failed, which the end reports.
        let _ = self.rows.send(codes.iter().map(|code| *code as u8).collect());
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), CodecError> {
        let Self { rows, packing, .. } = *self;
        drop(rows);
        let packed = packing.join().map_err(|_| CodecError::new(ErrorKind::Machine, "packing the JPEG failed"))?;
        packed.map_err(|error| failed(&error))
    }
}

fn sides(size: (u32, u32)) -> Result<(u16, u16), CodecError> {
    check_sides((size.0.into(), size.1.into()))?;
    let (Ok(width), Ok(height)) = (u16::try_from(size.0), u16::try_from(size.1)) else {
        return Err(CodecError::new(ErrorKind::TooLarge, "a JPEG has at most 65535 pixels in a row or column"));
    };
    Ok((width, height))
}

fn failed(error: &EncodingError) -> CodecError {
    match error {
        EncodingError::IoError(error) => CodecError::writing(error),
        error => CodecError::new(ErrorKind::Machine, format!("packing the JPEG failed: {error}")),
    }
}

fn profile(color: Colorimetry) -> Result<Vec<u8>, CodecError> {
    icc::write(&color).ok_or_else(|| {
        CodecError::new(ErrorKind::Unsupported, "a JPEG has eight bits, too few for PQ and HLG")
            .hint("write a PNG, or encode for an SDR display")
    })
}

/// A picture of which the encoder asks for one row after another.
struct Rows {
    width: u16,
    height: u16,
    waiting: RefCell<Waiting>,
}

/// The rows that came last.
struct Waiting {
    from: Receiver<Vec<u8>>,
    first_row: usize,
    bytes: Vec<u8>,
}

impl ImageBuffer for Rows {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.width
    }

    fn height(&self) -> u16 {
        self.height
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        let row = 3 * usize::from(self.width);
        let waiting = &mut *self.waiting.borrow_mut();
        while waiting.first_row + waiting.bytes.len() / row <= usize::from(y) {
            waiting.first_row += waiting.bytes.len() / row;
            // Of a file that was given up, the rest is black.
            waiting.bytes = waiting.from.recv().unwrap_or_else(|_| vec![0; row]);
        }
        for rgb in waiting.bytes[(usize::from(y) - waiting.first_row) * row..][..row].as_chunks::<3>().0 {
            let (luma, blue, red) = rgb_to_ycbcr(rgb[0], rgb[1], rgb[2]);
            [luma, blue, red].into_iter().zip(&mut *buffers).for_each(|(value, buffer)| buffer.push(value));
        }
    }
}
