//! Pictures of the documentation, which tests draw again with `AFTERIMAGE_WRITE_DOCS=1`.

use std::path::{Path, PathBuf};

use afterimage_media::{Encoding, Samples, write_image};

use super::gpu::Picture;

/// A file of the documentation.
pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../graph/docs").join(name)
}

/// True if the pictures are written, and not only what they show is computed.
pub fn are_written() -> bool {
    std::env::var_os("AFTERIMAGE_WRITE_DOCS").is_some()
}

/// Writes encoded pictures of one size as one, row by row, if pictures are written.
pub fn write_panels(name: &str, columns: u32, panels: &[Picture]) {
    let (width, height) = (panels[0].width, panels[0].height);
    let rows = (panels.len() as u32).div_ceil(columns);
    let all = Picture::new(width * columns, height * rows, |x, y| {
        panels[(y / height * columns + x / width) as usize].at(x % width, y % height)
    });
    if are_written() {
        write(name, &all, &Encoding::JPEG);
    }
}

pub fn write(name: &str, picture: &Picture, options: &Encoding) {
    let pixels = Samples::Float(picture.pixels.as_flattened());
    let written = write_image(&path(name), ((picture.width, picture.height), pixels), options);
    written.unwrap_or_else(|error| panic!("{error}"));
}
