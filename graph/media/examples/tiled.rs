//! Writes an EXR of half floats in tiles that may be larger than memory, for measurements:
//! `cargo run --release --example tiled -- FILE 32768 32768`.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use exr::block::writer::ChunksWriter as _;
use exr::block::{BlockIndex, UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Compression, LevelMode, LineOrder, SampleType, Text, TileDescription};
use exr::meta::header::Header;
use half::f16;
use rayon::prelude::*;

/// The sides of a tile.
const TILE: usize = 256;
/// Tiles that are in memory at a time.
const BATCH: usize = 512;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [file, width, height] = &words[..] else { return Err("FILE WIDTH HEIGHT".into()) };
    let size: (usize, usize) = (width.parse()?, height.parse()?);
    let channels: Vec<_> = ["B", "G", "R"].map(|name| ChannelDescription::named(name, SampleType::F16)).into();
    let (level_mode, rounding_mode) = (LevelMode::Singular, RoundingMode::Down);
    let tiles = TileDescription { tile_size: Vec2(TILE, TILE), level_mode, rounding_mode };
    let header = Header::new(Text::default(), size, channels.into());
    let tiles = BlockDescription::Tiles(tiles);
    let headers = [header.with_encoding(Compression::ZIP16, tiles, LineOrder::Increasing)];
    let blocks: Vec<_> = enumerate_ordered_header_block_indices(&headers).collect();
    let to = BufWriter::new(File::create(file)?);
    exr::block::write(to, headers.iter().cloned().collect(), false, |_, writer| {
        blocks.chunks(BATCH).try_for_each(|batch| {
            let packed = batch.par_iter().map(|(number, index)| {
                let block = UncompressedBlock { index: *index, data: texels(index) };
                block.compress_to_chunk(&headers).map(|chunk| (*number, chunk))
            });
            let packed = packed.collect::<Result<Vec<_>, _>>()?;
            packed.into_iter().try_for_each(|(number, chunk)| writer.write_chunk(number, chunk))
        })
    })?;
    Ok(())
}

/// A tile, each row channel after channel.
fn texels(block: &BlockIndex) -> Vec<u8> {
    let (Vec2(left, top), Vec2(width, height)) = (block.pixel_position, block.pixel_size);
    let mut bytes = Vec::with_capacity(6 * width * height);
    for y in top..top + height {
        for tint in [0.6, 0.8, 1.0] {
            bytes.extend((left..left + width).flat_map(|x| f16::from_f32(tint * light(x, y)).to_ne_bytes()));
        }
    }
    bytes
}

/// Light and shadow with a grain, and lamps.
fn light(x: usize, y: usize) -> f32 {
    if x % 997 < 3 && y % 1009 < 3 {
        return 60.0;
    }
    let mut bits = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    bits = (bits ^ bits >> 15).wrapping_mul(0x2c1b_3c6d);
    let grain = (bits >> 24) as f32 / 255.0;
    let (u, v) = (x as f32 / 1500.0, y as f32 / 2100.0);
    (0.3 + 0.25 * u.sin() * v.cos() + 0.02 * grain).max(0.0)
}
