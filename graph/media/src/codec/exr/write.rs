//! A picture to an EXR file: one scan-line part, R G B and perhaps A, attributes kept.
//!
//! Equal pictures give equal bytes: blocks are compressed on all cores but written in order, and
//! the attributes, which the `exr` crate takes from a hash map, are sorted by name afterwards.

use std::io::Cursor;

use afterimage_base::color::{Chromaticities, Colorimetry};
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    AttributeValue, ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType, Text,
};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes, standard_names};
use glam::Mat3;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

use super::describe::compression_name;
use super::explain;
use super::label::{describes_old_pixels, name_primaries};
use super::read::{adapted, point, to_attribute};
use crate::codec::chromaticities::convert;
use crate::codec::limits::check_size;
use crate::codec::panics::catch_panic;
use crate::codec::{CodecError, ErrorKind, Picture, Pixels};

/// How an EXR file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExrOptions {
    /// 32-bit floats instead of halves.
    pub float: bool,
    /// Whether the alpha channel is written.
    pub alpha: bool,
    /// How blocks are packed.
    pub compression: ExrCompression,
    /// What the numbers mean, which the file states: `chromaticities`, and `whiteLuminance` and `adoptedNeutral` where
    /// they are known. `None` keeps the attributes of the picture, for data and for unknown colors.
    pub color: Option<Colorimetry>,
    /// The primaries that the file has; those of `color` if `None`. Pixels are converted to them.
    pub primaries: Option<Chromaticities>,
    /// Whether the numbers are light of the scene: then `colorInteropID` names the primaries, if they have a name.
    pub scene: bool,
}

impl ExrOptions {
    /// The primaries of the written numbers; `None` for data.
    pub(super) fn written_primaries(&self) -> Option<Chromaticities> {
        self.color.map(|color| self.primaries.unwrap_or(color.primaries))
    }

    /// From the primaries of the picture to those of the file; `None` if they are the same.
    fn conversion(&self) -> Option<Mat3> {
        let (from, to) = (self.color?.primaries, self.written_primaries()?);
        (from != to).then(|| from.conversion(&to).as_mat3())
    }
}

impl Default for ExrOptions {
    /// Half, with alpha, ZIP, linear Rec.709.
    fn default() -> Self {
        Self {
            float: false,
            alpha: true,
            compression: ExrCompression::Zip,
            color: Some(Colorimetry::linear(Chromaticities::REC709)),
            primaries: None,
            scene: false,
        }
    }
}

/// Ways to pack an EXR file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExrCompression {
    /// Not packed: the fastest to write, the largest.
    None,
    /// Run lengths, for flat areas.
    Rle,
    /// Deflate, sixteen rows at a time.
    #[default]
    Zip,
    /// Deflate, row by row.
    Zips,
    /// Wavelets and Huffman codes: the smallest lossless one for grainy pictures.
    Piz,
    /// Deflate after differences, sixteen rows at a time; floats lose their last eight bits.
    Pxr24,
    /// Halves become blocks of a fixed size, with losses.
    B44,
    /// The same, with smaller blocks for flat areas.
    B44a,
    /// Cosines, with losses, 32 rows at a time.
    Dwaa,
    /// Cosines, with losses, 256 rows at a time.
    Dwab,
}

impl ExrCompression {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::None,
        Self::Rle,
        Self::Zips,
        Self::Zip,
        Self::Piz,
        Self::Pxr24,
        Self::B44,
        Self::B44a,
        Self::Dwaa,
        Self::Dwab,
    ];

    /// The name that OpenEXR has for it.
    pub fn name(self) -> &'static str {
        compression_name(self.method())
    }

    /// The one with that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|known| known.name() == name)
    }

    fn method(self) -> Compression {
        match self {
            Self::None => Compression::Uncompressed,
            Self::Rle => Compression::RLE,
            Self::Zip => Compression::ZIP16,
            Self::Zips => Compression::ZIP1,
            Self::Piz => Compression::PIZ,
            Self::Pxr24 => Compression::PXR24,
            Self::B44 => Compression::B44,
            Self::B44a => Compression::B44A,
            Self::Dwaa => Compression::DWAA(None),
            Self::Dwab => Compression::DWAB(None),
        }
    }
}

/// Encodes an EXR file.
pub fn encode_exr(picture: &Picture, options: &ExrOptions) -> Result<Vec<u8>, CodecError> {
    let bytes = if options.float { 4 } else { 2 };
    check_size((picture.width.into(), picture.height.into()), bytes)?;
    let header = header(picture, options);
    catch_panic(|| encode(picture, header, options.conversion())).unwrap_or_else(|panic| Err(ours(&panic)))
}

