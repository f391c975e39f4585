//! Step 4c: kernels that sum up one image by cells, and wait for the same passes, read it together.
//!
//! A pixel travels once for all of them, and a dispatch is saved.

use std::collections::BTreeSet;

use crate::codegen::CELLS_LANES;
use crate::pass_graph::PassGraph;
use crate::{Caps, PlanBuilder};
use afterimage_base::image::Size;
use afterimage_graph::node::{ByCells, Cells, CellsReader, EntryCall, ImageId, Pass, Recording, Resource, Work};

/// An image that several kernels read together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedRead {
    /// The image, as `node.port`.
    pub image: String,
    /// The nodes of the pass that reads it.
    pub nodes: Vec<String>,
    /// Bytes that are not read again, in one frame.
    pub bytes_saved: u64,
}

/// Cells of the finest lattice that a workgroup makes at most: with more, the invocations of each are too few to read rows of pixels.
const MOST_CELLS: u32 = 64;

pub(crate) fn cells(draft: &mut PlanBuilder, caps: &Caps) -> Vec<SharedRead> {
    let mut web = PassGraph::new(draft);
    let mut shared_reads = Vec::new();
    if caps.workgroup_invocations >= CELLS_LANES {
        for first in 0..web.len() {
            let group = Group::around(&web, &draft.recording, caps, first).filter(|group| group.members.len() > 1);
            shared_reads.extend(group.map(|group| join(&mut web, &draft.recording, group)));
        }
    }
    web.finish(draft);
    shared_reads
}

/// A whole kernel that has a form by cells, with the image that it sums up.
fn reader<'a>(web: &'a PassGraph, recording: &Recording, number: usize) -> Option<(ByCells, &'a EntryCall, ImageId)> {
    let Work::Entry(call) = &web.get(number)?.work else { return None };
    let by = call.by_cells?;
    let source = call.bindings.iter().find_map(|binding| match binding.resource {
        Resource::Image(image) if binding.name == by.source => Some(image),
        _ => None,
    })?;
    let writes_images = call.bindings.iter().filter(|b| b.writes).all(|b| matches!(b.resource, Resource::Image(_)));
    let is_flat = !recording.image(source).desc.volume;
    (is_flat && writes_images && call.constants.is_empty()).then_some((by, call, source))
}

/// Passes that can be one.
struct Group {
    source: ImageId,
    members: Vec<usize>,
    forms: Vec<ByCells>,
    /// What all of them wait for.
    before: BTreeSet<usize>,
    results: usize,
}

impl Group {
    /// The largest group that begins with a pass.
    fn around(web: &PassGraph, recording: &Recording, caps: &Caps, first: usize) -> Option<Self> {
        let (by, call, source) = reader(web, recording, first)?;
        let mut group =
            Self { source, members: vec![first], forms: vec![by], before: web.before(first), results: results(call) };
        for number in web.readers(Resource::Image(source)).filter(|number| *number > first) {
            group.take_in(web, recording, caps, number);
        }
        Some(group)
    }

    fn take_in(&mut self, web: &PassGraph, recording: &Recording, caps: &Caps, number: usize) {
        let Some((by, call, source)) = reader(web, recording, number) else { return };
        let results = self.results + results(call);
        let mut forms = self.forms.clone();
        forms.push(by);
        let is_same = source == self.source && by.step == self.forms[0].step;
        let fits = is_same && results <= caps.max_storage_images as usize;
        // Passes that wait for the same do not wait for each other.
        let waits_alike = self.before == web.before(number) && !self.is_disturbed(web, number);
        if fits && waits_alike && lattices(&forms).is_some() {
            (self.forms, self.results) = (forms, results);
            self.members.push(number);
        }
    }

