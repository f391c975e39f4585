//! The header of a picture in an EXR file: one scan-line part, R G B and perhaps A, attributes kept.

use afterimage_base::color::Chromaticities;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes, standard_names};
use glam::Mat3;

use super::attributes::{attribute_names, attributes_left_out, is_structure, remove_unwritable};
use super::colors::{adapted, point, to_attribute};
use super::label::{describes_old_pixels, name_primaries};
use super::pack::Column;
use crate::codec::chromaticities::{adopted_white, conversion};
use crate::codec::{Alpha, Encoding, ExrCompression, Metadata};

impl Encoding {
    /// The primaries of the written numbers; `None` for data.
    pub(super) fn written_primaries(&self) -> Option<Chromaticities> {
        self.color.map(|color| self.primaries.unwrap_or(color.primaries))
    }

    /// From the primaries of the picture to those of the file; `None` if they are the same.
    pub(super) fn conversion(&self) -> Option<Mat3> {
        conversion(&self.color?.primaries, &self.written_primaries()?).map(|matrix| matrix.as_mat3())
    }
}

/// Removes the attributes of a part that cannot be written. Returns notes about them, and about attributes of the
/// picture that the part lacks.
pub(super) fn finish_attributes(header: &mut Header, meta: &Metadata) -> Vec<String> {
    let before = attribute_names(&meta.image, &meta.layer);
    let wanted = attribute_names(&header.shared_attributes, &header.own_attributes);
    let mut notes = remove_unwritable(header);
    // Of the name of a part and of what the file consists of it has its own.
    let old = before.difference(&wanted).filter(|name| !is_structure(name));
    let old = old.filter(|name| name.as_slice() != standard_names::CHROMATICITIES);
    let old = old.map(|name| format!("`{}`", String::from_utf8_lossy(name)));
    notes.extend(attributes_left_out(old, "not true of the output"));
    notes
}

/// The names of red, green, blue and alpha.
pub(super) fn picture_names() -> [Text; 4] {
    ["R", "G", "B", "A"].map(Text::from)
}

/// The part of a picture of that size whose channels have these names, beside others that are kept, and where each of
/// its channels comes from. `is_alone` if the file has no other part.
pub(super) fn part_of(
    size: (u32, u32),
    meta: &Metadata,
    encoding: &Encoding,
    names: &[Text; 4],
    preserved: Vec<ChannelDescription>,
    is_alone: bool,
) -> (Header, Vec<Column>) {
    let sample_type = if encoding.bits == 32 { SampleType::F32 } else { SampleType::F16 };
    // B44 quantizes some channels on a curve that does not keep an alpha of 1.
    let is_curved = !matches!(encoding.compression, ExrCompression::B44 | ExrCompression::B44a);
    let channel = |name: &Text| {
        let named = ChannelDescription::named(name.clone(), sample_type);
        ChannelDescription { quantize_linearly: named.quantize_linearly && is_curved, ..named }
    };
    let written = if encoding.alpha == Alpha::Drop { &names[..3] } else { &names[..] };
    let mut channels: Vec<_> =
        written.iter().enumerate().map(|(slot, name)| (channel(name), Column::Picture(slot))).collect();
    // An ACES container (SMPTE ST 2065-4) has uncompressed halves in rows, and no channels but R, G, B and A.
    let is_plain =
        encoding.compression == ExrCompression::None && encoding.bits == 16 && preserved.is_empty() && is_alone;
    let mut start = 0;
    for channel in preserved {
        let length = size.0 as usize * channel.sample_type.bytes_per_sample();
        channels.push((channel, Column::Preserved { start, length }));
        start += length;
    }
    // EXR channels are stored in alphabetical order.
    channels.sort_by(|(a, _), (b, _)| a.name.as_slice().cmp(b.name.as_slice()));
    let (channels, columns): (Vec<_>, Vec<_>) = channels.into_iter().unzip();
    let image = image_attributes(size, meta, encoding);
    let mut layer = stated_luminance(layer_attributes(size, meta, &image), encoding);
    let has_unknown_colors = meta.has_unknown_colors && encoding.primaries.is_none();
    if let Some(primaries) = encoding.written_primaries().filter(|_| encoding.scene && !has_unknown_colors) {
        name_primaries(&mut layer, &primaries, is_plain);
    }
    let header = Header::new(Text::default(), (size.0 as usize, size.1 as usize), channels.into())
        .with_encoding(encoding.compression.method(), BlockDescription::ScanLines, LineOrder::Increasing)
        .with_shared_attributes(image)
        .with_attributes(layer);
    (header, columns)
}

fn image_attributes(size: (u32, u32), meta: &Metadata, encoding: &Encoding) -> ImageAttributes {
    let mut image = meta.image.clone();
    let is_window = is_data_window(size, meta);
    let size = (size.0 as usize, size.1 as usize);
    if !is_window && image.display_window.size != size.into() {
        image.display_window = IntegerBounds::from_dimensions(size);
    }
    if !(1e-6..=1e6).contains(&image.pixel_aspect) {
        image.pixel_aspect = 1.0;
    }
    let primaries = encoding.written_primaries().map(|primaries| to_attribute(&primaries));
    if !(meta.has_unknown_colors && encoding.primaries.is_none() && image.chromaticities.is_none()) {
        image.chromaticities = primaries;
    }
    image.other.retain(|name, _| is_kept(name));
    image
}

/// True if the picture is written as the data window of a larger or smaller display window.
fn is_data_window(size: (u32, u32), meta: &Metadata) -> bool {
    meta.data_size == Some(size)
}

/// The layer's attributes, without those that describe the old file rather than the picture.
fn layer_attributes(size: (u32, u32), meta: &Metadata, image: &ImageAttributes) -> LayerAttributes {
    let mut layer = meta.layer.clone();
    if !is_data_window(size, meta) {
        layer.layer_position = image.display_window.position;
    }
    layer.layer_name = None;
    layer.preview = None;
    layer.multi_view_names = None;
    layer.view_name = None;
    layer.deep_image_state = None;
    layer.screen_window_width = layer.screen_window_width.max(0.0);
    layer.other.retain(|name, _| is_kept(name));
    layer
}

/// Sets the luminance and the white that the colorimetry states in place of those of the input.
fn stated_luminance(layer: LayerAttributes, encoding: &Encoding) -> LayerAttributes {
    let white = encoding.color.and_then(|color| color.white_nits).map(|nits| nits.get() as f32);
    let neutral = encoding.color.and_then(|color| color.adopted_white).map(point);
    let neutral = neutral.or(layer.adopted_neutral).and_then(|xy| {
        match encoding.color.map(|color| color.primaries).zip(encoding.primaries) {
            Some((from, to)) => adapted(xy, adopted_white(&from), adopted_white(&to)),
            None => Some(xy),
        }
    });
    LayerAttributes { white_luminance: white.or(layer.white_luminance), adopted_neutral: neutral, ..layer }
}

/// True if an attribute of the input is written: not those that the encoder makes, and none that would be false.
fn is_kept(name: &Text) -> bool {
    !is_structure(name.as_slice()) && !BOUND.contains(&name.as_slice()) && !describes_old_pixels(name)
}

/// Attributes that describe the old picture or the old parts, which are not copied whatever their type.
const BOUND: [&[u8]; 4] =
    [standard_names::PREVIEW, standard_names::MULTI_VIEW, standard_names::VIEW, standard_names::DEEP_IMAGE_STATE];
