//! Statistics of channels.

use super::{Picture, Pixels};

/// The range of a channel, and its counts of NaN and infinities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelStatistics {
    /// The least and the greatest finite number; `None` if there is none.
    pub range: Option<[f64; 2]>,
    /// Number of NaN.
    pub nan: u64,
    /// Number of infinities.
    pub infinite: u64,
}

impl ChannelStatistics {
    pub(crate) fn add(&mut self, value: f64) {
        if value.is_finite() {
            let [least, most] = self.range.unwrap_or([value; 2]);
            self.range = Some([least.min(value), most.max(value)]);
        } else if value.is_nan() {
            self.nan += 1;
        } else {
            self.infinite += 1;
        }
    }

    pub(crate) fn and(self, other: Self) -> Self {
        let ranges = self.range.into_iter().chain(other.range);
        let range = ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        Self { range, nan: self.nan + other.nan, infinite: self.infinite + other.infinite }
    }
}

/// The channels of a picture without layers, by their names.
pub(crate) fn of_picture(picture: &Picture, names: &[String]) -> Vec<ChannelStatistics> {
    let slot = |name: &String| ["R", "G", "B", "A"].iter().position(|known| name == known).unwrap_or(0);
    let channel = |slot: usize| {
        let mut statistics = ChannelStatistics::default();
        match &picture.pixels {
            Pixels::Half(values) => values.iter().skip(slot).step_by(4).for_each(|v| statistics.add(v.to_f64())),
            Pixels::Float(values) => values.iter().skip(slot).step_by(4).for_each(|v| statistics.add((*v).into())),
        }
        statistics
    };
    names.iter().map(slot).map(channel).collect()
}
