//! Constants of the tone curves in double precision: for the curves on the CPU, and for the uniforms of the shaders.

use glam::{DMat3, DVec3, dvec3};

/// The input matrix of Hill's fit, as published.
pub(crate) const HILL_IN: DMat3 = DMat3::from_cols(
    dvec3(0.59719, 0.07600, 0.02840),
    dvec3(0.35458, 0.90834, 0.13383),
    dvec3(0.04823, 0.01566, 0.83777),
);

/// The output matrix of Hill's fit, as published.
pub(crate) const HILL_OUT: DMat3 = DMat3::from_cols(
    dvec3(1.60475, -0.10208, -0.00327),
    dvec3(-0.53108, 1.10813, -0.07276),
    dvec3(-0.07367, -0.00605, 1.07602),
);

/// The constants of Uchimura's curve that follow from its parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shoulder {
    /// Where the linear part begins; above 0.
    pub(crate) line_from: f64,
    /// Where the shoulder begins.
    pub(crate) from: f64,
    /// The limit of the curve for bright light.
    pub(crate) limit: f64,
    /// The distance from the shoulder's beginning to the limit.
    pub(crate) gap: f64,
    /// The rate at which the shoulder approaches the limit.
    pub(crate) steepness: f64,
}

impl Shoulder {
    /// From maximum P, contrast a, linear start m and linear length l. The length is limited, so that room for a
    /// shoulder remains.
    pub(crate) fn new(maximum: f64, contrast: f64, start: f64, length: f64) -> Self {
        let line_from = start.max(1e-4);
        let line = (maximum - line_from) * length.min(0.999) / contrast;
        let gap = maximum - (line_from + contrast * line);
        Self { line_from, from: line_from + line, limit: maximum, gap, steepness: contrast / gap }
    }
}

/// A look of AgX: slope, power and saturation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Agx {
    pub(crate) slope: DVec3,
    pub(crate) power: f64,
    pub(crate) saturation: f64,
}

impl Agx {
    pub(crate) const BASE: Self = Self { slope: DVec3::ONE, power: 1.0, saturation: 1.0 };
    pub(crate) const PUNCHY: Self = Self { slope: DVec3::ONE, power: 1.35, saturation: 1.4 };
    pub(crate) const GOLDEN: Self = Self { slope: dvec3(1.0, 0.9, 0.5), power: 0.8, saturation: 0.8 };
}

/// The constants of GT7's curve for a display.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gt7 {
    /// The peak of the display in units of 100 cd/m².
    pub(crate) peak: f64,
    /// Above the linear part: `offset + scale * exp(rate * x)`.
    pub(crate) offset: f64,
    pub(crate) scale: f64,
    pub(crate) rate: f64,
    /// The ICtCp intensity of white at the peak.
    pub(crate) intensity: f64,
}

impl Gt7 {
    pub(crate) fn new(peak: f64) -> Self {
        let k = (0.444 - 1.0) / (0.25 - 1.0);
        Self {
            peak,
            offset: peak * (0.444 + k),
            scale: -peak * k * (0.444_f64 / k).exp(),
            rate: -1.0 / (k * peak),
            intensity: pq_encode(100.0 * peak),
        }
    }
}

/// cd/m² to PQ (SMPTE ST 2084).
pub(crate) fn pq_encode(nits: f64) -> f64 {
    let y = (nits.max(0.0) / 10000.0).powf(2610.0 / 16384.0);
    ((0.8359375 + 18.8515625 * y) / (1.0 + 18.6875 * y)).powf(78.84375)
}
