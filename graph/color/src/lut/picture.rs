//! Tables stored as PNG images: tiles, as games use them, and HALD, as photographers use it.

use std::io::Cursor;

use afterimage_graph::prelude::*;
use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::{Lut, LutError, MAX_CUBE, Table};

/// Memory limit of the decoder.
const MAX_BYTES: usize = 512 << 20;

choices! {
    /// The layout of a 3-D table of n entries per side in an image.
    pub enum PngLayout {
        /// n tiles of n by n pixels, one per blue, in rows: a strip of 256x16 or 1024x32, or a square of 512x512 for
        /// 64. Within a tile, red increases to the right and green downwards, as Unreal has it.
        Tiles,
        /// The same with green upwards, as Unity has it.
        TilesUp,
        /// HALD: all entries in sequence, red fastest, row by row, in a square of k³ by k³ pixels for n = k².
        Hald,
    }
}

/// Parses a table stored as a PNG image. Codes are used as they are, from 0 to 1, and the image's gamma is ignored.
///
/// # Errors
/// Images that are broken, not in color, or of a size that no table of up to 256 entries per side has in this layout.
pub fn parse_png(bytes: &[u8], layout: PngLayout) -> Result<Lut, LutError> {
    let broken = |error: png::DecodingError| LutError::new(0, format!("the PNG cannot be read: {error}"));
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MAX_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    // Codes are used as they are: a profile is not applied, and need not be unpacked.
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let width = reader.info().width as usize;
    let side = side(width, reader.info().height as usize, layout)?;
    let size = reader.output_buffer_size().ok_or_else(|| LutError::new(0, "the PNG is too large"))?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(broken)?;
    let colors = colors(&pixels[..info.buffer_size()], info.color_type, info.bit_depth)?;
    Ok(table(side, width, &colors, layout, if info.bit_depth == BitDepth::Sixteen { 65535.0 } else { 255.0 }))
}

/// The entries per side of a table in an image of this size.
fn side(width: usize, height: usize, layout: PngLayout) -> Result<usize, LutError> {
    let side = (2..=MAX_CUBE).find(|side| side.pow(3) == width * height);
    if layout == PngLayout::Hald {
        // The side of the image is k³, so its area is k² to the third power.
        return side.filter(|_| width == height).ok_or_else(|| {
            let sides = "8, 27, 64, 125, 216, 343, 512 and so on up to 4096";
            LutError::new(0, format!("a HALD table is a square of {sides} pixels a side, not {width}x{height}"))
        });
    }
    side.filter(|side| width.is_multiple_of(*side) && height.is_multiple_of(*side)).ok_or_else(|| {
        let sizes = "256x16, 1024x32, 64x64 or 512x512";
        LutError::new(0, format!("a table has as many square tiles as they are wide, as {sizes}, not {width}x{height}"))
    })
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

fn table(side: usize, width: usize, colors: &[[f32; 3]], layout: PngLayout, last_code: f32) -> Lut {
    let entry = |index: usize| {
        let (red, green, blue) = (index % side, index / side % side, index / side / side);
        let row = match layout {
            PngLayout::Hald => return colors[index],
            PngLayout::Tiles => green,
            PngLayout::TilesUp => side - 1 - green,
        };
        let tiles = width / side;
        colors[(blue / tiles * side + row) * width + blue % tiles * side + red]
    };
    let entries = (0..side.pow(3)).map(entry).collect();
    let cube = Table { size: side, entries, low: [0.0; 3], high: [1.0; 3] };
    Lut { curve: None, cube: Some(cube), tolerance: 0.5 / last_code }
}
