//! Image files: read as the program reads them, written as it writes them.

use std::path::PathBuf;

use afterimage_graph::image::ColorState;
use afterimage_media::{Alpha, Encoding, Picture, Pixels, Samples, encode, write_atomic};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::Failure;
use crate::frame::Color;

/// An image of an EXR, Radiance or PNG file, linear Rec.709, with four channels: its numbers, its width and height,
/// their type, and what was assumed about the file. `layer` names a layer or channel of an EXR file.
#[pyfunction]
#[expect(clippy::type_complexity, reason = "a tuple for the Python half")]
pub(crate) fn read(
    py: Python<'_>,
    path: PathBuf,
    layer: Option<String>,
) -> PyResult<(Bound<'_, PyAny>, u32, u32, &'static str, Vec<String>)> {
    let source = afterimage_media::Source { path, layer };
    let picture = py.detach(|| afterimage_media::read(&source)).map_err(Failure::from)?;
    let (width, height) = (picture.width, picture.height);
    let (array, ty) = match picture.pixels {
        Pixels::Half(halves) => (PyArray1::from_vec(py, bytemuck::cast_vec::<_, u16>(halves)).into_any(), "float16"),
        Pixels::Float(floats) => (PyArray1::from_vec(py, floats).into_any(), "float32"),
    };
    Ok((array, width, height, ty, picture.notes))
}

/// Writes linear RGBA, or data, as an EXR file with numbers of the type of the array.
#[pyfunction]
pub(crate) fn write_exr(
    py: Python<'_>,
    path: PathBuf,
    numbers: PyReadonlyArray1<'_, u8>,
    size: (u32, u32),
    ty: &str,
    state: &str,
    color: Option<PyRef<'_, Color>>,
) -> PyResult<()> {
    let bytes = numbers.as_slice()?;
    let pixels = match ty {
        "float16" => Pixels::Half(bytemuck::pod_collect_to_vec(bytes)),
        _ => Pixels::Float(bytemuck::pod_collect_to_vec(bytes)),
    };
    let state = ColorState::named(state).unwrap_or(ColorState::Scene);
    let color = color.map_or(Encoding::EXR.color, |color| Some(color.colorimetry));
    let options = Encoding {
        bits: if ty == "float16" { 16 } else { 32 },
        color: color.filter(|_| !matches!(state, ColorState::Data | ColorState::LogLuminance)),
        scene: matches!(state, ColorState::Scene | ColorState::Exposed),
        ..Encoding::EXR
    };
    let picture = Picture::new(size.0, size.1, pixels);
    // A picture of numbers has no attributes that could be left out.
    py.detach(|| afterimage_media::write_image(&path, &picture, &options)).map_err(Failure::from)?;
    Ok(())
}

/// The PNG file of codes of 8 or 16 bits with 3 or 4 channels; written to `path` if there is one. The file states the
/// colors.
#[pyfunction]
pub(crate) fn write_png<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    codes: PyReadonlyArray1<'py, u16>,
    size: (u32, u32),
    channels: usize,
    bits: u32,
    color: Option<PyRef<'py, Color>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let codes = codes.as_slice()?;
    let last = ((1_u32 << bits) - 1) as f32;
    let color = color.map(|color| color.colorimetry);
    let file = py.detach(|| {
        let mut pixels = Vec::with_capacity(codes.len() / channels * 4);
        for pixel in codes.chunks_exact(channels) {
            pixels.extend((0..4).map(|channel| pixel.get(channel).map_or(1.0, |code| f32::from(*code) / last)));
        }
        let options = Encoding {
            bits,
            alpha: if channels == 4 { Alpha::Keep } else { Alpha::Drop },
            // The codes of an image are those of a PNG.
            premultiplied: false,
            dither: None,
            color: color.or(Encoding::PNG.color),
            ..Encoding::PNG
        };
        let file = encode((size, Samples::Float(&pixels)), &options)?;
        if let Some(path) = &path {
            write_atomic(path, &file)?;
        }
        Ok::<_, Failure>(file)
    })?;
    Ok(PyBytes::new(py, &file))
}
