//! Small files of images that take much memory: a picture within the budget, or an error that names it.

use std::fs::File;
use std::io::BufWriter;

use exr::block::UncompressedBlock;
use exr::block::writer::ChunksWriter;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType};
use exr::meta::header::Header;

use super::Folder;

const SIDE: u32 = 16384;
/// MiB that the program and the driver take without an image, with a margin for other drivers.
const PROGRAM: u64 = 400;

/// A PNG of one bit a pixel.
fn png_of_bits(folder: &Folder) {
    let file = BufWriter::new(File::create(folder.file("bits.png")).expect("a file"));
    let mut encoder = png::Encoder::new(file, SIDE, SIDE);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&vec![0x55; (SIDE * SIDE / 8) as usize]).expect("pixels");
}

/// An EXR whose data window is far larger than its display window.
fn exr_of_4x4(folder: &Folder) {
    let channel = ChannelDescription::named("Y", SampleType::F16);
    let mut header = Header::new("".into(), (SIDE as usize, SIDE as usize), [channel].into_iter().collect())
        .with_encoding(Compression::RLE, BlockDescription::ScanLines, LineOrder::Increasing);
    header.shared_attributes.display_window = IntegerBounds::from_dimensions(Vec2(4, 4));
    let file = BufWriter::new(File::create(folder.file("window.exr")).expect("a file"));
    exr::block::write(file, [header].into_iter().collect(), true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        blocks.into_iter().try_for_each(|(index, block)| {
            let block = UncompressedBlock { index: block, data: vec![0; block.pixel_size.area() * 2] };
            writer.write_chunk(index, block.compress_to_chunk(&meta.headers)?)
        })
    })
    .expect("an image");
}

/// Radiance rows of two bytes for 127 of a channel's pixels.
fn hdr_of_runs(folder: &Folder, name: &str, rows: usize) {
    let [high, low] = (SIDE as u16).to_be_bytes();
    let channel = [[255, 64].repeat(SIDE as usize / 127), vec![128 + (SIDE % 127) as u8, 64]].concat();
    let row = [vec![2, 2, high, low], channel.repeat(4)].concat();
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {SIDE} +X {SIDE}\n");
    folder.with(name, &[header.into_bytes(), row.repeat(rows)].concat());
}

/// The size of each image and what is said about it, with 512 MiB for decoding.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bombs_are_refused_by_their_headers() {
    let folder = Folder::new("bombs");
    png_of_bits(&folder);
    hdr_of_runs(&folder, "runs.hdr", SIDE as usize);
    for (name, needed) in [("bits.png", "2.0 GiB"), ("runs.hdr", "7.0 GiB")] {
        let (outcome, most) = folder.run_measured(&format!("render {{glare}} {name} -o out.png --memory 512M"));
        outcome.fails(
            1,
            &format!(
                "error: {name}: the image is too large: 16384×16384 pixels need {needed}\n  hint: decoding may take 512 MiB; \
                 `--memory SIZE` changes the limit"
            ),
        );
        assert!(most < PROGRAM, "{name}: {most} MiB");
    }
    folder.run("render {glare} bits.png -o out.png --memory 1.5").fails_saying(1, &["--memory", "such as 512M"]);
}

/// What a header claims takes no memory before the pixels are there.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_short_file_with_a_large_header_takes_no_memory() {
    let folder = Folder::new("short");
    hdr_of_runs(&folder, "short.hdr", 3);
    let (outcome, most) = folder.run_measured("render {glare} short.hdr -o out.png --memory 16G");
    outcome.fails_saying(1, &["short.hdr: the file ends too early"]);
    assert!(most < PROGRAM, "{most} MiB");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pixels_outside_of_the_display_window_take_no_memory() {
    let folder = Folder::new("window");
    exr_of_4x4(&folder);
    let (outcome, most) = folder.run_measured("render {glare} window.exr -o out.png --memory 64M");
    outcome.good();
    assert!(most < PROGRAM, "{most} MiB");
    let picture = afterimage_media::read(&afterimage_media::Source::file(folder.file("out.png"))).expect("it is whole");
    assert_eq!((picture.width, picture.height), (4, 4));
}
