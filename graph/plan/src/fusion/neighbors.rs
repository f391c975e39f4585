//! Fusion of a halving by rows with more than functions of one pixel: with a function that looks one texel around its
//! pixel, because the invocations share what their neighbors need, and results of half the size of the same image.
//!
//! So an image that is limited by its neighbors, selected and halved is read once, and nothing of its size is stored.
//! Kinds state how far their functions look: [`KernelCall::by_neighbors`] and [`KernelCall::quad_variant`].

use super::module_limits::fit_one_module;
use super::pass_graph::{PassGraph, is_cheap};
use crate::builder::copy_kernel;
use afterimage_base::caps::Caps;
use afterimage_graph::node::{
    Arg, Argument, ImageId, KernelCall, Origin, Pass, PassKind, PassResult, Recording, Resource,
};

/// The passes and kernels that a halving by rows takes over with a pass whose first function looks around its pixel.
pub(crate) struct Neighbors {
    /// The image that it reads around the pixel.
    pub(super) source: ImageId,
    /// The kernels that make a texel of that image.
    texel: Vec<KernelCall>,
    /// The pass that they are of; none if they read the image.
    maker: Option<usize>,
    /// The passes that make images from squares of the same texels.
    squares: Vec<usize>,
}

impl Neighbors {
    /// Finds them for the pass of that number, if it looks around a pixel and the halving can take it over.
    pub(super) fn find(
        graph: &PassGraph,
        recording: &Recording,
        caps: &Caps,
        number: usize,
        halving: usize,
    ) -> Option<Self> {
        let (pass, result) = graph.function_pass(number)?;
        let source = looks_around(pass)?;
        if recording.image(source).desc.size != recording.image(result).desc.size {
            return None;
        }
        // A retained image is written in other frames than images for later ones.
        let is_retained = |image: ImageId| recording.image(image).origin == Origin::Retained;
        let is_retained = graph.function_pass(halving).is_some_and(|(_, image)| is_retained(image));
        let mut squares = if is_retained { Vec::new() } else { squares(graph, recording, source) };
        squares.truncate(caps.max_storage_images as usize - 1);
        let mut joined = squares.clone();
        joined.push(number);
        let maker = source_maker(graph, recording, source, &joined);
        joined.push(halving);
        joined.extend(maker);
        let joined: Vec<&Pass> = joined.into_iter().filter_map(|number| graph.get(number)).collect();
        if !fit_one_module(joined.into_iter(), recording, caps) {
            return None;
        }
        let made = maker.and_then(|maker| graph.get(maker)).map(|maker| maker.kernels.clone());
        let texel = made.unwrap_or_else(|| vec![copy_kernel(&pass.kernels[0].node, source)]);
        Some(Self { source, texel, maker, squares })
    }

    /// The kernels of a pass that looks around, behind a copy of the image that it looks at.
    pub(crate) fn alone(kernels: Vec<KernelCall>) -> Option<(Vec<KernelCall>, Option<usize>)> {
        let (first, form) = (kernels.first()?, kernels.first()?.by_neighbors?);
        let Some(Arg::Texture(source)) = first.arg(form.source) else { return None };
        let texel = vec![copy_kernel(&first.node, source)];
        Some(Self { source, texel, maker: None, squares: Vec::new() }.kernels(kernels))
    }

    /// The kernels of the pass that looks around, behind those that make its texels, and the one that looks around.
    pub(super) fn kernels(&self, kernels: Vec<KernelCall>) -> (Vec<KernelCall>, Option<usize>) {
        let around = self.texel.len();
        let mut all = self.texel.clone();
        all.extend(kernels.into_iter().map(|kernel| kernel.moved(around, None, Arg::Around)));
        all[around] = in_form(&all[around], around - 1);
        (all, Some(around))
    }

    /// Takes the passes that make images from squares, and adds what they do to a pass by rows. How many they are.
    pub(super) fn join_squares(&self, graph: &mut PassGraph, rows: &mut Pass) -> u64 {
        for number in &self.squares {
            let pass = graph.take(*number).expect("a pass of squares was found");
            for result in &pass.results {
                rows.results.push(PassResult { kernel: rows.kernels.len(), image: result.image });
                rows.kernels.push(square_kernel(&pass.kernels[result.kernel], self.texel.len() - 1));
            }
            rows.nodes.extend(pass.nodes);
            rows.nodes.dedup();
            rows.label += &format!(", {}", pass.label);
        }
        self.squares.len() as u64
    }

