//! Image descriptions: formats, sizes and color states.

use serde::{Deserialize, Serialize};

/// The storage format of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Format {
    /// Four bytes, each 0..1 in steps of 1/255.
    Rgba8Unorm,
    /// One half float.
    R16Float,
    /// Two half floats.
    Rg16Float,
    /// Four half floats: the default of every intermediate.
    Rgba16Float,
    /// Three unsigned floats in four bytes: no sign, no alpha, 6 and 5 bits of mantissa.
    Rg11b10Ufloat,
    /// One float.
    R32Float,
    /// Four floats: the format of the reference of `measure`.
    Rgba32Float,
    /// A depth in two bytes, 0..1 in steps of 1/65535. Only drawing passes write it.
    Depth16Unorm,
    /// A depth as one float. Only drawing passes write it.
    Depth32Float,
    /// Three channels of ten bits and alpha of two, each 0..1, in four bytes.
    Rgb10a2Unorm,
}

impl Format {
    /// All formats of color, in a fixed order: those that pipeline files name.
    pub const ALL: [Self; 8] = [
        Self::Rgba8Unorm,
        Self::R16Float,
        Self::Rg16Float,
        Self::Rgba16Float,
        Self::Rg11b10Ufloat,
        Self::Rgb10a2Unorm,
        Self::R32Float,
        Self::Rgba32Float,
    ];

    /// Bytes of one texel.
    pub fn bytes(self) -> u64 {
        match self {
            Self::R16Float | Self::Depth16Unorm => 2,
            Self::Rgba8Unorm
            | Self::Rg16Float
            | Self::Rg11b10Ufloat
            | Self::Rgb10a2Unorm
            | Self::R32Float
            | Self::Depth32Float => 4,
            Self::Rgba16Float => 8,
            Self::Rgba32Float => 16,
        }
    }

    /// The name in WebGPU, and in WGSL storage textures, which hold no depth.
    pub fn wgsl(self) -> &'static str {
        match self {
            Self::Rgba8Unorm => "rgba8unorm",
            Self::R16Float => "r16float",
            Self::Rg16Float => "rg16float",
            Self::Rgba16Float => "rgba16float",
            Self::Rg11b10Ufloat => "rg11b10ufloat",
            Self::Rgb10a2Unorm => "rgb10a2unorm",
            Self::R32Float => "r32float",
            Self::Rgba32Float => "rgba32float",
            Self::Depth16Unorm => "depth16unorm",
            Self::Depth32Float => "depth32float",
        }
    }

    /// The name in pipeline files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgba8Unorm => "Rgba8Unorm",
            Self::R16Float => "R16Float",
            Self::Rg16Float => "Rg16Float",
            Self::Rgba16Float => "Rgba16Float",
            Self::Rg11b10Ufloat => "Rg11b10Ufloat",
            Self::Rgb10a2Unorm => "Rgb10a2Unorm",
            Self::R32Float => "R32Float",
            Self::Rgba32Float => "Rgba32Float",
            Self::Depth16Unorm => "Depth16Unorm",
            Self::Depth32Float => "Depth32Float",
        }
    }

    /// The format of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// The 32-bit float format with at least as many channels: the format of the reference of `measure`.
    pub fn exact(self) -> Self {
        match self {
            Self::R16Float | Self::R32Float => Self::R32Float,
            Self::Depth16Unorm | Self::Depth32Float => Self::Depth32Float,
            _ => Self::Rgba32Float,
        }
    }

    /// The next wider format, for a device or a pass that cannot store this one. Every chain ends in a format that all
    /// devices store.
    pub fn wider(self) -> Self {
        match self {
            Self::R16Float | Self::Depth16Unorm | Self::Depth32Float => Self::R32Float,
            Self::Rg16Float | Self::Rg11b10Ufloat | Self::Rgb10a2Unorm | Self::Rgba8Unorm => Self::Rgba16Float,
            other => other,
        }
    }

    /// Returns whether each channel has 32 bits. Many devices cannot filter these formats.
    pub fn is_32_bit(self) -> bool {
        matches!(self, Self::R32Float | Self::Rgba32Float | Self::Depth32Float)
    }

    /// Returns whether it holds a depth, which no device filters.
    pub fn is_depth(self) -> bool {
        matches!(self, Self::Depth16Unorm | Self::Depth32Float)
    }
}

/// Width, height and, for volumes, depth, in texels; never zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Size {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Depth in texels; 1 for an image.
    pub depth: u32,
}

impl Size {
    /// The size of an image; sides of 0 become 1.
    pub fn new(width: u32, height: u32) -> Self {
        Self::volume(width, height, 1)
    }

    /// The size of a volume; sides of 0 become 1.
    pub fn volume(width: u32, height: u32, depth: u32) -> Self {
        Self { width: width.max(1), height: height.max(1), depth: depth.max(1) }
    }

    /// Half of each side, rounded down, at least 1: the next level of a pyramid.
    pub fn half(self) -> Self {
        Self::new(self.width / 2, self.height / 2)
    }

