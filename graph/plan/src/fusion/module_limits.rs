//! Limits of fused passes, which become one module.

use afterimage_base::caps::Caps;
use afterimage_graph::node::{KernelCall, Pass, Recording};
use afterimage_wgsl::limits::CompileCost;

use crate::limits::MAX_PASS_OPERATIONS;

/// Returns whether passes of functions can be one module: it is compiled in time, has no more uniform buffers than the
/// device takes, and what is limited to finite numbers where it is read is so alike. All textures of a module are, so
/// the limits must be those of each that may not be finite, and no narrower than what the others hold.
pub(super) fn fit_one_module<'a>(
    passes: impl Iterator<Item = &'a Pass> + Clone,
    recording: &'a Recording,
    caps: &Caps,
) -> bool {
    let textures = || passes.clone().flat_map(|pass| &pass.kernels).flat_map(KernelCall::textures);
    let limits =
        textures().map(|image| recording.image(image)).filter(|image| !image.finite).map(|i| i.signedness).max();
    let is_kept = |limits| {
        textures().map(|image| recording.image(image)).all(|image| match image.finite {
            true => image.signedness <= limits,
            false => image.signedness == limits,
        })
    };
    let cost: CompileCost = passes.clone().map(Pass::compile_cost).sum();
    if cost.operations() > MAX_PASS_OPERATIONS {
        return false;
    }
    let binds = Pass::joined_uniform_buffers(passes.clone()) <= caps.max_fused_uniform_buffers as usize;
    binds && limits.is_none_or(is_kept)
}
