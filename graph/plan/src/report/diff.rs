//! Differences of two plans: passes, bytes moved in each frame, peak memory.

use std::collections::BTreeMap;

use super::units::mebibytes;
use crate::plan::Plan;

/// The changes from one plan to another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanDiff {
    /// Passes that only the second has, in the order of execution.
    pub added: Vec<String>,
    /// Passes that only the first has, in the order of execution.
    pub removed: Vec<String>,
    /// Images that both have, with what each states of them, where size or format differ.
    pub resized: Vec<(String, String, String)>,
    pub passes: (u64, u64),
    pub batches: (u64, u64),
    /// Bytes that each moves in one frame.
    pub bytes_moved: (u64, u64),
    /// Bytes of transient images that each needs.
    pub peak_memory: (u64, u64),
}

/// Compares two plans. Passes are the same if their nodes and their labels are; where a label names a size, a pass of
/// another size is another pass.
pub fn diff(first: &Plan, second: &Plan) -> PlanDiff {
    let (first_passes, second_passes) = (first.pass_names(), second.pass_names());
    let transient = |plan: &Plan| plan.memory.bytes(plan.options.alias);
    PlanDiff {
        added: missing(&second_passes, &first_passes),
        removed: missing(&first_passes, &second_passes),
        resized: resized(first, second),
        passes: (first_passes.len() as u64, second_passes.len() as u64),
        batches: (first.batches.len() as u64, second.batches.len() as u64),
        bytes_moved: (first.bytes_moved(), second.bytes_moved()),
        peak_memory: (transient(first), transient(second)),
    }
}

impl PlanDiff {
    pub fn is_empty(&self) -> bool {
        let figures = [self.passes, self.batches, self.bytes_moved, self.peak_memory];
        self.added.is_empty()
            && self.removed.is_empty()
            && self.resized.is_empty()
            && figures.into_iter().all(|(first, second)| first == second)
    }
}

fn missing(from: &[String], other: &[String]) -> Vec<String> {
    let other: std::collections::BTreeSet<&String> = other.iter().collect();
    from.iter().filter(|name| !other.contains(name)).cloned().collect()
}

fn resized(first: &Plan, second: &Plan) -> Vec<(String, String, String)> {
    let described = |plan: &Plan| -> Vec<(String, String)> {
        let images = plan.image_names().into_iter().zip(&plan.images);
        let live = images.filter(|(_, image)| image.lifetime.is_some());
        live.map(|(name, image)| (name, format!("{} {}", image.desc.size, image.desc.format.name()))).collect()
    };
    let second: BTreeMap<String, String> = described(second).into_iter().collect();
    let changed = described(first).into_iter().filter_map(|(name, before)| {
        let after = second.get(&name).filter(|after| **after != before)?.clone();
        Some((name, before, after))
    });
    changed.collect()
}

impl std::fmt::Display for PlanDiff {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.is_empty() {
            return writeln!(f, "the plans do the same work in the same memory");
        }
        let count = |(before, after): (u64, u64)| format!("{before} -> {after}{}", change(before, after));
        let bytes = |(before, after): (u64, u64)| {
            format!("{} -> {}{}", mebibytes(before), mebibytes(after), change(before, after))
        };
        writeln!(f, "passes       {}", count(self.passes))?;
        writeln!(f, "batches      {}", count(self.batches))?;
        writeln!(f, "bytes moved  {} a frame", bytes(self.bytes_moved))?;
        writeln!(f, "peak memory  {}", bytes(self.peak_memory))?;
        self.removed.iter().try_for_each(|pass| writeln!(f, "- {pass}"))?;
        self.added.iter().try_for_each(|pass| writeln!(f, "+ {pass}"))?;
        self.resized.iter().try_for_each(|(image, before, after)| writeln!(f, "~ {image}: {before} -> {after}"))
    }
}

/// The change in percent, where there is one that can be stated.
fn change(before: u64, after: u64) -> String {
    if before == after || before == 0 {
        return String::new();
    }
    let percent = 100.0 * (after as f64 - before as f64) / before as f64;
    format!(" ({percent:+.1} %)")
}
