//! Shapers: the mapping of linear values of any range to the entries of a table.

use afterimage_graph::prelude::*;

choices! {
    /// How a color maps to a position in a table.
    pub enum Shaper {
        /// Unchanged: for tables of encoded or display-linear colors.
        None,
        /// Log2, from 2^`low` to 2^`high`: equal steps in stops. Darker light counts as 2^`low`.
        Log2,
        /// A camera's logarithm with a linear part near black, from 0 to 2^`high`: finer near black than `Log2`, and
        /// exact at black.
        LogC,
        /// The sRGB curve: for display-linear light and tables made for encoded images.
        Srgb,
    }
}

/// A linear part up to a point and a logarithm above it: the form in which shaders compute every shaper but sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Slope, offset, end of the linear part, 0.
    pub line: [f64; 4],
    /// a, b, c, d of `c * log2(a * x + b) + d`.
    pub curve: [f64; 4],
}

impl Shape {
    /// The identity.
    pub const NONE: Self = Self { line: [1.0, 0.0, 3e38, 0.0], curve: [0.0, 1.0, 0.0, 0.0] };

    /// Maps 2^low to 0 and 2^high to 1, linear in stops.
    pub fn log2(low: f64, high: f64) -> Self {
        let scale = 1.0 / (high - low);
        Self { line: [0.0, 0.0, low.exp2(), 0.0], curve: [1.0, 0.0, scale, -low * scale] }
    }

    /// Maps 0 to 0 and 2^high to 1 by the logarithm of a film camera (ARRI's LogC, EI 200).
    pub fn log_c(high: f64) -> Self {
        let (a, b, c, d) = (5.555556, 0.047996, 0.244161 * 2.0_f64.log10(), 0.386036);
        let cut = 0.011361;
        let raw = |x: f64| c * (a * x + b).log2() + d;
        let slope = c * a / (std::f64::consts::LN_2 * (a * cut + b));
        let foot = raw(cut) - slope * cut;
        let scale = 1.0 / (raw(high.exp2()) - foot);
        Self { line: [slope * scale, 0.0, cut, 0.0], curve: [a, b, c * scale, (d - foot) * scale] }
    }

    /// The position of a linear value in a table.
    pub fn apply(&self, light: f64) -> f64 {
        let [slope, offset, end, _] = self.line;
        let [a, b, c, d] = self.curve;
        if light > end { c * (a * light + b).max(1e-30).log2() + d } else { slope * light + offset }
    }

    /// The inverse: the linear value at position `t` of a table.
    pub fn light(&self, t: f64) -> f64 {
        let [slope, offset, end, _] = self.line;
        let [a, b, c, d] = self.curve;
        if slope > 0.0 && t <= slope * end + offset { (t - offset) / slope } else { (((t - d) / c).exp2() - b) / a }
    }
}
