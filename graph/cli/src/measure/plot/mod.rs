//! Time against error as a picture for a slide: SVG, or PNG drawn from it.

mod axis;
pub(crate) mod canvas;
mod chart;
mod labels;

use std::path::Path;
use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg;

use super::report::Report;
use crate::failure::Failure;
use afterimage_media::{EncodedPixels, PngOptions, write_atomic, write_png};

/// Pixels of a PNG for each unit of the SVG.
const SHARPNESS: f32 = 2.0;

/// Refuses a name whose ending says nothing about the format, before anything is measured.
pub(crate) fn check_name(path: &Path) -> Result<(), Failure> {
    if super::ends_with(path, "svg") || super::ends_with(path, "png") {
        return Ok(());
    }
    Err(Failure::user(format!("`--plot {}` ends neither in `.svg` nor in `.png`", path.display())))
}

/// Writes the chart in the format that the file's name says.
pub(crate) fn write(path: &Path, report: &Report) -> Result<(), Failure> {
    let svg = chart::svg(report);
    if super::ends_with(path, "svg") {
        return Ok(write_atomic(path, svg.as_bytes())?);
    }
    let picture = drawn(&svg)?;
    let size = (picture.width(), picture.height());
    // The paper is opaque, so that premultiplied colours are the colours.
    Ok(write_png(
        path,
        size,
        EncodedPixels::Byte(picture.data()),
        &PngOptions { dither: None, ..PngOptions::default() },
    )?)
}

/// The pixels of an SVG. The font is ours, so that the picture is the same on every machine.
fn drawn(svg: &str) -> Result<Pixmap, Failure> {
    let mut options = usvg::Options::default();
    let fonts = Arc::make_mut(&mut options.fontdb);
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let failed = |why: String| Failure::machine(format!("cannot draw the plot: {why}"));
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| failed(error.to_string()))?;
    let size = tree.size().to_int_size();
    let scaled = |length: u32| (length as f32 * SHARPNESS) as u32;
    let mut picture =
        Pixmap::new(scaled(size.width()), scaled(size.height())).ok_or_else(|| failed("it is too large".into()))?;
    resvg::render(&tree, Transform::from_scale(SHARPNESS, SHARPNESS), &mut picture.as_mut());
    Ok(picture)
}
