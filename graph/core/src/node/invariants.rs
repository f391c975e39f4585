//! Invariants of a node's results.

/// Invariants of a node's results beyond finite numbers. `afterimage stress` tests them.
///
/// A node that does not keep the [default](Self::DEFAULT) declares what it does keep:
///
/// ```
/// use afterimage_graph::prelude::*;
/// // A vignette: a constant image becomes darker toward its corners.
/// const INVARIANTS: Invariants = Invariants { constant: false, ..Invariants::DEFAULT };
/// assert!(INVARIANTS.symmetric);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Invariants {
    /// A constant image comes out constant.
    pub constant: bool,
    /// A constant image comes out as it is.
    pub keeps_constant: bool,
    /// An image that equals its mirror image from left to right still does.
    pub symmetric: bool,
    /// The mean of all pixels stays the same, also in a smaller image, where all pixels near the border are black.
    pub keeps_sum: bool,
    /// A brighter pixel stays brighter: what a monotone curve does.
    pub monotone: bool,
    /// An image without negative numbers gets none.
    pub non_negative: bool,
    /// Traces of earlier frames in a history fade away.
    pub settles: bool,
    /// The result is an exposure in stops that falls as the frames get brighter.
    pub is_exposure: bool,
    /// Red, green and blue of a pixel follow from those of the same pixel of the input alone, and alpha stays. A table
    /// can take the place of such a node.
    pub of_color: bool,
}

impl Invariants {
    /// Only what the color state of a result demands: what a node promises that declares nothing.
    pub const NONE: Self = Self {
        constant: false,
        keeps_constant: false,
        symmetric: false,
        keeps_sum: false,
        monotone: false,
        non_negative: true,
        settles: false,
        is_exposure: false,
        of_color: false,
    };

    /// Invariants of most nodes: constant and symmetric images stay so, no number becomes negative, and
    /// histories settle.
    pub const DEFAULT: Self = Self { constant: true, symmetric: true, settles: true, ..Self::NONE };

    /// [`DEFAULT`](Self::DEFAULT), and the color of a pixel follows from its color.
    pub const OF_COLOR: Self = Self { of_color: true, ..Self::DEFAULT };
}
