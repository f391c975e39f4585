//! Percentile and mean.

/// The least number that at least `share` of all do not exceed (the nearest-rank percentile), or 0 of none.
pub fn percentile(values: &[f32], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = (share * values.len() as f64).ceil() as usize;
    let at = rank.clamp(1, values.len()) - 1;
    let mut values = values.to_vec();
    let (_, found, _) = values.select_nth_unstable_by(at, f32::total_cmp);
    f64::from(*found)
}

/// The mean, or 0 of none.
pub fn mean(values: &[f32]) -> f64 {
    let sum: f64 = values.iter().map(|x| f64::from(*x)).sum();
    sum / values.len().max(1) as f64
}
