//! Runs: point functions of one color, each of which reads the result of the one before and nothing else.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_base::image::ColorState;
use afterimage_graph::check::{Graph, GraphNode, Source};
use afterimage_graph::node::{
    Arg, Bake, ImageId, KernelCall, KernelOrigin, Origin, Pass, PassKind, Resource, VirtualImage,
};

use crate::builder::PlanBuilder;
use crate::options::Options;

/// Functions of a run, at most: with those that make the colors and store them they fit into one pass.
const MAX_FUNCTIONS: usize = 48;

/// Passes that become a table.
pub(super) struct Run {
    /// The passes in order, each of which reads the result of the one before.
    pub(super) passes: Vec<usize>,
    /// The image that the first pass reads.
    pub(super) source: ImageId,
    /// The image that the last pass writes.
    pub(super) result: ImageId,
    /// The size of the table: see [`Bake::size`].
    pub(super) size: u32,
    /// True if it begins with exposed scene colors, false if with display colors.
    pub(super) is_exposed: bool,
    /// True if a node in it reads a value that passes compute: then every frame fills the table.
    pub(super) reads_value: bool,
}

/// A pass that may be part of a run.
struct Link {
    source: ImageId,
    result: ImageId,
    /// The color state that the pass reads. A table can begin with exposed scene colors or display colors.
    reads: Option<ColorState>,
    bake: Option<Bake>,
    /// True if the file asks for a table at this node.
    is_asked: bool,
    reads_value: bool,
}

impl Run {
    pub(super) fn last(&self) -> usize {
        *self.passes.last().expect("a run has a pass")
    }
}

/// The longest runs of which a node asks for a table.
pub(super) fn runs(builder: &PlanBuilder, graph: &Graph, options: &Options) -> Vec<Run> {
    let passes = &builder.recording.passes;
    let mut readers: BTreeMap<ImageId, usize> = BTreeMap::new();
    for image in passes.iter().flat_map(Pass::reads).filter_map(Resource::image) {
        *readers.entry(image).or_default() += 1;
    }
    let kept = builder.kept();
    let is_read_once = |image: ImageId| {
        let is_transient = builder.recording.image(image).origin == Origin::Transient;
        is_transient && !kept.contains(&image) && readers.get(&image) == Some(&1)
    };
    let mut open: BTreeMap<ImageId, Vec<(usize, Link)>> = BTreeMap::new();
    let (mut finished, mut negative) = (Vec::new(), BTreeSet::new());
    for (number, pass) in passes.iter().enumerate() {
        if can_be_negative(graph, pass, &negative) {
            negative.extend(pass.results.iter().map(|result| result.image));
            continue;
        }
        let Some(link) = link(builder, graph, pass, options) else { continue };
        let mut chain = if is_read_once(link.source) { open.remove(&link.source) } else { None }.unwrap_or_default();
        if chain.len() == MAX_FUNCTIONS {
            finished.push(std::mem::take(&mut chain));
        }
        let result = link.result;
        chain.push((number, link));
        finished.extend(open.insert(result, chain));
    }
    let all = finished.into_iter().chain(open.into_values());
    let mut runs: Vec<Run> = all.filter_map(run).collect();
    runs.sort_by_key(Run::last);
    runs
}

/// Gives each reader of a pass that is to be in a table its own copy of it, if all readers are functions of its color:
/// each becomes a table of its own, and nobody stores what the pass makes. Returns the images of the copies.
pub(super) fn part(builder: &mut PlanBuilder, graph: &Graph, options: &Options) -> BTreeSet<ImageId> {
    let (kept, mut parted) = (builder.kept(), BTreeSet::new());
    for number in (0..builder.recording.passes.len()).rev() {
        let passes = &builder.recording.passes;
        let made = link(builder, graph, &passes[number], options);
        let Some(Link { result, bake: Some(_), .. }) = made else { continue };
        let reads = |pass: &Pass| pass.reads().contains(&Resource::Image(result));
        let readers: Vec<usize> = (number + 1..passes.len()).filter(|reader| reads(&passes[*reader])).collect();
        let is_transient = builder.recording.image(result).origin == Origin::Transient;
        let is_function =
            |reader: &usize| link(builder, graph, &passes[*reader], options).is_some_and(|link| link.source == result);
        if !is_transient || kept.contains(&result) || !readers.iter().all(is_function) {
            continue;
        }
        for (copies, reader) in readers.into_iter().skip(1).enumerate() {
            let original = builder.recording.image(result);
            let label = format!("{} again", original.label);
            let image = builder.recording.add_image(VirtualImage { label, ..original.clone() });
            parted.insert(image);
            let reader = reader + copies;
            for arg in builder.recording.passes[reader].kernels.iter_mut().flat_map(|kernel| &mut kernel.args) {
                if arg.value == Arg::Pixel(result) {
                    arg.value = Arg::Pixel(image);
                }
            }
            let mut pass = builder.recording.passes[number].clone();
            pass.results[0].image = image;
            builder.recording.passes.insert(number + 1, pass);
        }
    }
    parted
}

