//! Constants of the tone curves in double precision: for the curves on the CPU, and for the uniforms of the shaders.

use glam::{DMat3, DVec3, dvec3};

use crate::process::transfer::pq_encode;

/// The luminance that GT7's curve shows on SDR displays as white, in units of 100 cd/m².
pub const GT7_WHITE: f64 = 2.5;

/// The input matrix of Hill's fit, as published.
pub const HILL_IN: DMat3 = DMat3::from_cols(
    dvec3(0.59719, 0.07600, 0.02840),
    dvec3(0.35458, 0.90834, 0.13383),
    dvec3(0.04823, 0.01566, 0.83777),
);

/// The output matrix of Hill's fit, as published.
pub const HILL_OUT: DMat3 = DMat3::from_cols(
    dvec3(1.60475, -0.10208, -0.00327),
    dvec3(-0.53108, 1.10813, -0.07276),
    dvec3(-0.07367, -0.00605, 1.07602),
);

/// AgX's inset for Rec.2020, as published for the curve of HDR displays.
pub const AGX_IN_2020: DMat3 = DMat3::from_cols(
    dvec3(0.856627153315983, 0.137318972929847, 0.11189821299995),
    dvec3(0.0951212405381588, 0.761241990602591, 0.0767994186031903),
    dvec3(0.0482516061458583, 0.101439036467562, 0.811302368396859),
);

/// AgX's outset for Rec.2020: no inverse of the inset, but of one with less rotation.
pub const AGX_OUT_2020: DMat3 = DMat3::from_cols(
    dvec3(1.1271005818144368, -0.1413297634984383, -0.14132976349843826),
    dvec3(-0.11060664309660323, 1.157823702216272, -0.11060664309660294),
    dvec3(-0.016493938717834573, -0.016493938717834257, 1.2519364065950405),
);

/// The constants of the curve that replaces AgX's sigmoid on HDR displays (A. Pestaluky 2025, for Godot): up to middle
/// gray x^1.25 / (x^1.25 + toe), above it a shoulder after Reinhard that reaches the peak at 16.29 times the peak.
#[derive(Clone, Copy, Debug)]
pub struct AgxHdr {
    pub toe: f64,
    /// The slope at middle gray.
    pub slope: f64,
    /// From middle gray to the peak.
    pub rise: f64,
    /// The factor that makes the shoulder end at the peak.
    pub white: f64,
}

/// The contrast of AgX's curve for HDR displays.
const AGX_CONTRAST: f64 = 1.25;

/// The end of the toe of AgX's curve for HDR displays.
const AGX_GRAY: f64 = 0.18;

impl AgxHdr {
    pub fn new(peak: f64) -> Self {
        let power = AGX_GRAY.powf(AGX_CONTRAST);
        let toe = (1.0 / AGX_GRAY - 1.0) * power;
        let slope = AGX_CONTRAST * power / AGX_GRAY * toe / (power + toe).powi(2);
        let rise = peak - AGX_GRAY;
        let white = (16.29 * peak - AGX_GRAY).powi(2) * slope / rise;
        Self { toe, slope, rise, white }
    }

    pub fn apply(self, x: f64) -> f64 {
        if x < AGX_GRAY {
            let power = x.powf(AGX_CONTRAST);
            return power / (power + self.toe);
        }
        let above = x - AGX_GRAY;
        let line = self.slope * above;
        AGX_GRAY + (line * (1.0 + above / self.white) / (1.0 + line / self.rise)).min(self.rise)
    }
}

/// The constants of Uchimura's curve that follow from its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Shoulder {
    /// The beginning of the linear part; above 0.
    pub line_from: f64,
    /// The beginning of the shoulder.
    pub from: f64,
    /// The limit of the curve for large values.
    pub limit: f64,
    /// The distance from the shoulder's beginning to the limit.
    pub gap: f64,
    /// The rate at which the shoulder approaches the limit.
    pub steepness: f64,
}

impl Shoulder {
    /// From maximum P, contrast a, linear start m and linear length l. The length is limited, so that room for a
    /// shoulder remains.
    pub fn new(maximum: f64, contrast: f64, start: f64, length: f64) -> Self {
        let line_from = start.max(1e-4);
        let line = (maximum - line_from) * length.min(0.999) / contrast;
        let gap = maximum - (line_from + contrast * line);
        Self { line_from, from: line_from + line, limit: maximum, gap, steepness: contrast / gap }
    }
}

/// A look of AgX: slope, power and saturation.
#[derive(Clone, Copy, Debug)]
pub struct Agx {
    pub slope: DVec3,
    pub power: f64,
    pub saturation: f64,
}

impl Agx {
    pub const BASE: Self = Self { slope: DVec3::ONE, power: 1.0, saturation: 1.0 };
    pub const PUNCHY: Self = Self { slope: DVec3::ONE, power: 1.35, saturation: 1.4 };
    pub const GOLDEN: Self = Self { slope: dvec3(1.0, 0.9, 0.5), power: 0.8, saturation: 0.8 };
}

/// The constants of GT7's curve for a display.
#[derive(Clone, Copy, Debug)]
pub struct Gt7 {
    /// The peak of the display in units of 100 cd/m².
    pub peak: f64,
    /// Above the linear part: `offset + scale * exp(rate * x)`.
    pub offset: f64,
    pub scale: f64,
    pub rate: f64,
    /// The ICtCp intensity of white at the peak.
    pub intensity: f64,
}

impl Gt7 {
    pub fn new(peak: f64) -> Self {
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

/// The tone scale of ACES 2.0: for luminance x, with f = factor * (x / (x + offset))^1.15, the result is
/// f² / (f + 0.04).
#[derive(Clone, Copy, Debug)]
pub struct Aces2Tone {
    /// The result for middle gray.
    pub gray: f64,
    pub factor: f64,
    pub offset: f64,
}

/// The contrast of the tone scale.
const ACES2_CONTRAST: f64 = 1.15;

/// The toe of the tone scale: what it subtracts from large values.
const ACES2_TOE: f64 = 0.04;

impl Aces2Tone {
    /// For a display with this peak in cd/m², with the constants of the Academy's `init_TonescaleParams`. The result is
    /// in units of 100 cd/m².
    pub fn new(peak: f64) -> Self {
        let before_toe = |y: f64| 0.5 * (y + (y * (y + 4.0 * ACES2_TOE)).sqrt());
        let power = |x: f64| (x / (x + 1.0)).powf(ACES2_CONTRAST);
        let hit = Self::hit(peak);
        let gray = 0.10013 * (1.0 + 0.14 * (peak / 100.0).log2());
        let top = before_toe(peak / 100.0);
        let share = (before_toe(gray) / (top / power(hit / top))).powf(1.0 / ACES2_CONTRAST);
        let offset = 0.18 * (1.0 - share) / share;
        let factor = top / power(hit / offset);
        Self { gray, factor, offset }
    }

    /// The luminance that is mapped to the peak.
    pub fn hit(peak: f64) -> f64 {
        128.0 + (896.0 - 128.0) * (peak / 100.0).ln() / 100.0_f64.ln()
    }

    /// The result for luminance of 0 or more.
    pub fn apply(self, x: f64) -> f64 {
        let f = self.factor * (x / (x + self.offset)).powf(ACES2_CONTRAST);
        f * f / (f + ACES2_TOE)
    }
}
