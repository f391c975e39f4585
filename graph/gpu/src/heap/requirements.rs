//! Memory requirements of an image by the driver.

/// The memory that a driver asks for an image.
pub(super) struct MemoryRequirements {
    pub(super) bytes: u64,
    pub(super) alignment: u64,
    /// A bit for each suitable memory type.
    pub(super) memory_types: u32,
}
