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
//! [module](afterimage_wgsl::banded): [`Reach`] learns it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::{Arg, ImageId, Origin, Pass, PassKind, Resource};
use afterimage_wgsl::{GlobalKind, SampleMode};

use crate::codegen::rows_of_workgroup;
use crate::error::PlanError;
use crate::plan::{Plan, PlannedImage, Stage};
use crate::request::Requirement;

/// What a device has for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BandLimits {
    /// Bytes of all images and buffers as the driver pads them, and of the rows on their way from and to the host.
    pub bytes: u64,
    /// Bytes of these that others have.
    pub taken: u64,
    /// Bytes of the blocks in which memory for smaller images and buffers is taken; 0 if each has memory of its own.
    pub block: u64,
    /// The longest side of a texture.
    pub side: u32,
    /// Whether images that a sampler filters may be in bands, as they may on the processor. That of a card rounds
    /// places in a texture of fewer rows in other ways.
    pub filters: bool,
    /// The least number of bands of a sweep: more than one for tests.
    pub least: u32,
    /// The parts in which the largest images of a band are made, for tests; as is best without.
    pub parts: Option<Parts>,
    /// The first row that outputs are made of, and the one after the last; all of them without. Passes that make
    /// something whole see the whole picture all the same.
    pub rows: Option<[u32; 2]>,
    pub host: HostLimits,
}

/// Parts of a band: textures of its largest images have the rows of a part, those of others the rows of the band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// How many of the largest sizes.
    pub sizes: usize,
    /// About how many rows of the largest size.
    pub rows: u32,
}

/// What the host has for the rows that are on their way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostLimits {
    /// Bytes of all rows that are read ahead, decoded and written.
    pub bytes: u64,
    /// Rows that inputs are decoded in multiples of, which stay until no band needs them any more; 0 if they are in
    /// memory anyway.
    pub decoded: u32,
    /// Rows of an output that are written together.
    pub written: u32,
}

impl HostLimits {
    /// A host that has as much as it takes, and images in memory.
    pub const NONE: Self = Self { bytes: u64::MAX, decoded: 0, written: 1 };
}

/// How many rows passes read above and below those that they make, in images of each size.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reach(BTreeMap<(usize, [u32; 2]), [u32; 2]>);

/// A plan in bands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Banding {
    /// The sizes of the images of which textures hold a band.
    pub sizes: Vec<BandedSize>,
    /// For each image the place of its size, if its texture holds a band.
    pub images: Vec<Option<usize>>,
    /// The rows of the texture of each such image: fewer than those of the size for one that no pass reads.
    pub rows: Vec<u32>,
    /// The sweeps in their order.
    pub sweeps: Vec<Sweep>,
    /// Which images have textures: before the first sweep, in it, before the second one, and so on.
    pub lives: Vec<Vec<bool>>,
    /// Bytes of a copy from or to the host, unless a row has more.
    pub piece: u64,
    /// Bytes that are taken, of all that the limits count.
    pub bytes: u64,
    /// Bytes that the rows on their way take on the host.
    pub host_bytes: u64,
}

/// Images of one size that are in textures band by band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BandedSize {
    /// Width and height of the images.
    pub size: [u32; 2],
    /// Rows of the textures that passes read.
    pub rows: u32,
}

/// One way over the picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sweep {
    /// The passes that run before it, over whole images.
    pub before: Vec<usize>,
    pub bands: Vec<Band>,
}

/// One step of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Band {
    /// For each size, the row that is the first of the textures.
    pub first: Vec<u32>,
    /// The rows of host images that it needs.
    pub inputs: Vec<(ImageId, Range<u32>)>,
    /// What runs, in order.
    pub passes: Vec<BandPass>,
    /// The rows of images of the host that it makes, by the places of the outputs.
    pub outputs: Vec<(usize, Range<u32>)>,
}

/// Rows of an input for a band.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputRows {
    pub image: ImageId,
    pub rows: Range<u32>,
    /// The first row that this band or a later one of the sweep needs.
    pub needed: u32,
}

impl Sweep {
    /// The rows of inputs that its bands need, in their order.
    pub fn inputs(&self) -> Vec<InputRows> {
        let mut needed = BTreeMap::new();
        let mut all = Vec::new();
        for (image, rows) in self.bands.iter().flat_map(|band| &band.inputs).rev() {
            let first = needed.entry(image.0).or_insert(u32::MAX);
            *first = rows.start.min(*first);
            all.push(InputRows { image: *image, rows: rows.clone(), needed: *first });
        }
        all.reverse();
        all
    }
}

/// A pass in a band.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BandPass {
    pub pass: usize,
    /// Rows of workgroups.
    pub groups: Range<u32>,
    /// Rows of its first result; of no meaning for one that is not made row by row.
    pub rows: Range<u32>,
    /// For each size, the rows that all images which it reads have texels for.
    pub known: Vec<Range<u32>>,
}

impl Reach {
    /// Adds rows, above and below, to those that a pass is given.
    pub fn learn(&mut self, pass: &Pass, index: usize, size: [u32; 2], more: [u32; 2]) {
        let known = self.of(pass, index, size);
        self.0.insert((index, size), [known[0] + more[0], known[1] + more[1]]);
    }

