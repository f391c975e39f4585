//! Tables stored as PNG images: tiles, as games use them, and HALD, as photographers use it.

use std::io::Cursor;

use afterimage_graph::prelude::*;
use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::{Lut, LutError, Table};

/// Memory limit of the decoder.
const MAX_BYTES: usize = 512 << 20;

choices! {
    /// The layout of a 3-D table of k² entries per side in an image of k³ by k³ pixels, 512 by 512 for the usual 64.
    pub enum PngLayout {
        /// k by k tiles, one per blue. Within a tile, red increases to the right and green downwards.
        Tiles,
        /// HALD: all entries in sequence, red fastest, row by row.
        Hald,
    }
}

/// Parses a table stored as a PNG image. Codes are used as they are, from 0 to 1, and the image's gamma is ignored.
///
/// # Errors
/// Images that are broken, not in color, or not square with a side of 8, 27, 64 and so on up to 4096.
pub fn parse_png(bytes: &[u8], layout: PngLayout) -> Result<Lut, LutError> {
    let broken = |error: png::DecodingError| LutError::new(0, format!("the PNG cannot be read: {error}"));
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MAX_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    // Codes are used as they are: a profile is not applied, and need not be unpacked.
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let level = level(reader.info().width, reader.info().height)?;
    let size = reader.output_buffer_size().ok_or_else(|| LutError::new(0, "the PNG is too large"))?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(broken)?;
    let colors = colors(&pixels[..info.buffer_size()], info.color_type, info.bit_depth)?;
    Ok(table(level, &colors, layout, if info.bit_depth == BitDepth::Sixteen { 65535.0 } else { 255.0 }))
}

/// The k of k³ by k³ pixels.
fn level(width: u32, height: u32) -> Result<usize, LutError> {
    let level = (2..=16_u32).find(|k| k.pow(3) == width && width == height);
    let level = level.ok_or_else(|| {
        let sizes = "8, 27, 64, 125, 216, 343, 512 and so on up to 4096";
        LutError::new(0, format!("a table is a square of {sizes} pixels a side, not {width}x{height}"))
    })?;
    Ok(level as usize)
}

/// The pixels as three numbers from 0 to 1.
fn colors(pixels: &[u8], color: ColorType, depth: BitDepth) -> Result<Vec<[f32; 3]>, LutError> {
    if !matches!(color, ColorType::Rgb | ColorType::Rgba) {
        return Err(LutError::new(0, "the PNG has no colors: a table needs red, green and blue"));
    }
    let channels = color.samples();
    Ok(if depth == BitDepth::Sixteen {
        let code = |pixel: &[u8], c: usize| f32::from(u16::from_be_bytes([pixel[2 * c], pixel[2 * c + 1]])) / 65535.0;
        pixels.chunks_exact(2 * channels).map(|pixel| [code(pixel, 0), code(pixel, 1), code(pixel, 2)]).collect()
    } else {
        pixels
            .chunks_exact(channels)
            .map(|pixel| [pixel[0], pixel[1], pixel[2]].map(|code| f32::from(code) / 255.0))
            .collect()
    })
}

fn table(level: usize, colors: &[[f32; 3]], layout: PngLayout, last_code: f32) -> Lut {
    let size = level * level;
    let entry = |index: usize| match layout {
        PngLayout::Hald => colors[index],
        PngLayout::Tiles => {
            let (red, green, blue) = (index % size, index / size % size, index / size / size);
            let (x, y) = (blue % level * size + red, blue / level * size + green);
            colors[y * size * level + x]
        }
    };
    let entries = (0..size.pow(3)).map(entry).collect();
    let cube = Table { size, entries, low: [0.0; 3], high: [1.0; 3] };
    Lut { curve: None, cube: Some(cube), tolerance: 0.5 / last_code }
}