    /// Each side divided by `by` and rounded up: the number of tiles that cover it.
    pub fn div_up(self, by: u32) -> Self {
        Self::new(self.width.div_ceil(by), self.height.div_ceil(by))
    }

    /// The number of texels.
    pub fn texels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * u64::from(self.depth)
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }

    /// The number of levels of a pyramid over this size: halvings until both sides are 1.
    pub fn levels(self) -> u32 {
        self.width.max(self.height).ilog2()
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)?;
        if self.depth > 1 { write!(f, "x{}", self.depth) } else { Ok(()) }
    }
}

/// The meaning of an image's numbers. Part of the type of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ColorState {
    /// Linear scene light in the Rec.709 basis, not exposed. Colors outside of Rec.709 have negative components.
    Scene,
    /// Scene light times 2^stops.
    Exposed,
    /// Base-2 logarithm of luminance.
    LogLuminance,
    /// Display-linear light, after the tone curve, in the primaries of the display; 1 is SDR white.
    DisplayLinear,
    /// After a transfer function, for a file or a display.
    Encoded,
    /// Numbers that are not light: depth, normals, masks.
    Data,
}

/// The negative numbers that an image may hold. Follows from its color state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Signedness {
    /// None: light of a display, and signals.
    Unsigned,
    /// Negative components of a luminance that is 0 or more: scene light outside of the triangle of Rec.709.
    Extended,
    /// Any: numbers that are not light, and logarithms.
    Signed,
}

impl ColorState {
    /// All states.
    pub const ALL: [Self; 6] =
        [Self::Scene, Self::Exposed, Self::LogLuminance, Self::DisplayLinear, Self::Encoded, Self::Data];

    /// The state of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }

    /// The negative numbers that an image of this state may hold.
    pub fn signedness(self) -> Signedness {
        match self {
            Self::Scene | Self::Exposed => Signedness::Extended,
            Self::DisplayLinear | Self::Encoded => Signedness::Unsigned,
            Self::LogLuminance | Self::Data => Signedness::Signed,
        }
    }

    /// The name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Exposed => "Exposed",
            Self::LogLuminance => "LogLuminance",
            Self::DisplayLinear => "DisplayLinear",
            Self::Encoded => "Encoded",
            Self::Data => "Data",
        }
    }
}

/// The description of an image: size, format, dimension and samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ImageDesc {
    /// Size in texels.
    pub size: Size,
    /// Storage of one texel.
    pub format: Format,
    /// True if the image is a volume (3-D). A volume may have depth 1.
    pub volume: bool,
    /// Samples of each pixel: 1, or more for a multisampled image, which a host gives or a drawing pass makes.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub samples: u32,
    /// Mip levels: 1, or more for an image that drawing passes fill level by level. Each has half the size of the one
    /// before.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub levels: u32,
    /// Layers: 1, or more for an array of images that drawing passes fill layer by layer.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub layers: u32,
}

fn one() -> u32 {
    1
}

fn is_one(count: &u32) -> bool {
    *count == 1
}

impl ImageDesc {
    /// An image in the default format, `Rgba16Float`.
    pub fn new(size: Size) -> Self {
        Self { size, format: Format::Rgba16Float, volume: false, samples: 1, levels: 1, layers: 1 }
    }

    /// A volume in the default format.
    pub fn volume(size: Size) -> Self {
        Self { volume: true, ..Self::new(size) }
    }

    /// The same description with another format.
    pub fn format(self, format: Format) -> Self {
        Self { format, ..self }
    }

    /// The same description with half the size.
    pub fn half(self) -> Self {
        Self { size: self.size.half(), ..self }
    }

    /// The same description with another size.
    pub fn sized(self, size: Size) -> Self {
        Self { size, ..self }
    }

    /// The same description with this many samples in each pixel.
    pub fn multisampled(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// The same description with this many mip levels.
    pub fn with_levels(self, levels: u32) -> Self {
        Self { levels, ..self }
    }

    /// The same description with this many layers.
    pub fn with_layers(self, layers: u32) -> Self {
        Self { layers, ..self }
    }

    /// One mip level of one layer: an image of its own size.
    pub fn level(self, level: u32) -> Self {
        let size = (0..level).fold(self.size, |size, _| size.half());
        Self { size, levels: 1, layers: 1, ..self }
    }

    /// Returns whether it is one image: one sample in each pixel, one mip level and one layer.
    pub fn is_plain(self) -> bool {
        self.samples == 1 && self.levels == 1 && self.layers == 1
    }

    /// The number of bytes of all texels, without padding by the driver.
    pub fn bytes(self) -> u64 {
        let sizes = std::iter::successors(Some(self.size), |size| Some(size.half()));
        let texels: u64 = match self.levels {
            1 => self.size.texels(),
            levels => sizes.take(levels as usize).map(Size::texels).sum(),
        };
        texels * self.format.bytes() * u64::from(self.samples) * u64::from(self.layers)
    }
}
