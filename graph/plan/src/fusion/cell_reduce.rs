//! Kernels that reduce one image by cells, and wait for the same passes, read it together: a pixel is read once for all
//! of them, and a dispatch is saved.

use std::collections::BTreeSet;

use super::pass_graph::PassGraph;
use crate::builder::PlanBuilder;
use crate::plan::SharedRead;
use afterimage_base::caps::Caps;
use afterimage_base::image::Size;
use afterimage_graph::node::{Arg, ByCells, CellReduce, ImageId, KernelCall, Pass, PassKind, Recording, Resource};

/// Cells of the finest lattice that a workgroup makes at most: with more, each has too few invocations to read rows of
/// pixels.
const MAX_CELLS: u32 = 64;
/// Readers of an image that are tried as members of one group; more only cost planning time.
const MAX_CANDIDATES: usize = 64;

pub(super) fn join_cell_reductions(builder: &mut PlanBuilder, caps: &Caps) {
    let mut graph = PassGraph::new(builder);
    if caps.workgroup_invocations >= CellReduce::MAX_INVOCATIONS {
        for first in 0..graph.len() {
            let group = Group::around(&graph, &builder.recording, caps, first).filter(|group| group.members.len() > 1);
            builder.shared_reads.extend(group.map(|group| join(&mut graph, &builder.recording, group)));
        }
    }
    graph.finish(builder);
}

/// A compute kernel that has a form by cells, with the image that it reduces.
fn reducer<'a>(
    graph: &'a PassGraph,
    recording: &Recording,
    number: usize,
) -> Option<(ByCells, &'a KernelCall, ImageId)> {
    let [kernel] = graph.get(number)?.kernels.as_slice() else { return None };
    if graph.is_pinned(number) {
        return None;
    }
    let by = kernel.by_cells?;
    let Some(Arg::Texture(source)) = kernel.arg(by.source) else { return None };
    let writes_images = kernel.args.iter().all(|arg| !matches!(arg.value, Arg::Buffer(_, true)));
    let is_flat = !recording.image(source).desc.volume;
    let is_cached = kernel.args.iter().filter_map(|arg| arg.value.written()?.image()).any(|it| recording.is_cached(it));
    (is_flat && writes_images && !is_cached && kernel.constants.is_empty()).then_some((by, kernel, source))
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
    fn around(graph: &PassGraph, recording: &Recording, caps: &Caps, first: usize) -> Option<Self> {
        let (by, kernel, source) = reducer(graph, recording, first)?;
        let (before, results) = (graph.before(first), results(kernel));
        let mut group = Self { source, members: vec![first], forms: vec![by], before, results };
        for number in graph.readers_after(Resource::Image(source), first).take(MAX_CANDIDATES) {
            group.take_in(graph, recording, caps, number);
        }
        Some(group)
    }

    fn take_in(&mut self, graph: &PassGraph, recording: &Recording, caps: &Caps, number: usize) {
        let Some((by, kernel, source)) = reducer(graph, recording, number) else { return };
        let results = self.results + results(kernel);
        let mut forms = self.forms.clone();
        forms.push(by);
        let is_same = source == self.source && by.stride == self.forms[0].stride;
        let fits = is_same && results <= caps.max_storage_images as usize;
        // Passes that wait for the same do not wait for each other.
        let waits_alike = self.before == graph.before(number) && !self.is_disturbed(graph, number);
        if fits && waits_alike && lattices(&forms).is_some() {
            (self.forms, self.results) = (forms, results);
            self.members.push(number);
        }
    }

    /// Whether a pass between the first member and a later one writes, in place, a buffer that one of them reads.
    fn is_disturbed(&self, graph: &PassGraph, later: usize) -> bool {
        let first = self.members[0];
        let members = self.members.iter().chain([&later]).filter_map(|number| graph.get(*number));
        let mut buffers = members.flat_map(Pass::reads).filter(|read| matches!(read, Resource::Buffer(_)));
        buffers.any(|buffer| graph.writers(buffer).any(|writer| first < writer && writer < later))
    }
}

