//! A picture in memory, and what its file stated about it.

use afterimage_base::color::Colorimetry;
use afterimage_base::image::{Format, ImageDesc, Size};
use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use half::f16;
use half::slice::HalfFloatSliceExt;

/// Linear color with Rec.709 primaries and D65 white, or data, interleaved RGBA, rows from the top.
///
/// A value of 1 is SDR white in a file for a display: code 255 of sRGB, and 203 cd/m2 of PQ and HLG (ITU-R BT.2408), so
/// that the SDR and the HDR version of an image agree. In EXR and Radiance files it is 1 in the unit of the file; a
/// stated `whiteLuminance` is kept in `stated` and not multiplied in, and the `EXPOSURE` of a Radiance file is divided
/// out.
///
/// Values are as the file has them: negative, infinite and NaN values are kept; graphs sanitize
/// their inputs. Alpha is 1 where the file has none, 0 outside an EXR data window.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels in a row; never 0.
    pub width: u32,
    /// Rows; never 0.
    pub height: u32,
    /// `width` × `height` × 4 numbers.
    pub pixels: Pixels,
    /// The attributes of the file, to be written out again.
    pub meta: Metadata,
    /// The colorimetry that the file states; `None` if it states nothing. The numbers are converted to linear Rec.709
    /// in any case, and negative ones are colors outside of Rec.709.
    pub stated: Option<Colorimetry>,
    /// Sentences for the user about what was ignored or assumed while reading.
    pub notes: Vec<String>,
}

/// The numbers of a picture, as precise as its file was.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// 16-bit floats, ready for `Rgba16Float`.
    Half(Vec<f16>),
    /// 32-bit floats.
    Float(Vec<f32>),
}

impl Pixels {
    /// Bytes of one channel of one pixel: 2 or 4.
    pub fn bytes_per_channel(&self) -> usize {
        match self {
            Self::Half(_) => 2,
            Self::Float(_) => 4,
        }
    }

    /// The number of samples: four for each pixel.
    pub fn len(&self) -> usize {
        match self {
            Self::Half(values) => values.len(),
            Self::Float(values) => values.len(),
        }
    }

    /// True if there is no pixel at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All numbers as 32-bit floats.
    pub fn to_f32(&self) -> Vec<f32> {
        match self {
            Self::Half(values) => values.to_f32_vec(),
            Self::Float(values) => values.clone(),
        }
    }
}

impl Picture {
    /// A picture without a file. `pixels` holds `width` × `height` × 4 numbers.
    pub fn new(width: u32, height: u32, pixels: Pixels) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize * 4, "four numbers for a pixel");
        let meta = Metadata::of_size(width, height);
        Self { width, height, pixels, meta, stated: None, notes: Vec::new() }
    }

    /// Size and format of the texels: half floats or floats.
    pub fn desc(&self) -> ImageDesc {
        let desc = ImageDesc::new(Size::new(self.width, self.height));
        match &self.pixels {
            Pixels::Half(_) => desc,
            Pixels::Float(_) => desc.format(Format::Rgba32Float),
        }
    }

    /// The rows of the picture in its file, of which this one may have some.
    pub fn whole_height(&self) -> u32 {
        self.meta.data_size.map_or(self.meta.image.display_window.size.1 as u32, |(_, height)| height)
    }

    /// The texels as bytes, rows without gaps.
    pub fn bytes(&self) -> &[u8] {
        match &self.pixels {
            Pixels::Half(halves) => bytemuck::cast_slice(halves),
            Pixels::Float(floats) => bytemuck::cast_slice(floats),
        }
    }

    /// The four numbers of a pixel, for tests and reports.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        match &self.pixels {
            Pixels::Half(values) => std::array::from_fn(|c| values[at + c].to_f32()),
            Pixels::Float(values) => std::array::from_fn(|c| values[at + c]),
        }
    }
}

/// Attributes in the terms of OpenEXR: windows, pixel aspect, primaries, camera, custom ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Metadata {
    /// Display window, pixel aspect, primaries, time code.
    pub image: ImageAttributes,
    /// Data window's corner, owner, comments, camera, custom attributes.
    pub layer: LayerAttributes,
    /// Width and height of the data window, if the picture is that and not the display window. A picture of that size
    /// is written with both windows.
    pub data_size: Option<(u32, u32)>,
    /// Rows that the file packs together: those of a tile, or of a block of scan lines.
    pub block_rows: Option<u32>,
    /// True if the numbers are data, or colors of a space that the file names and that is not known: what is made from
    /// them claims no space.
    pub has_unknown_colors: bool,
}

impl Metadata {
    /// The sentence about an aspect of pixels that no other file than an EXR states.
    pub(crate) fn other_aspect(&self) -> Option<String> {
        let aspect = self.image.pixel_aspect;
        let note =
            || format!("the pixels of the image are {aspect} times as wide as high, which only an EXR file states");
        ((aspect - 1.0).abs() > 1e-6).then(note)
    }

    /// Nothing but a window of that size, square pixels, no stated primaries.
    pub fn of_size(width: u32, height: u32) -> Self {
        let window = IntegerBounds::from_dimensions((width as usize, height as usize));
        Self {
            image: ImageAttributes::new(window),
            layer: LayerAttributes::default(),
            data_size: None,
            block_rows: None,
            has_unknown_colors: false,
        }
    }

    /// Sets a custom text attribute. Characters outside Latin-1 become `?`, as EXR text has none.
    pub fn set_text(&mut self, name: &str, value: &str) {
        self.layer.other.insert(text(name), AttributeValue::Text(text(value)));
    }

    /// Sets a custom number.
    pub fn set_number(&mut self, name: &str, value: f32) {
        self.layer.other.insert(text(name), AttributeValue::F32(value));
    }
}

fn text(value: &str) -> Text {
    let latin: String = value.chars().map(|c| if u32::from(c) < 256 { c } else { '?' }).collect();
    Text::new_or_none(&latin).unwrap_or_default()
}
