//! The images of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::FileError;
use crate::codec::ErrorKind;

/// Endings of files that can be read as images.
const ENDINGS: [&str; 5] = ["exr", "hdr", "jpeg", "jpg", "png"];

/// The images of a folder by their names: the files that end in `.exr`, `.hdr` or `.png`. Folders in it are not
/// searched.
///
/// # Errors
/// The folder cannot be listed, or has no image.
pub fn images_in(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let entries = fs::read_dir(folder).map_err(|error| FileError::reading(folder, &error))?;
    let mut images = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| FileError::reading(folder, &error))?.path();
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        if ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())) && path.is_file() {
            images.push(path);
        }
    }
    if images.is_empty() {
        let message = "the folder has no image that ends in `.exr`, `.hdr` or `.png`";
        return Err(FileError::new(folder, ErrorKind::Missing, message).hint("name another folder, or files"));
    }
    images.sort();
    Ok(images)
}
