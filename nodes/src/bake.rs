//! Evaluates a chain of color nodes in double precision at the entries of a 3-D table.

use afterimage_graph::color::Chromaticities;
use glam::DVec3;

use crate::lift_gamma_gain::LiftGammaGain;
use crate::tone_map::ToneMap;
use crate::white_balance::WhiteBalance;
use afterimage_color::adaptation::luminance_weights;
use afterimage_color::lut::Lut;
use afterimage_color::shaper::Shape;

/// Maps display-linear light to the display signal. Both are 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Signal {
    Srgb,
    Gamma(f64),
    Linear,
}

impl Signal {
    fn encode(self, x: f64) -> f64 {
        match self {
            Self::Srgb if x <= 0.0031308 => 12.92 * x,
            Self::Srgb => 1.055 * x.powf(1.0 / 2.4) - 0.055,
            Self::Gamma(gamma) => x.powf(1.0 / gamma),
            Self::Linear => x,
        }
    }
}

/// White balance, tone curve, lift-gamma-gain and transfer function, each as in the node of that name.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) balance: WhiteBalance,
    pub(crate) curve: ToneMap,
    pub(crate) grade: LiftGammaGain,
    pub(crate) signal: Signal,
    /// The primaries of the display, and of the light at the axes of the table.
    pub(crate) display: Chromaticities,
}

impl Chain {
    /// Maps exposed light in the primaries of the display to its signal. After the balance the light is limited to
    /// these primaries.
    fn encoder(&self) -> impl Fn(DVec3) -> DVec3 {
        let rec709 = Chromaticities::REC709;
        let (enter, leave) = (self.display.conversion(&rec709), rec709.conversion(&self.display));
        let (balance, curve) = (leave * self.balance.matrix() * enter, self.curve.operator(&self.display));
        let weights = luminance_weights(&self.display);
        move |exposed| {
            let balanced = enter * (balance * exposed).max(DVec3::ZERO);
            let graded = self.grade.by_luminance(curve(balanced), weights).min(DVec3::ONE);
            DVec3::from(graded.to_array().map(|x| self.signal.encode(x)))
        }
    }

    /// Evaluates the chain at every entry of a table. `shape` spaces the axes of the table.
    pub(crate) fn bake(&self, size: usize, shape: Shape) -> Lut {
        let encode = self.encoder();
        let lights: Vec<f64> = (0..size).map(|step| shape.light(step as f64 / (size - 1) as f64)).collect();
        Lut::of(size, |steps| encode(DVec3::from(steps.map(|step| lights[step]))).as_vec3().to_array())
    }
}
