//! Numbers that can be compared and hashed.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

const STEPS: f64 = 1e6;

/// A number in steps of 1e-6, so that equal numbers are equal bits and can be hashed.
///
/// The steps are those of published chromaticities and of file formats, which are coarser. The nearest `f64` of a
/// number with at most six decimals survives the conversion, and that of its `f32` becomes that number up to 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Decimal(i64);

impl Decimal {
    /// The nearest step. NaN becomes 0, and numbers beyond ±9e12 become that limit.
    pub const fn new(value: f64) -> Self {
        Self((value * STEPS).round() as i64)
    }

    /// The number.
    pub const fn get(self) -> f64 {
        self.0 as f64 / STEPS
    }
}

impl From<f64> for Decimal {
    fn from(value: f64) -> Self {
        Self::new(value)
    }
}

impl From<f32> for Decimal {
    fn from(value: f32) -> Self {
        Self::new(f64::from(value))
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl Serialize for Decimal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.get())
    }
}

impl<'de> Deserialize<'de> for Decimal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        f64::deserialize(deserializer).map(Self::new)
    }
}
