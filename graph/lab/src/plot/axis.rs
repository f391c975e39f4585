//! From numbers to positions in the chart.

/// The least number of marks of an axis.
const MIN_MARKS: f64 = 4.0;

pub(crate) struct LinearAxis {
    low: f64,
    high: f64,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl LinearAxis {
    /// Covers the numbers with a margin. Starts at 0 unless the numbers are close to each other.
    pub(crate) fn new(numbers: &[f64], from: f64, to: f64) -> Self {
        let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let most = numbers.iter().copied().fold(0.0, f64::max).max(1e-6);
        let margin = (most - least).max(0.05 * most) * 0.1;
        Self { low: if least < 0.5 * most { 0.0 } else { (least - margin).max(0.0) }, high: most + margin, from, to }
    }

    pub(crate) fn place(&self, number: f64) -> f64 {
        self.from + (number - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round numbers on the axis, and their decimal places.
    pub(crate) fn marks(&self) -> (Vec<f64>, usize) {
        let span = self.high - self.low;
        let decade = 10.0_f64.powf((span / MIN_MARKS).log10().floor());
        let step =
            [5.0, 2.0, 1.0].into_iter().map(|s| s * decade).find(|step| span / step >= MIN_MARKS).unwrap_or(decade);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        let places = (-step.log10().floor()).max(0.0) as usize;
        ((first..=last).map(|i| i as f64 * step).collect(), places)
    }
}

/// A logarithmic axis with a position for 0 below its lowest decade.
pub(crate) struct LogAxis {
    lowest: i32,
    highest: i32,
    has_zero: bool,
    from: f64,
    to: f64,
}

/// Smaller errors are drawn as 0.
const LEAST: f64 = 1e-4;
/// LogAxis between 0 and the least mark.
const STEP_TO_ZERO: f64 = 0.7;

impl LogAxis {
    pub(crate) fn new(numbers: &[f64], from: f64, to: f64) -> Self {
        let seen: Vec<f64> = numbers.iter().copied().filter(|number| *number >= LEAST).collect();
        let least = seen.iter().copied().fold(f64::INFINITY, f64::min).min(1.0);
        let most = seen.iter().copied().fold(0.0, f64::max).max(least * 1.01);
        let lowest = least.log10().floor() as i32;
        let highest = (most.log10().ceil() as i32).max(lowest + 1);
        Self { lowest, highest, has_zero: seen.len() < numbers.len(), from, to }
    }

    pub(crate) fn place(&self, number: f64) -> f64 {
        let bottom = f64::from(self.lowest) - if self.has_zero { STEP_TO_ZERO } else { 0.0 };
        let exponent = if number < LEAST { bottom } else { number.log10() };
        self.from + (exponent - bottom) / (f64::from(self.highest) - bottom) * (self.to - self.from)
    }

    /// Powers of ten and, if there is one, 0, with their texts.
    pub(crate) fn marks(&self) -> Vec<(f64, String)> {
        let zero = self.has_zero.then(|| (0.0, "0".to_owned()));
        let power = |exponent: i32| {
            let places = (-exponent).max(0) as usize;
            let number = 10.0_f64.powi(exponent);
            (number, format!("{number:.places$}"))
        };
        zero.into_iter().chain((self.lowest..=self.highest).map(power)).collect()
    }

    pub(crate) fn fine_marks(&self) -> Vec<f64> {
        (self.lowest..self.highest).flat_map(|exponent| [2.0, 5.0].map(|step| step * 10.0_f64.powi(exponent))).collect()
    }
}
