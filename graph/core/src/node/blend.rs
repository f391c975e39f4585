//! Blending as data: how what a fragment gives is combined with what an attachment holds.

use serde::Serialize;

/// Blending of fragments with a color attachment. The source is the value of a fragment, the target what is there. One
/// draw after the other is blended, and in a draw one triangle after the other, in the order of the buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Blend {
    /// For red, green and blue.
    pub color: BlendComponent,
    /// For alpha.
    pub alpha: BlendComponent,
}

/// Blending of the color channels, or of alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum BlendComponent {
    /// source × factor + target × factor.
    Add(Factors),
    /// source × factor − target × factor.
    Subtract(Factors),
    /// target × factor − source × factor.
    ReverseSubtract(Factors),
    /// The smaller one.
    Min,
    /// The larger one.
    Max,
}

/// Factors of source and target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Factors {
    /// For the source.
    pub source: BlendFactor,
    /// For the target.
    pub target: BlendFactor,
}

/// Factor of the source or the target. A format without alpha has an alpha of 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum BlendFactor {
    /// 0.
    Zero,
    /// 1.
    One,
    /// The source, channel by channel.
    Source,
    /// 1 less the source.
    OneMinusSource,
    /// The alpha of the source.
    SourceAlpha,
    /// 1 less the alpha of the source.
    OneMinusSourceAlpha,
    /// The target, channel by channel.
    Target,
    /// 1 less the target.
    OneMinusTarget,
    /// The alpha of the target.
    TargetAlpha,
    /// 1 less the alpha of the target.
    OneMinusTargetAlpha,
}

/// The channels that a draw writes: red, green, blue, alpha. The others stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct WriteMask(pub [bool; 4]);

impl Default for Blend {
    fn default() -> Self {
        Self::REPLACE
    }
}

impl Default for WriteMask {
    fn default() -> Self {
        Self::ALL
    }
}

impl Blend {
    /// The source takes the place of the target.
    pub const REPLACE: Self = Self::all(BlendComponent::REPLACE);
    /// The source over the target, of colors that are multiplied with their alpha: Porter and Duff, "Compositing
    /// Digital Images", 1984.
    pub const OVER: Self = Self::all(BlendComponent::OVER);
    /// The source over the target, of colors that are not multiplied with their alpha.
    pub const STRAIGHT_OVER: Self = Self {
        color: BlendComponent::add(BlendFactor::SourceAlpha, BlendFactor::OneMinusSourceAlpha),
        alpha: BlendComponent::OVER,
    };
    /// The sum: added radiance.
    pub const ADD: Self = Self::all(BlendComponent::add(BlendFactor::One, BlendFactor::One));
    /// The product: a filter.
    pub const MULTIPLY: Self = Self::all(BlendComponent::add(BlendFactor::Zero, BlendFactor::Source));
    /// The smaller one, channel by channel.
    pub const MIN: Self = Self::all(BlendComponent::Min);
    /// The larger one, channel by channel.
    pub const MAX: Self = Self::all(BlendComponent::Max);

    /// The same for colors and alpha.
    pub const fn all(component: BlendComponent) -> Self {
        Self { color: component, alpha: component }
    }

    /// Returns whether finite numbers stay finite. A sum of halves may be larger than the largest half.
    pub fn stays_finite(self) -> bool {
        [self.color, self.alpha]
            .into_iter()
            .all(|component| matches!(component, BlendComponent::REPLACE | BlendComponent::Min | BlendComponent::Max))
    }
}

impl BlendComponent {
    /// The source.
    pub const REPLACE: Self = Self::add(BlendFactor::One, BlendFactor::Zero);
    /// The source over the target.
    pub const OVER: Self = Self::add(BlendFactor::One, BlendFactor::OneMinusSourceAlpha);

    /// The sum with these factors.
    pub const fn add(source: BlendFactor, target: BlendFactor) -> Self {
        Self::Add(Factors { source, target })
    }
}

impl WriteMask {
    /// All channels.
    pub const ALL: Self = Self([true; 4]);
    /// Red, green and blue.
    pub const COLOR: Self = Self([true, true, true, false]);
    /// Alpha.
    pub const ALPHA: Self = Self([false, false, false, true]);
}