    fn of(&self, pass: &Pass, index: usize, size: [u32; 2]) -> [u32; 2] {
        let first = if matches!(pass.kind, PassKind::RowDownsample(_)) { 2 } else { 1 };
        self.0.get(&(index, size)).copied().unwrap_or([first; 2])
    }
}

/// The most bytes of an image that a host uploads or reads back at a time, unless a row has more.
const MAX_PIECE: u64 = 16 << 20;

/// The part of the memory that such a copy has at most.
const PIECES: u64 = 64;

/// What wgpu stages of parameters and zeros, and what it has for itself.
const STAGED: u64 = 1 << 20;

/// The parts that are tried.
const PARTS: [Parts; 4] = [
    Parts { sizes: 1, rows: 128 },
    Parts { sizes: 1, rows: 32 },
    Parts { sizes: 2, rows: 128 },
    Parts { sizes: 2, rows: 32 },
];

/// Bands whose rows of an input are in memory: at the reader, on the way, and at the device.
const READ_AHEAD: u64 = 3;

/// The same for the rows of outputs.
const WRITTEN_BEHIND: u64 = 3;

/// Copies that a writer makes of texels: as codes, waiting, filtered, packed.
const WRITING: u64 = 4;

/// Bytes that could be uploaded while a band starts.
const STARTED: u64 = 4 << 20;

/// How a pass takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// It has whole images only.
    Whole,
    /// It makes bands, as often as they are needed.
    Band,
    /// It makes something whole from bands, each part once.
    Sweep,
}

/// What runs in a band or in a part of it.
struct Running {
    /// The steps that it is for.
    wanted: BTreeMap<usize, Range<u32>>,
    /// These, and those of passes that make images for them.
    steps: BTreeMap<usize, Range<u32>>,
    /// The rows of each image in bands that are made, or that are there before.
    known: Vec<Option<Range<u32>>>,
}

/// Passes of a band that run together: part by part if they have images of the largest size.
struct Group {
    passes: Vec<usize>,
    has_largest: bool,
}

impl Running {
    fn steps_of(&self, group: &Group) -> BTreeMap<usize, Range<u32>> {
        group.passes.iter().map(|pass| (*pass, self.steps[pass].clone())).collect()
    }
}

/// What a device asks for an image.
type Asked<'a> = &'a dyn Fn(&ImageDesc) -> Requirement;

/// A plan with some sizes in bands.
struct Sizes<'a> {
    plan: &'a Plan,
    reach: &'a Reach,
    limits: BandLimits,
    asked: Asked<'a>,
    sizes: Vec<[u32; 2]>,
    images: Vec<Option<usize>>,
    /// The images that a sampler filters.
    filtered: &'a [bool],
    roles: Vec<Role>,
    /// The sweep of each pass that is no part of bands alone; those that are whole run before it.
    sweeps: Vec<u32>,
}

