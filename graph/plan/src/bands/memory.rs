//! Device and host memory of a plan in bands.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::{ImageId, Origin};

use super::banded::{BandedPlan, images};
use super::banding::{Band, Banding, InputRows, Sweep};
use super::limits::{BandLimits, HostLimits};
use crate::error::PlanError;
use crate::request::Requirement;

/// The most bytes of an image that a host uploads or reads back at a time, unless a row has more.
const MAX_PIECE: u64 = 16 << 20;

/// The part of the memory that such a copy has at most.
const PIECES: u64 = 64;

/// Staging memory of wgpu for parameters and zeros, and its own overhead.
const STAGED: u64 = 1 << 20;

/// Bands whose rows of an input are in memory: at the reader, on the way, and at the device.
const READ_AHEAD: u64 = 3;

/// The same for the rows of outputs.
const WRITTEN_BEHIND: u64 = 3;

/// Copies that a writer makes of texels: as codes, waiting, filtered, packed.
const WRITING: u64 = 4;

/// Bytes that could be uploaded while a band starts.
const STARTED: u64 = 4 << 20;

/// Memory requirement of an image on a device.
pub(super) type Asked<'a> = &'a dyn Fn(&ImageDesc) -> Requirement;

/// The memory of a plan with some sizes in bands.
pub(super) struct BandMemory<'a> {
    pub(super) banded: &'a BandedPlan<'a>,
    pub(super) asked: Asked<'a>,
}

