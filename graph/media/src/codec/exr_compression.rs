//! Compressions of EXR files.

use exr::meta::attribute::{Compression, SampleType};

use super::format::listed;

listed! {
    /// Ways to pack an EXR file.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum ExrCompression {
        /// Not packed: the fastest to write, the largest.
        None,
        /// Run lengths, for flat areas.
        Rle,
        /// Deflate, row by row.
        Zips,
        /// Deflate, sixteen rows at a time.
        #[default]
        Zip,
        /// Wavelets and Huffman codes: the smallest lossless one for grainy pictures.
        Piz,
        /// Deflate after differences, sixteen rows at a time; floats lose their last eight bits.
        Pxr24,
        /// Halves become blocks of a fixed size, with losses.
        B44,
        /// The same, with smaller blocks for flat areas.
        B44a,
        /// Cosines, with losses, 32 rows at a time.
        Dwaa,
        /// Cosines, with losses, 256 rows at a time.
        Dwab,
    }
}

impl ExrCompression {
    /// The name that OpenEXR has for it.
    pub fn name(self) -> &'static str {
        compression_name(self.method())
    }

    /// The one with that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|known| known.name() == name)
    }

    /// Rows that it packs together.
    pub fn block_rows(self) -> u32 {
        self.method().scan_lines_per_block() as u32
    }

    /// True if numbers of that type come back as they were.
    pub(crate) fn is_lossless_for(self, samples: SampleType) -> bool {
        self.method().is_lossless_for(samples)
    }

    /// The same for the `exr` crate.
    pub(crate) fn method(self) -> Compression {
        match self {
            Self::None => Compression::Uncompressed,
            Self::Rle => Compression::RLE,
            Self::Zip => Compression::ZIP16,
            Self::Zips => Compression::ZIP1,
            Self::Piz => Compression::PIZ,
            Self::Pxr24 => Compression::PXR24,
            Self::B44 => Compression::B44,
            Self::B44a => Compression::B44A,
            Self::Dwaa => Compression::DWAA(None),
            Self::Dwab => Compression::DWAB(None),
        }
    }
}

/// The name that OpenEXR has for a compression.
pub(crate) fn compression_name(method: Compression) -> &'static str {
    match method {
        Compression::Uncompressed => "none",
        Compression::RLE => "rle",
        Compression::ZIP1 => "zips",
        Compression::ZIP16 => "zip",
        Compression::PIZ => "piz",
        Compression::PXR24 => "pxr24",
        Compression::B44 => "b44",
        Compression::B44A => "b44a",
        Compression::DWAA(_) => "dwaa",
        Compression::DWAB(_) => "dwab",
        Compression::HTJ2K32 => "htj2k32",
        Compression::HTJ2K256 => "htj2k256",
    }
}
