//! A halving that has a form by rows takes it, and makes the texels of its source itself where no other pass reads
//! them.
//!
//! On an H200 at 4K, extracting and halving take 0.039 ms so, and 0.123 ms in two passes of which the second filters
//! thirteen times a texel.

use super::pass_graph::PassGraph;
use crate::builder::{PlanBuilder, copy_kernel};
use crate::plan::Fused;
use afterimage_graph::node::{
    Arg, ByRows, ImageId, KernelCall, Origin, Pass, PassKind, PassResult, Recording, Resource, RowDownsample,
};

/// Results with fewer texels leave most of the device idle, and are filtered by its texture units.
const MIN_TEXELS: u64 = 100_000;

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

pub(super) fn downsample_by_rows(builder: &mut PlanBuilder, always: bool) {
    let mut graph = PassGraph::new(builder);
    for number in 0..graph.len() {
        let Some(halving) = Halving::find(&graph, &builder.recording, number, always) else { continue };
        let maker = maker(&graph, &builder.recording, number, halving.source);
        if always || maker.is_some() || halving.by.reach >= WIDE {
            builder.fused.extend(halving.replace(&mut graph, &builder.recording, maker));
        }
    }
    graph.finish(builder);
}

/// A pass that halves an image and has a form by rows.
struct Halving {
    number: usize,
    source: ImageId,
    result: ImageId,
    by: ByRows,
}

impl Halving {
    /// The halving of that number, if it can and should be done by rows.
    fn find(graph: &PassGraph, recording: &Recording, number: usize, always: bool) -> Option<Self> {
        let (pass, result) = graph.function_pass(number)?;
        let [kernel] = pass.kernels.as_slice() else { return None };
        let by = kernel.by_rows.filter(|_| !graph.is_output(result))?;
        let source = kernel.textures().next()?;
        let (from, to) = (recording.image(source).desc, recording.image(result).desc);
        let is_exact_half = from.size.width == 2 * to.size.width && from.size.height == 2 * to.size.height;
        // Neighbors share texels as half floats.
        let is_half_float = !from.format.is_32_bit() && !to.format.is_32_bit();
        let is_large = always || to.size.texels() >= MIN_TEXELS;
        (is_exact_half && is_half_float && is_large).then_some(Self { number, source, result, by })
    }

    /// Puts the pass by rows in the place of the halving and of the pass that makes its source, if that one is given.
    fn replace(self, graph: &mut PassGraph, recording: &Recording, maker: Option<usize>) -> Option<Fused> {
        let maker = maker.and_then(|maker| graph.take(maker));
        let is_fused = maker.is_some();
        let halving = graph.take(self.number).expect("a halving was found");
        let node = halving.kernels[0].node.clone();
        let (mut nodes, label, mut kernels) = match maker {
            Some(Pass { nodes, label, kernels, .. }) => (nodes, format!("{label} > {}", halving.label), kernels),
            None => (Vec::new(), halving.label, vec![copy_kernel(&node, self.source)]),
        };
        nodes.extend(halving.nodes);
        nodes.dedup();
        kernels.push(row_kernel(nodes.last().unwrap_or(&node), self.by));
        let rows = rows_of(recording.image(self.result).desc.size.texels());
        graph.put(self.number, row_pass(nodes.clone(), label, kernels, self.result, self.by, rows));
        let image = recording.image(self.source);
        is_fused.then(|| Fused { image: image.label.clone(), nodes, bytes_saved: 2 * image.desc.bytes() })
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
    by: ByRows,
    rows: u32,
) -> Pass {
    let results = vec![PassResult { kernel: kernels.len() - 1, image }];
    let kind = PassKind::RowDownsample(RowDownsample { state: by.state, rows });
    Pass { nodes, label, kernels, results, kind }
}

/// The pass that makes the source, if it reads single pixels and makes them for this halving alone.
fn maker(graph: &PassGraph, recording: &Recording, number: usize, source: ImageId) -> Option<usize> {
    let is_ours = recording.image(source).origin == Origin::Transient && !graph.is_kept(source);
    let is_alone = graph.readers(Resource::Image(source)).all(|reader| reader == number);
    if !is_ours || !is_alone {
        return None;
    }
    let mut writers = graph.writers(Resource::Image(source));
    writers.find(|writer| graph.get(*writer).is_some_and(|pass| pass.kind == PassKind::Point))
}
