//! Files that lie. Each must give an error, soon, and never take the process with it.

use std::fs;

use ::exr::block::UncompressedBlock;
use ::exr::block::writer::ChunksWriter;
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{ChannelDescription, Compression, LevelMode, LineOrder, SampleType, TileDescription};
use ::exr::meta::header::Header;

use super::{Folder, message_and_hint, picture};
use afterimage_media::*;

fn small_exr() -> Vec<u8> {
    encode(&picture(33, 17), &Encoding::EXR).unwrap()
}

/// Where the value of an attribute begins: after name, type and length.
fn value_of(file: &[u8], name: &str) -> usize {
    let name = format!("{name}\0");
    let at = file.windows(name.len()).position(|window| window == name.as_bytes()).unwrap();
    let kind = at + name.len();
    kind + file[kind..].iter().position(|byte| *byte == 0).unwrap() + 1 + 4
}

fn put(file: &mut [u8], at: usize, values: &[i32]) {
    for (i, value) in values.iter().enumerate() {
        file[at + i * 4..at + i * 4 + 4].copy_from_slice(&value.to_le_bytes());
    }
}

/// The valid file with another window, as minimum and maximum.
fn with_window(name: &str, corners: [i32; 4]) -> Vec<u8> {
    let mut file = small_exr();
    let at = value_of(&file, name);
    put(&mut file, at, &corners);
    // The number of blocks would contradict the window; old files do not state it.
    let count = file.windows(10).position(|window| window == b"chunkCount").unwrap();
    file[count] = b'C';
    file
}

#[test]
fn absurd_windows_are_refused_before_decoding() {
    let folder = Folder::new("absurd");
    let table = [
        ("dataWindow", [0, 0, 999_999_999, 999_999_999], ErrorKind::TooLarge),
        ("displayWindow", [0, 0, 999_999_999, 999_999_999], ErrorKind::TooLarge),
        ("dataWindow", [0, 0, 70_000, 16], ErrorKind::TooLarge),
        ("displayWindow", [0, 0, 60_000, 60_000], ErrorKind::TooLarge),
        ("dataWindow", [0, 0, 32, 60_000], ErrorKind::Broken),
        ("dataWindow", [0, 0, -5, -5], ErrorKind::Broken),
        ("displayWindow", [0, 0, i32::MAX, i32::MIN], ErrorKind::Broken),
        ("dataWindow", [i32::MIN, i32::MIN, i32::MAX, i32::MAX], ErrorKind::Broken),
    ];
    for (window, corners, kind) in table {
        let error = folder.read(&with_window(window, corners)).unwrap_err();
        assert_eq!(error.kind, kind, "{window} {corners:?}: {error}");
        assert_eq!(error.exit(), 1);
    }
    let error = folder.read(&with_window("displayWindow", [0, 0, 29_999, 39_999])).unwrap_err();
    assert_eq!(
        message_and_hint(&error),
        "the image is too large: 30000×40000 pixels need 9.0 GiB; \
         decoding may take 4.0 GiB; `--memory SIZE` changes the limit"
    );
    let error = folder.read(&with_window("dataWindow", [1, 0, 70_000, 16])).unwrap_err();
    assert_eq!(
        message_and_hint(&error),
        "the image is too large: a data window has 70000×17 pixels; \
         a side may have at most 65536 pixels"
    );
}

/// The offset of each block takes eight bytes, so a file that is too short for them is not as its header describes it.
#[test]
fn a_file_that_is_too_short_for_its_blocks_is_not_described() {
    let folder = Folder::new("too-short");
    let describe = |bytes: &[u8]| read_description(&Source::file(folder.with("described.exr", bytes)));
    describe(&with_window("dataWindow", [0, 0, 32, 16])).expect("it is whole");
    let error = describe(&with_window("dataWindow", [0, 0, 32, 60_000])).unwrap_err();
    assert_eq!((error.kind, error.message.as_str()), (ErrorKind::Broken, "the file ends too early"));
}

#[test]
fn subsampled_and_deep_files_say_so() {
    let folder = Folder::new("subsampled");
    let mut file = small_exr();
    // A channel is its name, type, linearity with three spare bytes, and two sampling rates.
    let sampling = value_of(&file, "channels") + 2 + 4 + 4;
    put(&mut file, sampling, &[3, 1]);
    let error = folder.read(&file).unwrap_err();
    assert_eq!(
        message_and_hint(&error),
        "its channel `A` has one number for 3x1 pixels, which is not supported; \
         save it again with that channel in full size, or without it"
    );
    let mut file = small_exr();
    let at = value_of(&file, "type");
    assert_eq!(&file[at..at + 13], b"scanlineimage");
    put(&mut file, at - 4, &[12]);
    file.splice(at..at + 13, *b"deepscanline");
    let error = folder.read(&file).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Unsupported);
    assert_eq!(
        message_and_hint(&error),
        "deep EXR (many samples in a pixel) is not supported; \
         flatten it first, for example `oiiotool deep.exr --flatten -o flat.exr`"
    );
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let folder = Folder::new("cut");
    let pixels = numbers_as_bytes();
    let png = encode(((16, 9), Samples::Byte(&pixels)), &Encoding { alpha: Alpha::Keep, ..Encoding::PNG });
    let tiff = encode(((16, 9), Samples::Byte(&pixels)), &TIFF).unwrap();
    let tiny_hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 40 +X 7\n".to_vec();
    let hdr = [tiny_hdr, vec![77; 40 * 7 * 4]].concat();
    for (file, step) in [(small_exr(), 97), (png.unwrap(), 7), (hdr, 31), (tiff, 7)] {
        assert!(folder.read(&file).is_ok());
        for length in (0..file.len() - 12).step_by(step) {
            let error = folder.read(&file[..length]).unwrap_err();
            let kinds = [ErrorKind::Broken, ErrorKind::Unsupported];
            assert!(kinds.contains(&error.kind), "{length}: {error}");
        }
    }
}