fn results(kernel: &KernelCall) -> usize {
    kernel.args.iter().filter(|arg| arg.value.written().is_some()).count()
}

/// The coarsest and the finest lattice of kernels that one workgroup can serve.
fn lattices(forms: &[ByCells]) -> Option<([u32; 2], [u32; 2])> {
    let sides = |axis: usize| forms.iter().map(move |by| by.cells[axis]);
    let coarsest = [0, 1].map(|axis| sides(axis).min().unwrap_or(1));
    let finest = [0, 1].map(|axis| sides(axis).max().unwrap_or(1));
    let divide = |fine: [u32; 2], coarse: [u32; 2]| (0..2).all(|axis| fine[axis].is_multiple_of(coarse[axis]));
    let inside = |fine: [u32; 2]| fine[0] / coarsest[0] * (fine[1] / coarsest[1]);
    let suits =
        |by: &ByCells| divide(finest, by.cells) && divide(by.cells, coarsest) && inside(by.cells) <= by.together;
    let cells = inside(finest);
    let fits = forms.iter().all(suits) && cells <= MAX_CELLS && CellReduce::MAX_INVOCATIONS.is_multiple_of(cells);
    fits.then_some((coarsest, finest))
}

/// Pixels under a workgroup's cells from which on it has as many invocations as it can have. With fewer pixels, half as
/// many read more of them each: on an H200, at 1080p, 0.0128 ms instead of 0.0150 for the grid and the wide mean of
/// `tsushima.ron`.
const MANY_PIXELS: u64 = 2048;

/// A cell's invocations, across and down: as many across as it has columns, so that few have nothing to do.
fn invocations(size: Size, coarsest: [u32; 2], finest: [u32; 2]) -> [u32; 2] {
    let cells = u64::from(coarsest[0]) * u64::from(coarsest[1]);
    let is_small = size.texels() < MANY_PIXELS * cells;
    let workgroup = if is_small { CellReduce::MAX_INVOCATIONS / 2 } else { CellReduce::MAX_INVOCATIONS };
    let own = workgroup / (finest[0] / coarsest[0] * (finest[1] / coarsest[1]));
    let [width, cells] = [size.width, finest[0]].map(u64::from);
    let columns = (0..cells).map(|cell| ((cell + 1) * width).div_ceil(cells) - cell * width / cells).max();
    let across = columns.unwrap_or(1).next_power_of_two().min(u64::from(own)) as u32;
    [across, own / across]
}

fn join(graph: &mut PassGraph, recording: &Recording, group: Group) -> SharedRead {
    let image = recording.image(group.source);
    let (coarsest, finest) = lattices(&group.forms).expect("a group's lattices were tried");
    let (mut kernels, mut nodes, mut labels) = (Vec::new(), Vec::new(), Vec::new());
    for number in &group.members {
        let pass = graph.take(*number).expect("a member was found");
        let groups = Some([coarsest[0], coarsest[1], 1]);
        kernels.extend(pass.kernels.into_iter().map(|kernel| KernelCall { workgroups: groups, ..kernel }));
        nodes.extend(pass.nodes);
        labels.push(pass.label);
    }
    nodes.dedup();
    let again = kernels.len() as u64 - 1;
    let stride = group.forms[0].stride;
    let invocations = invocations(image.desc.size.div_up(stride), coarsest, finest);
    let kind = PassKind::CellReduce(CellReduce { coarsest, finest, invocations, stride });
    let last = *group.members.last().expect("a group has members");
    let label = labels.join(" & ");
    graph.put(last, Pass { nodes: nodes.clone(), label, kernels, results: Vec::new(), kind });
    SharedRead { image: image.label.clone(), nodes, bytes_saved: again * image.desc.bytes() }
}
