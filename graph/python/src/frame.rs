//! A frame: its images from Python and to Python.

use afterimage_gpu::Texels;
use afterimage_graph::color::Colorimetry;
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{Camera, Matrix};
use afterimage_lab::quantize::with_encoded_pixels;
use afterimage_media::{Alpha, PngDepth, PngOptions, png_codes};
use afterimage_plan::PlanOutput;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::error::Failure;
use crate::files::format;

/// What the numbers of an image mean: primaries, transfer function, white.
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

/// The same without Python.
pub(crate) struct Given<'a> {
    pub(crate) input: &'a str,
    pub(crate) desc: ImageDesc,
    pub(crate) bytes: &'a [u8],
}

impl GivenArray<'_> {
    pub(crate) fn given(&self) -> PyResult<Given<'_>> {
        let Self(input, bytes, (width, height, depth), channels, ty) = self;
        let Some(format) = format(ty, *channels) else {
            return Err(Failure::Image(format!("no texture has {channels} channels of {ty}")).into());
        };
        let desc = match depth {
            0 => ImageDesc::new(Size::new(*width, *height)),
            depth => ImageDesc::volume(Size::volume(*width, *height, *depth)),
        };
        let (desc, bytes) = (desc.format(format), bytes_of(bytes)?);
        if bytes.len() as u64 != desc.size.texels() * format.bytes() {
            return Err(Failure::Image(format!("`{input}` has {} bytes, which is not its size", bytes.len())).into());
        }
        Ok(Given { input, desc, bytes })
    }
}

pub(crate) fn bytes_of<'a>(array: &'a PyReadonlyArray1<'_, u8>) -> PyResult<&'a [u8]> {
    Ok(array.as_slice()?)
}

/// A camera for an input: the name, view and projection of this frame and of the one before, as columns, and the jitter
/// of both.
#[derive(FromPyObject)]
pub(crate) struct GivenCamera(String, Matrix, Matrix, Matrix, Matrix, [f32; 2], [f32; 2]);

impl GivenCamera {
    pub(crate) fn into_camera(self) -> (String, Camera) {
        let Self(name, view, projection, previous_view, previous_projection, jitter, previous_jitter) = self;
        (name, Camera { view, projection, previous_view, previous_projection, jitter, previous_jitter })
    }
}

/// When a frame is, and its number.
#[derive(FromPyObject)]
pub(crate) struct Moment {
    #[pyo3(item)]
    pub(crate) time: f32,
    #[pyo3(item)]
    pub(crate) dt: f32,
    #[pyo3(item)]
    pub(crate) reset: bool,
    #[pyo3(item)]
    pub(crate) number: u32,
}

/// How display outputs become numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Codes of 8 bits for SDR, of 16 for PQ and HLG.
    Codes,
    Codes8,
    Codes16,
    /// Numbers from 0 to 1, which are not rounded.
    Half,
    Float,
}

impl Encoding {
    pub(crate) fn of(ty: Option<&str>) -> Result<Self, Failure> {
        Ok(match ty {
            None => Self::Codes,
            Some("uint8") => Self::Codes8,
            Some("uint16") => Self::Codes16,
            Some("float16") => Self::Half,
            Some("float32") => Self::Float,
            Some(other) => {
                let known = "uint8, uint16, float16 or float32";
                return Err(Failure::Image(format!("display outputs are {known}, not {other}")));
            }
        })
    }

    /// The bits that the pipeline must keep.
    pub(crate) fn bits(self, is_hdr: bool) -> u32 {
        match self {
            Self::Codes if is_hdr => 16,
            Self::Codes | Self::Codes8 | Self::Half => 8,
            Self::Codes16 | Self::Float => 16,
        }
    }

    fn is_rounded(self) -> bool {
        !matches!(self, Self::Half | Self::Float)
    }
}

