//! The header of a picture in an EXR file: one scan-line part, R G B and perhaps A, attributes kept.

use afterimage_base::color::{Chromaticities, Colorimetry};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes, standard_names};
use glam::Mat3;

use super::attributes::{attribute_names, attributes_left_out, is_structure, remove_unwritable};
use super::describe::compression_name;
use super::label::{describes_old_pixels, name_primaries};
use super::pack::{Column, Content, pack};
use super::read::{adapted, point, to_attribute};
use crate::codec::chromaticities::{adopted_white, conversion};
use crate::codec::limits::check_size;
use crate::codec::{CodecError, Metadata, Picture};

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
    /// they are known. `None` for data, of which the file states no `chromaticities`.
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
    pub(super) fn conversion(&self) -> Option<Mat3> {
        conversion(&self.color?.primaries, &self.written_primaries()?).map(|matrix| matrix.as_mat3())
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

    /// Rows that it packs together.
    pub fn block_rows(self) -> u32 {
        self.method().scan_lines_per_block() as u32
    }

    /// Whether numbers of that type come back as they were.
    pub(super) fn is_lossless_for(self, samples: SampleType) -> bool {
        self.method().is_lossless_for(samples)
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
    encode(picture, options).map(|(file, _)| file)
}

/// The file, and sentences about attributes of the picture that are left out.
pub(crate) fn encode(picture: &Picture, options: &ExrOptions) -> Result<(Vec<u8>, Vec<String>), CodecError> {
    let bytes = if options.float { 4 } else { 2 };
    check_size((picture.width.into(), picture.height.into()), bytes)?;
    let size = (picture.width, picture.height);
    let (mut header, columns) = part_of(size, &picture.meta, options, &picture_names(), Vec::new(), true);
    let notes = settle(&mut header, &picture.meta);
    let (headers, conversion) = ([header], options.conversion());
    let (width, pixels, headers, columns) = (picture.width, &picture.pixels, &headers, &columns);
    let content = Content { width, pixels, first_row: 0, conversion, headers, part: 0, columns, rows: &[] };
    Ok((pack(&content, Vec::new())?, notes))
}

/// Takes away what cannot be written of the attributes of a part with a picture. Returns sentences about that, and
/// about what the picture has and the part has not.
pub(super) fn settle(header: &mut Header, meta: &Metadata) -> Vec<String> {
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
pub(super) fn picture_names() -> [String; 4] {
    ["R", "G", "B", "A"].map(str::to_owned)
}

/// The part of a picture of that size whose channels have these names, beside others that are kept, and where each of
/// its channels comes from. `is_alone` if the file has no other part.
pub(super) fn part_of(
    size: (u32, u32),
    meta: &Metadata,
    options: &ExrOptions,
    names: &[String; 4],
    kept: Vec<ChannelDescription>,
    is_alone: bool,
) -> (Header, Vec<Column>) {
    let sample_type = if options.float { SampleType::F32 } else { SampleType::F16 };
    // B44 quantizes some channels on a curve that does not keep an alpha of 1.
    let is_curved = !matches!(options.compression, ExrCompression::B44 | ExrCompression::B44a);
    let channel = |name: &String| {
        let named = ChannelDescription::named(name.as_str(), sample_type);
        ChannelDescription { quantize_linearly: named.quantize_linearly && is_curved, ..named }
    };
    let written = if options.alpha { &names[..] } else { &names[..3] };
    let mut channels: Vec<_> =
        written.iter().enumerate().map(|(slot, name)| (channel(name), Column::Picture(slot))).collect();
    // An ACES container (SMPTE ST 2065-4) has uncompressed halves in rows, and no channels but R, G, B and A.
    let is_plain = options.compression == ExrCompression::None && !options.float && kept.is_empty() && is_alone;
    let mut start = 0;
    for channel in kept {
        let length = size.0 as usize * channel.sample_type.bytes_per_sample();
        channels.push((channel, Column::Kept { start, length }));
        start += length;
    }
    // EXR channels are stored in alphabetical order.
    channels.sort_by(|(a, _), (b, _)| a.name.as_slice().cmp(b.name.as_slice()));
    let (channels, columns): (Vec<_>, Vec<_>) = channels.into_iter().unzip();
    let image = image_attributes(size, meta, options);
    let mut layer = stated_luminance(layer_attributes(size, meta, &image), options);
    let has_unknown_colors = meta.has_unknown_colors && options.primaries.is_none();
    if let Some(primaries) = options.written_primaries().filter(|_| options.scene && !has_unknown_colors) {
        name_primaries(&mut layer, &primaries, is_plain);
    }
    let header = Header::new(Text::default(), (size.0 as usize, size.1 as usize), channels.into())
        .with_encoding(options.compression.method(), BlockDescription::ScanLines, LineOrder::Increasing)
        .with_shared_attributes(image)
        .with_attributes(layer);
    (header, columns)
}

fn image_attributes(size: (u32, u32), meta: &Metadata, options: &ExrOptions) -> ImageAttributes {
    let mut image = meta.image.clone();
    let is_window = is_data_window(size, meta);
    let size = (size.0 as usize, size.1 as usize);
    if !is_window && image.display_window.size != size.into() {
        image.display_window = IntegerBounds::from_dimensions(size);
    }
    if !(1e-6..=1e6).contains(&image.pixel_aspect) {
        image.pixel_aspect = 1.0;
    }
    let primaries = options.written_primaries().map(|primaries| to_attribute(&primaries));
    if !(meta.has_unknown_colors && options.primaries.is_none() && image.chromaticities.is_none()) {
        image.chromaticities = primaries;
    }
    image.other.retain(|name, _| is_kept(name));
    image
}

/// Whether the picture is written as the data window of a larger or smaller display window.
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

/// What the colorimetry states replaces what the picture's file stated.
fn stated_luminance(layer: LayerAttributes, options: &ExrOptions) -> LayerAttributes {
    let white = options.color.and_then(|color| color.white_nits).map(|nits| nits.get() as f32);
    let neutral = options.color.and_then(|color| color.adopted_white).map(point);
    let neutral = neutral.or(layer.adopted_neutral).and_then(|xy| {
        match options.color.map(|color| color.primaries).zip(options.primaries) {
            Some((from, to)) => adapted(xy, adopted_white(&from), adopted_white(&to)),
            None => Some(xy),
        }
    });
    LayerAttributes { white_luminance: white.or(layer.white_luminance), adopted_neutral: neutral, ..layer }
}

/// Whether an attribute of the input is written: not those that the encoder makes, and none that would be false.
fn is_kept(name: &Text) -> bool {
    !is_structure(name.as_slice()) && !BOUND.contains(&name.as_slice()) && !describes_old_pixels(name)
}

/// Attributes that describe the old picture or the old parts, which are not copied whatever their type.
const BOUND: [&[u8]; 4] =
    [standard_names::PREVIEW, standard_names::MULTI_VIEW, standard_names::VIEW, standard_names::DEEP_IMAGE_STATE];
