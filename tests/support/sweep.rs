//! The share of a sweep that runs.

/// `all` cases for `tests/sweeps.sh`, which sets `AFTERIMAGE_SWEEPS=all`; otherwise the first tenth of them.
pub fn cases(all: u64) -> u64 {
    if is_whole() { all } else { all.div_ceil(10) }
}

/// True if all of each sweep runs.
pub fn is_whole() -> bool {
    std::env::var("AFTERIMAGE_SWEEPS").is_ok_and(|asked| asked == "all")
}

/// All items for a whole sweep, otherwise this many of them, evenly spread.
pub fn some<T>(items: impl IntoIterator<Item = T>, count: usize) -> Vec<T> {
    let items: Vec<T> = items.into_iter().collect();
    let (all, count) = (items.len(), if is_whole() { items.len() } else { count });
    let is_chosen = |index: usize| (0..count).any(|i| (2 * i + 1) * all / (2 * count) == index);
    items.into_iter().enumerate().filter(|(index, _)| is_chosen(*index)).map(|(_, item)| item).collect()
}