impl Plan {
    /// The plan in bands: those sizes in bands, and about as few bands, that make and upload the fewest rows again.
    /// `requirement` is what the device asks for an image, with its padding.
    ///
    /// # Errors
    /// A pass cannot be made in bands, or no band is small enough.
    pub fn banding(
        &self,
        limits: BandLimits,
        reach: &Reach,
        requirement: &dyn Fn(&ImageDesc) -> Requirement,
    ) -> Result<Banding, PlanError> {
        let is_too_wide = |image: &&PlannedImage| image.lifetime.is_some() && image.desc.size.width > limits.side;
        if let Some(PlannedImage { label, desc, .. }) = self.images.iter().find(is_too_wide) {
            return Err(PlanError::TooLarge { label: label.clone(), size: desc.size, limit: limits.side });
        }
        let mut sizes: Vec<[u32; 2]> = Vec::new();
        for image in (0..self.images.len()).filter(|image| self.can_be_banded(*image)) {
            let size = self.size_of(image);
            if !sizes.contains(&size) {
                sizes.push(size);
            }
        }
        sizes.sort_by_key(|[width, height]| std::cmp::Reverse(u64::from(*width) * u64::from(*height)));
        let (mut best, mut lacks): (Option<(u64, Banding)>, _) = (None, Vec::new());
        let mut parts: Vec<Option<Parts>> = vec![limits.parts];
        if limits.parts.is_none() {
            parts.extend(PARTS.map(Some));
        }
        let filtered: Vec<bool> = (0..self.images.len()).map(|image| self.is_filtered(image)).collect();
        for count in 1..=sizes.len() {
            let known = best.as_ref().map(|(cost, _)| *cost);
            let sizes = match Sizes::new(self, reach, limits, requirement, &filtered, sizes[..count].to_vec()) {
                Ok(sizes) if sizes.longest_whole() > limits.side => continue,
                Ok(sizes) => sizes,
                Err(error) => {
                    lacks.insert(0, error);
                    break;
                }
            };
            for parts in &parts {
                match sizes.fewest_bands(*parts) {
                    Ok(banding) => {
                        let cost = sizes.cost(&banding);
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
        best.map(|(_, banding)| banding).ok_or_else(|| said_first(lacks, limits))
    }

    fn can_be_banded(&self, image: usize) -> bool {
        let planned = &self.images[image];
        let desc = planned.desc;
        let is_plain = desc.samples == 1 && desc.levels == 1 && desc.layers == 1 && !desc.volume;
        let is_made = !matches!(planned.origin, Origin::Constant(_) | Origin::Baked);
        is_plain && is_made && !desc.format.is_depth() && planned.lifetime.is_some()
    }

    fn size_of(&self, image: usize) -> [u32; 2] {
        let size = self.images[image].desc.size;
        [size.width, size.height]
    }

    /// Whether a pass reads an image through a sampler that filters.
    fn is_filtered(&self, image: usize) -> bool {
        (0..self.passes.len()).any(|index| {
            let pass = &self.passes[index].pass;
            let has_sampler = pass.kernels.iter().any(|kernel| match kernel.shader.reflect() {
                Ok(known) if pass.results.is_empty() => {
                    known.globals.iter().any(|global| global.kind == GlobalKind::Sampler)
                }
                _ => kernel.args.iter().any(|arg| arg.value == Arg::Sampler),
            });
            let reads = pass.args().any(|arg| arg == Arg::Texture(ImageId(image as u32)));
            has_sampler && reads && self.sample_mode(index) == SampleMode::Plain
        })
    }

    /// The strictest way in which a pass samples.
    fn sample_mode(&self, pass: usize) -> SampleMode {
        let images = self.passes[pass].pass.kernels.iter().flat_map(|kernel| kernel.textures());
        images.map(|image| self.image(image).sample_mode).max().unwrap_or_default()
    }
}

/// What a user should know of all that has failed: that a pass cannot be made in bands; that bands fit into the device,
/// but not into the host; or how little memory the smallest bands need.
fn said_first(lacks: Vec<PlanError>, limits: BandLimits) -> PlanError {
    let place = |lack: &PlanError| match lack {
        PlanError::TooMuchHostMemory { bytes, .. } => (1, *bytes),
        PlanError::TooMuchMemory { bytes, .. } => (2, *bytes),
        _ => (0, 0),
    };
    let nothing = PlanError::TooMuchMemory { bytes: limits.bytes.saturating_add(1), limit: limits.bytes };
    lacks.into_iter().min_by_key(place).unwrap_or(nothing)
}

fn images(resources: Vec<Resource>) -> impl Iterator<Item = usize> {
    resources.into_iter().filter_map(Resource::image).map(|image| image.0 as usize)
}

/// The range that holds both.
fn joined(one: Option<Range<u32>>, other: Range<u32>) -> Range<u32> {
    one.map_or(other.clone(), |one| one.start.min(other.start)..one.end.max(other.end))
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

/// That part of a number of steps: the `index`th of `count` parts. Of steps over several bands, each is made in the
/// second one of these: bands around it need no more rows than it does, and find them decoded.
fn part(steps: u32, index: u32, count: u32) -> Range<u32> {
    let late = if count / 2 >= steps { 2 } else { 0 };
    let place = |index: u32| match index.checked_sub(late) {
        Some(index) => (u64::from(steps) * u64::from(index) / u64::from(count)) as u32 + late.min(1),
        None => 0,
    };
    place(index)..place(index + 1)
}

impl<'a> Sizes<'a> {
    fn new(
        plan: &'a Plan,
        reach: &'a Reach,
        limits: BandLimits,
        asked: Asked<'a>,
        filtered: &'a [bool],
        sizes: Vec<[u32; 2]>,
    ) -> Result<Self, PlanError> {
        let place = |image: usize| {
            let found = sizes.iter().position(|size| *size == plan.size_of(image));
            found.filter(|_| plan.can_be_banded(image) && (limits.filters || !filtered[image]))
        };
        let images: Vec<Option<usize>> = (0..plan.images.len()).map(place).collect();
        let (roles, sweeps) = (Vec::new(), Vec::new());
        let mut banded = Self { plan, reach, limits, asked, sizes, images, filtered, roles, sweeps };
        for pass in 0..plan.passes.len() {
            banded.roles.push(banded.role(pass)?);
        }
        banded.order()?;
        Ok(banded)
    }

    fn pass(&self, pass: usize) -> &'a Pass {
        &self.plan.passes[pass].pass
    }

    fn refusal(&self, pass: usize, why: &str) -> PlanError {
        PlanError::NoBands { node: self.pass(pass).nodes.join(" + "), why: why.to_owned() }
    }

    /// The images in bands among these resources.
    fn banded(&self, resources: Vec<Resource>) -> impl Iterator<Item = usize> + '_ {
        images(resources).filter(|image| self.images[*image].is_some())
    }

    fn is_banded(&self, resource: Resource) -> bool {
        resource.image().is_some_and(|image| self.images[image.0 as usize].is_some())
    }

    fn role(&self, index: usize) -> Result<Role, PlanError> {
        let pass = self.pass(index);
        let reads_bands = self.banded(pass.reads()).next().is_some();
        let written = pass.writes();
        let bands = written.iter().filter(|resource| self.is_banded(**resource)).count();
        let makes_in_order = !matches!(pass.kind, PassKind::Compute | PassKind::CellReduce(_));
        match (bands, reads_bands) {
            (0, false) if self.plan.passes[index].stage != Stage::Drawing => Ok(Role::Whole),
            _ if self.plan.passes[index].stage == Stage::Drawing => Err(self.refusal(index, "it draws geometry")),
            (0, _) => Ok(Role::Sweep),
            _ if !makes_in_order => Err(self.refusal(index, "its kernel makes the rows of an image in its own order")),
            (bands, _) if bands == written.len() => Ok(Role::Band),
            _ => Ok(Role::Sweep),
        }
    }

    /// Finds the sweep of each pass.
    fn order(&mut self) -> Result<(), PlanError> {
        let mut ready: BTreeMap<Resource, u32> = BTreeMap::new();
        // When nothing reads it any more; never, if bands are made of it whenever they are needed.
        let mut free: BTreeMap<Resource, Option<u32>> = BTreeMap::new();
        for index in 0..self.roles.len() {
            let (pass, role) = (self.pass(index), self.roles[index]);
            let (reads, writes) = (pass.reads(), pass.writes());
            let known = reads.iter().chain(&writes).filter_map(|resource| ready.get(resource));
            let mut sweep = known.copied().max().unwrap_or(0);
            for written in &writes {
                match free.get(written) {
                    Some(None) => return Err(self.refusal(index, "it overwrites what bands are made of")),
                    Some(Some(after)) => sweep = sweep.max(*after),
                    None => {}
                }
                if role == Role::Sweep && self.is_banded(*written) && self.is_read(*written) {
                    return Err(self.refusal(index, "it makes images of several sizes at once"));
                }
            }
            let after = sweep + u32::from(role == Role::Sweep);
            ready.extend(writes.iter().map(|resource| (*resource, after)));
            for read in reads.iter().filter(|read| !self.is_banded(**read)) {
                let until = if role == Role::Band { None } else { Some(after) };
                let known = free.entry(*read).or_insert(until);
                *known = known.zip(until).map(|(known, until)| known.max(until));
            }
            self.sweeps.push(sweep);
        }
        // What depends on nothing is made when it is needed.
        for index in (0..self.roles.len()).rev() {
            let written = self.pass(index).writes();
            if self.roles[index] == Role::Whole && self.pass(index).reads().is_empty() {
                let readers = (0..self.roles.len()).filter(|reader| {
                    let reads = self.pass(*reader).reads();
                    written.iter().any(|resource| reads.contains(resource))
                });
                self.sweeps[index] = readers.map(|reader| self.sweeps[reader]).min().unwrap_or(self.sweeps[index]);
            }
        }
        Ok(())
    }

    /// Whether a pass reads it, or the host does.
    fn is_read(&self, resource: Resource) -> bool {
        let is_output = self.plan.outputs.iter().any(|output| Resource::Image(output.image) == resource);
        is_output || self.plan.work().any(|pass| pass.reads().contains(&resource))
    }

    /// The outputs that a pass makes in bands.
    fn outputs(&self, pass: usize) -> impl Iterator<Item = usize> + '_ {
        let outputs = self.plan.outputs.iter().enumerate();
        let written = self.pass(pass).writes();
        let made = outputs.filter(move |(_, output)| written.contains(&Resource::Image(output.image)));
        made.map(|(index, _)| index).filter(move |_| self.roles[pass] == Role::Band)
    }

    /// The passes that sweeps are for.
    fn targets(&self) -> impl Iterator<Item = usize> + '_ {
        let passes = 0..self.roles.len();
        passes.filter(|pass| self.roles[*pass] == Role::Sweep || self.outputs(*pass).next().is_some())
    }

    fn lives(&self, image: usize) -> bool {
        self.plan.images[image].lifetime.is_some()
    }

    fn whole(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.images.len()).filter(|image| self.images[*image].is_none() && self.lives(*image))
    }

