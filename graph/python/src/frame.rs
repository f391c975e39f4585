//! A frame: its images from Python and to Python.

use afterimage::FrameKind;
use afterimage::host::FrameStep;
use afterimage::offline::{ComponentType, Encoding, OfflineImage, PixelData, RenderedImage, format_of};
use afterimage_graph::color::Colorimetry;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::{Camera, Matrix};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::Failure;

/// The colorimetry of an image: primaries, transfer function, white.
#[pyclass(frozen, module = "afterimage")]
pub(crate) struct Color {
    pub(crate) colorimetry: Colorimetry,
}

#[pymethods]
impl Color {
    fn __repr__(&self) -> String {
        format!("Color({})", serde_json::json!(self.colorimetry))
    }
}

/// An image for an input: the name, the bytes, columns, rows and slices (0 for an image that is no volume), channels,
/// and the type of the numbers.
#[derive(FromPyObject)]
pub(crate) struct GivenArray<'py>(String, PyReadonlyArray1<'py, u8>, (u32, u32, u32), u32, String);

impl GivenArray<'_> {
    /// The same without Python.
    pub(crate) fn given(&self) -> PyResult<OfflineImage<'_>> {
        let Self(input, bytes, (width, height, depth), channels, ty) = self;
        let number = if ty == "float16" { ComponentType::F16 } else { ComponentType::F32 };
        let Some(format) = format_of(number, *channels) else {
            return Err(Failure::Image(format!("no texture has {channels} channels of {ty}")).into());
        };
        let desc = match depth {
            0 => ImageDesc::new(Size::new(*width, *height)),
            depth => ImageDesc::volume(Size::volume(*width, *height, *depth)),
        };
        Ok(OfflineImage { input, desc: desc.format(format), bytes: bytes.as_slice()? })
    }
}

/// A camera for an input: the name, view and projection of this frame and of the one before, as columns, and the jitter
/// of both.
#[derive(FromPyObject)]
pub(crate) struct GivenCamera(String, Matrix, Matrix, Matrix, Matrix, [f32; 2], [f32; 2]);

impl GivenCamera {
    pub(crate) fn camera(&self) -> (&str, Camera) {
        let Self(name, view, projection, previous_view, previous_projection, jitter, previous_jitter) = self;
        let camera = Camera {
            view: *view,
            projection: *projection,
            previous_view: *previous_view,
            previous_projection: *previous_projection,
            jitter: *jitter,
            previous_jitter: *previous_jitter,
        };
        (name, camera)
    }
}

/// The time of a frame, and its number.
#[derive(FromPyObject)]
pub(crate) struct Moment {
    #[pyo3(item)]
    time: f64,
    #[pyo3(item)]
    dt: f32,
    #[pyo3(item)]
    reset: bool,
    #[pyo3(item)]
    pub(crate) number: u32,
}

impl Moment {
    pub(crate) fn step(&self) -> FrameStep {
        FrameStep { time: self.time, dt: self.dt, kind: FrameKind::cut_if(self.reset) }
    }
}

/// The components of display outputs, by the name of their type.
pub(crate) fn encoding(ty: Option<&str>) -> Result<Encoding, Failure> {
    Ok(match ty {
        None => Encoding::Codes,
        Some("uint8") => Encoding::Codes8,
        Some("uint16") => Encoding::Codes16,
        Some("float16") => Encoding::Half,
        Some("float32") => Encoding::Float,
        Some(other) => {
            let known = "uint8, uint16, float16 or float32";
            return Err(Failure::Image(format!("display outputs are {known}, not {other}")));
        }
    })
}

/// The name, the components in a row, the shape, their type, the color state, and the colorimetry.
pub(crate) type PythonImage<'py> = (String, Bound<'py, PyAny>, Vec<usize>, &'static str, &'static str, Color);

pub(crate) fn into_python(py: Python<'_>, image: RenderedImage) -> PyResult<PythonImage<'_>> {
    let ty = match image.data.ty() {
        ComponentType::U8 => "uint8",
        ComponentType::U16 => "uint16",
        ComponentType::F16 => "float16",
        ComponentType::F32 => "float32",
    };
    let array = match image.data {
        PixelData::Bytes(bytes, _) => PyArray1::from_vec(py, bytes).into_any(),
        PixelData::Codes(codes) => PyArray1::from_vec(py, codes).into_any(),
        PixelData::Floats(floats) => PyArray1::from_vec(py, floats).into_any(),
    };
    let size = image.desc.size;
    let mut shape = vec![size.height as usize, size.width as usize];
    if image.desc.volume {
        shape.insert(0, size.depth as usize);
    }
    if image.channels > 1 {
        shape.push(image.channels);
    }
    let color = Color { colorimetry: image.colorimetry };
    Ok((image.name, array, shape, ty, image.state.name(), color))
}
