//! The color decision list of the American Society of Cinematographers, version 1.2, with and without limits.

use glam::DVec3;

use super::curves::{LIMIT, each, power};
use crate::adaptation::LUMINANCE;
use crate::lut::ColorCorrection;

/// A color decision list and the direction in which it is applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CdlStep {
    /// Factor of each channel; of the reverse, its reciprocal.
    pub slope: DVec3,
    /// Added after the slope; of the reverse, subtracted before its reciprocal.
    pub offset: DVec3,
    /// Exponent of each channel; of the reverse, its reciprocal.
    pub power: DVec3,
    /// Factor of the distance from gray; of the reverse, its reciprocal.
    pub saturation: f64,
    /// True if values are limited to 0 to 1.
    pub is_limited: bool,
    /// True if the list is inverted.
    pub is_reverse: bool,
}

impl From<ColorCorrection> for CdlStep {
    /// Without limits.
    fn from(correction: ColorCorrection) -> Self {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        Self {
            slope: wide(correction.slope),
            offset: wide(correction.offset),
            power: wide(correction.power),
            saturation: f64::from(correction.saturation),
            is_limited: false,
            is_reverse: false,
        }
    }
}

impl CdlStep {
    /// The list that undoes this one. No component of the slope and not the saturation may be 0.
    pub fn reversed(self) -> Self {
        Self {
            slope: self.slope.recip(),
            power: self.power.recip(),
            saturation: self.saturation.recip(),
            is_reverse: true,
            ..self
        }
    }

    /// The limits of the values.
    pub fn limits(&self) -> [f64; 2] {
        if self.is_limited { [0.0, 1.0] } else { [-LIMIT, LIMIT] }
    }

    pub(super) fn apply(&self, v: DVec3) -> DVec3 {
        let [low, high] = self.limits();
        let limited = |v: DVec3| v.clamp(DVec3::splat(low), DVec3::splat(high));
        // Values below 0 skip the power.
        let powered = |v: DVec3| each(v, |channel, x| if x < 0.0 { x } else { power(x, self.power[channel]) });
        let saturated = |v: DVec3| DVec3::splat(v.dot(LUMINANCE)) * (1.0 - self.saturation) + v * self.saturation;
        if self.is_reverse {
            let base = powered(limited(saturated(limited(v))));
            limited((base - self.offset) * self.slope)
        } else {
            limited(saturated(powered(limited(v * self.slope + self.offset))))
        }
    }

    pub(super) fn is_identity(&self) -> bool {
        let neutral = self.slope == DVec3::ONE && self.offset == DVec3::ZERO && self.power == DVec3::ONE;
        neutral && self.saturation == 1.0 && !self.is_limited
    }
}