    /// Returns whether the image whose texels it computes is still stored for other passes.
    pub(super) fn is_still_stored(&self, graph: &PassGraph) -> bool {
        self.maker.is_some() && graph.readers(Resource::Image(self.source)).next().is_some()
    }

    /// Takes the pass that has made the image for it alone. Whether there was one.
    pub(super) fn take_maker(&self, graph: &mut PassGraph) -> bool {
        !self.is_still_stored(graph) && self.maker.and_then(|maker| graph.take(maker)).is_some()
    }
}

/// A kernel in its form by squares, for the texels of the kernel `texel`.
pub(crate) fn square_kernel(kernel: &KernelCall, texel: usize) -> KernelCall {
    let form = kernel.quad_variant.expect("a pass of squares has a form for them");
    let args = vec![Argument { name: "square".into(), value: Arg::SquareOf(texel) }];
    KernelCall { function: form.into(), args, ..kernel.clone() }
}

/// A kernel in its form by neighbors, for the value of the kernel `texel`. Its arguments are found by their names in
/// the shader.
fn in_form(kernel: &KernelCall, texel: usize) -> KernelCall {
    let form = kernel.by_neighbors.expect("a kernel that looks around has a form for it");
    let reflection = kernel.shader.reflect().expect("a kernel that is recorded was reflected");
    let function = reflection.function(form.function).expect("a kernel has the form that it states");
    let argument = |(name, _): &(String, _)| {
        let value = match name.as_str() {
            "around" => Arg::Around,
            name if name == form.source => Arg::Kernel(texel),
            name => kernel.arg(name).expect("a form takes what the function takes"),
        };
        Argument { name: name.clone(), value }
    };
    let args = function.args.iter().map(argument).collect();
    KernelCall { function: form.function.into(), args, ..kernel.clone() }
}

/// The image around whose pixel a pass looks, if its first function does and has a form for it, and the others need
/// only what that one gives.
fn looks_around(pass: &Pass) -> Option<ImageId> {
    let [first, others @ ..] = pass.kernels.as_slice() else { return None };
    let Some(Arg::Texture(source)) = first.arg(first.by_neighbors?.source) else { return None };
    let reads_once = first.textures().filter(|image| *image == source).count() == 1;
    let has_pixels = pass.args().any(|arg| matches!(arg, Arg::Pixel(_)));
    let is_fit = reads_once && !has_pixels && !others.iter().any(KernelCall::reads_texture);
    is_fit.then_some(source)
}

/// The passes that make an image from squares of `source`, a texel from each, for later frames alone: the halving might
/// wait for a pass of this frame that reads it.
fn squares(graph: &PassGraph, recording: &Recording, source: ImageId) -> Vec<usize> {
    let size = |image: ImageId| recording.image(image).desc.size;
    let is_of_squares = |number: &usize| {
        let Some((pass, result)) = graph.function_pass(*number) else { return false };
        let is_read = graph.readers(Resource::Image(result)).next().is_some() || graph.is_output(result);
        let has_form = matches!(pass.kernels.as_slice(), [kernel] if kernel.quad_variant.is_some());
        has_form && !is_read && size(result) == size(source).div_up(2)
    };
    graph.readers(Resource::Image(source)).filter(is_of_squares).collect()
}

/// The pass that makes `source`, if the image need not be stored when the passes `joined` make its texels themselves:
/// the others, if there are any, read its pixels one by one, and to make it again costs less than to store it.
fn source_maker(graph: &PassGraph, recording: &Recording, source: ImageId, joined: &[usize]) -> Option<usize> {
    if recording.image(source).origin != Origin::Transient || graph.is_kept(source) {
        return None;
    }
    let mut makers = graph.writers(Resource::Image(source));
    let maker = makers.next().filter(|_| makers.next().is_none())?;
    let (pass, _) = graph.function_pass(maker).filter(|(pass, _)| pass.kind == PassKind::Point)?;
    let reads_pixels = |number: usize| {
        let is_pixel = |arg: Arg| arg == Arg::Pixel(source) || arg.read() != Some(Resource::Image(source));
        graph.function_pass(number).is_some_and(|(pass, _)| pass.args().all(is_pixel))
    };
    let mut others = graph.readers(Resource::Image(source)).filter(|number| !joined.contains(number)).peekable();
    let is_cheaper = others.peek().is_none() || is_cheap(pass);
    (is_cheaper && others.all(reads_pixels)).then_some(maker)
}