fn encode(picture: &Picture, header: Header, conversion: Option<Mat3>) -> Result<Vec<u8>, CodecError> {
    let headers = std::slice::from_ref(&header);
    let blocks: Vec<_> = enumerate_ordered_header_block_indices(headers).collect();
    let chunks = blocks.into_par_iter().map(|(number, index)| {
        let data = planes(picture, &header, conversion.as_ref(), &index);
        let chunk = catch_panic(|| UncompressedBlock { index, data }.compress_to_chunk(headers))
            .map_err(|panic| ours(&panic))?;
        chunk.map(|chunk| (number, chunk)).map_err(|error| explain(&error))
    });
    let chunks: Vec<_> = chunks.collect::<Result<_, CodecError>>()?;
    let mut file = Cursor::new(Vec::new());
    exr::block::write(&mut file, [header.clone()].into_iter().collect(), false, |_, writer| {
        chunks.into_iter().try_for_each(|(index, chunk)| writer.write_chunk(index, chunk))
    })
    .map_err(|error| explain(&error))?;
    let mut bytes = file.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

fn ours(panic: &str) -> CodecError {
    CodecError::new(ErrorKind::Machine, format!("packing the EXR failed: {panic}"))
}

/// EXR channels are stored in alphabetical order; this is where each lies in RGBA.
const STORED: [(&str, usize); 4] = [("A", 3), ("B", 2), ("G", 1), ("R", 0)];

fn header(picture: &Picture, options: &ExrOptions) -> Header {
    let sample_type = if options.float { SampleType::F32 } else { SampleType::F16 };
    let stored = if options.alpha { &STORED[..] } else { &STORED[1..] };
    // B44 quantizes some channels on a curve that does not keep an alpha of 1.
    let is_curved = !matches!(options.compression, ExrCompression::B44 | ExrCompression::B44a);
    let channel = |name| {
        let named = ChannelDescription::named(name, sample_type);
        ChannelDescription { quantize_linearly: named.quantize_linearly && is_curved, ..named }
    };
    let channels = stored.iter().map(|&(name, _)| channel(name)).collect();
    let size = (picture.width as usize, picture.height as usize);
    let image = image_attributes(picture, options);
    let mut layer = stated_luminance(layer_attributes(picture, &image), options);
    // An ACES container (SMPTE ST 2065-4) has uncompressed halves in rows, and no channels but R, G, B and A.
    let is_plain = options.compression == ExrCompression::None && !options.float;
    if let Some(primaries) = options.written_primaries().filter(|_| options.scene) {
        name_primaries(&mut layer, &primaries, is_plain);
    }
    Header::new(Text::default(), size, channels)
        .with_encoding(options.compression.method(), BlockDescription::ScanLines, LineOrder::Increasing)
        .with_shared_attributes(image)
        .with_attributes(layer)
}

fn image_attributes(picture: &Picture, options: &ExrOptions) -> ImageAttributes {
    let mut image = picture.meta.image.clone();
    let size = (picture.width as usize, picture.height as usize);
    if image.display_window.size != size.into() {
        image.display_window = IntegerBounds::from_dimensions(size);
    }
    if !(1e-6..=1e6).contains(&image.pixel_aspect) {
        image.pixel_aspect = 1.0;
    }
    if let Some(primaries) = options.written_primaries() {
        image.chromaticities = Some(to_attribute(&primaries));
    }
    image.other.retain(|name, value| is_kept(name) && is_writable(name, value));
    image
}

/// The layer's attributes, without those that describe the old file rather than the picture.
fn layer_attributes(picture: &Picture, image: &ImageAttributes) -> LayerAttributes {
    let mut layer = picture.meta.layer.clone();
    layer.layer_position = image.display_window.position;
    layer.layer_name = None;
    layer.preview = None;
    layer.multi_view_names = None;
    layer.view_name = None;
    layer.deep_image_state = None;
    layer.screen_window_width = layer.screen_window_width.max(0.0);
    let is_shared =
        |value: &AttributeValue| matches!(value, AttributeValue::Chromaticities(_) | AttributeValue::TimeCode(_));
    layer.other.retain(|name, value| {
        is_kept(name) && is_writable(name, value) && !is_shared(value) && !image.other.contains_key(name)
    });
    layer
}

/// What the colorimetry states replaces what the picture's file stated.
fn stated_luminance(layer: LayerAttributes, options: &ExrOptions) -> LayerAttributes {
    let white = options.color.and_then(|color| color.white_nits).map(|nits| nits.get() as f32);
    let neutral = options.color.and_then(|color| color.adopted_white).map(point);
    let neutral = neutral.or(layer.adopted_neutral).and_then(|xy| {
        match options.color.map(|color| color.primaries.white).zip(options.primaries.map(|space| space.white)) {
            Some((from, to)) if from != to => adapted(xy, from, to),
            _ => Some(xy),
        }
    });
    LayerAttributes { white_luminance: white.or(layer.white_luminance), adopted_neutral: neutral, ..layer }
}

/// Whether an attribute of the input is written: not those that the encoder makes, and none that would be false.
fn is_kept(name: &Text) -> bool {
    let is_reserved = standard_names::ALL.iter().any(|reserved| *reserved == name.as_slice());
    !is_reserved && !describes_old_pixels(name)
}

/// Whether the name and the type of an attribute have an end: a zero ends them, so neither may be empty or have one.
/// The reader takes a zero at the beginning of a type for a letter.
fn is_writable(name: &Text, value: &AttributeValue) -> bool {
    let is_text = |text: &Text| !text.as_slice().is_empty() && !text.as_slice().contains(&0);
    is_text(name) && !matches!(value, AttributeValue::Custom { kind, .. } if !is_text(kind))
}

/// The rows of one block, each row channel after channel.
fn planes(picture: &Picture, header: &Header, conversion: Option<&Mat3>, block: &BlockIndex) -> Vec<u8> {
    let row_length = picture.width as usize * 4;
    let (first, rows) = (block.pixel_position.1, block.pixel_size.1);
    let range = first * row_length..(first + rows) * row_length;
    let is_float = header.channels.uniform_sample_type == Some(SampleType::F32);
    let stored = &STORED[STORED.len() - header.channels.list.len()..];
    let mut bytes = Vec::with_capacity(rows * picture.width as usize * header.channels.bytes_per_pixel);
    if let Pixels::Half(v) = &picture.pixels
        && conversion.is_none()
        && !is_float
    {
        plane_rows(&v[range], row_length, stored, |v| v.to_ne_bytes(), &mut bytes);
        return bytes;
    }
    let mut values = match &picture.pixels {
        Pixels::Half(values) => values[range].to_f32_vec(),
        Pixels::Float(values) => values[range].to_vec(),
    };
    if let Some(matrix) = conversion {
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            [*r, *g, *b] = convert(matrix, [*r, *g, *b]);
        }
    }
    if is_float {
        plane_rows(&values, row_length, stored, f32::to_ne_bytes, &mut bytes);
    } else {
        plane_rows(&values, row_length, stored, |v| to_half(v).to_ne_bytes(), &mut bytes);
    }
    bytes
}

