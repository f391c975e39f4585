//! How much of a sweep runs.

/// `all` cases for `tests/sweeps.sh`, which sets `AFTERIMAGE_SWEEPS=all`; otherwise the first tenth of them.
pub fn cases(all: u64) -> u64 {
    if is_whole() { all } else { all.div_ceil(10) }
}

/// Whether all of each sweep runs.
pub fn is_whole() -> bool {
    std::env::var("AFTERIMAGE_SWEEPS").is_ok_and(|asked| asked == "all")
}