    /// Bytes that are taken, with textures of these rows for images in bands.
    fn bytes(&self, rows: &[u32], lives: &[Vec<bool>]) -> u64 {
        let of_image = |image: usize| {
            let desc = self.plan.images[image].desc;
            let height = self.images[image].map_or(desc.size.height, |_| rows[image]);
            (self.asked)(&ImageDesc { size: Size { height, ..desc.size }, ..desc }).bytes
        };
        let images: Vec<u64> =
            (0..rows.len()).map(|image| if self.lives(image) { of_image(image) } else { 0 }).collect();
        let buffers: Vec<u64> = self.plan.buffers.iter().map(|buffer| buffer.bytes.next_multiple_of(256)).collect();
        let device = lives.iter().map(|lives| {
            let living = images.iter().zip(lives).filter(|(_, lives)| **lives).map(|(bytes, _)| *bytes);
            taken([STAGED].into_iter().chain(buffers.iter().copied()).chain(living), self.limits.block)
        });
        let constants = self.plan.images.iter().filter_map(|image| match &image.origin {
            Origin::Constant(bytes) => Some(bytes.len() as u64),
            _ => None,
        });
        let copied = |image: ImageId| {
            let desc = self.plan.image(image).desc;
            let row = (u64::from(desc.size.width) * desc.format.bytes()).next_multiple_of(256);
            row * (self.piece() / row).clamp(1, u64::from(desc.size.height))
        };
        let uploaded = self.plan.inputs.iter().map(|(_, image)| copied(*image)).max();
        let read = self.plan.outputs.iter().map(|output| copied(output.image)).max();
        // Memory of the device, that which the host writes, and that which it reads.
        self.limits.taken
            + device.max().unwrap_or(0)
            + taken(uploaded.into_iter().chain(constants).chain([STAGED]), self.limits.block)
            + taken(read.into_iter().chain([STAGED]), self.limits.block)
    }