fn plane_rows<T: Copy, const N: usize>(
    values: &[T],
    row_length: usize,
    stored: &[(&str, usize)],
    to_bytes: impl Fn(T) -> [u8; N],
    out: &mut Vec<u8>,
) {
    for row in values.chunks_exact(row_length) {
        for &(_, slot) in stored {
            out.extend(row[slot..].iter().step_by(4).flat_map(|&value| to_bytes(value)));
        }
    }
}

/// Finite stays finite: beyond the range of a half, the largest half is written.
fn to_half(value: f32) -> f16 {
    if value.is_finite() { f16::from_f32(value.clamp(-65504.0, 65504.0)) } else { f16::from_f32(value) }
}

/// Puts the attributes of a single-part file into the order of their names. The header's length
/// stays the same, so every offset stays right.
fn sort_attributes(file: &mut [u8]) {
    const START: usize = 8;
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut at = START;
    while file[at] != 0 {
        let end = attribute_end(file, at);
        attributes.push(file[at..end].to_vec());
        at = end;
    }
    attributes.sort();
    file[START..at].copy_from_slice(&attributes.concat());
}

/// An attribute is a name and a type, each ended by 0, the length of its value, and the value.
fn attribute_end(file: &[u8], start: usize) -> usize {
    let after_zero = |from: usize| from + file[from..].iter().take_while(|b| **b != 0).count() + 1;
    let length_at = after_zero(after_zero(start));
    let length: [u8; 4] = std::array::from_fn(|i| file[length_at + i]);
    length_at + 4 + u32::from_le_bytes(length) as usize
}
