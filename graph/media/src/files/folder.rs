//! The images of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::FileError;
use crate::codec::{ErrorKind, ImageFormat};

/// The images of a folder by the endings of their names. Folders in it are not searched.
///
/// # Errors
/// The folder cannot be listed, or has no image.
pub fn images_in(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let entries = fs::read_dir(folder).map_err(|error| FileError::reading(folder, &error))?;
    let mut images = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| FileError::reading(folder, &error))?.path();
        if ImageFormat::of_name(&path).is_some() && path.is_file() {
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
