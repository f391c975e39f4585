//! Encoded pixels to JPEG: eight bits, no alpha, SDR.

use std::cell::RefCell;
use std::io::{BufWriter, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use afterimage_base::color::Colorimetry;
use jpeg_encoder::{ColorType, Encoder, EncodingError, ImageBuffer, JpegColorType, SamplingFactor, rgb_to_ycbcr};

use crate::codec::limits::{check_sides, check_size};
use crate::codec::quantize::Quantizer;
use crate::codec::{CodecError, EncodedPixels, ErrorKind, icc};

/// How a JPEG is written. The color channels have full resolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JpegOptions {
    /// 1 to 100: of the quantization tables of libjpeg.
    pub quality: u8,
    /// Seed of the dither to eight bits, or `None` to round.
    pub dither: Option<u32>,
    /// What the numbers mean, stated by an ICC profile; not stated if `None`.
    pub color: Option<Colorimetry>,
}

impl Default for JpegOptions {
    /// Quality 92, sRGB, dithered with seed 0.
    fn default() -> Self {
        Self { quality: 92, dither: Some(0), color: Some(Colorimetry::SRGB) }
    }
}

/// Encodes a JPEG of `size` (width, height). Alpha is not written.
///
/// # Errors
/// More than 65535 pixels in a row or column, `Pq` and `Hlg`.
pub fn encode_jpeg(size: (u32, u32), pixels: EncodedPixels<'_>, options: &JpegOptions) -> Result<Vec<u8>, CodecError> {
    let (width, height) = sides(size)?;
    check_size((size.0.into(), size.1.into()), 1)?;
    let profile = options.color.map(profile).transpose()?;
    let bytes = bytes(&options.quantizer(), size, pixels)?;
    let mut file = Vec::new();
    let encoded = encoder(&mut file, profile.as_deref(), options)
        .and_then(|encoder| encoder.encode(&bytes, width, height, ColorType::Rgb));
    encoded.map_err(|error| failed(&error))?;
    Ok(file)
}

impl JpegOptions {
    fn quantizer(&self) -> Quantizer {
        Quantizer { bits: 8, dither: self.dither, channels: 3, first_row: 0, premultiplied: None }
    }
}

fn sides(size: (u32, u32)) -> Result<(u16, u16), CodecError> {
    check_sides((size.0.into(), size.1.into()))?;
    let (Ok(width), Ok(height)) = (u16::try_from(size.0), u16::try_from(size.1)) else {
        return Err(CodecError::new(ErrorKind::TooLarge, "a JPEG has at most 65535 pixels in a row or column"));
    };
    Ok((width, height))
}

fn bytes(quantizer: &Quantizer, size: (u32, u32), pixels: EncodedPixels<'_>) -> Result<Vec<u8>, CodecError> {
    Ok(quantizer.codes(size, pixels)?.iter().map(|code| *code as u8).collect())
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

fn encoder<W: Write>(to: W, profile: Option<&[u8]>, options: &JpegOptions) -> Result<Encoder<W>, EncodingError> {
    let mut encoder = Encoder::new(to, options.quality.clamp(1, 100));
    encoder.set_sampling_factor(SamplingFactor::F_1_1);
    if let Some(profile) = profile {
        encoder.add_icc_profile(profile)?;
    }
    Ok(encoder)
}

/// A JPEG that is written from the top to the bottom, so that no more than some rows are in memory: the bytes of
/// [`encode_jpeg`]. A thread packs them, because the encoder asks for rows.
pub struct JpegRows {
    rows: SyncSender<Vec<u8>>,
    packing: JoinHandle<Result<(), EncodingError>>,
    width: u32,
    quantizer: Quantizer,
}

impl JpegRows {
    /// Writes what comes before the rows of a JPEG of `size`.
    ///
    /// # Errors
    /// As [`encode_jpeg`].
    pub fn new(to: impl Write + Send + 'static, size: (u32, u32), options: &JpegOptions) -> Result<Self, CodecError> {
        let (width, height) = sides(size)?;
        let (profile, options) = (options.color.map(profile).transpose()?, *options);
        let (rows, from) = sync_channel(1);
        let waiting = RefCell::new(Waiting { from, first_row: 0, bytes: Vec::new() });
        let picture = Rows { width, height, waiting };
        let packing = move || {
            let mut to = BufWriter::new(to);
            encoder(&mut to, profile.as_deref(), &options)?.encode_image(picture)?;
            to.flush().map_err(EncodingError::IoError)
        };
        let packing = std::thread::Builder::new().name("JPEG".to_owned()).spawn(packing);
        let packing = packing.map_err(|error| CodecError::new(ErrorKind::Machine, format!("no thread: {error}")))?;
        Ok(Self { rows, packing, width: size.0, quantizer: options.quantizer() })
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// No memory for the codes.
    pub fn write(&mut self, pixels: EncodedPixels<'_>) -> Result<(), CodecError> {
        let rows = (pixels.len() / 4 / self.width as usize) as u32;
        let bytes = bytes(&self.quantizer, (self.width, rows), pixels)?;
        self.quantizer.first_row += rows;
        // An encoder that is gone has failed, which the end reports.
        let _ = self.rows.send(bytes);
        Ok(())
    }

    /// Writes what comes after the last row.
    ///
    /// # Errors
    /// What writing reported.
    pub fn finish(self) -> Result<(), CodecError> {
        drop(self.rows);
        let packed = self.packing.join().map_err(|_| CodecError::new(ErrorKind::Machine, "packing the JPEG failed"))?;
        packed.map_err(|error| failed(&error))
    }
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
