//! How large an image may be. Checked on the header, before anything is allocated or decoded,
//! because a damaged header can claim hundreds of gigabytes.

use crate::codec::{CodecError, ErrorKind};

/// Largest width and height, in pixels.
pub const MAX_SIDE: u64 = 65536;

/// Largest picture in memory, in bytes: four channels of two or four bytes for each pixel.
pub const MAX_BYTES: u64 = 4 << 30;

/// Largest single scan-line block or tile of an EXR file, in bytes, all channels together.
pub(crate) const MAX_BLOCK_BYTES: u64 = 1 << 30;

/// Accepts a picture of `width` × `height` RGBA pixels with `bytes` per channel, or returns the reason why not.
pub(crate) fn check_size((width, height): (u64, u64), bytes: u64) -> Result<(), CodecError> {
    if width == 0 || height == 0 {
        return Err(CodecError::broken(format!("its header says {width}×{height} pixels")));
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(too_large(format!("its header says {width}×{height} pixels"))
            .hint(format!("a side may have at most {MAX_SIDE} pixels")));
    }
    let needed = width * height * 4 * bytes;
    if needed > MAX_BYTES {
        let gigabytes = needed as f64 / f64::from(1 << 30);
        return Err(too_large(format!("{width}×{height} pixels need {gigabytes:.1} GiB"))
            .hint(format!("a picture may take at most {} GiB in memory", MAX_BYTES >> 30)));
    }
    Ok(())
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
/// none is touched.
pub(crate) fn zeroed<T: bytemuck::Zeroable>(len: usize) -> Result<Vec<T>, CodecError> {
    bytemuck::allocation::try_zeroed_vec(len)
        .map_err(|()| too_large(format!("this machine has no {} MiB free", (len * size_of::<T>()) >> 20)))
}

pub(crate) fn too_large(what: impl Into<String>) -> CodecError {
    CodecError::new(ErrorKind::TooLarge, format!("the image is too large: {}", what.into()))
}
