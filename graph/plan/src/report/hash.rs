//! The hash of a plan: equal plans have equal hashes on every machine and in every version of Rust.

use super::content::content;
use super::fnv::fnv1a;
use crate::plan::Plan;

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
        PlanHash(fnv1a(content(self).to_string().as_bytes()))
    }
}
