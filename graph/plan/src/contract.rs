//! The contract of node kinds, with code generation: every pass that a kind records becomes a module that naga accepts.

use std::collections::BTreeSet;

use afterimage_base::image::{Format, Signedness, Size};
use afterimage_graph::node::{
    Arg, ByRows, ImageId, KernelCall, NodeKind, Pass, PassKind, PassResult, Recording, Resource, RowDownsample,
    contract_with,
};
use afterimage_wgsl::{SampleMode, Shader};

use crate::builder::copy_kernel;
use crate::codegen::{CodeOptions, compose_pass, functions_cover};
use crate::fusion::{Neighbors, row_kernel, row_pass, square_kernel};

/// The contract of [`afterimage_graph::node::contract`], and beyond it: every pass becomes a valid module, alone and
/// fused with another one, in every way in which its textures may be sampled and its numbers computed, and its
/// workgroup memory is within what every WebGPU device has.
///
/// Returns what could not be checked, one sentence each.
///
/// # Errors
/// All violations, one sentence each, with the kind's name in front.
pub fn contract(kinds: &[NodeKind]) -> Result<Vec<String>, Vec<String>> {
    let mut modules = Modules::default();
    contract_with(kinds, &mut |recording| modules.look(recording))
}

/// The WGSL of every module that the contract composes from these kinds without immediates, for validators other than
/// naga.
pub fn modules(kinds: &[NodeKind]) -> BTreeSet<String> {
    let mut modules = Modules::default();
    let _ = contract_with(kinds, &mut |recording| modules.look(recording));
    modules.plain
}

/// The pass as the planner records it: it limits the results of untrusted shaders.
fn limited(pass: &Pass) -> Pass {
    let mut pass = pass.clone();
    let untrusted = pass.kernels.iter_mut().filter(|kernel| kernel.shader.is_untrusted());
    untrusted.for_each(|kernel| kernel.limited = Some(Signedness::Unsigned));
    pass
}

/// All of a pass that its module depends on.
fn shape(pass: &Pass, recording: &Recording) -> String {
    let images = pass.writes().into_iter().map(Resource::image);
    let formats: Vec<Option<Format>> = images.map(|image| Some(recording.image(image?).desc.format)).collect();
    let calls: Vec<_> = pass.kernels.iter().map(|kernel| (&kernel.shader, &kernel.function, &kernel.args)).collect();
    format!("{calls:?} {:?} {formats:?} {:?}", pass.kind, cover(pass, recording))
}

/// Texels that a workgroup of functions makes: more of large images.
fn cover(pass: &Pass, recording: &Recording) -> Option<[u32; 2]> {
    let sanitizes = pass.kernels.iter().flat_map(KernelCall::textures).any(|image| !recording.image(image).finite);
    pass.function_result().map(|image| functions_cover(pass, recording.image(image).desc.size, sanitizes))
}

/// Variants of a module: the sampling of its textures, and whether the frame's time comes from immediates.
const VARIANTS: [(SampleMode, bool); 6] = [
    (SampleMode::Plain, false),
    (SampleMode::ByHand, false),
    (SampleMode::Sanitized, false),
    (SampleMode::SanitizedLight, false),
    (SampleMode::SanitizedSigned, false),
    (SampleMode::Plain, true),
];

#[derive(Default)]
struct Modules {
    shapes: BTreeSet<String>,
    sources: BTreeSet<String>,
    /// Those of the sources without immediates, which not every device has.
    plain: BTreeSet<String>,
    violations: Vec<String>,
}

impl Modules {
    /// The violations of the passes of a recording that are new.
    fn look(&mut self, recording: &Recording) -> Vec<String> {
        for pass in &recording.passes {
            if self.shapes.insert(shape(pass, recording)) {
                self.check(&limited(pass), recording);
            }
        }
        std::mem::take(&mut self.violations)
    }

    /// The pass as a module, for every way in which its textures may be read and its numbers may be made; and in its
    /// other forms.
    fn check(&mut self, pass: &Pass, recording: &Recording) {
        if pass.kernels.is_empty() {
            // It clears, or the host draws with its own modules.
            return;
        }
        // In large images the same functions are called in a longer entry point.
        let small = functions_cover(pass, Size::new(1, 1), false);
        let is_small = cover(pass, recording).is_none_or(|cover| cover == small);
        self.variants(pass, recording, "", if is_small { &VARIANTS } else { &VARIANTS[..1] });
        if let Some(fused) = fused(pass) {
            self.variants(&fused, recording, " fused with its reader", &VARIANTS[..1]);
        }
        let forms = by_rows(pass).into_iter().chain(by_neighbors(pass)).chain(quad_variant(pass));
        for mut pass in forms {
            self.variants(&pass, recording, "", &VARIANTS);
            if let PassKind::RowDownsample(rows) = &mut pass.kind {
                rows.odd = [1; 2];
                self.variants(&pass, recording, " at an odd size", &VARIANTS[..1]);
            }
        }
    }

