//! The transfer functions of HDR, in double precision.

use afterimage_graph::color::{LUMINANCE_REC2020, Transfer, hlg_gamma};
use glam::DVec3;

use super::curves::{each, power};

/// Luminance in cd/m2, limited to 0 to 10000, to the perceptual quantizer.
pub fn pq_encode(nits: f64) -> f64 {
    Transfer::Pq.to_signal(nits / 10000.0)
}

/// The perceptual quantizer, limited to 0 to 1, to luminance in cd/m2.
pub fn pq_decode(signal: f64) -> f64 {
    10000.0 * Transfer::Pq.to_light(signal)
}

/// Hybrid log-gamma on a display (ITU-R BT.2100): the luminances of a linear value of 1 and of a signal of 1, in cd/m2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hlg {
    pub white: f64,
    pub peak: f64,
}

impl Hlg {
    /// The exponents of luminance from the scene to the display, and back.
    pub fn powers(&self) -> [f64; 2] {
        let gamma = hlg_gamma(self.peak);
        [gamma - 1.0, (1.0 - gamma) / gamma]
    }

    pub(super) fn encode(&self, light: DVec3) -> DVec3 {
        let bounded = (light * (self.white / self.peak)).clamp(DVec3::ZERO, DVec3::ONE);
        let scene = bounded * power(bounded.dot(LUMINANCE_REC2020.into()).max(1e-30), self.powers()[1]);
        each(scene, |_, x| Transfer::Hlg.to_signal(x))
    }

    pub(super) fn decode(&self, signal: DVec3) -> DVec3 {
        let scene = each(signal, |_, x| Transfer::Hlg.to_light(x));
        scene * power(scene.dot(LUMINANCE_REC2020.into()), self.powers()[0]) * (self.peak / self.white)
    }
}
