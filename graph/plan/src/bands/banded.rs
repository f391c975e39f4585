//! Some sizes of a plan in bands: what each pass does there, and which rows it makes and reads.

use std::collections::BTreeMap;
use std::ops::Range;

use afterimage_graph::node::{Arg, ImageId, Origin, Pass, PassKind, Resource};
use afterimage_wgsl::{GlobalKind, SampleMode};

use super::banding::{BandedSize, Sweep};
use super::limits::BandLimits;
use super::reach::Reach;
use crate::codegen::rows_of_workgroup;
use crate::error::PlanError;
use crate::plan::{Plan, Stage};

/// The role of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It has whole images only.
    Whole,
    /// It makes bands, as often as they are needed.
    Band,
    /// It makes something whole from bands, each part once.
    Sweep,
}

/// A plan with some sizes in bands.
pub(super) struct BandedPlan<'a> {
    pub(super) plan: &'a Plan,
    pub(super) reach: &'a Reach,
    pub(super) limits: BandLimits,
    pub(super) sizes: Vec<[u32; 2]>,
    pub(super) images: Vec<Option<usize>>,
    /// The images in bands that each pass reads.
    pub(super) reads: Vec<Vec<usize>>,
    /// The same of those that it writes.
    pub(super) writes: Vec<Vec<usize>>,
    /// Rows of results that a workgroup of each pass makes, if it makes them in order.
    workgroup_rows: Vec<Option<u32>>,
    /// The images that a sampler filters.
    pub(super) filtered: &'a [bool],
    pub(super) roles: Vec<Role>,
    /// The sweep of each pass that is no part of bands alone; those that are whole run before it.
    pub(super) sweeps: Vec<u32>,
}

impl<'a> BandedPlan<'a> {
    pub(super) fn new(
        plan: &'a Plan,
        reach: &'a Reach,
        limits: BandLimits,
        filtered: &'a [bool],
        sizes: Vec<[u32; 2]>,
    ) -> Result<Self, PlanError> {
        let place = |image: usize| {
            let found = sizes.iter().position(|size| *size == plan.size_of(image));
            found.filter(|_| plan.can_be_banded(image) && (limits.filters || !filtered[image]))
        };
        let images: Vec<Option<usize>> = (0..plan.images.len()).map(place).collect();
        let mut banded = Self {
            plan,
            reach,
            limits,
            sizes,
            images,
            reads: Vec::new(),
            writes: Vec::new(),
            workgroup_rows: plan.work().map(|pass| rows_of_workgroup(pass, &plan.images)).collect(),
            filtered,
            roles: Vec::new(),
            sweeps: Vec::new(),
        };
        for pass in 0..plan.passes.len() {
            banded.reads.push(banded.in_bands(plan.passes[pass].pass.reads()));
            banded.writes.push(banded.in_bands(plan.passes[pass].pass.writes()));
            banded.roles.push(banded.role(pass)?);
        }
        banded.order()?;
        Ok(banded)
    }

