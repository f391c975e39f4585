//! A band in parts.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use afterimage_graph::node::{ImageId, Origin};

use super::banded::{BandedPlan, Role, joined};
use super::banding::{Band, BandPass};
use super::limits::Parts;

/// The passes of a band or of a part of it.
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

/// A band or a part of it.
pub(super) struct BandPart {
    pub(super) band: Band,
    /// For each size, the rows that its textures have.
    pub(super) rows: Vec<Range<u32>>,
}

/// The bands of a plan in parts.
pub(super) struct BandParts<'a> {
    pub(super) banded: &'a BandedPlan<'a>,
    pub(super) parts: Parts,
}

impl BandParts<'_> {
    /// The parts of the band of a sweep that is for these steps.
    pub(super) fn of(&self, wanted: BTreeMap<usize, Range<u32>>) -> Vec<BandPart> {
        let whole = self.running(wanted, |_| true);
        let mut parts = Vec::new();
        for group in self.groups(&whole) {
            let steps_of_parts =
                if group.has_largest { self.slices(&group, &whole) } else { vec![whole.steps_of(&group)] };
            for steps in steps_of_parts {
                let part = self.running(steps, |image| self.is_largest(image));
                parts.push(self.part(&part, &whole, parts.is_empty()));
            }
        }
        parts
    }

    /// The steps of all passes for those that are wanted, as far as images that may be made are needed.
    fn running(&self, wanted: BTreeMap<usize, Range<u32>>, may_make: impl Fn(usize) -> bool) -> Running {
        let mut known: Vec<Option<Range<u32>>> = vec![None; self.banded.images.len()];
        let mut running = BTreeMap::new();
        for pass in (0..self.banded.roles.len()).rev() {
            let mut steps = wanted.get(&pass).cloned();
            if self.banded.roles[pass] == Role::Band {
                for image in self.banded.writes[pass].iter().copied().filter(|image| may_make(*image)) {
                    if let Some(rows) = &known[image] {
                        steps = Some(joined(steps, self.banded.making(pass, image, rows)));
                    }
                }
            }
            let Some(steps) = steps else { continue };
            for &image in &self.banded.reads[pass] {
                known[image] = Some(joined(known[image].take(), self.banded.read(pass, image, &steps)));
            }
            running.insert(pass, steps);
        }
        for (pass, steps) in &running {
            for &image in &self.banded.writes[*pass] {
                known[image] = Some(self.banded.made(*pass, image, steps));
            }
        }
        Running { wanted, steps: running, known }
    }

    /// Returns whether an image is in bands and has one of the largest sizes.
    fn is_largest(&self, image: usize) -> bool {
        self.banded.images[image].is_some_and(|size| size < self.parts.sizes)
    }

    /// The passes of a band in the order of its parts. Those that make largest images for others run in the parts of
    /// these.
    fn groups(&self, whole: &Running) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for pass in whole.steps.keys() {
            let (reads, writes) = (&self.banded.reads[*pass], &self.banded.writes[*pass]);
            let has_largest = reads.iter().chain(writes).any(|image| self.is_largest(*image));
            let is_for_others =
                self.banded.roles[*pass] == Role::Band && writes.iter().all(|image| self.is_largest(*image));
            if has_largest && is_for_others && !whole.wanted.contains_key(pass) {
                continue;
            }
            let sources = self.sources(*pass);
            let place = groups.iter().rposition(|group| group.has_largest == has_largest);
            // Parts of a group run one after another, with all of its passes in each.
            let since = place.map_or(0, |place| place + usize::from(!has_largest));
            let before = groups[since..].iter().flat_map(|group| &group.passes);
            let mut written = before.flat_map(|pass| &self.banded.writes[*pass]);
            let depends = written.any(|image| sources.contains(image));
            match place.filter(|_| !depends) {
                Some(place) => groups[place].passes.push(*pass),
                None => groups.push(Group { passes: vec![*pass], has_largest }),
            }
        }
        groups
    }

    /// The smaller images in bands that a pass reads, also through the largest ones that are made for it.
    fn sources(&self, pass: usize) -> BTreeSet<usize> {
        let mut sources = BTreeSet::new();
        let mut seen = BTreeSet::from([pass]);
        let mut passes = vec![pass];
        while let Some(pass) = passes.pop() {
            for &image in &self.banded.reads[pass] {
                if !self.is_largest(image) {
                    sources.insert(image);
                    continue;
                }
                let makers = (0..self.banded.roles.len()).filter(|maker| self.banded.writes[*maker].contains(&image));
                passes.extend(makers.filter(|maker| seen.insert(*maker)));
            }
        }
        sources
    }

    /// The steps of the passes of a group, for each part.
    fn slices(&self, group: &Group, whole: &Running) -> Vec<BTreeMap<usize, Range<u32>>> {
        let height = u64::from(self.banded.sizes[0][1]);
        let place = |pass: usize, step: u32| {
            let (made, of) = self.banded.extent(pass, &(step..step + 1));
            (u64::from(made.start) * height / u64::from(of)) as u32
        };
        let all = || group.passes.iter().flat_map(|pass| whole.steps[pass].clone().map(|step| (*pass, step)));
        let first = all().map(|(pass, step)| place(pass, step)).min().unwrap_or(0);
        let mut slices: BTreeMap<u32, BTreeMap<usize, Range<u32>>> = BTreeMap::new();
        for (pass, step) in all() {
            let slice = slices.entry((place(pass, step) - first) / self.parts.rows).or_default();
            let steps = joined(slice.remove(&pass), step..step + 1);
            slice.insert(pass, steps);
        }
        slices.into_values().collect()
    }

    /// The passes of a part. Images without one of the largest sizes have the rows of the whole band.
    fn part(&self, part: &Running, whole: &Running, is_first: bool) -> BandPart {
        let mut band = Band::default();
        for (pass, steps) in &part.wanted {
            let own = whole.wanted.get(pass).map(|own| own.start.max(steps.start)..own.end.min(steps.end));
            let Some(own) = own.filter(|own| !own.is_empty()) else { continue };
            for output in self.banded.outputs(*pass) {
                let made = self.banded.made(*pass, self.banded.plan.outputs[output].image.0 as usize, &own);
                let [first, end] = self.banded.limits.rows.unwrap_or([0, u32::MAX]);
                let start = made.start.max(first);
                // Rows that are wanted of below the picture are none.
                band.outputs.push((output, start.min(made.end)..made.end.min(end)));
            }
        }
        let mut known = part.known.clone();
        let mut covered: Vec<Option<Range<u32>>> = vec![None; self.banded.sizes.len()];
        for (image, rows) in known.iter_mut().enumerate() {
            let Some(size) = self.banded.images[image] else { continue };
            if !self.is_largest(image) {
                rows.clone_from(&whole.known[image]);
            }
            let Some(own) = rows.clone() else { continue };
            match &self.banded.plan.images[image].origin {
                Origin::Input(_) if is_first || self.is_largest(image) => {
                    band.inputs.push((ImageId(image as u32), own.clone()))
                }
                // It is black everywhere.
                Origin::Previous { .. } => {
                    *rows = Some(0..self.banded.sizes[size][1]);
                    continue;
                }
                _ => {}
            }
            covered[size] = Some(joined(covered[size].take(), own));
        }
        for (pass, steps) in &part.steps {
            let mut rows: Vec<Range<u32>> = self.banded.sizes.iter().map(|[_, height]| 0..*height).collect();
            for &image in &self.banded.reads[*pass] {
                let own = known[image].clone().expect("what a pass reads is needed");
                let all = &mut rows[self.banded.images[image].expect("it is banded")];
                *all = all.start.max(own.start)..all.end.min(own.end);
            }
            let result = self.banded.pass(*pass).results.first().map(|result| result.image.0 as usize);
            let made = result.map_or(0..0, |image| self.banded.made(*pass, image, steps));
            band.passes.push(BandPass {
                pass: *pass,
                groups: self.banded.groups_of(*pass, steps),
                rows: made,
                known: rows,
            });
        }
        BandPart { band, rows: covered.into_iter().map(Option::unwrap_or_default).collect() }
    }
}
