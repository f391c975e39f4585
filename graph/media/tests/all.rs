//! Files in and out: round trips, selections, odd files, hostile files.

#![allow(missing_docs, clippy::unwrap_used, reason = "a test binary exports nothing")]

mod atomic;
#[cfg(feature = "avif")]
mod avif;
mod budget;
#[cfg(any(feature = "avif", feature = "jxl"))]
mod decoders;
mod described;
mod dpx;
mod exr_attributes;
mod exr_layouts;
mod exr_read;
mod exr_write;
mod formats;
mod gain_maps;
mod hostile;
#[cfg(feature = "jxl")]
mod jxl;
mod labels;
mod layers;
mod names;
mod oracles;
mod permitted;
mod png;
mod png_layouts;
mod resample;
mod sequence;
mod spaces;
mod tiff;
mod watch;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process;

use afterimage_media::{Budget, FileError, Picture, Pixels, Source, read, read_within};

/// The bytes of hexadecimal digits.
#[cfg(any(feature = "avif", feature = "jxl"))]
fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u32> = hex.chars().filter_map(|digit| digit.to_digit(16)).collect();
    digits.as_chunks::<2>().0.iter().map(|[high, low]| (high * 16 + low) as u8).collect()
}

/// A folder of one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = env::temp_dir().join(format!("afterimage-{}-{test}", process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn with(&self, name: &str, bytes: &[u8]) -> PathBuf {
        fs::write(self.file(name), bytes).unwrap();
        self.file(name)
    }

    /// Reads bytes as a file of this folder.
    fn read(&self, bytes: &[u8]) -> Result<Picture, FileError> {
        read_within(&Source::file(self.with("bytes", bytes)), Budget(4 << 30))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const ODD_SIZES: [(u32, u32); 3] = [(1, 1), (3, 5), (257, 129)];

/// Different numbers in every channel of every pixel, negative and large ones among them.
fn numbers(width: u32, height: u32) -> Vec<f32> {
    let value = |i: u32| (i.wrapping_mul(2_654_435_761) >> 16) as f32 / 256.0 - 16.0;
    (0..width * height * 4).map(value).collect()
}

fn picture(width: u32, height: u32) -> Picture {
    Picture::new(width, height, Pixels::Float(numbers(width, height)))
}

/// Message and hint without the path, which differs from run to run.
fn message_and_hint(error: &FileError) -> String {
    match &error.hint {
        Some(hint) => format!("{}; {hint}", error.message),
        None => error.message.clone(),
    }
}

fn read_layer(path: &Path, layer: &str) -> Result<Picture, FileError> {
    read(&Source { path: path.into(), layer: Some(layer.to_owned()) })
}
