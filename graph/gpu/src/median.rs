//! Medians of samples.

/// The median; the mean of the two middle values of an even number, 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// A median, and how well it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MedianEstimate {
    /// The median of the samples.
    pub median: f64,
    /// The interval that holds the true median with a confidence of 95 %: two of the samples, or the least and the
    /// greatest of fewer than six.
    pub interval: [f64; 2],
}

impl MedianEstimate {
    /// The median of samples that do not depend on each other. All is 0 without samples.
    pub fn of(mut samples: Vec<f64>) -> Self {
        samples.sort_by(f64::total_cmp);
        let count = samples.len();
        if count == 0 {
            return Self::default();
        }
        // How many samples lie below the true median is binomial: half of them, with a deviation of half the root.
        let rank = (0.5 * count as f64 - 0.98 * (count as f64).sqrt()).floor().max(1.0) as usize;
        let interval = [samples[rank - 1], samples[count - rank]];
        Self { median: median(samples), interval }
    }
}

#[cfg(test)]
mod tests {
    use super::{MedianEstimate, median};

    /// Numbers from 0 to 1 that look random.
    fn noise(seed: u64) -> impl Iterator<Item = f64> {
        let next =
            |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
        std::iter::successors(Some(seed), next).skip(8).map(|state| (state >> 33) as f64 / (1_u64 << 31) as f64)
    }

    #[test]
    fn the_interval_holds_the_true_median_in_ninety_five_of_a_hundred_cases() {
        for count in [7, 24, 50, 100] {
            let cases = 2000;
            let holds = |case: &u64| {
                // The square makes the distribution lopsided; its median is 0.25.
                let samples = noise(case * 7919 + 13).take(count).map(|sample| sample * sample).collect();
                let [low, high] = MedianEstimate::of(samples).interval;
                (low..=high).contains(&0.25)
            };
            let share = (0..cases).filter(holds).count() as f64 / cases as f64;
            assert!((0.94..0.995).contains(&share), "{count} samples: {share}");
        }
        assert_eq!(MedianEstimate::of(vec![2.0, 1.0, 4.0]).interval, [1.0, 4.0]);
        assert_eq!(MedianEstimate::of(Vec::new()), MedianEstimate::default());
    }

    #[test]
    fn the_median_is_the_middle_value_or_the_mean_of_the_two_middle_ones() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!(median(Vec::new()), 0.0);
    }
}
