//! A halving that has a form by rows takes it, and makes the texels of its source itself where no other pass reads
//! them.
//!
//! Passes that look at the [neighbors](super::neighbors) of a pixel are taken over, too.
//!
//! On an H200 at 4K, extracting and halving take 0.039 ms so, and 0.123 ms in two passes of which the second filters
//! thirteen times a texel.

use super::neighbors::Neighbors;
use super::pass_graph::PassGraph;
use crate::builder::{PlanBuilder, copy_kernel};
use crate::plan::{Fused, SharedRead};
use afterimage_base::caps::Caps;
use afterimage_graph::node::{
    Arg, ByRows, ImageId, KernelCall, Origin, Pass, PassKind, PassResult, Recording, Resource, RowDownsample,
};

/// Results with fewer texels leave most of the device idle, and are filtered by its texture units.
const MIN_TEXELS: u64 = 100_000;

/// The same of halvings whose source is stored: on an H200, the texture units take 11.4 us for 480x270 texels, and rows
/// 12.5 us.
const MIN_TEXELS_OF_STORED: u64 = 300_000;

/// Filters that reach less far take so few taps that they gain nothing, unless their source need not be stored.
const WIDE: f32 = 2.0;

/// Rows of the result that a workgroup walks down. With more rows fewer texels are made twice; with fewer rows more
/// workgroups share a small result.
fn rows_of(texels: u64) -> u32 {
    match texels {
        0..300_000 => 4,
        300_000..1_000_000 => 8,
        _ => 16,
    }
}

/// Selection of the halvings that run by rows.
#[derive(Clone, Copy)]
pub(super) struct RowDownsampling {
    /// All that have a form for it, and not only those that gain by it.
    pub(super) always: bool,
}

impl RowDownsampling {
    /// Returns whether the pass is a halving that runs by rows, whatever writes its source.
    pub(super) fn takes(self, graph: &PassGraph, recording: &Recording, number: usize) -> bool {
        let halving = Halving::find(graph, recording, number, self.always);
        halving.is_some_and(|halving| self.always || halving.by.reach >= WIDE)
    }

    /// Halves by rows; whether a pass makes an image again that is still stored for others, which read only its pixels.
    pub(super) fn replace_halvings(self, builder: &mut PlanBuilder, caps: &Caps) -> bool {
        let mut graph = PassGraph::new(builder);
        let mut makes_again = false;
        for number in 0..graph.len() {
            let Some(halving) = Halving::find(&graph, &builder.recording, number, self.always) else { continue };
            let maker = Maker::find(&graph, &builder.recording, caps, &halving);
            if self.always || maker.is_some() || halving.gains(&builder.recording) {
                makes_again |= halving.replace(&mut graph, builder, maker);
            }
        }
        graph.finish(builder);
        makes_again
    }
}

/// A pass that halves an image and has a form by rows.
pub(super) struct Halving {
    number: usize,
    source: ImageId,
    result: ImageId,
    by: ByRows,
    /// See [`RowDownsample::odd`].
    odd: [u32; 2],
}

impl Halving {
    /// The halving of that number, if it can and should be done by rows.
    fn find(graph: &PassGraph, recording: &Recording, number: usize, always: bool) -> Option<Self> {
        let (pass, result) = graph.function_pass(number)?;
        let [kernel] = pass.kernels.as_slice() else { return None };
        let by = kernel.by_rows.filter(|_| !graph.is_output(result))?;
        let source = kernel.textures().next()?;
        let (from, to) = (recording.image(source).desc, recording.image(result).desc);
        let odd = [(from.size.width, to.size.width), (from.size.height, to.size.height)]
            .map(|(from, to)| from.checked_sub(2 * to).unwrap_or(u32::MAX));
        // A side of one texel stays one.
        let is_half = odd.iter().all(|texels| *texels <= 1);
        // Neighbors share texels as half floats.
        let is_half_float = !from.format.is_32_bit() && !to.format.is_32_bit();
        let is_large = always || to.size.texels() >= MIN_TEXELS;
        (is_half && is_half_float && is_large).then_some(Self { number, source, result, by, odd })
    }

