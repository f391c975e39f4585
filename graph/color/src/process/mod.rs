//! Processes: color operations in a row, evaluated in double precision or written as WGSL.
//!
//! A `ColorLut` runs a file in Common LUT Format, and the conversions around a table, as processes. Values between two
//! steps are limited to ±1e12, so that 32 bits hold them.

mod cdl;
mod conversion;
mod curves;
mod encoding;
mod lookup;
mod spaces;
pub mod transfer;
mod wgsl;

use glam::DVec3;

pub use cdl::CdlStep;
pub use conversion::Conversion;
pub use conversion::LutState;
pub use curves::{Antilog, LIMIT, Logarithm, Power};
pub use encoding::Encoding;
pub use spaces::LutSpace;
pub use transfer::Hlg;
pub use wgsl::{Parts, function};

use crate::lut::{ColorCorrection, Interpolation, Lut, Table};
use crate::shaper::Shape;
use curves::each;

/// Color operations in a row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Process {
    pub steps: Vec<Step>,
}

/// One color operation.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Rows of factors for red, green and blue, and an offset.
    Matrix([[f64; 4]; 3]),
    /// `x * slope + offset`, limited to `low` and `high`.
    Range { slope: f64, offset: f64, low: f64, high: f64 },
    /// A color decision list.
    Cdl(CdlStep),
    /// A logarithm per channel.
    Logarithm([Logarithm; 3]),
    /// An exponential per channel.
    Antilog([Antilog; 3]),
    /// A power per channel.
    Power([Power; 3]),
    /// Light, in units of the white of this luminance in cd/m2, to the perceptual quantizer.
    PqEncode(f64),
    /// The reverse.
    PqDecode(f64),
    /// Light to hybrid log-gamma.
    HlgEncode(Hlg),
    /// The reverse.
    HlgDecode(Hlg),
    /// A shaper of `ColorLut`.
    Shape(Shape),
    /// A 1-D table per channel.
    Curve(Table),
    /// A 1-D table per channel with one entry for each code of a half float.
    HalfCurve(Vec<[f32; 3]>),
    /// A 3-D table.
    Cube(Table, Interpolation),
}

impl Process {
    /// A process without the steps that change nothing.
    pub fn new(steps: impl IntoIterator<Item = Step>) -> Self {
        Self { steps: steps.into_iter().filter(|step| !step.is_identity()).collect() }
    }

    /// The process of a table: its 1-D table, then its 3-D table.
    pub fn of_table(lut: &Lut, interpolation: Interpolation) -> Self {
        let curve = lut.curve.clone().map(Step::Curve);
        let cube = lut.cube.clone().map(|table| Step::Cube(table, interpolation));
        Self { steps: curve.into_iter().chain(cube).collect() }
    }

    /// The result for a color, in double precision. The GPU computes the same in 32 bits.
    pub fn apply(&self, rgb: [f64; 3]) -> [f64; 3] {
        let bounded = |v: DVec3| v.clamp(DVec3::splat(-LIMIT), DVec3::splat(LIMIT));
        self.steps.iter().fold(DVec3::from(rgb), |v, step| bounded(step.apply(v))).to_array()
    }
}

impl From<ColorCorrection> for Process {
    /// The correction as the node `Cdl` computes it: without limits.
    fn from(correction: ColorCorrection) -> Self {
        Self::new([Step::Cdl(correction.into())])
    }
}

impl Step {
    /// A matrix without an offset.
    pub fn matrix(matrix: glam::DMat3) -> Self {
        Self::Matrix([0, 1, 2].map(|row| matrix.row(row).extend(0.0).to_array()))
    }

    /// Limits every channel.
    pub fn limits(low: f64, high: f64) -> Self {
        Self::Range { slope: 1.0, offset: 0.0, low, high }
    }

    fn apply(&self, v: DVec3) -> DVec3 {
        match self {
            Self::Matrix(rows) => DVec3::from(rows.map(|row| glam::DVec4::from(row).dot(v.extend(1.0)))),
            Self::Range { slope, offset, low, high } => {
                (v * *slope + *offset).clamp(DVec3::splat(*low), DVec3::splat(*high))
            }
            Self::Cdl(cdl) => cdl.apply(v),
            Self::Logarithm(curves) => each(v, |channel, x| curves[channel].apply(x)),
            Self::Antilog(curves) => each(v, |channel, x| curves[channel].apply(x)),
            Self::Power(curves) => each(v, |channel, x| curves[channel].apply(x)),
            Self::PqEncode(white) => each(v, |_, x| transfer::pq_encode(x * white)),
            Self::PqDecode(white) => each(v, |_, x| transfer::pq_decode(x) / white),
            Self::HlgEncode(hlg) => hlg.encode(v),
            Self::HlgDecode(hlg) => hlg.decode(v),
            Self::Shape(shape) => each(v, |_, x| shape.apply(x)),
            Self::Curve(table) => each(v, |channel, x| lookup::curve(table, channel, x)),
            Self::HalfCurve(entries) => each(v, |channel, x| lookup::half_curve(entries, channel, x)),
            Self::Cube(table, interpolation) => lookup::cube(table, *interpolation, v),
        }
    }

    fn is_identity(&self) -> bool {
        const UNIT: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        match self {
            Self::Matrix(rows) => *rows == UNIT,
            Self::Range { slope, offset, low, high } => {
                *slope == 1.0 && *offset == 0.0 && *low <= -LIMIT && *high >= LIMIT
            }
            Self::Cdl(cdl) => cdl.is_identity(),
            Self::Power(curves) => curves.iter().all(Power::is_identity),
            _ => false,
        }
    }
}
