//! Formulas of blending, in f64.

use afterimage_graph::node::{Blend, BlendComponent, BlendFactor, Factors, WriteMask};
use afterimage_graph::prelude::*;

choices! {
    /// The blending of triangles.
    pub enum Mode {
        /// Not at all.
        Replace,
        /// Over, with colors that are multiplied with alpha.
        Over,
        /// Over, with colors that are not.
        StraightOver,
        /// The sum.
        Sum,
        /// The product.
        Product,
        /// The smaller one.
        Smaller,
        /// The larger one.
        Larger,
        /// The difference of colors, and the other difference of alphas.
        Difference,
        /// Colors are added, and the larger alpha stays.
        Apart,
        /// By the target's alpha.
        Under,
        /// By colors.
        Colored,
    }
}

/// Factors that no constant has.
const UNDER: Factors = Factors { source: BlendFactor::OneMinusTargetAlpha, target: BlendFactor::TargetAlpha };
const COLORED: Factors = Factors { source: BlendFactor::Target, target: BlendFactor::OneMinusSource };
const TINTED: Factors = Factors { source: BlendFactor::OneMinusTarget, target: BlendFactor::Zero };

/// The modes by name.
pub const MODES: [(&str, Blend); 11] = [
    ("Replace", Blend::REPLACE),
    ("Over", Blend::OVER),
    ("StraightOver", Blend::STRAIGHT_OVER),
    ("Sum", Blend::ADD),
    ("Product", Blend::MULTIPLY),
    ("Smaller", Blend::MIN),
    ("Larger", Blend::MAX),
    (
        "Difference",
        Blend {
            color: BlendComponent::Subtract(Factors { source: BlendFactor::One, target: BlendFactor::One }),
            alpha: BlendComponent::ReverseSubtract(Factors { source: BlendFactor::One, target: BlendFactor::One }),
        },
    ),
    ("Apart", Blend { color: Blend::ADD.color, alpha: BlendComponent::Max }),
    ("Under", Blend::all(BlendComponent::Add(UNDER))),
    ("Colored", Blend { color: BlendComponent::Add(COLORED), alpha: BlendComponent::Add(TINTED) }),
];

impl Mode {
    pub fn blend(self) -> Blend {
        MODES[self as usize].1
    }
}

/// The numbers of the four channels that a factor stands for.
fn factor(factor: BlendFactor, source: [f64; 4], target: [f64; 4]) -> [f64; 4] {
    let less = |numbers: [f64; 4]| numbers.map(|number| 1.0 - number);
    match factor {
        BlendFactor::Zero => [0.0; 4],
        BlendFactor::One => [1.0; 4],
        BlendFactor::Source => source,
        BlendFactor::OneMinusSource => less(source),
        BlendFactor::SourceAlpha => [source[3]; 4],
        BlendFactor::OneMinusSourceAlpha => [1.0 - source[3]; 4],
        BlendFactor::Target => target,
        BlendFactor::OneMinusTarget => less(target),
        BlendFactor::TargetAlpha => [target[3]; 4],
        BlendFactor::OneMinusTargetAlpha => [1.0 - target[3]; 4],
    }
}

/// The formulas of blending: WebGPU, "Blend State".
pub fn blended(blend: Blend, source: [f64; 4], target: [f64; 4]) -> [f64; 4] {
    let scaled = |factors: Factors, channel: usize| {
        let [of_source, of_target] = [factors.source, factors.target].map(|kind| factor(kind, source, target)[channel]);
        (source[channel] * of_source, target[channel] * of_target)
    };
    [0, 1, 2, 3].map(|channel| match if channel < 3 { blend.color } else { blend.alpha } {
        BlendComponent::Add(factors) => {
            let (source, target) = scaled(factors, channel);
            source + target
        }
        BlendComponent::Subtract(factors) => {
            let (source, target) = scaled(factors, channel);
            source - target
        }
        BlendComponent::ReverseSubtract(factors) => {
            let (source, target) = scaled(factors, channel);
            target - source
        }
        BlendComponent::Min => source[channel].min(target[channel]),
        BlendComponent::Max => source[channel].max(target[channel]),
    })
}

choices! {
    /// The channels that are written.
    pub enum Written {
        /// All.
        Everything,
        /// Red, green and blue.
        Colors,
        /// Alpha.
        Alphas,
        /// Green.
        Green,
    }
}

/// The masks by name.
pub const MASKS: [(&str, WriteMask); 4] = [
    ("Everything", WriteMask::ALL),
    ("Colors", WriteMask::COLOR),
    ("Alphas", WriteMask::ALPHA),
    ("Green", WriteMask([false, true, false, false])),
];