    pub(super) fn pass(&self, pass: usize) -> &'a Pass {
        &self.plan.passes[pass].pass
    }

    fn refusal(&self, pass: usize, why: &str) -> PlanError {
        PlanError::NoBands { node: self.pass(pass).nodes.join(" + "), why: why.to_owned() }
    }

    /// The images in bands among these resources.
    fn in_bands(&self, resources: Vec<Resource>) -> Vec<usize> {
        images(resources).filter(|image| self.images[*image].is_some()).collect()
    }

    fn is_banded(&self, resource: Resource) -> bool {
        resource.image().is_some_and(|image| self.images[image.0 as usize].is_some())
    }

    fn role(&self, index: usize) -> Result<Role, PlanError> {
        let pass = self.pass(index);
        let (reads_bands, bands) = (!self.reads[index].is_empty(), self.writes[index].len());
        let makes_in_order = pass.kind != PassKind::Compute;
        match (bands, reads_bands) {
            (0, false) if self.plan.passes[index].stage != Stage::Drawing => Ok(Role::Whole),
            _ if self.plan.passes[index].stage == Stage::Drawing => Err(self.refusal(index, "it draws geometry")),
            (0, _) => Ok(Role::Sweep),
            _ if !makes_in_order => Err(self.refusal(index, "its kernel makes the rows of an image in its own order")),
            (bands, _) if bands == pass.writes().len() => Ok(Role::Band),
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

    /// Returns whether a pass or the host reads it.
    fn is_read(&self, resource: Resource) -> bool {
        let is_output = self.plan.outputs.iter().any(|output| Resource::Image(output.image) == resource);
        is_output || self.plan.work().any(|pass| pass.reads().contains(&resource))
    }

    /// The outputs that a pass makes in bands.
    pub(super) fn outputs(&self, pass: usize) -> impl Iterator<Item = usize> + '_ {
        let outputs = self.plan.outputs.iter().enumerate();
        let made = outputs.filter(move |(_, output)| self.writes[pass].contains(&(output.image.0 as usize)));
        made.map(|(index, _)| index).filter(move |_| self.roles[pass] == Role::Band)
    }

    /// The passes that sweeps are for.
    pub(super) fn targets(&self) -> impl Iterator<Item = usize> + '_ {
        let passes = 0..self.roles.len();
        passes.filter(|pass| self.roles[*pass] == Role::Sweep || self.outputs(*pass).next().is_some())
    }

    pub(super) fn lives(&self, image: usize) -> bool {
        self.plan.images[image].lifetime.is_some()
    }

    pub(super) fn whole(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.images.len()).filter(|image| self.images[*image].is_none() && self.lives(*image))
    }

    pub(super) fn longest_whole(&self) -> u32 {
        let flat = self.whole().filter(|image| !self.plan.images[*image].desc.volume);
        flat.flat_map(|image| self.plan.size_of(image)).max().unwrap_or(0)
    }

    pub(super) fn is_filtered(&self, size: usize) -> bool {
        let banded = self.images.iter().enumerate().filter(|(_, own)| **own == Some(size));
        banded.map(|(image, _)| image).any(|image| self.filtered[image])
    }

    pub(super) fn steps(&self, pass: usize) -> u32 {
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

    /// The steps of these passes in a band.
    pub(super) fn wanted_of(&self, targets: &[usize], index: u32, count: u32) -> BTreeMap<usize, Range<u32>> {
        let own = |pass: &usize| {
            let all = self.wanted(*pass);
            let own = part(all.end - all.start, index, count);
            (*pass, all.start + own.start..all.start + own.end)
        };
        targets.iter().map(own).filter(|(_, steps)| !steps.is_empty()).collect()
    }

    /// Returns whether workgroups begin at the bottom of the image.
    fn is_upward(&self, pass: usize) -> bool {
        matches!(self.pass(pass).kind, PassKind::Point | PassKind::Gather)
    }

    /// The rows of an image that these steps of a pass from the top to the bottom make.
    pub(super) fn made(&self, pass: usize, image: usize, steps: &Range<u32>) -> Range<u32> {
        let (count, height) = (self.steps(pass), self.plan.size_of(image)[1]);
        let rows = self.workgroup_rows[pass].unwrap_or(height);
        let end = |step: u32| match self.is_upward(pass) {
            true => height.saturating_sub((count - step) * rows),
            false if step == count => height,
            false => height.min(step * rows),
        };
        end(steps.start)..end(steps.end)
    }

    /// The steps of a pass that make these rows of an image.
    pub(super) fn making(&self, pass: usize, image: usize, rows: &Range<u32>) -> Range<u32> {
        let (count, height) = (self.steps(pass), self.plan.size_of(image)[1]);
        let own = self.workgroup_rows[pass].unwrap_or(height);
        let step = |row: u32| match self.is_upward(pass) {
            true => count - 1 - (height - 1 - row) / own,
            false => (row / own).min(count - 1),
        };
        step(rows.start)..step(rows.end - 1) + 1
    }

    /// The rows of workgroups of these steps; and the steps of rows of workgroups.
    pub(super) fn groups_of(&self, pass: usize, steps: &Range<u32>) -> Range<u32> {
        let count = self.steps(pass);
        if self.is_upward(pass) { count - steps.end..count - steps.start } else { steps.clone() }
    }

    /// The rows of its first result that a pass makes in these steps, or the steps without any, and how many it has.
    pub(super) fn extent(&self, pass: usize, steps: &Range<u32>) -> (Range<u32>, u32) {
        match self.pass(pass).results.first().map(|result| result.image.0 as usize) {
            Some(result) => (self.made(pass, result, steps), self.plan.size_of(result)[1]),
            None => (steps.clone(), self.steps(pass)),
        }
    }

    /// The rows of an image that a pass reads for these steps.
    pub(super) fn read(&self, pass: usize, image: usize, steps: &Range<u32>) -> Range<u32> {
        let (made, of) = self.extent(pass, steps);
        let size = self.plan.size_of(image);
        let place = |row: u32, rounded: u32| {
            ((u64::from(row) * u64::from(size[1]) + u64::from(rounded)) / u64::from(of)) as u32
        };
        let [above, below] = self.reach.of(self.pass(pass), pass, size);
        place(made.start, 0).saturating_sub(above)..place(made.end, of - 1).saturating_add(below).min(size[1])
    }

    /// The textures of a size whose bands have that many rows at most.
    pub(super) fn textures(&self, size: usize, tallest: u32) -> BandedSize {
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

    /// The rows of the textures of all images in bands: of one that no pass reads, those that a band makes.
    pub(super) fn rows(&self, sizes: &[BandedSize], sweeps: &[Sweep]) -> Vec<u32> {
        let mut rows: Vec<u32> = self.images.iter().map(|size| size.map_or(0, |size| sizes[size].rows)).collect();
        for (image, rows) in rows.iter_mut().enumerate() {
            let Some(size) = self.images[image] else { continue };
            if self.reads.iter().any(|read| read.contains(&image)) {
                continue;
            }
            let ends = sweeps.iter().flat_map(|sweep| &sweep.bands).flat_map(|band| {
                let own = band.passes.iter().filter(|run| self.writes[run.pass].contains(&image));
                own.map(|run| {
                    let steps = self.groups_of(run.pass, &run.groups);
                    self.made(run.pass, image, &steps).end.saturating_sub(band.first[size])
                })
            });
            *rows = ends.max().unwrap_or(1).clamp(1, *rows);
        }
        rows
    }
}

impl Plan {
    pub(super) fn can_be_banded(&self, image: usize) -> bool {
        let planned = &self.images[image];
        let desc = planned.desc;
        let is_plain = desc.samples == 1 && desc.levels == 1 && desc.layers == 1 && !desc.volume;
        let is_table = matches!(planned.origin, Origin::Constant(_)) || self.is_written_on_change(image);
        is_plain && !is_table && !desc.format.is_depth() && planned.lifetime.is_some()
    }

    fn is_written_on_change(&self, image: usize) -> bool {
        let written = Resource::Image(ImageId(image as u32));
        (0..self.passes.len()).any(|at| self.runs_on_change(at) && self.passes[at].pass.writes().contains(&written))
    }

    pub(super) fn size_of(&self, image: usize) -> [u32; 2] {
        let size = self.images[image].desc.size;
        [size.width, size.height]
    }

    /// Returns whether a pass reads an image through a filtering sampler.
    pub(super) fn is_filtered(&self, image: usize) -> bool {
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

pub(super) fn images(resources: Vec<Resource>) -> impl Iterator<Item = usize> {
    resources.into_iter().filter_map(Resource::image).map(|image| image.0 as usize)
}

/// The range that holds both.
pub(super) fn joined(one: Option<Range<u32>>, other: Range<u32>) -> Range<u32> {
    one.map_or(other.clone(), |one| one.start.min(other.start)..one.end.max(other.end))
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
