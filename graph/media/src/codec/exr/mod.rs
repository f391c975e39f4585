//! OpenEXR in and out. Reading goes header → choice of layer → size limits → blocks, and nothing
//! is allocated for pixels before the limits have passed.

mod attributes;
mod blocks;
mod camera;
mod colors;
mod decode;
mod describe;
mod dwa_counters;
mod label;
mod layers;
mod measure;
mod pack;
mod read;
mod rows;
mod select;
mod write;

use exr::error::Error;
use exr::meta::attribute::Text;

use crate::codec::{CodecError, ErrorKind};

pub use camera::CameraMatrices;
pub(crate) use camera::camera;
#[cfg(test)]
pub(crate) use camera::of_attributes;
pub(crate) use describe::describe;
pub(crate) use layers::{encode_beside, left_out};
pub(crate) use measure::measure;
pub(crate) use read::check;
pub(crate) use read::decode;
pub(crate) use rows::ExrRows;

/// Explains an error of the decoder to the user.
fn explain(error: &Error) -> CodecError {
    match error {
        Error::Io(error) => CodecError::reading(error),
        Error::Invalid(what) if what.contains("missing bytes") => CodecError::cut_short(),
        Error::NotSupported(what) if what.contains("deep") => deep(),
        Error::NotSupported(what) => unsupported(format!("this EXR cannot be read: {what}"))
            .hint("save it again as a flat, ZIP-compressed OpenEXR 2 file"),
        Error::Invalid(what) => CodecError::broken(what),
        Error::Aborted => CodecError::broken(error),
    }
}

/// A text of a file, which is UTF-8 (OpenEXR, "String Data"); other bytes are characters of Latin-1.
fn text(bytes: &Text) -> String {
    std::str::from_utf8(bytes.as_slice()).map_or_else(|_| bytes.to_string(), str::to_owned)
}

fn unsupported(what: impl Into<String>) -> CodecError {
    CodecError::new(ErrorKind::Unsupported, what)
}

fn deep() -> CodecError {
    unsupported("deep EXR (many samples in a pixel) is not supported")
        .hint("flatten it first, for example `oiiotool deep.exr --flatten -o flat.exr`")
}

fn luminance_chroma() -> CodecError {
    unsupported("chroma-subsampled EXR (luminance with `RY` and `BY`) is not supported")
        .hint("save it again with full-size `R`, `G` and `B` channels")
}

/// Channels that are stored for some pixels only.
fn subsampled(channels: &[(String, [i32; 2])]) -> Option<CodecError> {
    let is_chroma = |name: &str| name.rsplit('.').next().is_some_and(|last| matches!(last, "RY" | "BY"));
    let (name, [across, down]) = channels.first()?;
    if channels.iter().any(|(name, _)| is_chroma(name)) {
        return Some(luminance_chroma());
    }
    let what = format!("its channel `{name}` has one number for {across}x{down} pixels, which is not supported");
    Some(unsupported(what).hint("save it again with that channel in full size, or without it"))
}
