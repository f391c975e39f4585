//! Quantization of files. The file's depth and the options of the command line decide it, not the pipeline: what a
//! `Dither` node does for a display, the writer does for a file, with the same noise and at the depth of the file.

use std::collections::BTreeSet;

use afterimage_gpu::Texels;
use afterimage_graph::check::{Graph, GraphNode, Source};
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::value::Value;
use afterimage_media::Samples;
use half::f16;

/// The noise of the `Dither` nodes of a pipeline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Noise {
    seed: u32,
    animate: bool,
}

impl Noise {
    /// The seed of a frame.
    pub fn seed(self, frame: u32) -> u32 {
        // Numbers of frames wrap like those on the device.
        if self.animate { self.seed.wrapping_add(frame) } else { self.seed }
    }
}

/// A pipeline whose outputs are written to files.
pub struct Unquantized {
    /// The pipeline without its `Dither`.
    pub graph: Graph,
    /// That of the last `Dither`; seed 0 without one.
    pub noise: Noise,
    /// Notes for users, as sentences.
    pub notes: Vec<String>,
}

/// A file that takes an encoded output.
pub struct EncodedFile {
    /// The source of the output.
    pub source: Source,
    /// Bits of a channel of the file.
    pub bits: u32,
}

/// Switches the `Dither` nodes of a pipeline off, and stores what leads to the files in floats: of 16 bits for a file
/// with eight bits, else of 32. So nothing is rounded before the file is written. `is_asked` is whether the user chose
/// the depth: then it is no news that it replaces that of the pipeline.
pub fn unquantized(mut graph: Graph, files: &[EncodedFile], is_asked: bool) -> Unquantized {
    let (mut noise, mut notes) = (Noise::default(), Vec::new());
    let needed: Vec<BTreeSet<usize>> = files.iter().map(|file| nodes_before(&graph, file.source)).collect();
    for (index, node) in graph.nodes.iter_mut().enumerate() {
        let mut own = files.iter().zip(&needed).filter(|(_, nodes)| nodes.contains(&index)).map(|(file, _)| file.bits);
        if node.kind().name() != "Dither" || node.off || own.clone().count() == 0 {
            continue;
        }
        node.off = true;
        noise = Noise { seed: integer(node, "seed"), animate: flag(node, "animate") };
        let stated = integer(node, "bits");
        if !is_asked && let Some(bits) = own.find(|bits| *bits != stated) {
            let name = &node.name;
            notes.push(format!("`{name}` dithers to {stated} bits; the file has {bits}, and its depth decides"));
        }
    }
    for EncodedFile { source, bits } in files {
        let format = if *bits > MAX_HALF_BITS { Format::Rgba32Float } else { Format::Rgba16Float };
        store_as(&mut graph, *source, format);
    }
    Unquantized { graph, noise, notes }
}

/// A pipeline whose `Dither` nodes make the codes of its files, as they make those of a display. What no `Dither` has
/// rounded is stored in 32-bit floats, so that the file rounds it as a display does.
pub fn with_codes(mut graph: Graph, files: &[EncodedFile]) -> Graph {
    for EncodedFile { source, .. } in files {
        let Source::Node { node, .. } = *source else { continue };
        let node = &mut graph.nodes[node];
        if node.format.is_none() && node.kind().name() != "Dither" {
            node.format = Some(Format::Rgba32Float);
        }
    }
    graph
}

/// Calls `write` with texels in the form that writers of files take.
pub fn with_samples<T>(texels: &Texels, write: impl FnOnce(Samples<'_>) -> T) -> T {
    match texels.desc.format {
        Format::Rgba8Unorm => write(Samples::Byte(&texels.bytes)),
        Format::Rgba16Float => match bytemuck::try_cast_slice(&texels.bytes) {
            Ok(halves) => write(Samples::Half(halves)),
            // They begin at an odd address.
            Err(_) => write(Samples::Half(&bytemuck::pod_collect_to_vec::<u8, f16>(&texels.bytes))),
        },
        _ => write(Samples::Float(texels.to_floats().as_flattened())),
    }
}

/// The nodes that an output needs.
fn nodes_before(graph: &Graph, end: Source) -> BTreeSet<usize> {
    let (mut found, mut waiting) = (BTreeSet::new(), vec![end]);
    while let Some(source) = waiting.pop() {
        if let Source::Node { node, .. } = source
            && found.insert(node)
        {
            waiting.extend(graph.nodes[node].wires.iter().flatten());
        }
    }
    found
}

/// Half floats have eleven bits below 1: the rounding to them moves the mean of eight-bit codes by a sixteenth of a
/// code at most.
const MAX_HALF_BITS: u32 = 8;

/// Sets the format of the encoded images from `end` back to the light, and leaves wider ones.
fn store_as(graph: &mut Graph, end: Source, format: Format) {
    let mut source = end;
    // A path that is longer than the number of nodes is a cycle through earlier frames.
    for _ in 0..graph.nodes.len() {
        let Source::Node { node, .. } = source else { return };
        let node = &mut graph.nodes[node];
        if node.states.first() != Some(&Some(ColorState::Encoded)) {
            return;
        }
        let is_narrow = node.format.is_some_and(|stated| stated.bytes() < format.bytes());
        if !node.off && (is_narrow || format == Format::Rgba32Float) {
            node.format = Some(format);
        }
        let Some(wire) = node.wires.iter().flatten().next() else { return };
        source = *wire;
    }
}

fn integer(node: &GraphNode, name: &str) -> u32 {
    match node.instance.value(name) {
        Some(Value::Int(number)) => u32::try_from(*number).expect("the domain has no negative numbers"),
        other => panic!("`Dither` has the whole number `{name}`, not {other:?}"),
    }
}

fn flag(node: &GraphNode, name: &str) -> bool {
    matches!(node.instance.value(name), Some(Value::Bool(true)))
}
