//! Multisampled images.

use super::Op;
use crate::reference::resolve::weighted;

pub(super) const OPS: &[Op] = &[("msaa_resolve", |case| {
    let samples = case.triples();
    [0.0, 1.0].map(|gain| weighted(&samples, gain)).concat()
})];