    /// Bytes of rows on the host: those that are decoded, and those of the bands that are read ahead and written
    /// behind.
    fn host_bytes(&self, sweeps: &[Sweep]) -> u64 {
        let HostLimits { decoded, written, .. } = self.limits.host;
        let rows = |rows: &Range<u32>| u64::from(rows.end - rows.start);
        let mut most = BTreeMap::new();
        for sweep in sweeps {
            let mut ends = BTreeMap::new();
            for InputRows { image, rows: own, needed } in sweep.inputs() {
                let mut bytes = READ_AHEAD * rows(&own);
                if decoded > 0 {
                    let known: u32 = ends.get(&image).copied().filter(|end| *end >= needed).unwrap_or(needed);
                    let end = known.max(own.end.next_multiple_of(decoded).min(self.plan.image(image).desc.size.height));
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
            copies * self.row(self.plan.outputs[*output].image.0 as usize)
        };
        most.values().sum::<u64>() + outputs.map(output).max().unwrap_or(0)
    }

    /// Bytes of a row of an image.
    fn row(&self, image: usize) -> u64 {
        let desc = self.plan.images[image].desc;
        u64::from(desc.size.width) * desc.format.bytes()
    }

    /// Bytes of the rows that are uploaded and made, and as many for each band as take the time of its start.
    fn cost(&self, banding: &Banding) -> u64 {
        let rows = |rows: &Range<u32>| u64::from(rows.end - rows.start);
        let bands = banding.sweeps.iter().flat_map(|sweep| &sweep.bands);
        let of_band = |band: &Band| {
            let uploaded: u64 = band.inputs.iter().map(|(image, own)| rows(own) * self.row(image.0 as usize)).sum();
            let made = band.passes.iter().filter_map(|run| {
                let image = self.banded(self.pass(run.pass).writes()).next()?;
                Some(rows(&run.rows) * self.row(image))
            });
            STARTED + uploaded + made.sum::<u64>()
        };
        bands.map(of_band).sum()
    }

    /// Which images have textures before each sweep and in it: those in bands while a pass uses them, others from their
    /// first use to the last one.
    fn living(&self, sweeps: &[Sweep]) -> Vec<Vec<bool>> {
        let used_by = |pass: usize| images(self.pass(pass).reads()).chain(images(self.pass(pass).writes()));
        let mut lives = Vec::new();
        for sweep in sweeps {
            let in_bands: BTreeSet<usize> =
                sweep.bands.iter().flat_map(|band| &band.passes).map(|run| run.pass).collect();
            for passes in [sweep.before.clone(), in_bands.into_iter().collect()] {
                let mut used = vec![false; self.images.len()];
                passes.into_iter().flat_map(used_by).for_each(|image| used[image] = true);
                lives.push(used);
            }
        }
        let end = lives.len();
        for image in (0..self.images.len()).filter(|image| self.images[*image].is_none()) {
            let id = ImageId(image as u32);
            let mut used: Vec<usize> = (0..end).filter(|stage| lives[*stage][image]).collect();
            // The host fills it before all, or reads it after all.
            used.extend(self.plan.inputs.iter().any(|(_, input)| *input == id && self.lives(image)).then_some(0));
            used.extend(self.plan.outputs.iter().any(|output| output.image == id).then_some(end - 1));
            if let Some((first, last)) = used.iter().min().zip(used.iter().max()) {
                lives[*first..=*last].iter_mut().for_each(|lives| lives[image] = true);
            }
        }
        lives
    }

    fn piece(&self) -> u64 {
        (self.limits.bytes / PIECES).min(MAX_PIECE)
    }

    fn longest_whole(&self) -> u32 {
        let flat = self.whole().filter(|image| !self.plan.images[*image].desc.volume);
        flat.flat_map(|image| self.plan.size_of(image)).max().unwrap_or(0)
    }

    fn steps(&self, pass: usize) -> u32 {
        self.plan.passes[pass].workgroups[1]
    }

    /// The steps of a pass that a sweep is for.
    fn wanted(&self, pass: usize) -> Range<u32> {
        let mut images = self.outputs(pass).map(|output| self.plan.outputs[output].image.0 as usize);
        match (self.limits.rows, images.next()) {
            (Some([first, end]), Some(image)) => {
                let end = end.min(self.plan.size_of(image)[1]).max(1);
                self.making(pass, image, &(first.min(end - 1)..end))
            }
            _ => 0..self.steps(pass),
        }
    }

    /// Whether workgroups begin at the bottom of the image.
    fn is_upward(&self, pass: usize) -> bool {
        matches!(self.pass(pass).kind, PassKind::Point | PassKind::Gather)
    }

    /// The rows of an image that these steps of a pass from the top to the bottom make.
    fn made(&self, pass: usize, image: usize, steps: &Range<u32>) -> Range<u32> {
        let (count, height) = (self.steps(pass), self.plan.size_of(image)[1]);
        let rows = rows_of_workgroup(self.pass(pass), &self.plan.images).unwrap_or(height);
        let end = |step: u32| match self.is_upward(pass) {
            true => height.saturating_sub((count - step) * rows),
            false if step == count => height,
            false => height.min(step * rows),
        };
        end(steps.start)..end(steps.end)
    }

    /// The steps of a pass that make these rows of an image.
    fn making(&self, pass: usize, image: usize, rows: &Range<u32>) -> Range<u32> {
        let (count, height) = (self.steps(pass), self.plan.size_of(image)[1]);
        let own = rows_of_workgroup(self.pass(pass), &self.plan.images).unwrap_or(height);
        let step = |row: u32| match self.is_upward(pass) {
            true => count - 1 - (height - 1 - row) / own,
            false => (row / own).min(count - 1),
        };
        step(rows.start)..step(rows.end - 1) + 1
    }

    /// The rows of workgroups of these steps; and the steps of rows of workgroups.
    fn groups_of(&self, pass: usize, steps: &Range<u32>) -> Range<u32> {
        let count = self.steps(pass);
        if self.is_upward(pass) { count - steps.end..count - steps.start } else { steps.clone() }
    }

    /// The rows of its first result that a pass makes in these steps, or the steps without any, and how many it has.
    fn extent(&self, pass: usize, steps: &Range<u32>) -> (Range<u32>, u32) {
        match self.pass(pass).results.first().map(|result| result.image.0 as usize) {
            Some(result) => (self.made(pass, result, steps), self.plan.size_of(result)[1]),
            None => (steps.clone(), self.steps(pass)),
        }
    }

    /// The rows of an image that a pass reads for these steps.
    fn read(&self, pass: usize, image: usize, steps: &Range<u32>) -> Range<u32> {
        let (made, of) = self.extent(pass, steps);
        let size = self.plan.size_of(image);
        let place = |row: u32, rounded: u32| {
            ((u64::from(row) * u64::from(size[1]) + u64::from(rounded)) / u64::from(of)) as u32
        };
        let [above, below] = self.reach.of(self.pass(pass), pass, size);
        place(made.start, 0).saturating_sub(above)..place(made.end, of - 1).saturating_add(below).min(size[1])
    }

    /// About as few bands as fit.
    ///
    /// # Errors
    /// What the smallest bands take.
    fn fewest_bands(&self, parts: Option<Parts>) -> Result<Banding, PlanError> {
        let limits = self.limits;
        let whole = self.bytes(&vec![1; self.images.len()], &self.banding(1, None).lives);
        if whole > limits.bytes {
            return Err(PlanError::TooMuchMemory { bytes: whole, limit: limits.bytes });
        }
        let most = self.targets().map(|pass| self.steps(pass)).max().unwrap_or(1);
        let more = |count: &u32| count.checked_add((count / 4).max(1));
        let counts = std::iter::successors(Some(limits.least.max(1)), more);
        let counts: Vec<u32> = counts.take_while(|count| *count < 2 * most.max(limits.least)).collect();
        let (mut least, mut end) = (0, counts.len() - 1);
        let mut fitting = self.banding(counts[end], parts);
        self.check(&fitting)?;
        while least < end {
            let middle = least.midpoint(end);
            let banding = self.banding(counts[middle], parts);
            if self.check(&banding).is_ok() {
                (end, fitting) = (middle, banding);
            } else {
                least = middle + 1;
            }
        }
        Ok(fitting)
    }

    /// Whether the device and the host have the memory.
    fn check(&self, banding: &Banding) -> Result<(), PlanError> {
        let BandLimits { bytes: limit, side, host, .. } = self.limits;
        let is_short = banding.sizes.iter().all(|size| size.size[0].max(size.rows) <= side);
        if !is_short || banding.bytes > limit {
            return Err(PlanError::TooMuchMemory { bytes: banding.bytes.max(limit.saturating_add(1)), limit });
        }
        match banding.host_bytes > host.bytes {
            true => Err(PlanError::TooMuchHostMemory { bytes: banding.host_bytes, limit: host.bytes }),
            false => Ok(()),
        }
    }

    /// All sweeps in so many bands, which have parts or not.
    fn banding(&self, count: u32, parts: Option<Parts>) -> Banding {
        let mut sweeps = vec![Sweep::default(); self.sweeps.iter().max().map_or(0, |last| *last as usize + 1)];
        for pass in (0..self.roles.len()).filter(|pass| self.roles[*pass] == Role::Whole) {
            sweeps[self.sweeps[pass] as usize].before.push(pass);
        }
        let mut tallest = vec![0; self.sizes.len()];
        let mut ends = Vec::new();
        for (number, sweep) in sweeps.iter_mut().enumerate() {
            let targets: Vec<usize> = self.targets().filter(|pass| self.sweeps[*pass] as usize == number).collect();
            for index in 0..count {
                for (band, covered) in self.bands(self.wanted_of(&targets, index, count), parts) {
                    for (tallest, covered) in tallest.iter_mut().zip(&covered) {
                        *tallest = (*tallest).max(covered.end - covered.start);
                    }
                    ends.push(covered);
                    sweep.bands.push(band);
                }
            }
        }
        let sizes: Vec<BandedSize> = (0..self.sizes.len()).map(|size| self.textures(size, tallest[size])).collect();
        let filtered: Vec<bool> = (0..self.sizes.len()).map(|size| self.is_filtered(size)).collect();
        for (band, covered) in sweeps.iter_mut().flat_map(|sweep| &mut sweep.bands).zip(ends) {
            // A sampler clamps to the last row of the texture, which must be that of the image.
            let first = covered.iter().enumerate().map(|(size, covered)| match filtered[size] {
                true => covered.start.min(sizes[size].size[1] - sizes[size].rows),
                false => covered.start,
            });
            band.first = first.collect();
        }
        let rows = self.rows(&sizes, &sweeps);
        let lives = self.living(&sweeps);
        let (bytes, host_bytes, images) = (self.bytes(&rows, &lives), self.host_bytes(&sweeps), self.images.clone());
        Banding { sizes, images, rows, sweeps, lives, piece: self.piece(), bytes, host_bytes }
    }

    /// The rows of the textures of all images in bands: of one that no pass reads, those that a band makes.
    fn rows(&self, sizes: &[BandedSize], sweeps: &[Sweep]) -> Vec<u32> {
        let mut rows: Vec<u32> = self.images.iter().map(|size| size.map_or(0, |size| sizes[size].rows)).collect();
        for (image, rows) in rows.iter_mut().enumerate() {
            let Some(size) = self.images[image] else { continue };
            let resource = Resource::Image(ImageId(image as u32));
            if self.plan.work().any(|pass| pass.reads().contains(&resource)) {
                continue;
            }
            let ends = sweeps.iter().flat_map(|sweep| &sweep.bands).flat_map(|band| {
                let own = band.passes.iter().filter(|run| self.pass(run.pass).writes().contains(&resource));
                own.map(|run| {
                    let steps = self.groups_of(run.pass, &run.groups);
                    self.made(run.pass, image, &steps).end.saturating_sub(band.first[size])
                })
            });
            *rows = ends.max().unwrap_or(1).clamp(1, *rows);
        }
        rows
    }

    /// The steps of these passes in a band.
    fn wanted_of(&self, targets: &[usize], index: u32, count: u32) -> BTreeMap<usize, Range<u32>> {
        let own = |pass: &usize| {
            let all = self.wanted(*pass);
            let own = part(all.end - all.start, index, count);
            (*pass, all.start + own.start..all.start + own.end)
        };
        targets.iter().map(own).filter(|(_, steps)| !steps.is_empty()).collect()
    }

    /// The steps of all passes for those that are wanted, as far as images that may be made are needed.
    fn running(&self, wanted: BTreeMap<usize, Range<u32>>, may_make: impl Fn(usize) -> bool) -> Running {
        let mut known: Vec<Option<Range<u32>>> = vec![None; self.images.len()];
        let mut running = BTreeMap::new();
        for pass in (0..self.roles.len()).rev() {
            let mut steps = wanted.get(&pass).cloned();
            if self.roles[pass] == Role::Band {
                for image in self.banded(self.pass(pass).writes()).filter(|image| may_make(*image)) {
                    if let Some(rows) = &known[image] {
                        steps = Some(joined(steps, self.making(pass, image, rows)));
                    }
                }
            }
            let Some(steps) = steps else { continue };
            for image in self.banded(self.pass(pass).reads()) {
                known[image] = Some(joined(known[image].take(), self.read(pass, image, &steps)));
            }
            running.insert(pass, steps);
        }
        for (pass, steps) in &running {
            for image in self.banded(self.pass(*pass).writes()) {
                known[image] = Some(self.made(*pass, image, steps));
            }
        }
        Running { wanted, steps: running, known }
    }

    /// A band of a sweep for these steps, or its parts, and the rows of each size that each of them has.
    fn bands(&self, wanted: BTreeMap<usize, Range<u32>>, parts: Option<Parts>) -> Vec<(Band, Vec<Range<u32>>)> {
        let whole = self.running(wanted, |_| true);
        if whole.steps.is_empty() {
            return Vec::new();
        }
        let Some(Parts { sizes, rows }) = parts else { return vec![self.band(&whole, &whole, 0, true)] };
        let mut bands = Vec::new();
        for group in self.groups(&whole, sizes) {
            let steps_of_parts =
                if group.has_largest { self.slices(&group, &whole, rows) } else { vec![whole.steps_of(&group)] };
            for steps in steps_of_parts {
                let part = self.running(steps, |image| self.is_largest(image, sizes));
                bands.push(self.band(&part, &whole, sizes, bands.is_empty()));
            }
        }
        bands
    }

    /// Whether an image is in bands and has one of the first `sizes`, which are the largest.
    fn is_largest(&self, image: usize, sizes: usize) -> bool {
        self.images[image].is_some_and(|size| size < sizes)
    }

    /// The passes of a band in the order of its parts. Those that make largest images for others run in the parts of
    /// these.
    fn groups(&self, whole: &Running, sizes: usize) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for pass in whole.steps.keys() {
            let (reads, writes) = (self.pass(*pass).reads(), self.pass(*pass).writes());
            let mut images = self.banded(reads).chain(self.banded(writes.clone()));
            let has_largest = images.any(|image| self.is_largest(image, sizes));
            let is_for_others =
                self.roles[*pass] == Role::Band && self.banded(writes).all(|image| self.is_largest(image, sizes));
            if has_largest && is_for_others && !whole.wanted.contains_key(pass) {
                continue;
            }
            let sources = self.sources(*pass, sizes);
            let place = groups.iter().rposition(|group| group.has_largest == has_largest);
            // Parts of a group run one after another, with all of its passes in each.
            let since = place.map_or(0, |place| place + usize::from(!has_largest));
            let before = groups[since..].iter().flat_map(|group| &group.passes);
            let mut written = before.flat_map(|pass| self.banded(self.pass(*pass).writes()));
            let depends = written.any(|image| sources.contains(&image));
            match place.filter(|_| !depends) {
                Some(place) => groups[place].passes.push(*pass),
                None => groups.push(Group { passes: vec![*pass], has_largest }),
            }
        }
        groups
    }

    /// The smaller images in bands that a pass reads, also through the largest ones that are made for it.
    fn sources(&self, pass: usize, sizes: usize) -> BTreeSet<usize> {
        let mut sources = BTreeSet::new();
        let mut seen = BTreeSet::from([pass]);
        let mut passes = vec![pass];
        while let Some(pass) = passes.pop() {
            for image in self.banded(self.pass(pass).reads()) {
                if !self.is_largest(image, sizes) {
                    sources.insert(image);
                    continue;
                }
                let resource = Resource::Image(ImageId(image as u32));
                let makers = (0..self.roles.len()).filter(|maker| self.pass(*maker).writes().contains(&resource));
                passes.extend(makers.filter(|maker| seen.insert(*maker)));
            }
        }
        sources
    }

    /// The steps of the passes of a group, for each part of about `rows` rows of the largest size.
    fn slices(&self, group: &Group, whole: &Running, rows: u32) -> Vec<BTreeMap<usize, Range<u32>>> {
        let height = u64::from(self.sizes[0][1]);
        let place = |pass: usize, step: u32| {
            let (made, of) = self.extent(pass, &(step..step + 1));
            (u64::from(made.start) * height / u64::from(of)) as u32
        };
        let all = || group.passes.iter().flat_map(|pass| whole.steps[pass].clone().map(|step| (*pass, step)));
        let first = all().map(|(pass, step)| place(pass, step)).min().unwrap_or(0);
        let mut slices: BTreeMap<u32, BTreeMap<usize, Range<u32>>> = BTreeMap::new();
        for (pass, step) in all() {
            let slice = slices.entry((place(pass, step) - first) / rows).or_default();
            let steps = joined(slice.remove(&pass), step..step + 1);
            slice.insert(pass, steps);
        }
        slices.into_values().collect()
    }

    /// A band or a part of one, and the rows of each size that it has. Images that do not have one of the largest sizes
    /// have the rows of the whole band.
    fn band(&self, part: &Running, whole: &Running, sizes: usize, is_first: bool) -> (Band, Vec<Range<u32>>) {
        let mut band = Band::default();
        for (pass, steps) in &part.wanted {
            let own = whole.wanted.get(pass).map(|own| own.start.max(steps.start)..own.end.min(steps.end));
            let Some(own) = own.filter(|own| !own.is_empty()) else { continue };
            for output in self.outputs(*pass) {
                let made = self.made(*pass, self.plan.outputs[output].image.0 as usize, &own);
                let [first, end] = self.limits.rows.unwrap_or([0, u32::MAX]);
                band.outputs.push((output, made.start.max(first)..made.end.min(end)));
            }
        }
        let mut known = part.known.clone();
        let mut covered: Vec<Option<Range<u32>>> = vec![None; self.sizes.len()];
        for (image, rows) in known.iter_mut().enumerate() {
            let Some(size) = self.images[image] else { continue };
            if size >= sizes {
                rows.clone_from(&whole.known[image]);
            }
            let Some(own) = rows.clone() else { continue };
            match &self.plan.images[image].origin {
                Origin::Input(_) if size < sizes || is_first => band.inputs.push((ImageId(image as u32), own.clone())),
                // It is black everywhere.
                Origin::Previous { .. } => {
                    *rows = Some(0..self.sizes[size][1]);
                    continue;
                }
                _ => {}
            }
            covered[size] = Some(joined(covered[size].take(), own));
        }
        for (pass, steps) in &part.steps {
            let mut rows: Vec<Range<u32>> = self.sizes.iter().map(|[_, height]| 0..*height).collect();
            for image in self.banded(self.pass(*pass).reads()) {
                let own = known[image].clone().expect("what a pass reads is needed");
                let all = &mut rows[self.images[image].expect("it is banded")];
                *all = all.start.max(own.start)..all.end.min(own.end);
            }
            let result = self.pass(*pass).results.first().map(|result| result.image.0 as usize);
            let made = result.map_or(0..0, |image| self.made(*pass, image, steps));
            band.passes.push(BandPass { pass: *pass, groups: self.groups_of(*pass, steps), rows: made, known: rows });
        }
        (band, covered.into_iter().map(Option::unwrap_or_default).collect())
    }

    fn is_filtered(&self, size: usize) -> bool {
        let banded = self.images.iter().enumerate().filter(|(_, own)| **own == Some(size));
        banded.map(|(image, _)| image).any(|image| self.filtered[image])
    }

    /// The textures of a size whose bands have that many rows at most.
    fn textures(&self, size: usize, tallest: u32) -> BandedSize {
        let [width, height] = self.sizes[size];
        let is_filtered = self.is_filtered(size);
        let is_taken = |rows: u32| self.whole().any(|image| self.plan.size_of(image) == [width, rows]);
        // A sampler finds the same places in textures whose rows are a power of two.
        let mut rows = if is_filtered { tallest.next_power_of_two() } else { tallest.max(1) };
        while rows < height && (is_taken(rows) || self.sizes.contains(&[width, rows])) {
            rows = if is_filtered { 2 * rows } else { rows + 1 };
        }
        BandedSize { size: [width, height], rows: rows.min(height) }
    }
}