const TIFF: Encoding = Encoding { format: ImageFormat::Tiff, alpha: Alpha::Keep, ..Encoding::PNG };

fn numbers_as_bytes() -> Vec<u8> {
    (0..16 * 9 * 4).map(|i| (i * 37 % 251) as u8).collect()
}

#[test]
fn a_file_with_any_byte_changed_is_read_or_refused() {
    let folder = Folder::new("changed");
    let tiff = encode(((16, 9), Samples::Byte(&numbers_as_bytes())), &TIFF).unwrap();
    for (file, step) in [(small_exr(), 11), (tiff, 3)] {
        let mut refused = 0;
        for at in (4..file.len()).step_by(step) {
            for value in [0, 0xff, file[at] ^ 0x41] {
                let mut changed = file.clone();
                changed[at] = value;
                refused += usize::from(folder.read(&changed).is_err());
            }
        }
        assert!(refused > 50, "{refused}");
    }
}

#[test]
fn a_table_that_names_a_block_twice_is_refused() {
    let folder = Folder::new("twice");
    let mut file = small_exr();
    let table = header_end(&file);
    // 17 rows are two blocks of 16; the second entry now names the first block.
    file.copy_within(table..table + 8, table + 8);
    assert_eq!(
        folder.read(&file).unwrap_err().message,
        "the file is damaged: blocks of the image are missing or stored twice"
    );
}

fn header_end(file: &[u8]) -> usize {
    let skip = |from: usize| from + file[from..].iter().position(|byte| *byte == 0).unwrap() + 1;
    let mut at = 8;
    while file[at] != 0 {
        let length = skip(skip(at));
        let bytes: [u8; 4] = file[length..length + 4].try_into().unwrap();
        at = length + 4 + u32::from_le_bytes(bytes) as usize;
    }
    at + 1
}

/// The decoder believes these counters, and one failed allocation would end the process.
#[test]
fn dwa_counters_that_lie_are_refused() {
    let folder = Folder::new("dwa");
    let tiles =
        TileDescription { tile_size: Vec2(64, 32), level_mode: LevelMode::Singular, rounding_mode: RoundingMode::Down };
    // With the bytes of each block before its counters: its row and its size, or its place and level and its size.
    for (blocks, before) in [(BlockDescription::ScanLines, 8), (BlockDescription::Tiles(tiles), 20)] {
        let file = dwa_exr(blocks);
        assert!(folder.read(&file).is_ok(), "{blocks:?}");
        let table = header_end(&file);
        let offset: [u8; 8] = file[table..table + 8].try_into().unwrap();
        let counters = u64::from_le_bytes(offset) as usize + before;
        for counter in [1, 6, 7, 8, 9] {
            let mut lying = file.clone();
            let at = counters + counter * 8;
            lying[at..at + 8].copy_from_slice(&(1_u64 << 42).to_le_bytes());
            assert_eq!(
                folder.read(&lying).unwrap_err().message,
                "the file is damaged: a DWA block claims more data than it has pixels",
                "{blocks:?}"
            );
        }
    }
}

fn dwa_exr(blocks: BlockDescription) -> Vec<u8> {
    let channels = ["B", "G", "R"].map(|name| ChannelDescription::named(name, SampleType::F16));
    let header = Header::new("".into(), (64, 32), channels.into_iter().collect()).with_encoding(
        Compression::DWAA(None),
        blocks,
        LineOrder::Increasing,
    );
    let mut file = std::io::Cursor::new(Vec::new());
    let headers = [header].into_iter().collect();
    ::exr::block::write(&mut file, headers, true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        blocks.into_iter().try_for_each(|(index, block)| {
            let halves = (0..block.pixel_size.area() * 3).map(|i| 0x3000 + (i % 64) as u16);
            let data = halves.flat_map(u16::to_ne_bytes).collect();
            let block = UncompressedBlock { index: block, data };
            writer.write_chunk(index, block.compress_to_chunk(&meta.headers)?)
        })
    })
    .unwrap();
    file.into_inner()
}

#[test]
fn other_formats_are_held_to_the_same_size() {
    let folder = Folder::new("sizes");
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n".to_vec();
    let mut png = encode(((16, 9), Samples::Byte(&numbers_as_bytes())), &Encoding::PNG).unwrap();
    png[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    // The checksum of the header chunk, CRC-32 of its type and the changed body.
    let crc = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    for file in [hdr, png] {
        let error = folder.read(&file).unwrap_err();
        assert_eq!(error.kind, ErrorKind::TooLarge, "{error}");
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc));
    !bytes.iter().fold(!0, byte)
}

#[test]
fn panics_become_errors() {
    let caught = catch_panic(|| -> u32 { panic!("block {}", 7) });
    assert_eq!(caught, Err("block 7".to_owned()));
    let folder = Folder::new("after-panic");
    fs::write(folder.file("a"), small_exr()).unwrap();
    assert!(read(&Source::file(folder.file("a"))).is_ok());
}
