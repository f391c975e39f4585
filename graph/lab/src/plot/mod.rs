//! Charts as SVG, or as PNG rendered from it.

pub mod axis;
pub mod labels;
pub mod palette;

use std::path::Path;
use std::sync::Arc;

pub use afterimage_base::svg;
use afterimage_media::{EncodedPixels, PngOptions, write_atomic, write_png};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg;

use crate::LabError;
use crate::files::has_extension;

/// Pixels of a PNG for each unit of the SVG.
const SCALE: f32 = 2.0;

/// True if [`save`] knows the file's format: `.svg` or `.png`.
pub fn is_chart(path: &Path) -> bool {
    has_extension(path, "svg") || has_extension(path, "png")
}

/// Writes an SVG text to a file, rendered to pixels if the file's extension is `.png`.
///
/// # Errors
/// The file cannot be written, or the SVG cannot be rendered.
pub fn save(path: &Path, svg: &str) -> Result<(), LabError> {
    if !has_extension(path, "png") {
        return Ok(write_atomic(path, svg.as_bytes())?);
    }
    let picture = render(svg)?;
    let size = (picture.width(), picture.height());
    let options = PngOptions { dither: None, ..PngOptions::default() };
    // The background is opaque, so premultiplied colors are the colors.
    Ok(write_png(path, size, EncodedPixels::Byte(picture.data()), &options)?)
}

/// The pixels of an SVG. The font comes with the program, so that the result is the same on every machine.
fn render(svg: &str) -> Result<Pixmap, LabError> {
    let mut options = usvg::Options::default();
    let fonts = Arc::make_mut(&mut options.fontdb);
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let failed = |why: String| LabError::Machine(format!("cannot render the plot: {why}"));
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| failed(error.to_string()))?;
    let size = tree.size().to_int_size();
    let scaled = |length: u32| (length as f32 * SCALE) as u32;
    let mut picture =
        Pixmap::new(scaled(size.width()), scaled(size.height())).ok_or_else(|| failed("it is too large".into()))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut picture.as_mut());
    Ok(picture)
}
