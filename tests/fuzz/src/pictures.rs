//! Small images in every form that is read.

use afterimage_media::{Alpha, Encoding, ImageFormat, Picture, Pixels, Samples, encode};
use exr::block::UncompressedBlock;
use exr::block::writer::ChunksWriter;
use exr::math::{RoundingMode, Vec2};
use exr::meta::BlockDescription;
use exr::meta::attribute::LevelMode;
use exr::meta::attribute::{ChannelDescription, Compression, LineOrder, SampleType, TileDescription};
use exr::meta::header::Header;

const COMPRESSIONS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

/// Each kind of image that is read, always in the same order.
pub(crate) fn pictures() -> Vec<Vec<u8>> {
    let scanlines = COMPRESSIONS.map(|compression| exr_of(compression, BlockDescription::ScanLines));
    let tiles = COMPRESSIONS.map(|compression| exr_of(compression, in_tiles()));
    let own = encode(&picture(), &Encoding::EXR).expect("a picture can be encoded");
    scanlines
        .into_iter()
        .chain(tiles)
        .chain([own, runs(), flat_radiance()])
        .chain(pngs())
        .chain([jpeg()])
        .chain(tiffs())
        .collect()
}

fn picture() -> Picture {
    let numbers = (0..17 * 11 * 4).map(|i| (i * 37 % 251) as f32 * 0.03).collect();
    Picture::new(17, 11, Pixels::Float(numbers))
}

fn jpeg() -> Vec<u8> {
    let codes: Vec<u8> = (0..17 * 11 * 4).map(|i| (i * 37 % 251) as u8).collect();
    encode(((17, 11), Samples::Byte(&codes)), &Encoding::JPEG).expect("a picture can be encoded")
}

/// A TIFF of codes of each depth, and one of floats.
fn tiffs() -> impl Iterator<Item = Vec<u8>> {
    [8, 16, 32].into_iter().map(|bits| {
        let encoding = Encoding { format: ImageFormat::Tiff, bits, alpha: Alpha::Keep, ..Encoding::PNG };
        encode(&picture(), &encoding).expect("a picture can be encoded")
    })
}

fn in_tiles() -> BlockDescription {
    BlockDescription::Tiles(TileDescription {
        tile_size: Vec2(16, 16),
        level_mode: LevelMode::Singular,
        rounding_mode: RoundingMode::Down,
    })
}

/// An EXR of 40x24 pixels with channels of each type.
fn exr_of(compression: Compression, blocks: BlockDescription) -> Vec<u8> {
    let channels = [("B", SampleType::F16), ("G", SampleType::F16), ("R", SampleType::F32), ("Z", SampleType::U32)];
    let channels = channels.map(|(name, kind)| ChannelDescription::named(name, kind));
    let header = Header::new("".into(), (40, 24), channels.into_iter().collect());
    let header = header.with_encoding(compression, blocks, LineOrder::Increasing);
    let mut file = std::io::Cursor::new(Vec::new());
    let written = exr::block::write(&mut file, [header].into_iter().collect(), true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        blocks.into_iter().try_for_each(|(index, block)| {
            let halves = (0..block.pixel_size.area() * 6).map(|i| 0x3000 + (i * 7 % 64) as u16);
            let block = UncompressedBlock { index: block, data: halves.flat_map(u16::to_ne_bytes).collect() };
            writer.write_chunk(index, block.compress_to_chunk(&meta.headers)?)
        })
    });
    written.expect("an image can be encoded");
    file.into_inner()
}

/// A Radiance file of runs and of single bytes.
fn runs() -> Vec<u8> {
    let channel = [vec![128 + 20, 64, 12], (1..=12).collect::<Vec<u8>>(), vec![128 + 8, 130]].concat();
    let row = [vec![2, 2, 0, 40], channel.repeat(4)].concat();
    [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2.0\n\n-Y 6 +X 40\n".to_vec(), row.repeat(6)].concat()
}

/// A Radiance file without runs.
fn flat_radiance() -> Vec<u8> {
    [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 5 +X 7\n".to_vec(), vec![77; 5 * 7 * 4]].concat()
}

fn pngs() -> Vec<Vec<u8>> {
    use png::{BitDepth, ColorType};
    let codes: Vec<u8> = (0..16 * 9 * 4).map(|i| (i * 37 % 251) as u8).collect();
    let options = Encoding { alpha: Alpha::Keep, ..Encoding::PNG };
    let own = encode(((16, 9), Samples::Byte(&codes)), &options).expect("a picture can be encoded");
    let kinds = [
        (ColorType::Grayscale, BitDepth::One, 2),
        (ColorType::Indexed, BitDepth::Four, 8),
        (ColorType::GrayscaleAlpha, BitDepth::Eight, 32),
        (ColorType::Rgb, BitDepth::Sixteen, 96),
        (ColorType::Rgba, BitDepth::Sixteen, 128),
    ];
    [own].into_iter().chain(kinds.map(|(color, depth, stride)| png_of(color, depth, stride))).collect()
}

/// A PNG of 16x9 pixels whose rows have that many bytes.
fn png_of(color: png::ColorType, depth: png::BitDepth, stride: usize) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 16, 9);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_palette((0..48).map(|i| i * 5).collect::<Vec<u8>>());
    encoder.set_source_gamma(png::ScaledFloat::new(0.45455));
    let mut writer = encoder.write_header().expect("a header can be written");
    let rows: Vec<u8> = (0..stride * 9).map(|i| (i * 29 % 241) as u8).collect();
    writer.write_image_data(&rows).expect("pixels can be written");
    drop(writer);
    file
}
