//! The hash of a plan: equal plans have equal hashes on every machine and in every version of Rust.

use afterimage_base::hash::fnv1a;
use afterimage_graph::node::Resource;

use crate::plan::{Metering, Plan, PlannedPass};

/// The hash of a plan, shown as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PlanHash(pub u128);

impl std::fmt::Display for PlanHash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl Plan {
    /// The hash of the canonical content: everything that [`Plan::to_json`] shows. Numbers that shaders take as
    /// uniforms are no part of it, so the hash stays when one changes while a pipeline runs; constants are part of it.
    pub fn hash(&self) -> PlanHash {
        PlanHash(fnv1a(self.content().to_string().as_bytes()))
    }

    /// The hash of the passes that measure, with their uniforms: plans in which it is equal measure frames alike, on
    /// one adapter bit for bit.
    pub fn measuring_hash(&self, metering: &Metering) -> PlanHash {
        let passes = metering.measuring.iter().map(|&index| measuring_words(self, &self.passes[index]));
        PlanHash(fnv1a(passes.collect::<String>().as_bytes()))
    }
}

/// A description of a pass without the names of its resources, which depend on other passes.
fn measuring_words(plan: &Plan, planned: &PlannedPass) -> String {
    let PlannedPass { pass, stage, workgroups, uniform, .. } = planned;
    let mut words = format!("{stage:?} {workgroups:?} {:032x}\n", fnv1a(&uniform.bytes));
    for kernel in &pass.kernels {
        let text = fnv1a(kernel.shader.text().as_bytes());
        words += &format!("{} {text:032x} {:?}\n", kernel.function, kernel.constants);
    }
    for resource in pass.resources() {
        words += &match resource {
            Resource::Image(image) => {
                let image = plan.image(image);
                format!("{:?} {:?}\n", image.desc, image.sample_mode)
            }
            Resource::Buffer(buffer) => format!("{} bytes\n", plan.buffers[buffer.0 as usize].bytes),
        };
    }
    words
}
