//! Memory and limits of device and host for an image in bands.

/// Memory and limits of a device for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BandLimits {
    /// Bytes of all images and buffers as the driver pads them, and of the rows on their way from and to the host.
    pub bytes: u64,
    /// Bytes of these that others have.
    pub taken: u64,
    /// Bytes of the blocks in which memory for smaller images and buffers is taken; 0 if each has memory of its own.
    pub block: u64,
    /// The longest side of a texture.
    pub side: u32,
    /// Allows images that a sampler filters to be in bands, as they may on a CPU. The sampler of a graphics card rounds
    /// places in a texture of fewer rows in other ways.
    pub filters: bool,
    /// The least number of bands of a sweep: more than one for tests.
    pub least: u32,
    /// The parts in which bands are made, for tests; as is best without.
    pub parts: Option<Parts>,
    /// The first row that outputs are made of, and the one after the last; all of them without. Passes that make
    /// something whole see the whole picture all the same.
    pub rows: Option<[u32; 2]>,
    pub host: HostLimits,
}

/// Parts of a band: textures of its largest images have the rows of a part, those of others the rows of the band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Number of the largest sizes.
    pub sizes: usize,
    /// About how many rows of the largest size.
    pub rows: u32,
}

impl Parts {
    /// A band of one part.
    pub const ONE: Self = Self { sizes: 0, rows: u32::MAX };
    pub(super) const TRIED: [Self; 5] = [
        Self::ONE,
        Self { sizes: 1, rows: 128 },
        Self { sizes: 1, rows: 32 },
        Self { sizes: 2, rows: 128 },
        Self { sizes: 2, rows: 32 },
    ];
}

/// Host memory for rows in flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostLimits {
    /// Bytes of all rows that are read ahead, decoded and written.
    pub bytes: u64,
    /// Rows that inputs are decoded in multiples of, which stay until no band needs them any more; 0 if they are in
    /// memory anyway.
    pub decoded: u32,
    /// Rows of an output that are written together.
    pub written: u32,
}

impl HostLimits {
    /// A host that has as much as it takes, and images in memory.
    pub const NONE: Self = Self { bytes: u64::MAX, decoded: 0, written: 1 };
}
