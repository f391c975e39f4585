//! The images of a plan of which textures can hold a band.

use std::collections::BTreeSet;

use afterimage_graph::node::{Arg, ImageId, Origin, Resource};
use afterimage_wgsl::{GlobalKind, SampleMode};

use crate::plan::{Plan, PlannedImage};

/// The images of a plan of which textures can hold a band.
pub(super) struct BandCandidates {
    /// For each image, true if it can be in bands.
    pub(super) fits: Vec<bool>,
    /// For each image, true if a pass reads it through a filtering sampler.
    pub(super) filtered: Vec<bool>,
}

impl BandCandidates {
    pub(super) fn new(plan: &Plan) -> Self {
        let on_change = (0..plan.passes.len()).filter(|pass| plan.runs_on_change(*pass));
        let tables = on_change.flat_map(|pass| plan.passes[pass].pass.writes()).filter_map(Resource::image).collect();
        let filtered = filtered(plan);
        let images = || plan.images.iter().zip(0..);
        Self {
            fits: images().map(|(image, id)| fits(image, ImageId(id), &tables)).collect(),
            filtered: images().map(|(_, id)| filtered.contains(&ImageId(id))).collect(),
        }
    }

    /// The sizes of these images, the largest first.
    pub(super) fn sizes(&self, plan: &Plan) -> Vec<[u32; 2]> {
        let mut sizes: Vec<[u32; 2]> = Vec::new();
        for (image, _) in plan.images.iter().zip(&self.fits).filter(|(_, fits)| **fits) {
            if !sizes.contains(&image.sides()) {
                sizes.push(image.sides());
            }
        }
        sizes.sort_by_key(|[width, height]| std::cmp::Reverse(u64::from(*width) * u64::from(*height)));
        sizes
    }
}

/// `tables` are the images that are made after a change of uniforms alone.
fn fits(image: &PlannedImage, id: ImageId, tables: &BTreeSet<ImageId>) -> bool {
    let desc = image.desc;
    let is_plain = desc.samples == 1 && desc.levels == 1 && desc.layers == 1 && !desc.volume;
    let is_table = matches!(image.origin, Origin::Constant(_)) || tables.contains(&id);
    is_plain && !is_table && !desc.format.is_depth() && image.lifetime.is_some()
}

/// The images that passes read through a filtering sampler.
fn filtered(plan: &Plan) -> BTreeSet<ImageId> {
    let mut filtered = BTreeSet::new();
    for pass in plan.work() {
        let has_sampler = pass.kernels.iter().any(|kernel| match kernel.shader.reflect() {
            Ok(known) if pass.results.is_empty() => {
                known.globals.iter().any(|global| global.kind == GlobalKind::Sampler)
            }
            _ => kernel.args.iter().any(|arg| arg.value == Arg::Sampler),
        });
        // The strictest sample mode of its textures holds for all.
        let textures = pass.kernels.iter().flat_map(|kernel| kernel.textures());
        let mode = textures.map(|image| plan.image(image).sample_mode).max().unwrap_or_default();
        if has_sampler && mode == SampleMode::Plain {
            filtered.extend(pass.args().filter_map(|arg| match arg {
                Arg::Texture(image) => Some(image),
                _ => None,
            }));
        }
    }
    filtered
}
