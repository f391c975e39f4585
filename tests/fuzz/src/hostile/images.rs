//! Images that are damaged, and small ones that claim to be large.

use std::io::Cursor;

use exr::block::UncompressedBlock;
use exr::block::writer::ChunksWriter;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::Header;

use crate::case::Case;
use crate::classes::Sources;

const SIDE: usize = 16384;
const LINE: &str = "render p.ron in -o out.exr --memory";
/// For decoding: the picture alone exceeds the first, and the second is the most that the class allows.
const MEMORY: [&str; 2] = ["16M", "128M"];

const PIPELINE: &str = r#"Pipeline(inputs: { "scene": Color }, nodes: { "a": Saturation(source: "scene", amount: 0.5) }, outputs: { "out": "a" })"#;

type Make = fn() -> Vec<u8>;

const BOMBS: [(&str, Make); 17] = [
    ("a PNG of bits", || png_of((SIDE as u32, SIDE as u32), None)),
    ("a PNG of bits with 11000 pixels a side", || png_of((11_000, 11_000), None)),
    ("a PNG header of 65536x65536", || png_header(65536, 65536)),
    ("a PNG header of 4294967295x1", || png_header(u32::MAX, 1)),
    ("a PNG of one row", || png_of((65535, 1), None)),
    ("a PNG with a profile of 2 MB", || png_of((8, 8), Some(vec![7; 2 << 20]))),
    ("a PNG with a profile of 200 MB of zeros", || png_of((8, 8), Some(vec![0; 200 << 20]))),
    ("a PNG with 50 MB of text", || png_of_text(50 << 20)),
    ("a Radiance file of runs", || radiance(SIDE, SIDE)),
    ("a Radiance file of three rows", || radiance(SIDE, 3)),
    ("a Radiance file of old runs", old_runs),
    ("an EXR of 4x4 pixels in a window of 16384x16384", || exr_of((SIDE, SIDE), 1, Some((4, 4)))),
    ("an EXR of runs", || exr_of((8192, 8192), 1, None)),
    ("an EXR of 16384x16384 pixels", || exr_of((SIDE, SIDE), 1, None)),
    ("an EXR of 3000 channels", || exr_of((16, 16), 3000, None)),
    ("an EXR of 2000 parts", || exr_of_parts(2000)),
    ("an EXR with a long name", || exr_of_parts(0)),
];

pub(crate) fn mutated(sources: &Sources, number: u64) -> Case {
    Case::new(LINE).word("128M").with("p.ron", PIPELINE).with("in", sources.images.get(number))
}

pub(crate) fn bombs() -> u64 {
    (BOMBS.len() * MEMORY.len()) as u64
}

pub(crate) fn bomb(_: &Sources, number: u64) -> Case {
    let (_, make) = BOMBS[number as usize / MEMORY.len()];
    Case::new(LINE).word(MEMORY[number as usize % MEMORY.len()]).with("p.ron", PIPELINE).with("in", make())
}

/// A PNG of one bit a pixel, with a profile.
fn png_of((width, height): (u32, u32), profile: Option<Vec<u8>>) -> Vec<u8> {
    let mut file = Vec::new();
    let mut info = png::Info::with_size(width, height);
    info.bit_depth = png::BitDepth::One;
    info.color_type = png::ColorType::Grayscale;
    info.icc_profile = profile.map(Into::into);
    let encoder = png::Encoder::with_info(&mut file, info).expect("an image");
    let mut writer = encoder.write_header().expect("a header can be written");
    writer.write_image_data(&vec![0x55; width.div_ceil(8) as usize * height as usize]).expect("pixels");
    drop(writer);
    file
}

/// The header of a PNG of bytes, and nothing else but a few bytes.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut file = png_of((8, 8), None);
    file[16..20].copy_from_slice(&width.to_be_bytes());
    file[20..24].copy_from_slice(&height.to_be_bytes());
    let bit = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    let sum = !file[12..29].iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| bit(crc)));
    file[29..33].copy_from_slice(&sum.to_be_bytes());
    file
}

fn png_of_text(bytes: usize) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 8, 8);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.add_ztxt_chunk("Comment".into(), "x".repeat(bytes)).expect("a comment");
    let mut writer = encoder.write_header().expect("a header can be written");
    writer.write_image_data(&[0; 64]).expect("pixels");
    drop(writer);
    file
}

/// A Radiance file whose header claims 16384x16384 pixels. Rows have two bytes for 127 of a channel's pixels.
fn radiance(width: usize, rows: usize) -> Vec<u8> {
    let [high, low] = (width as u16).to_be_bytes();
    let channel = [[255, 64].repeat(width / 127), vec![128 + (width % 127) as u8, 64]].concat();
    let row = [vec![2, 2, high, low], channel.repeat(4)].concat();
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {SIDE} +X {width}\n");
    [header.into_bytes(), row.repeat(rows)].concat()
}

/// Runs of the first form: each repeats a pixel, and several after each other are multiplied by 256.
fn old_runs() -> Vec<u8> {
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n".to_vec();
    [header, vec![9, 9, 9, 128], [1, 1, 1, 255].repeat(64)].concat()
}

/// An EXR of equal pixels.
fn exr_of((width, height): (usize, usize), channels: usize, display: Option<(usize, usize)>) -> Vec<u8> {
    let name = |at: usize| if at == 0 { "Y".to_owned() } else { format!("channel{at:05}") };
    let mut channels: Vec<_> =
        (0..channels).map(|at| ChannelDescription::named(name(at).as_str(), SampleType::F16)).collect();
    channels.sort_by(|one, other| one.name.bytes().cmp(other.name.bytes()));
    let count = channels.len();
    let mut header = Header::new("".into(), (width, height), channels.into_iter().collect()).with_encoding(
        Compression::RLE,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    let (across, down) = display.unwrap_or((width, height));
    header.shared_attributes.display_window = IntegerBounds::from_dimensions(Vec2(across, down));
    written(vec![header], count)
}

/// An EXR of `count` parts of one pixel, or of one part with a name of a million letters.
fn exr_of_parts(count: usize) -> Vec<u8> {
    let part = |name: String| {
        let channels = [ChannelDescription::named("Y", SampleType::F16)].into_iter().collect();
        let name = Text::new_or_none(&name).expect("letters");
        Header::new(name, (1, 1), channels).with_encoding(
            Compression::Uncompressed,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
    };
    let parts = (0..count).map(|at| part(format!("part{at}"))).collect();
    written(if count == 0 { vec![part("x".repeat(1 << 20))] } else { parts }, 1)
}

fn written(headers: Vec<Header>, channels: usize) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let result = exr::block::write(&mut file, headers.into_iter().collect(), true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        blocks.into_iter().try_for_each(|(index, block)| {
            let block = UncompressedBlock { index: block, data: vec![0; block.pixel_size.area() * 2 * channels] };
            writer.write_chunk(index, block.compress_to_chunk(&meta.headers)?)
        })
    });
    result.expect("an image can be encoded");
    file.into_inner()
}
