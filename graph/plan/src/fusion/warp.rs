//! A warp that only another warp reads becomes part of it: its functions are called at the places that the other one
//! computes, so the image between them is neither stored nor filtered.

use super::module_limits::fit_one_module;
use super::pass_graph::PassGraph;
use crate::builder::PlanBuilder;
use crate::plan::Fused;
use afterimage_base::caps::Caps;
use afterimage_graph::node::{Arg, KernelCall, Origin, Pass, Recording, Resource, WarpPart};

/// Reads of the image before all warps, at most: more cost more than to store the image between two of them.
const MAX_TAPS: usize = 4;

pub(super) fn fuse_warps(builder: &mut PlanBuilder, caps: &Caps) {
    let mut graph = PassGraph::new(builder);
    for number in (0..graph.len()).rev() {
        let Some(reader) = warp_reader(&graph, &builder.recording, caps, number) else { continue };
        let producer = graph.take(number).expect("a producer was found");
        let taker = graph.take(reader).expect("a reader was found");
        let (pass, fused) = merge(&builder.recording, &producer, taker);
        graph.put(reader, pass);
        builder.savings.fused.push(fused);
    }
    graph.finish(builder);
}

/// The only reader of a warp's result, if it reads it by taps alone.
fn warp_reader(graph: &PassGraph, recording: &Recording, caps: &Caps, number: usize) -> Option<usize> {
    let (producer, intermediate) = graph.function_pass(number)?;
    let image = recording.image(intermediate);
    let is_intermediate = image.origin == Origin::Transient && !graph.is_kept(intermediate);
    if !is_intermediate || !producer.kernels.iter().all(|kernel| kernel.warp.is_some()) {
        return None;
    }
    let mut readers = graph.readers(Resource::Image(intermediate));
    let reader = readers.next().filter(|_| readers.next().is_none())?;
    let (taker, result) = graph.function_pass(reader)?;
    let reads =
        |kernel: &&KernelCall| kernel.args.iter().any(|arg| arg.value.read() == Some(Resource::Image(intermediate)));
    let only_taps = taker.kernels.iter().filter(reads).all(|kernel| kernel.warp == Some(WarpPart::Tap));
    let copies = taker.kernels.iter().filter(reads).count();
    let taps = copies * taps(producer);
    let same_size = recording.image(result).desc.size == image.desc.size;
    let passes = std::iter::repeat_n(producer, copies).chain([taker]);
    let fits = fit_one_module(passes, recording, caps);
    (only_taps && same_size && fits && taps <= MAX_TAPS).then_some(reader)
}

fn taps(pass: &Pass) -> usize {
    pass.kernels.iter().filter(|kernel| kernel.warp == Some(WarpPart::Tap)).count()
}

/// The reader with the producer's kernels in place of each of its taps.
fn merge(recording: &Recording, producer: &Pass, reader: Pass) -> (Pass, Fused) {
    let intermediate = producer.function_result().expect("only passes of functions are fused");
    let result = reader.function_result().expect("only passes of functions are fused");
    let mut kernels: Vec<KernelCall> = Vec::new();
    // The new place of each of the reader's kernels.
    let mut places = Vec::new();
    for kernel in reader.kernels {
        let kernel = renumbered(kernel, &places);
        if kernel.accepts(Arg::Texture(intermediate)) {
            let at = kernel.arg("at").expect("a tap has a place");
            let earlier = kernels.len();
            kernels.extend(producer.kernels.iter().map(|kernel| kernel.clone().moved(earlier, Some(Arg::Point), at)));
        } else {
            kernels.push(kernel);
        }
        places.push(kernels.len() - 1);
    }
    let mut nodes = producer.nodes.clone();
    nodes.extend(reader.nodes);
    nodes.dedup();
    let label = format!("{} + {}", producer.label, reader.label);
    let image = recording.image(intermediate);
    let fused = Fused { image: image.label.clone(), nodes: nodes.clone(), bytes_saved: 2 * image.desc.bytes() };
    (Pass::of_functions(nodes, label, kernels, result), fused)
}

fn renumbered(mut kernel: KernelCall, places: &[usize]) -> KernelCall {
    for arg in &mut kernel.args {
        arg.value = match arg.value {
            Arg::Kernel(earlier) => Arg::Kernel(places[earlier]),
            Arg::PointOf(earlier) => Arg::PointOf(places[earlier]),
            value => value,
        };
    }
    kernel
}
