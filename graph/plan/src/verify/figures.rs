//! Figures: the bytes that the plan states are those of its places.

use std::collections::BTreeMap;

use super::walk::{Faults, Walk};
use crate::options::Alias;
use crate::plan::PlannedImage;

pub(super) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    let memory = &walk.plan.memory;
    let images = || walk.plan.images.iter();
    let bytes = |image: &PlannedImage| Some(image.requirement?.bytes);
    let wants: Vec<(usize, u64)> = images().enumerate().filter_map(|(at, image)| Some((at, bytes(image)?))).collect();
    let all: u64 = wants.iter().map(|(_, bytes)| bytes).sum();
    let placed = images().filter_map(|image| Some(image.offset? + bytes(image)?)).max().unwrap_or(0);
    let mut figures = vec![
        ("without sharing", memory.unshared, all),
        ("placed", memory.placed, placed),
        ("lower bound", memory.lower_bound, most_alive(walk, &wants)),
    ];
    if walk.plan.options.alias != Alias::None {
        let textures: BTreeMap<u32, u64> = images().filter_map(|image| Some((image.slot?, bytes(image)?))).collect();
        figures.push(("pooled", memory.pooled, textures.values().sum()));
    }
    for (name, stated, found) in figures.into_iter().filter(|(_, stated, found)| stated != found) {
        faults.add(format!("the plan states {stated} bytes for `{name}`, but its places come to {found}"));
    }
    if memory.unaliased < memory.unshared || (walk.plan.savings.fused.is_empty() && memory.unaliased != memory.unshared)
    {
        faults
            .add(format!("the plan stores {} bytes of {} that its nodes describe", memory.unshared, memory.unaliased));
    }
}

/// The most bytes of shared images that any batch keeps alive.
fn most_alive(walk: &Walk<'_>, wants: &[(usize, u64)]) -> u64 {
    let mut change: BTreeMap<usize, i128> = BTreeMap::new();
    for (image, bytes) in wants {
        let Some((first, last)) = walk.spans[*image] else { continue };
        *change.entry(first).or_default() += i128::from(*bytes);
        *change.entry(last + 1).or_default() -= i128::from(*bytes);
    }
    let mut alive = 0;
    let totals = change.values().map(|bytes| {
        alive += bytes;
        alive
    });
    totals.max().and_then(|most| u64::try_from(most).ok()).unwrap_or(0)
}
