//! Pictures that are larger than a device: a plan that runs band by band.
//!
//! Of the largest images, textures hold a band of rows. A sweep goes over the picture from the top to the bottom, and
//! its passes make some rows of workgroups for each band: exactly those that one dispatch would make, so that each
//! number stays the same, bit by bit, also where workgroups add to a buffer. Passes that reduce the picture to
//! something small, as meters, grids and levels of pyramids are, end a sweep; what follows from their results is
//! made in the next one, and an image of rows that several sweeps need is made in each of them.
//!
//! A band may be made in parts: then textures of the largest images have the rows of a part only, and those of smaller
//! ones, which passes far down a pyramid need many rows of, the rows of the band.
//!
//! How far a pass reads around its pixels is not stated by its kernels, but noticed by its
//! [module](afterimage_wgsl::banded): [`Halos`] learns it.

mod banded;
mod banding;
mod candidates;
mod halos;
mod limits;
mod memory;
mod parts;

use afterimage_graph::image::ImageDesc;

use crate::error::PlanError;
use crate::plan::{Plan, PlannedImage};
use crate::request::Requirement;
use banded::{BandedPlan, Role};
pub use banding::{Band, BandPass, BandedSize, Banding, InputRows, Sweep};
use candidates::BandCandidates;
pub use halos::Halos;
pub use limits::{BandLimits, HostLimits, Parts};
use memory::BandMemory;
use parts::BandParts;

impl Plan {
    /// The plan in bands: those sizes in bands, and about as few bands, that make and upload the fewest rows again.
    /// `requirement` is what the device asks for an image, with its padding.
    ///
    /// # Errors
    /// A pass cannot be made in bands, or no band is small enough.
    pub fn banding(
        &self,
        limits: BandLimits,
        halos: &Halos,
        requirement: &dyn Fn(&ImageDesc) -> Requirement,
    ) -> Result<Banding, PlanError> {
        let is_too_wide = |image: &&PlannedImage| image.lifetime.is_some() && image.desc.size.width > limits.side;
        if let Some(PlannedImage { label, desc, .. }) = self.images.iter().find(is_too_wide) {
            return Err(PlanError::TooLarge { label: label.clone(), size: desc.size, limit: limits.side });
        }
        let candidates = BandCandidates::new(self);
        let sizes = candidates.sizes(self);
        let (mut best, mut lacks): (Option<(u64, Banding)>, _) = (None, Vec::new());
        let parts = limits.parts.map_or(Parts::TRIED.to_vec(), |parts| vec![parts]);
        for count in 1..=sizes.len() {
            let known = best.as_ref().map(|(cost, _)| *cost);
            let banded = match BandedPlan::new(self, halos, limits, &candidates, sizes[..count].to_vec()) {
                Ok(banded) if banded.longest_whole() > limits.side => continue,
                Ok(banded) => banded,
                Err(error) => {
                    lacks.insert(0, error);
                    break;
                }
            };
            let memory = BandMemory { banded: &banded, asked: requirement };
            for parts in &parts {
                match fewest_bands(&memory, *parts) {
                    Ok(banding) => {
                        let cost = memory.cost(&banding);
                        if best.as_ref().is_none_or(|(known, _)| cost < *known) {
                            best = Some((cost, banding));
                        }
                    }
                    Err(lack) => lacks.push(lack),
                }
            }
            // With more sizes in bands, more is made again.
            if known.is_some() && known == best.as_ref().map(|(cost, _)| *cost) {
                break;
            }
        }
        best.map(|(_, banding)| banding).ok_or_else(|| most_relevant_error(lacks, limits))
    }
}

/// The most relevant of several errors: that a pass cannot run in bands; that bands fit into the device,
/// but not into the host; or how little memory the smallest bands need.
fn most_relevant_error(lacks: Vec<PlanError>, limits: BandLimits) -> PlanError {
    let place = |lack: &PlanError| match lack {
        PlanError::TooMuchHostMemory { bytes, .. } => (1, *bytes),
        PlanError::TooMuchMemory { bytes, .. } => (2, *bytes),
        _ => (0, 0),
    };
    let nothing = PlanError::TooMuchMemory { bytes: limits.bytes.saturating_add(1), limit: limits.bytes };
    lacks.into_iter().min_by_key(place).unwrap_or(nothing)
}

/// About as few bands as fit.
///
/// # Errors
/// What the smallest bands take.
fn fewest_bands(memory: &BandMemory<'_>, parts: Parts) -> Result<Banding, PlanError> {
    let banded = memory.banded;
    let limits = banded.limits;
    let whole = memory.bytes(&vec![1; banded.images.len()], &banding(memory, 1, Parts::ONE).lives);
    if whole > limits.bytes {
        return Err(PlanError::TooMuchMemory { bytes: whole, limit: limits.bytes });
    }
    let most = banded.targets().map(|pass| banded.steps(pass)).max().unwrap_or(1);
    let more = |count: &u32| count.checked_add((count / 4).max(1));
    let counts = std::iter::successors(Some(limits.least.max(1)), more);
    let counts: Vec<u32> = counts.take_while(|count| *count < 2 * most.max(limits.least)).collect();
    let (mut least, mut end) = (0, counts.len() - 1);
    let mut fitting = banding(memory, counts[end], parts);
    memory.check(&fitting)?;
    while least < end {
        let middle = least.midpoint(end);
        let banding = banding(memory, counts[middle], parts);
        if memory.check(&banding).is_ok() {
            (end, fitting) = (middle, banding);
        } else {
            least = middle + 1;
        }
    }
    Ok(fitting)
}

/// All sweeps in so many bands of such parts.
fn banding(memory: &BandMemory<'_>, count: u32, parts: Parts) -> Banding {
    let banded = memory.banded;
    let mut sweeps = vec![Sweep::default(); banded.sweeps.iter().max().map_or(0, |last| *last as usize + 1)];
    for pass in (0..banded.roles.len()).filter(|pass| banded.roles[*pass] == Role::Whole) {
        sweeps[banded.sweeps[pass] as usize].before.push(pass);
    }
    let mut covered = Vec::new();
    for (number, sweep) in sweeps.iter_mut().enumerate() {
        let targets: Vec<usize> = banded.targets().filter(|pass| banded.sweeps[*pass] as usize == number).collect();
        for index in 0..count {
            for part in (BandParts { banded, parts }).of(banded.wanted_of(&targets, index, count)) {
                covered.push(part.rows);
                sweep.bands.push(part.band);
            }
        }
    }
    let mut textures = Vec::new();
    for size in 0..banded.sizes.len() {
        let tallest = covered.iter().map(|rows| rows[size].end - rows[size].start).max();
        textures.push(banded.textures(size, tallest.unwrap_or(0)));
    }
    let mut last = vec![u32::MAX; textures.len()];
    for (size, texture) in textures.iter().enumerate().filter(|(size, _)| banded.is_filtered(*size)) {
        // A sampler clamps to the last row of the texture, which must be that of the image.
        last[size] = texture.size[1] - texture.rows;
    }
    for (band, covered) in sweeps.iter_mut().flat_map(|sweep| &mut sweep.bands).zip(covered) {
        band.first = covered.iter().zip(&last).map(|(rows, last)| rows.start.min(*last)).collect();
    }
    let rows = banded.rows(&textures, &sweeps);
    let lives = memory.living(&sweeps);
    let (bytes, host_bytes) = (memory.bytes(&rows, &lives), memory.host_bytes(&sweeps));
    let (images, piece) = (banded.images.clone(), memory.piece());
    Banding { sizes: textures, images, rows, sweeps, lives, piece, bytes, host_bytes }
}