/// The numbers of an output.
enum Numbers {
    /// Bytes of numbers of this type.
    Bytes(Vec<u8>, &'static str),
    Codes(Vec<u16>),
    Floats(Vec<f32>),
}

/// An output of a frame.
pub(crate) struct Rendered {
    name: String,
    numbers: Numbers,
    channels: usize,
    desc: ImageDesc,
    output: PlanOutput,
}

/// How the display outputs of a pipeline are rounded.
pub(crate) struct Rounding {
    pub(crate) bits: u32,
    /// The seed of the noise; `None` rounds to the nearest code.
    pub(crate) dither: Option<u32>,
    pub(crate) keeps_alpha: bool,
}

impl Rendered {
    /// An output of linear light, of data, or of encoded numbers that are not rounded.
    fn plain(output: PlanOutput, texels: Texels) -> Self {
        let desc = texels.desc;
        let (numbers, channels) = match desc.format {
            Format::Rgba16Float => (Numbers::Bytes(texels.bytes, "float16"), 4),
            Format::Rg16Float => (Numbers::Bytes(texels.bytes, "float16"), 2),
            Format::R16Float => (Numbers::Bytes(texels.bytes, "float16"), 1),
            Format::Rgba32Float => (Numbers::Bytes(texels.bytes, "float32"), 4),
            Format::R32Float | Format::Depth32Float => (Numbers::Bytes(texels.bytes, "float32"), 1),
            Format::Rgba8Unorm | Format::Rg11b10Ufloat | Format::Depth16Unorm => {
                (Numbers::Floats(texels.to_floats().into_flattened()), 4)
            }
        };
        Self { name: output.name.clone(), numbers, channels, desc, output }
    }

    /// An output for a display in the codes of the program's PNG.
    fn rounded(output: PlanOutput, texels: &Texels, rounding: &Rounding) -> Result<Self, Failure> {
        let size = (texels.desc.size.width, texels.desc.size.height);
        let options = PngOptions {
            depth: if rounding.bits == 16 { PngDepth::Sixteen } else { PngDepth::Eight },
            alpha: if rounding.keeps_alpha { Alpha::Keep } else { Alpha::Drop },
            dither: rounding.dither,
            color: None,
        };
        let (codes, channels) = with_encoded_pixels(texels, |pixels| png_codes(size, pixels, &options))?;
        let numbers = match rounding.bits {
            16 => Numbers::Codes(codes),
            _ => Numbers::Bytes(codes.into_iter().map(|code| code as u8).collect(), "uint8"),
        };
        Ok(Self { name: output.name.clone(), numbers, channels, desc: texels.desc, output })
    }

    pub(crate) fn of(
        output: PlanOutput,
        texels: Texels,
        encoding: Encoding,
        rounding: Option<&Rounding>,
    ) -> Result<Self, Failure> {
        match rounding.filter(|_| encoding.is_rounded()) {
            Some(rounding) => Self::rounded(output, &texels, rounding),
            None => Ok(Self::plain(output, texels)),
        }
    }

    /// The name, the numbers in a row, the shape, their type, what they mean, and their colors.
    #[expect(clippy::type_complexity, reason = "a tuple for the Python half")]
    pub(crate) fn into_python(
        self,
        py: Python<'_>,
    ) -> PyResult<(String, Bound<'_, PyAny>, Vec<usize>, &'static str, &'static str, Color)> {
        let (array, ty) = match self.numbers {
            Numbers::Bytes(bytes, ty) => (PyArray1::from_vec(py, bytes).into_any(), ty),
            Numbers::Codes(codes) => (PyArray1::from_vec(py, codes).into_any(), "uint16"),
            Numbers::Floats(floats) => (PyArray1::from_vec(py, floats).into_any(), "float32"),
        };
        let size = self.desc.size;
        let mut shape = vec![size.height as usize, size.width as usize];
        if self.desc.volume {
            shape.insert(0, size.depth as usize);
        }
        if self.channels > 1 {
            shape.push(self.channels);
        }
        let color = Color { colorimetry: self.output.colorimetry };
        Ok((self.name, array, shape, ty, self.output.state.name(), color))
    }
}