impl BandMemory<'_> {
    /// Checks that device and host have the memory.
    pub(super) fn check(&self, banding: &Banding) -> Result<(), PlanError> {
        let BandLimits { bytes: limit, side, host, .. } = self.banded.limits;
        let is_short = banding.sizes.iter().all(|size| size.size[0].max(size.rows) <= side);
        if !is_short || banding.bytes > limit {
            return Err(PlanError::TooMuchMemory { bytes: banding.bytes.max(limit.saturating_add(1)), limit });
        }
        match banding.host_bytes > host.bytes {
            true => Err(PlanError::TooMuchHostMemory { bytes: banding.host_bytes, limit: host.bytes }),
            false => Ok(()),
        }
    }

    /// Bytes that are taken, with textures of these rows for images in bands.
    pub(super) fn bytes(&self, rows: &[u32], lives: &[Vec<bool>]) -> u64 {
        let of_image = |image: usize| {
            let desc = self.banded.plan.images[image].desc;
            let height = self.banded.images[image].map_or(desc.size.height, |_| rows[image]);
            (self.asked)(&ImageDesc { size: Size { height, ..desc.size }, ..desc }).bytes
        };
        let images: Vec<u64> =
            (0..rows.len()).map(|image| if self.banded.lives(image) { of_image(image) } else { 0 }).collect();
        let buffers: Vec<u64> =
            self.banded.plan.buffers.iter().map(|buffer| buffer.bytes.next_multiple_of(256)).collect();
        let device = lives.iter().map(|lives| {
            let living = images.iter().zip(lives).filter(|(_, lives)| **lives).map(|(bytes, _)| *bytes);
            taken([STAGED].into_iter().chain(buffers.iter().copied()).chain(living), self.banded.limits.block)
        });
        let constants = self.banded.plan.images.iter().filter_map(|image| match &image.origin {
            Origin::Constant(bytes) => Some(bytes.len() as u64),
            _ => None,
        });
        let copied = |image: ImageId| {
            let desc = self.banded.plan.image(image).desc;
            let row = (u64::from(desc.size.width) * desc.format.bytes()).next_multiple_of(256);
            row * (self.piece() / row).clamp(1, u64::from(desc.size.height))
        };
        let uploaded = self.banded.plan.inputs.iter().map(|(_, image)| copied(*image)).max();
        let read = self.banded.plan.outputs.iter().map(|output| copied(output.image)).max();
        // Memory of the device, that which the host writes, and that which it reads.
        self.banded.limits.taken
            + device.max().unwrap_or(0)
            + taken(uploaded.into_iter().chain(constants).chain([STAGED]), self.banded.limits.block)
            + taken(read.into_iter().chain([STAGED]), self.banded.limits.block)
    }

    /// Bytes of rows on the host: those that are decoded, and those of the bands that are read ahead and written
    /// behind.
    pub(super) fn host_bytes(&self, sweeps: &[Sweep]) -> u64 {
        let HostLimits { decoded, written, .. } = self.banded.limits.host;
        let rows = |rows: &Range<u32>| u64::from(rows.end - rows.start);
        let mut most = BTreeMap::new();
        for sweep in sweeps {
            let mut ends = BTreeMap::new();
            for InputRows { image, rows: own, needed } in sweep.inputs() {
                let mut bytes = READ_AHEAD * rows(&own);
                if decoded > 0 {
                    let known: u32 = ends.get(&image).copied().filter(|end| *end >= needed).unwrap_or(needed);
                    let end = known
                        .max(own.end.next_multiple_of(decoded).min(self.banded.plan.image(image).desc.size.height));
                    // Those that are decoded now are there twice.
                    bytes += rows(&(needed..end)) + rows(&(known..end));
                    ends.insert(image, end);
                }
                let bytes = bytes * self.row(image.0 as usize);
                most.entry(image).and_modify(|most: &mut u64| *most = bytes.max(*most)).or_insert(bytes);
            }
        }
        let outputs = sweeps.iter().flat_map(|sweep| &sweep.bands).flat_map(|band| &band.outputs);
        let output = |(output, own): &(usize, Range<u32>)| {
            let copies = WRITTEN_BEHIND * rows(own) + WRITING * (rows(own) + u64::from(written));
            copies * self.row(self.banded.plan.outputs[*output].image.0 as usize)
        };
        most.values().sum::<u64>() + outputs.map(output).max().unwrap_or(0)
    }

    /// Bytes of a row of an image.
    fn row(&self, image: usize) -> u64 {
        let desc = self.banded.plan.images[image].desc;
        u64::from(desc.size.width) * desc.format.bytes()
    }

    /// Bytes of the rows that are uploaded and made, and as many for each band as take the time of its start.
    pub(super) fn cost(&self, banding: &Banding) -> u64 {
        let rows = |rows: &Range<u32>| u64::from(rows.end - rows.start);
        let bands = banding.sweeps.iter().flat_map(|sweep| &sweep.bands);
        let of_band = |band: &Band| {
            let uploaded: u64 = band.inputs.iter().map(|(image, own)| rows(own) * self.row(image.0 as usize)).sum();
            let made = band.passes.iter().filter_map(|run| {
                let image = *self.banded.writes[run.pass].first()?;
                Some(rows(&run.rows) * self.row(image))
            });
            STARTED + uploaded + made.sum::<u64>()
        };
        bands.map(of_band).sum()
    }

    /// Marks the images that have textures before each sweep and in it: those in bands while a pass uses them, others
    /// from their first use to the last one.
    pub(super) fn living(&self, sweeps: &[Sweep]) -> Vec<Vec<bool>> {
        let used_by =
            |pass: usize| images(self.banded.pass(pass).reads()).chain(images(self.banded.pass(pass).writes()));
        let mut lives = Vec::new();
        for sweep in sweeps {
            let in_bands: BTreeSet<usize> =
                sweep.bands.iter().flat_map(|band| &band.passes).map(|run| run.pass).collect();
            for passes in [sweep.before.clone(), in_bands.into_iter().collect()] {
                let mut used = vec![false; self.banded.images.len()];
                passes.into_iter().flat_map(used_by).for_each(|image| used[image] = true);
                lives.push(used);
            }
        }
        let end = lives.len();
        for image in (0..self.banded.images.len()).filter(|image| self.banded.images[*image].is_none()) {
            let id = ImageId(image as u32);
            let mut used: Vec<usize> = (0..end).filter(|stage| lives[*stage][image]).collect();
            // The host fills it before all, or reads it after all.
            used.extend(
                self.banded.plan.inputs.iter().any(|(_, input)| *input == id && self.banded.lives(image)).then_some(0),
            );
            used.extend(self.banded.plan.outputs.iter().any(|output| output.image == id).then_some(end - 1));
            if let Some((first, last)) = used.iter().min().zip(used.iter().max()) {
                lives[*first..=*last].iter_mut().for_each(|lives| lives[image] = true);
            }
        }
        lives
    }

    pub(super) fn piece(&self) -> u64 {
        (self.banded.limits.bytes / PIECES).min(MAX_PIECE)
    }
}

/// Bytes of memory for these images and buffers, which are taken one after another: smaller ones share blocks.
fn taken(bytes: impl Iterator<Item = u64>, block: u64) -> u64 {
    let mut taken = 0;
    let mut free: Vec<u64> = Vec::new();
    for bytes in bytes {
        match free.iter_mut().find(|free| **free >= bytes) {
            _ if bytes > block => taken += bytes,
            Some(free) => *free -= bytes,
            None => {
                taken += block;
                free.push(block - bytes);
            }
        }
    }
    taken
}
