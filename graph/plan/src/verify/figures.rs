//! Figures: the bytes that the plan prints are those of its places.

use std::collections::BTreeMap;

use super::{Faults, Walk};
use crate::Alias;

pub(crate) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    let memory = &walk.plan.memory;
    let wants: Vec<(usize, u64)> =
        memory.requirement_of.iter().enumerate().filter_map(|(image, wants)| Some((image, (*wants)?.bytes))).collect();
    let all: u64 = wants.iter().map(|(_, bytes)| bytes).sum();
    let placed = wants.iter().filter_map(|(image, bytes)| Some(memory.offset_of[*image]? + bytes)).max().unwrap_or(0);
    let mut figures = vec![
        ("without sharing", memory.unshared, all),
        ("placed", memory.placed, placed),
        ("lower bound", memory.lower_bound, most_alive(walk, &wants)),
    ];
    if walk.plan.options.alias != Alias::None {
        let textures: BTreeMap<u32, u64> =
            wants.iter().filter_map(|(image, bytes)| Some((memory.slot_of[*image]?, *bytes))).collect();
        figures.push(("pooled", memory.pooled, textures.values().sum()));
    }
    for (name, stated, found) in figures.into_iter().filter(|(_, stated, found)| stated != found) {
        faults.add(format!("the plan states {stated} bytes for `{name}`, but its places come to {found}"));
    }
    if memory.unaliased < memory.unshared || (walk.plan.fused.is_empty() && memory.unaliased != memory.unshared) {
        faults
            .add(format!("the plan stores {} bytes of {} that its nodes describe", memory.unshared, memory.unaliased));
    }
    if memory.placed > memory.heap {
        faults.add(format!("the plan places {} bytes in a heap of {}", memory.placed, memory.heap));
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
