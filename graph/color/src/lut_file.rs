//! Color files of any kind.

use crate::clf::parse_clf;
use crate::lut::text::lines;
use crate::lut::{Lut, LutError, PngLayout, parse_cube, parse_png, parse_spi1d, parse_spi3d};
use crate::process::Process;

/// The content of a color file.
#[derive(Clone, Debug, PartialEq)]
pub enum LutFile {
    /// A table.
    Table(Lut),
    /// Steps in a row.
    Process(Process),
}

const PNG_SIGNATURE: &[u8] = b"\x89PNG";

/// Parses a color file of any kind, which is recognized by its content. `layout` is that of a PNG.
///
/// # Errors
/// The first error of the parser of its kind, or that it is of no known kind.
pub fn parse_lut_file(bytes: &[u8], layout: PngLayout) -> Result<LutFile, LutError> {
    if bytes.starts_with(PNG_SIGNATURE) {
        return parse_png(bytes, layout).map(LutFile::Table);
    }
    let known = "the file is neither a table (.cube, .spi1d, .spi3d, .clf) nor a PNG";
    let text = std::str::from_utf8(bytes).map_err(|_| LutError::new(0, known))?;
    match lines(text).next().map(|(_, line)| line.split_whitespace().next().unwrap_or(line)) {
        Some(word) if word.starts_with('<') => parse_clf(text).map(LutFile::Process),
        Some("Version" | "From" | "Length" | "Components") => parse_spi1d(text).map(LutFile::Table),
        Some("SPILUT") => parse_spi3d(text).map(LutFile::Table),
        _ => parse_cube(text).map(LutFile::Table),
    }
}
