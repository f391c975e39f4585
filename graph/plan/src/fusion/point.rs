//! A kernel function whose result is read only as "this pixel" becomes part of its reader; the image between them is
//! never stored.
//!
//! A light function, which does little to one pixel, becomes part of each of several readers: to compute it again costs
//! less than to store it.

use super::module_limits::fit_one_module;
use super::pass_graph::{PassGraph, is_cheap};
use crate::builder::PlanBuilder;
use crate::plan::Fused;
use afterimage_base::caps::Caps;
use afterimage_graph::node::{Arg, Origin, Pass, Recording, Resource};

/// Resources that a pass reads, at most: small devices refuse more bindings.
const MAX_BINDINGS: usize = 12;
/// Readers into which a light pass is copied, at most.
const MAX_COPIES: usize = 4;
/// Kernels of one pass, at most: it keeps planning linear, and modules small enough for a device's compiler, whose time
/// grows with the square of their number.
const MAX_KERNELS: usize = 24;

/// Fuses until no pass can become part of its readers. A pass that changes puts those that make its images back on the
/// stack. `stays` selects passes that become part of none.
pub(super) fn fuse_points(
    builder: &mut PlanBuilder,
    caps: &Caps,
    stays: &dyn Fn(&PassGraph, &Recording, usize) -> bool,
) {
    let mut graph = PassGraph::new(builder);
    let mut pending: Vec<usize> = (0..graph.len()).rev().collect();
    while let Some(number) = pending.pop() {
        if stays(&graph, &builder.recording, number) {
            continue;
        }
        let readers = pixel_readers(&graph, &builder.recording, caps, number);
        let Some((last, others)) = readers.split_last() else { continue };
        let producer = graph.take(number).expect("a producer was found");
        // The last reader takes the pass itself: a long chain would otherwise be copied at every link.
        let copies: Vec<Pass> = others.iter().map(|_| producer.clone()).collect();
        for (reader, producer) in others.iter().zip(copies).chain([(last, producer)]) {
            builder.savings.fused.push(merge(&mut graph, &builder.recording, producer, *reader));
            // Two readers of one image may have become one, so the pass that makes it can perhaps be fused now.
            let reads = graph.get(*reader).map(Pass::reads).unwrap_or_default();
            pending.extend(reads.into_iter().flat_map(|resource| graph.writers(resource).collect::<Vec<_>>()));
        }
    }
    graph.finish(builder);
}

/// The passes that this one can become part of: all that read its result, or none.
fn pixel_readers(graph: &PassGraph, recording: &Recording, caps: &Caps, number: usize) -> Vec<usize> {
    let Some((pass, result)) = graph.function_pass(number) else { return Vec::new() };
    let image = recording.image(result);
    if image.origin != Origin::Transient || graph.is_kept(result) {
        return Vec::new();
    }
    // An image may have thousands of readers, and this is asked whenever one of them changes.
    let readers: Vec<usize> = graph.readers(Resource::Image(result)).take(MAX_COPIES + 1).collect();
    let can_absorb = |reader: &usize| {
        let Some((reader, _)) = graph.function_pass(*reader) else { return false };
        let reads_only_own_pixel =
            reader.args().all(|arg| arg == Arg::Pixel(result) || arg.read() != Some(Resource::Image(result)));
        // A pixel is of an image of the result's size: others are refused when they are recorded.
        reads_only_own_pixel
            && is_within_limits(pass, reader)
            && fit_one_module([pass, reader].into_iter(), recording, caps)
    };
    let is_worthwhile = readers.len() == 1 || readers.len() <= MAX_COPIES && is_cheap(pass);
    if is_worthwhile && readers.iter().all(can_absorb) { readers } else { Vec::new() }
}

fn is_within_limits(producer: &Pass, reader: &Pass) -> bool {
    let kernels = producer.kernels.len() + reader.kernels.len();
    kernels <= MAX_KERNELS && bindings(producer) + bindings(reader) <= MAX_BINDINGS
}

fn bindings(pass: &Pass) -> usize {
    pass.args().filter(|arg| arg.read().is_some()).count()
}

fn merge(graph: &mut PassGraph, recording: &Recording, producer: Pass, reader_number: usize) -> Fused {
    let intermediate = producer.function_result().expect("only passes of functions are fused");
    let reader = graph.take(reader_number).expect("a reader was found");
    let result = reader.function_result().expect("only passes of functions are fused");
    let Pass { mut nodes, label, mut kernels, .. } = producer;
    // The reader's kernels follow those of the producer, and take the result of its last one in place of the pixel.
    let (earlier, pixel) = (kernels.len(), Some(Arg::Pixel(intermediate)));
    kernels.extend(reader.kernels.into_iter().map(|kernel| kernel.moved(earlier, pixel, Arg::Kernel(earlier - 1))));
    nodes.extend(reader.nodes);
    nodes.dedup();
    let label = format!("{label} + {}", reader.label);
    graph.put(reader_number, Pass::of_functions(nodes.clone(), label, kernels, result));
    let image = recording.image(intermediate);
    Fused { image: image.label.clone(), nodes, bytes_saved: 2 * image.desc.bytes() }
}
