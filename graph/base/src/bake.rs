//! Tables of colors in the place of point nodes.

use std::fmt::{self, Display};

use serde::Serialize;

/// True if a run of nodes whose results depend on the color of a pixel alone becomes a table of colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub enum Bake {
    /// The node is computed for every pixel.
    Off,
    /// A table, in the size that is enough for 8 bits.
    Auto,
    /// A table with this many levels of each channel: one of [`SIZES`](Self::SIZES).
    Size(u32),
}

impl Bake {
    /// The sizes of tables.
    pub const SIZES: [u32; 3] = [33, 48, 64];

    /// The size of the table; `None` without one.
    pub fn size(self) -> Option<u32> {
        match self {
            Self::Off => None,
            Self::Auto => Some(64),
            Self::Size(size) => Some(size),
        }
    }

    /// The value with this name: `Off`, `Auto`, or a size.
    pub fn named(name: &str) -> Option<Self> {
        let sizes = Self::SIZES.map(Self::Size);
        [Self::Off, Self::Auto].into_iter().chain(sizes).find(|bake| bake.to_string() == name)
    }
}

impl Display for Bake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("Off"),
            Self::Auto => f.write_str("Auto"),
            Self::Size(size) => write!(f, "{size}"),
        }
    }
}
