//! The memory of decoding: known from the header, and refused before anything is decoded.

use super::{Folder, picture};
use afterimage_media::*;

fn hdr(lines: &str, (width, height): (u32, u32)) -> Vec<u8> {
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{lines}\n-Y {height} +X {width}\n");
    [header.into_bytes(), [77, 78, 79, 130].repeat((width * height) as usize)].concat()
}

fn png(bits: u32) -> Vec<u8> {
    let codes: Vec<u8> = (0..16 * 9 * 4).map(|i| (i * 37 % 251) as u8).collect();
    let options = Encoding { bits, alpha: Alpha::Keep, ..Encoding::PNG };
    encode(((16, 9), Samples::Byte(&codes)), &options).unwrap()
}

/// The pixels, and what the decoder has besides them: all codes of a PNG, three floats a pixel of a Radiance file,
/// three batches of 16 MiB of an EXR.
#[test]
fn each_format_needs_what_its_header_says() {
    let folder = Folder::new("budget");
    let exr = encode(&picture(33, 17), &Encoding::EXR).unwrap();
    let exact = encode(&picture(33, 17), &Encoding { bits: 32, ..Encoding::EXR }).unwrap();
    for (name, file, needed) in [
        ("8 bits", png(8), 16 * 9 * (8 + 4)),
        ("16 bits", png(16), 16 * 9 * (16 + 8)),
        ("hdr", hdr("", (7, 40)), 7 * 40 * (16 + 12)),
        ("half", exr, 33 * 17 * 8 + (48 << 20)),
        ("float", exact, 33 * 17 * 16 + (48 << 20)),
    ] {
        let source = Source::file(folder.with(name, &file));
        assert!(read_within(&source, Budget(needed)).is_ok(), "{name}");
        let error = read_within(&source, Budget(needed - 1)).unwrap_err();
        assert_eq!((error.kind, error.exit()), (ErrorKind::TooLarge, 1), "{name}: {error}");
        assert!(error.hint.is_some_and(|hint| hint.contains("`--memory SIZE`")), "{name}");
    }
}

#[test]
fn headers_without_an_end_are_refused() {
    let folder = Folder::new("headers");
    let usual = hdr("VIEW=a camera\n", (7, 40));
    assert!(folder.read(&usual).is_ok());
    let long_line = hdr(&format!("{}\n", "A".repeat(64 << 10)), (7, 40));
    let many_lines = hdr(&"A=1\n".repeat(16 << 10), (7, 40));
    let mut exr = encode(&picture(33, 17), &Encoding::EXR).unwrap();
    let attribute = [b"note\0string\0".as_slice(), &(33_u32 << 20).to_le_bytes(), &vec![b'a'; 33 << 20]].concat();
    exr.splice(8..8, attribute);
    for (name, file) in [("a line", long_line), ("lines", many_lines), ("an attribute", exr)] {
        let error = folder.read(&file).unwrap_err();
        assert_eq!(error.message, "the file is damaged: its header is too long", "{name}");
    }
}

#[test]
fn a_profile_of_some_megabytes_is_ignored_or_refused() {
    let folder = Folder::new("profiles");
    let with_profile = |bytes: usize| {
        let mut info = ::png::Info::with_size(4, 4);
        info.color_type = ::png::ColorType::Rgb;
        info.icc_profile = Some((0..bytes).map(|i| (i >> 9) as u8).collect());
        let mut file = Vec::new();
        let mut writer = ::png::Encoder::with_info(&mut file, info).unwrap().write_header().unwrap();
        writer.write_image_data(&[90; 48]).unwrap();
        writer.finish().unwrap();
        file
    };
    for bytes in [2 << 20, 64 << 20] {
        let picture = folder.read(&with_profile(bytes)).unwrap();
        assert_eq!((picture.width, picture.pixel(0, 0)[3]), (4, 1.0), "{bytes}");
    }
}
