//! Functions of one channel: logarithms, exponentials and powers, each with a linear part.

use glam::DVec3;

/// The largest magnitude of a value between two steps.
pub const LIMIT: f64 = 1e12;

/// The smallest argument of a logarithm: the smallest normal number in 32 bits, as the Common LUT Format states.
const SMALLEST: f64 = f32::MIN_POSITIVE as f64;

/// Applies a function of the channel and its value to every channel.
pub(super) fn each(v: DVec3, f: impl Fn(usize, f64) -> f64) -> DVec3 {
    DVec3::new(f(0, v.x), f(1, v.y), f(2, v.z))
}

/// `x^exponent` for x above 0, else 0. Limited to 2^40.
pub(super) fn power(x: f64, exponent: f64) -> f64 {
    match x > 0.0 {
        true if exponent == 1.0 => x,
        true => exp2(exponent * x.max(SMALLEST).log2()),
        false => 0.0,
    }
}

/// `2^x`, limited to 2^40.
fn exp2(x: f64) -> f64 {
    x.clamp(-126.0, 40.0).exp2()
}

/// `slope * x + offset` up to `end`, `scale * log2(a * x + b) + shift` above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logarithm {
    pub slope: f64,
    pub offset: f64,
    pub end: f64,
    pub a: f64,
    pub b: f64,
    pub scale: f64,
    pub shift: f64,
}

impl Logarithm {
    pub(super) fn apply(&self, x: f64) -> f64 {
        match x <= self.end {
            true => self.slope * x + self.offset,
            false => self.curve(x),
        }
    }

    /// The logarithmic part.
    pub fn curve(&self, x: f64) -> f64 {
        self.scale * (self.a * x + self.b).max(SMALLEST).log2() + self.shift
    }

    pub fn inverse(&self) -> Antilog {
        let end = if self.end > -LIMIT { self.slope * self.end + self.offset } else { self.end };
        Antilog {
            slope: self.slope.recip(),
            offset: -self.offset / self.slope,
            end,
            a: self.scale.recip(),
            b: -self.shift / self.scale,
            scale: self.a.recip(),
            shift: -self.b / self.a,
        }
    }
}

/// `slope * x + offset` up to `end`, `scale * 2^(a * x + b) + shift` above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antilog {
    pub slope: f64,
    pub offset: f64,
    pub end: f64,
    pub a: f64,
    pub b: f64,
    pub scale: f64,
    pub shift: f64,
}

impl Antilog {
    pub(super) fn apply(&self, x: f64) -> f64 {
        match x <= self.end {
            true => self.slope * x + self.offset,
            false => self.scale * exp2(self.a * x + self.b) + self.shift,
        }
    }
}

/// `slope * x` below `end`, `scale * (a * x + b)^exponent + shift` from it on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    pub slope: f64,
    pub end: f64,
    pub a: f64,
    pub b: f64,
    pub exponent: f64,
    pub scale: f64,
    pub shift: f64,
    /// True if the function of -x is minus the function of x.
    pub is_mirrored: bool,
}

impl Power {
    /// `x^exponent` from 0 on, `slope * x` below.
    pub fn plain(exponent: f64, slope: f64) -> Self {
        Self { slope, end: 0.0, a: 1.0, b: 0.0, exponent, scale: 1.0, shift: 0.0, is_mirrored: false }
    }

    /// The same with minus the function of x for -x.
    pub fn mirrored(self) -> Self {
        Self { is_mirrored: true, ..self }
    }

    pub(super) fn apply(&self, x: f64) -> f64 {
        match self.is_mirrored {
            true => self.straight(x.abs()) * if x < 0.0 { -1.0 } else { 1.0 },
            false => self.straight(x),
        }
    }

    fn straight(&self, x: f64) -> f64 {
        match x < self.end {
            true => self.slope * x,
            false => self.scale * power(self.a * x + self.b, self.exponent) + self.shift,
        }
    }

    pub(super) fn is_identity(&self) -> bool {
        let neutral = Self::plain(1.0, 1.0);
        *self == neutral || *self == neutral.mirrored()
    }
}
