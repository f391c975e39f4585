//! The blocks of an EXR file: chunks are read in order and in batches, and unpacked on all cores.

use std::io::{Read, Seek};

use exr::block::chunk::Chunk;
use exr::block::reader::{ChunksReader, Reader};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::math::Vec2;
use exr::meta::MetaData;

use super::dwa_counters::check_chunk;
use super::explain;
use crate::codec::CodecError;

/// Bytes of the blocks that are unpacked at a time: enough for every core, and little enough for the next batch to find
/// the memory of the last one still in the caches.
pub(super) const BATCH_BYTES: usize = 16 << 20;

/// Reads the chunks that `is_wanted` accepts by their block and their level, and passes them to `take` in batches.
/// `block_bytes` are those of the largest block. Returns the number of chunks that the file must have.
pub(super) fn read_batches<R: Read + Seek>(
    reader: Reader<R>,
    block_bytes: usize,
    is_wanted: impl Fn(&BlockIndex, Vec2<usize>) -> bool,
    mut take: impl FnMut(Vec<Chunk>, &MetaData) -> Result<(), CodecError>,
) -> Result<usize, CodecError> {
    let chunks = reader.filter_chunks(false, |_, tile, block| is_wanted(&block, tile.level_index));
    let mut chunks = chunks.map_err(|error| explain(&error))?;
    let expected = chunks.expected_chunk_count();
    let count = (BATCH_BYTES / block_bytes.max(1)).clamp(1, 4096);
    loop {
        let batch: Result<Vec<Chunk>, _> = chunks.by_ref().take(count).collect();
        let batch = batch.map_err(|error| explain(&error))?;
        if batch.is_empty() {
            return Ok(expected);
        }
        take(batch, chunks.meta_data())?;
    }
}

pub(super) fn unpack(chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock, CodecError> {
    let header = meta.headers.get(chunk.layer_index).ok_or_else(missing_blocks)?;
    let block = check_chunk(&chunk, header).and_then(|()| UncompressedBlock::decompress_chunk(chunk, meta, false));
    let block = block.map_err(|error| explain(&error))?;
    if block.data.len() != block.index.pixel_size.area() * header.channels.bytes_per_pixel {
        return Err(CodecError::broken("a block has the wrong size"));
    }
    Ok(block)
}

pub(super) fn missing_blocks() -> CodecError {
    CodecError::broken("blocks of the image are missing or stored twice")
}
