//! Films, which the program `ffmpeg` decodes and encodes: it is found on the `PATH` and not linked.
//!
//! Frames go through pipes as full-size planes in the bits of the film, so `ffmpeg` changes nothing but the size of
//! color planes. Range, matrix, transfer function and primaries are converted here, and times are those of the film.

mod ffmpeg;
mod matroska;
mod preset;
mod probe;
mod reader;
mod timecode;
mod timeline;
mod writer;

use std::path::Path;

pub use ffmpeg::require as require_ffmpeg;
pub use preset::Preset;
pub use probe::Film;
pub use reader::FilmReader;
pub use timeline::Timeline;
pub use writer::{FilmWriter, Sound};

use crate::codec::ForeignFormat;

/// True if a file is a film, by its name.
pub fn is_film(name: impl AsRef<Path>) -> bool {
    ForeignFormat::of_name(name).is_some_and(|format| format.is_film())
}
