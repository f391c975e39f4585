//! Numbers inside compressed blocks that the decoder would believe.
//!
//! A DWA block begins with eleven counters. The `exr` crate allocates what they state, so a damaged
//! counter asks for terabytes, and an allocation that fails ends the process where no one can
//! catch it.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::error::{Error, Result};
use exr::math::Vec2;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;

/// Refuses a chunk whose counters exceed what its pixels could need.
pub(super) fn check_chunk(chunk: &Chunk, header: &Header) -> Result<()> {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let tile = header.get_block_data_indices(&chunk.compressed_block)?;
    let size = header.get_absolute_block_pixel_coordinates(tile)?.size;
    let is_packed = bytes.len() != size.area() * header.channels.bytes_per_pixel;
    if is_packed && dwa_sizes(bytes).any(|stated| stated > most_dwa_bytes(size, header)) {
        return Err(Error::Invalid("a DWA block claims more data than it has pixels".into()));
    }
    Ok(())
}

/// The counters of unpacked data: unknown bytes, run-length tokens and bytes, AC and DC counts.
fn dwa_sizes(bytes: &[u8]) -> impl Iterator<Item = u64> {
    const UNPACKED: [usize; 5] = [1, 6, 7, 8, 9];
    let (counters, _) = bytes.as_chunks::<8>();
    UNPACKED.iter().filter_map(|at| counters.get(*at)).map(|counter| u64::from_le_bytes(*counter))
}

/// Every sample once, in whole 8×8 blocks, and as much again for tokens that do not pack.
fn most_dwa_bytes(size: Vec2<usize>, header: &Header) -> u64 {
    let padded = size.0.next_multiple_of(8) * size.1.next_multiple_of(8);
    2 * padded as u64 * header.channels.bytes_per_pixel as u64 + 4096
}
