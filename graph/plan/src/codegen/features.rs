//! What shaders may use beyond what every device has: what was asked for, as far as the device has it, and pass by pass.

use crate::{Caps, Options, Plan};
use afterimage_graph::node::{Pass, Recording, Resource, Work};
use afterimage_wgsl::ShaderFeatures;

/// A switch of [`Options`] that has no effect on this device or beside another switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ignored {
    /// The switch, as the field of [`Options`] is called.
    pub switch: &'static str,
    /// Why.
    pub why: &'static str,
}

impl Options {
    /// The options without what this device lacks or another of them excludes, which is told beside them. PlanCache are made with these.
    pub fn granted(self, caps: &Caps) -> (Self, Vec<Ignored>) {
        let mut options = self;
        let mut ignored = Vec::new();
        if self.subgroups && !caps.subgroups {
            options.subgroups = false;
            ignored.push(Ignored { switch: "subgroups", why: "the device has no operations of subgroups" });
        }
        let half = match (self.exact, caps.half_arithmetic) {
            (true, _) => Some("`exact` wants all bits"),
            (false, false) => Some("the device has no half-precision arithmetic"),
            (false, true) => None,
        };
        if let Some(why) = half.filter(|_| self.half) {
            options.half = false;
            ignored.push(Ignored { switch: "half", why });
        }
        (options, ignored)
    }
}

impl Plan {
    /// What the shader of a pass may use.
    pub fn features(&self, pass: usize) -> ShaderFeatures {
        features(&self.recording, &self.options, &self.recording.passes[pass])
    }
}

/// Half floats are not for passes that read an image in 32 bits: its numbers may have more bits and be larger.
pub(crate) fn features(recording: &Recording, options: &Options, pass: &Pass) -> ShaderFeatures {
    let fits = |resource: &Resource| match resource {
        Resource::Image(image) => !recording.image(*image).desc.format.is_32_bit(),
        Resource::Buffer(_) => true,
    };
    let tiles_fit = !matches!(&pass.work, Work::Tiled(tiling) if !tiling.halves);
    let half = options.half && tiles_fit && pass.reads().iter().all(fits);
    ShaderFeatures { half, subgroups: options.subgroups }
}