    /// Whether a pass between the first member and a later one writes, in place, a buffer that one of them reads.
    fn is_disturbed(&self, web: &PassGraph, later: usize) -> bool {
        let first = self.members[0];
        let members = self.members.iter().chain([&later]).filter_map(|number| web.get(*number));
        let mut buffers = members.flat_map(Pass::reads).filter(|read| matches!(read, Resource::Buffer(_)));
        buffers.any(|buffer| web.writers(buffer).any(|writer| first < writer && writer < later))
    }
}

fn results(call: &EntryCall) -> usize {
    call.bindings.iter().filter(|binding| binding.writes).count()
}

/// The coarsest and the finest lattice of readers that one workgroup can serve.
fn lattices(forms: &[ByCells]) -> Option<([u32; 2], [u32; 2])> {
    let sides = |axis: usize| forms.iter().map(move |by| by.cells[axis]);
    let coarsest = [0, 1].map(|axis| sides(axis).min().unwrap_or(1));
    let finest = [0, 1].map(|axis| sides(axis).max().unwrap_or(1));
    let divide = |fine: [u32; 2], coarse: [u32; 2]| (0..2).all(|axis| fine[axis].is_multiple_of(coarse[axis]));
    let inside = |fine: [u32; 2]| fine[0] / coarsest[0] * (fine[1] / coarsest[1]);
    let suits =
        |by: &ByCells| divide(finest, by.cells) && divide(by.cells, coarsest) && inside(by.cells) <= by.together;
    let fits = forms.iter().all(suits) && inside(finest) <= MOST_CELLS && CELLS_LANES.is_multiple_of(inside(finest));
    fits.then_some((coarsest, finest))
}

/// Pixels under a workgroup's cells from which on it has all the invocations that it can have. With fewer pixels, half as many meet
/// more of them each: on an H200, at 1080p, 0.0128 ms instead of 0.0150 for the grid and the wide mean of `tsushima.ron`.
const MANY_PIXELS: u64 = 2048;

/// A cell's invocations, across and down: as many across as it has columns, so that few have nothing to do.
fn lanes(size: Size, coarsest: [u32; 2], finest: [u32; 2]) -> [u32; 2] {
    let cells = u64::from(coarsest[0]) * u64::from(coarsest[1]);
    let workgroup = if size.texels() < MANY_PIXELS * cells { CELLS_LANES / 2 } else { CELLS_LANES };
    let lanes = workgroup / (finest[0] / coarsest[0] * (finest[1] / coarsest[1]));
    let [width, cells] = [size.width, finest[0]].map(u64::from);
    let columns = (0..cells).map(|cell| ((cell + 1) * width).div_ceil(cells) - cell * width / cells).max();
    let across = columns.unwrap_or(1).next_power_of_two().min(u64::from(lanes)) as u32;
    [across, lanes / across]
}

fn join(web: &mut PassGraph, recording: &Recording, group: Group) -> SharedRead {
    let image = recording.image(group.source);
    let (coarsest, finest) = lattices(&group.forms).expect("a group's lattices were tried");
    let (mut readers, mut nodes, mut labels) = (Vec::new(), Vec::new(), Vec::new());
    for (number, by) in group.members.iter().zip(&group.forms) {
        let pass = web.take(*number).expect("a reader was found");
        let Work::Entry(call) = pass.work else { unreachable!("readers by cells are whole kernels") };
        let node = pass.nodes.first().cloned().unwrap_or_default();
        readers.push(CellsReader { node, call, by: *by });
        nodes.extend(pass.nodes);
        labels.push(pass.label);
    }
    nodes.dedup();
    let again = readers.len() as u64 - 1;
    let step = group.forms[0].step;
    let lanes = lanes(image.desc.size.div_up(step), coarsest, finest);
    let work = Work::Cells(Cells { source: group.source, readers, coarsest, finest, lanes, step });
    let last = *group.members.last().expect("a group has members");
    web.put(last, Pass { nodes: nodes.clone(), label: labels.join(" & "), work });
    SharedRead { image: image.label.clone(), nodes, bytes_saved: again * image.desc.bytes() }
}
