//! Statistics of all channels of an EXR file.

use std::io::{Read, Seek};

use exr::block::UncompressedBlock;
use exr::math::Vec2;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use half::f16;
use rayon::prelude::*;

use super::blocks::{read_batches, unpack};
use super::read::{Opened, open, working_bytes};
use crate::codec::statistics::ChannelStatistics;
use crate::codec::{Budget, CodecError, guarded};

/// The statistics of the largest level of each channel, part by part.
pub(crate) fn measure(reader: impl Read + Seek, budget: Budget) -> Result<Vec<Vec<ChannelStatistics>>, CodecError> {
    let Opened { reader, .. } = open(reader)?;
    let mut parts: Vec<Vec<_>> =
        reader.headers().iter().map(|part| vec![ChannelStatistics::default(); part.channels.list.len()]).collect();
    let mut most = 1;
    for header in reader.headers() {
        budget.check((header.layer_size.0 as u64, header.layer_size.1 as u64), 0, working_bytes(header))?;
        most = most.max(header.max_block_byte_size());
    }
    read_batches(
        reader,
        most,
        |_, level| level == Vec2(0, 0),
        |batch, meta| {
            let measured = batch.into_par_iter().map(|chunk| {
                let block = guarded(|| unpack(chunk, meta))?;
                Ok((block.index.layer, of_block(&meta.headers[block.index.layer], &block)))
            });
            for (part, channels) in measured.collect::<Result<Vec<_>, CodecError>>()? {
                parts[part].iter_mut().zip(channels).for_each(|(all, block)| *all = all.and(block));
            }
            Ok(())
        },
    )?;
    Ok(parts)
}

fn of_block(header: &Header, block: &UncompressedBlock) -> Vec<ChannelStatistics> {
    let width = block.index.pixel_size.0;
    let line = header.channels.bytes_per_pixel * width;
    let mut found = vec![ChannelStatistics::default(); header.channels.list.len()];
    for row in block.data.chunks_exact(line.max(1)) {
        let mut rest = row;
        for (channel, statistics) in header.channels.list.iter().zip(&mut found) {
            let (bytes, after) = rest.split_at(width * channel.sample_type.bytes_per_sample());
            rest = after;
            let (pairs, quads) = (bytes.as_chunks::<2>().0, bytes.as_chunks::<4>().0);
            match channel.sample_type {
                SampleType::F16 => pairs.iter().for_each(|b| statistics.add(f16::from_ne_bytes(*b).to_f64())),
                SampleType::F32 => quads.iter().for_each(|b| statistics.add(f32::from_ne_bytes(*b).into())),
                SampleType::U32 => quads.iter().for_each(|b| statistics.add(u32::from_ne_bytes(*b).into())),
            }
        }
    }
    found
}
