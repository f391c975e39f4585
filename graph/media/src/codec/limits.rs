//! Limits of the size of images. Checked on the header, before anything is allocated or decoded,
//! because a damaged header can claim hundreds of gigabytes.

use crate::codec::{CodecError, ErrorKind};

/// Largest width and height, in pixels.
pub const MAX_SIDE: u64 = 65536;

/// Largest picture that is written, in bytes: four channels of one, two or four bytes for each pixel.
pub const MAX_BYTES: u64 = 4 << 30;

/// Largest single scan-line block or tile of an EXR file, in bytes, all channels together.
pub(crate) const MAX_BLOCK_BYTES: u64 = 1 << 30;

/// Largest header of a Radiance file, in bytes; usual ones have some hundred.
pub(crate) const MAX_HDR_HEADER: u64 = 64 << 10;

/// Largest headers of an EXR file, in bytes. Names of objects (Cryptomatte) can take some MiB.
pub(crate) const MAX_EXR_HEADER: u64 = 32 << 20;

/// Most bytes of what a PNG has besides its pixels: an ICC profile takes a few KiB, or some MiB for a printer.
pub(crate) const MAX_PNG_EXTRAS: usize = 16 << 20;

/// Most scans of a JPEG; usual progressive ones have ten.
pub(crate) const MAX_SCANS: usize = 100;

/// The bytes that decoding an image may take: the picture, and what the decoder needs at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget(pub u64);

impl Budget {
    /// Accepts a picture of `width` × `height` RGBA pixels with `bytes` per channel, whose decoder needs `extra` bytes
    /// more, or returns the reason why not.
    pub(crate) fn check(self, size: (u64, u64), bytes: u64, extra: u64) -> Result<(), CodecError> {
        check_sides(size)?;
        let needed = (size.0 * size.1 * 4 * bytes).saturating_add(extra);
        if needed <= self.0 {
            return Ok(());
        }
        Err(too_much(size, needed)
            .hint(format!("decoding may take {}; `--memory SIZE` changes the limit", size_of_bytes(self.0))))
    }
}

/// Accepts a picture of `width` × `height` RGBA pixels with `bytes` per channel for writing, or returns the reason why
/// not.
pub(crate) fn check_size(size: (u64, u64), bytes: u64) -> Result<(), CodecError> {
    check_sides(size)?;
    let needed = size.0 * size.1 * 4 * bytes;
    if needed > MAX_BYTES {
        return Err(
            too_much(size, needed).hint(format!("a picture may take at most {} GiB in memory", MAX_BYTES >> 30))
        );
    }
    Ok(())
}

pub(crate) fn check_sides((width, height): (u64, u64)) -> Result<(), CodecError> {
    if width == 0 || height == 0 {
        return Err(CodecError::broken(format!("its header says {width}×{height} pixels")));
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(too_large(format!("its header says {width}×{height} pixels"))
            .hint(format!("a side may have at most {MAX_SIDE} pixels")));
    }
    Ok(())
}

fn too_much((width, height): (u64, u64), needed: u64) -> CodecError {
    too_large(format!("{width}×{height} pixels need {}", size_of_bytes(needed)))
}

/// Bytes in the unit that suits their number.
pub(crate) fn size_of_bytes(bytes: u64) -> String {
    match bytes {
        0..0x400 => format!("{bytes} bytes"),
        0x400..0x10_0000 => format!("{} KiB", bytes >> 10),
        0x10_0000..0x4000_0000 => format!("{} MiB", bytes >> 20),
        _ => format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30)),
    }
}

/// All bytes of a file that decoders take as a whole.
#[cfg(any(feature = "avif", feature = "jxl"))]
pub(crate) fn read_all(reader: impl std::io::Read, budget: u64) -> Result<Vec<u8>, CodecError> {
    use std::io::Read as _;

    let mut bytes = Vec::new();
    let read =
        reader.take(budget.saturating_add(1)).read_to_end(&mut bytes).map_err(|error| CodecError::reading(&error))?;
    if read as u64 > budget {
        return Err(too_large("the file is larger than what decoding may take"));
    }
    Ok(bytes)
}

/// A vector of `len` copies of `value`, or an error where memory does not suffice.
pub(crate) fn filled<T: Copy>(len: usize, value: T) -> Result<Vec<T>, CodecError> {
    let mut vec = Vec::new();
    vec.try_reserve_exact(len)
        .map_err(|_| too_large(format!("this machine has no {} MiB free", (len * size_of::<T>()) >> 20)))?;
    vec.resize(len, value);
    Ok(vec)
}

/// A vector of `len` zeros, or an error where memory does not suffice. The system's fresh pages are zero already:
/// none is touched, so that a short file with a large header takes no memory.
pub(crate) fn zeroed<T: bytemuck::Zeroable>(len: usize) -> Result<Vec<T>, CodecError> {
    bytemuck::allocation::try_zeroed_vec(len)
        .map_err(|()| too_large(format!("this machine has no {} MiB free", (len * size_of::<T>()) >> 20)))
}

pub(crate) fn too_large(what: impl Into<String>) -> CodecError {
    CodecError::new(ErrorKind::TooLarge, format!("the image is too large: {}", what.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_of_no_pixels_or_of_too_many_is_refused_when_reading_and_writing() {
        let cases = [
            ((1, 1), None),
            ((0, 1), Some(ErrorKind::Broken)),
            ((1, 0), Some(ErrorKind::Broken)),
            ((MAX_SIDE, 1), None),
            ((MAX_SIDE + 1, 1), Some(ErrorKind::TooLarge)),
            ((1, MAX_SIDE + 1), Some(ErrorKind::TooLarge)),
        ];
        for (size, kind) in cases {
            assert_eq!(Budget(MAX_BYTES).check(size, 4, 0).err().map(|error| error.kind), kind, "read {size:?}");
            assert_eq!(check_size(size, 4).err().map(|error| error.kind), kind, "write {size:?}");
        }
    }

    #[test]
    fn sizes_are_told_in_the_unit_that_suits_them() {
        let cases = [(0, "0 bytes"), (1023, "1023 bytes"), (1024, "1 KiB"), (3 << 20, "3 MiB"), (3 << 29, "1.5 GiB")];
        for (bytes, text) in cases {
            assert_eq!(size_of_bytes(bytes), text);
        }
    }
}