    /// Returns whether rows take less time than texture units where the source is stored.
    fn gains(&self, recording: &Recording) -> bool {
        self.by.reach >= WIDE && recording.image(self.result).desc.size.texels() >= MIN_TEXELS_OF_STORED
    }

    /// Puts the pass by rows in the place of the halving and of the pass that makes its source, if that one is given.
    /// Whether it makes an image again that is still stored.
    fn replace(self, graph: &mut PassGraph, builder: &mut PlanBuilder, maker: Option<Maker>) -> bool {
        let PlanBuilder { recording, savings, .. } = builder;
        let made = maker.as_ref().and_then(|maker| graph.take(maker.number));
        let neighbors = maker.and_then(|maker| maker.neighbors);
        let is_fused = made.is_some();
        let halving = graph.take(self.number).expect("a halving was found");
        let node = halving.kernels[0].node.clone();
        let (mut nodes, label, mut kernels) = match made {
            Some(Pass { nodes, label, kernels, .. }) => (nodes, format!("{label} > {}", halving.label), kernels),
            None => (Vec::new(), halving.label, vec![copy_kernel(&node, self.source)]),
        };
        let mut around = None;
        if let Some(neighbors) = &neighbors {
            (kernels, around) = neighbors.kernels(kernels);
        }
        nodes.extend(halving.nodes);
        nodes.dedup();
        kernels.push(row_kernel(nodes.last().unwrap_or(&node), self.by));
        let rows = rows_of(recording.image(self.result).desc.size.texels());
        let kind = RowDownsample { state: self.by.state, rows, odd: self.odd, around, is_open: self.by.is_open };
        let mut pass = row_pass(nodes, label, kernels, self.result, kind);
        if is_fused {
            savings.fused.push(Fused::new(recording.image(self.source), &pass.nodes));
        }
        let mut makes_again = false;
        if let Some(neighbors) = neighbors {
            let joined = neighbors.join_squares(graph, &mut pass);
            if joined > 0 {
                let image = recording.image(neighbors.source);
                let (nodes, bytes_saved) = (pass.nodes.clone(), joined * image.desc.bytes());
                savings.shared_reads.push(SharedRead { image: image.label.clone(), nodes, bytes_saved });
            }
            makes_again = neighbors.is_still_stored(graph);
            if neighbors.take_maker(graph) {
                savings.fused.push(Fused::new(recording.image(neighbors.source), &pass.nodes));
            }
        }
        graph.put(self.number, pass);
        makes_again
    }
}

/// The kernel that makes a texel of the result from four of the source.
pub(crate) fn row_kernel(node: &str, by: ByRows) -> KernelCall {
    KernelCall::function(node, by.shader, by.function, &[("square", Arg::Square)])
}

/// A pass by rows: kernels that make a texel of the source, and the one that makes a texel of the result.
pub(crate) fn row_pass(
    nodes: Vec<String>,
    label: String,
    kernels: Vec<KernelCall>,
    image: ImageId,
    rows: RowDownsample,
) -> Pass {
    let results = vec![PassResult { kernel: kernels.len() - 1, image }];
    Pass { nodes, label, kernels, results, kind: PassKind::RowDownsample(rows) }
}

/// The pass that makes the source of a halving, and makes it for this halving alone.
struct Maker {
    number: usize,
    /// Its neighbor reads; `None` if it reads single pixels.
    neighbors: Option<Neighbors>,
}

impl Maker {
    /// The pass, if the halving can take it over.
    fn find(graph: &PassGraph, recording: &Recording, caps: &Caps, halving: &Halving) -> Option<Self> {
        let source = halving.source;
        let is_ours = recording.image(source).origin == Origin::Transient && !graph.is_kept(source);
        let is_alone = graph.readers(Resource::Image(source)).all(|reader| reader == halving.number);
        if !is_ours || !is_alone {
            return None;
        }
        let find = |number: usize| {
            let is_point = graph.get(number).is_some_and(|pass| pass.kind == PassKind::Point);
            let neighbors = Neighbors::find(graph, recording, caps, number, halving.number);
            (is_point || neighbors.is_some()).then_some(Self { number, neighbors })
        };
        graph.writers(Resource::Image(source)).find_map(find)
    }
}
