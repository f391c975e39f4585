//! Names of images, buffers and passes for people: labels, made unique.

use std::collections::BTreeMap;

/// The labels, with `#2` and so on after those that occurred before.
pub(super) fn unique<'a>(labels: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let mut names = Vec::new();
    for label in labels {
        let count = seen.entry(label).or_default();
        *count += 1;
        names.push(if *count == 1 { label.to_owned() } else { format!("{label}#{count}") });
    }
    names
}