/// Returns whether results can have a luminance below 0, which tables do not cover: those of functions that move zero,
/// and all that is made of them. `negative` are the images that can.
fn can_be_negative(graph: &Graph, pass: &Pass, negative: &BTreeSet<ImageId>) -> bool {
    let Some(KernelOrigin::Node { node, .. }) = pass.kernels.first().and_then(|kernel| kernel.origin) else {
        return false;
    };
    let mut read = pass.reads().into_iter().filter_map(Resource::image);
    !graph.nodes[node].instance.invariants().non_negative || read.any(|image| negative.contains(&image))
}

/// The part of a chain from the node that asks for a table.
///
/// What stands before it, such as a balance or a saturation, is cheap, and moves the borders of the gamut: behind it,
/// they would lie between the entries of a table, and not along its sides.
fn run(chain: Vec<(usize, Link)>) -> Option<Run> {
    let asked = chain.iter().position(|(_, link)| link.is_asked).unwrap_or(0);
    let can_begin = |at: &usize| matches!(chain[*at].1.reads, Some(ColorState::Exposed | ColorState::DisplayLinear));
    let first = (0..=asked).rev().find(can_begin).or_else(|| (asked..chain.len()).find(can_begin))?;
    let reads_value = chain[first..].iter().any(|(_, link)| link.reads_value);
    // The size that a table of every frame has been given is its price, which `Auto` does not raise.
    let asked = chain[first..].iter().filter_map(|(_, link)| link.bake);
    let size = asked.filter(|bake| !reads_value || *bake != Bake::Auto).filter_map(Bake::size).max()?;
    Some(Run {
        passes: chain[first..].iter().map(|(number, _)| *number).collect(),
        source: chain[first].1.source,
        result: chain.last()?.1.result,
        size,
        is_exposed: chain[first].1.reads == Some(ColorState::Exposed),
        reads_value,
    })
}

/// The pass as a part of a run, if its result is a function of one color. One that reads a value, such as that of a
/// meter, is none for `Auto`: to fill a table in every frame can cost more than its nodes do.
fn link(builder: &PlanBuilder, graph: &Graph, pass: &Pass, options: &Options) -> Option<Link> {
    let (PassKind::Point | PassKind::Gather, [kernel], [result]) = (&pass.kind, &*pass.kernels, &*pass.results) else {
        return None;
    };
    let Some(KernelOrigin::Node { node, .. }) = kernel.origin else { return None };
    let node = &graph.nodes[node];
    let bake = match (node.bake, options.bake) {
        (Some(Bake::Off), _) | (_, Some(Bake::Off)) => return None,
        (Some(Bake::Auto), None) if options.one_frame => return None,
        (written, replaced) => replaced.or(written),
    };
    let (port, source) = node.instance.invariants().of_color.then(|| color_of(builder, kernel))??;
    let reads_value = kernel.args.iter().any(|arg| matches!(arg.value, Arg::Value(..)));
    if reads_value && !matches!(bake, Some(Bake::Size(_))) {
        return None;
    }
    let [of_source, of_result] = [source, result.image].map(|image| builder.recording.image(image).desc.size);
    let reads = state_of(graph, node, port);
    (of_source == of_result).then_some(Link {
        source,
        result: result.image,
        reads,
        bake,
        is_asked: node.bake.is_some(),
        reads_value,
    })
}

/// The color state of an input, also if the node that feeds it is skipped.
fn state_of(graph: &Graph, node: &GraphNode, port: &str) -> Option<ColorState> {
    let port = node.kind().inputs().iter().position(|input| input.name == port)?;
    match node.wires[port]? {
        Source::Input(input) => Some(graph.inputs[input].state),
        Source::Node { node, output, .. } => graph.nodes[node].states[output],
    }
}

/// The argument and the image of which the kernel reads one pixel, if nothing else that it reads depends on the pixel.
fn color_of<'k>(builder: &PlanBuilder, kernel: &'k KernelCall) -> Option<(&'k str, ImageId)> {
    let mut source = None;
    for arg in &kernel.args {
        match arg.value {
            Arg::Pixel(image) if source.is_none() => source = Some((arg.name.as_str(), image)),
            Arg::Texture(image) if matches!(builder.recording.image(image).origin, Origin::Constant(_)) => {}
            Arg::Params | Arg::Zero(_) | Arg::Sampler | Arg::Value(..) => {}
            _ => return None,
        }
    }
    source
}