    fn variants(&mut self, pass: &Pass, recording: &Recording, form: &str, variants: &[(SampleMode, bool)]) {
        let desc_of = |image: ImageId| recording.image(image).desc;
        for (mode, immediates) in variants.iter().copied() {
            let options = CodeOptions { immediates, ..CodeOptions::default() };
            let composed = compose_pass(pass, &desc_of, &|_| mode, options);
            self.plain.extend(composed.iter().filter(|_| !immediates).map(|composed| composed.source.clone()));
            let fault = match composed {
                Ok(composed) if !self.sources.insert(composed.source.clone()) => None,
                Ok(composed) => match composed.validate() {
                    Ok(module) => too_much_memory(&module),
                    Err(error) => Some(format!("is no valid module: {error}")),
                },
                Err(error) => Some(format!("is no module: {error}")),
            };
            self.violations.extend(fault.map(|fault| format!("the pass `{}`{form} {fault}", pass.label)));
        }
    }
}

/// Bytes of workgroup memory that every WebGPU device has.
const MIN_WORKGROUP_BYTES: u32 = 16 << 10;

/// Workgroup memory beyond what every device has.
fn too_much_memory(module: &naga::Module) -> Option<String> {
    let shared = module.global_variables.iter().filter(|(_, global)| global.space == naga::AddressSpace::WorkGroup);
    let bytes: u32 =
        shared.map(|(_, global)| module.types[global.ty].inner.size(module.to_ctx()).next_multiple_of(16)).sum();
    (bytes > MIN_WORKGROUP_BYTES)
        .then(|| format!("has {bytes} bytes of workgroup memory; the limit of a device may be {MIN_WORKGROUP_BYTES}"))
}

/// The pass before a reader of its pixels, in one module: itself once more, or a copy.
fn fused(pass: &Pass) -> Option<Pass> {
    let (image, [kernel]) = (pass.function_result()?, pass.kernels.as_slice()) else { return None };
    if !matches!(pass.kind, PassKind::Point | PassKind::Gather) {
        return None;
    }
    let pixel = kernel.args.iter().map(|arg| arg.value).find(|value| matches!(value, Arg::Pixel(_)));
    let (reader, read) = match pixel {
        Some(pixel) => (kernel.clone(), pixel),
        None => (copy_kernel(&kernel.node, image), Arg::Pixel(image)),
    };
    let kernels = vec![kernel.clone(), reader.moved(0, Some(read), Arg::Kernel(0))];
    Some(Pass { kernels, results: vec![PassResult { kernel: 1, image }], ..pass.clone() })
}

/// The pass in its form by rows, if it has one.
fn by_rows(pass: &Pass) -> Option<Pass> {
    let (image, [kernel]) = (pass.function_result()?, pass.kernels.as_slice()) else { return None };
    let by = kernel.by_rows?;
    let kernels = vec![copy_kernel(&kernel.node, kernel.textures().next()?), row_kernel(&kernel.node, by)];
    Some(of_rows(pass, kernels, image, by, None))
}

fn of_rows(pass: &Pass, kernels: Vec<KernelCall>, image: ImageId, by: ByRows, around: Option<usize>) -> Pass {
    let rows = RowDownsample { state: by.state, rows: 1, odd: [0; 2], around, is_open: by.is_open };
    row_pass(pass.nodes.clone(), pass.label.clone(), kernels, image, rows)
}

/// A halving for forms that are called in one.
static HALVING: Shader = Shader::new(
    "halving.wgsl",
    "struct Halving { sum: vec4f }
fn halving(state: ptr<function, Halving>, square: Square, invocation: u32) -> vec4f {
    (*state).sum += square.upper_left + square.upper_right + square.lower_left + square.lower_right;
    return (*state).sum;
}",
);
const HALF: ByRows = ByRows { shader: &HALVING, function: "halving", state: "Halving", reach: 0.0, is_open: true };

/// The pass in its form by neighbors in a halving by rows, if it has one.
fn by_neighbors(pass: &Pass) -> Option<Pass> {
    let image = pass.function_result()?;
    let (mut kernels, around) = Neighbors::alone(pass.kernels.clone())?;
    kernels.push(row_kernel(&kernels[0].node, HALF));
    Some(of_rows(pass, kernels, image, HALF, around))
}

/// The pass in its form by squares beside a halving by rows, if it has one.
fn quad_variant(pass: &Pass) -> Option<Pass> {
    let (image, [kernel]) = (pass.function_result()?, pass.kernels.as_slice()) else { return None };
    kernel.quad_variant?;
    let kernels = vec![copy_kernel(&kernel.node, kernel.textures().next()?), row_kernel(&kernel.node, HALF)];
    let mut rows = of_rows(pass, kernels, image, HALF, None);
    rows.kernels.push(square_kernel(kernel, 0));
    rows.results.push(PassResult { kernel: 2, image });
    Some(rows)
}
