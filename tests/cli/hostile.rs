//! Images that are broken or lie: each is refused in its own words, soon, and nothing is written.

use afterimage_media::{Encoding, Picture, Pixels, write_image};

use super::Folder;
use super::broken::{
    block_twice, cut, deep, endless_attribute, exr, hdr, noise, png, png_of, png_with_a_flipped_bit, subsampled,
    unknown_compression, unknown_type, window,
};

const SHORT: &str =
    "the file ends too early\n  hint: it was cut short or is still being written; copy or render it again";

fn damaged(what: &str) -> String {
    format!("the file is damaged: {what}\n  hint: copy or render it again")
}

fn unknown(what: &str) -> String {
    format!(
        "this is {what}\n  hint: EXR, Radiance HDR, PNG, JPEG, TIFF and DPX files are read; convert it to one of them"
    )
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_broken_image_has_its_words() {
    let folder = Folder::new("hostile");
    let table: Vec<(&str, Vec<u8>, String)> = vec![
        ("empty.exr", Vec::new(), "the file is empty\n  hint: copy or render it again".into()),
        ("text.exr", b"Please find the render attached.".to_vec(), unknown("not an image that this program knows")),
        ("photo.exr", b"\xff\xd8\xff\xe0\0\x10JFIF\0".to_vec(), SHORT.into()),
        ("scan.exr", b"8BPS\0\x01\0\0".to_vec(), "this is a file of Photoshop\n  hint: export it as a PNG of 16 bits, or convert its flat picture: `magick 'IN.psd[0]' OUT.png`".into()),
        ("magic.exr", cut(&exr(), 4), unknown("not an image that this program knows")),
        ("header.exr", cut(&exr(), 150), SHORT.into()),
        ("pixels.exr", cut(&exr(), 900), SHORT.into()),
        ("huge.exr", window("dataWindow", [0, 0, 999_999_999, 999_999_999]), "the image is too large: a data window has 1000000000×1000000000 pixels\n  hint: a side may have at most 65536 pixels".into()),
        ("wide.exr", window("dataWindow", [0, 0, 70_000, 16]), "the image is too large: a data window has 70001×17 pixels\n  hint: a side may have at most 65536 pixels".into()),
        ("tall.exr", window("dataWindow", [0, 0, 32, 60_000]), SHORT.into()),
        ("backwards.exr", window("dataWindow", [0, 0, -5, -5]), damaged("its data window is empty or inverted")),
        ("overflow.exr", window("dataWindow", [i32::MIN, i32::MIN, i32::MAX, i32::MAX]), damaged("window size exceeding integer maximum")),
        ("deep.exr", deep(), "deep EXR (many samples in a pixel) is not supported\n  hint: flatten it first, for example `oiiotool deep.exr --flatten -o flat.exr`".into()),
        ("subsampled.exr", subsampled(), "its channel `A` has one number for 3x1 pixels, which is not supported\n  hint: save it again with that channel in full size, or without it".into()),
        ("type.exr", unknown_type(), damaged("pixel type attribute value")),
        ("compression.exr", unknown_compression(), "this EXR cannot be read: unknown compression method\n  hint: save it again as a flat, ZIP-compressed OpenEXR 2 file".into()),
        ("attribute.exr", endless_attribute(), SHORT.into()),
        ("twice.exr", block_twice(), damaged("blocks of the image are missing or stored twice")),
        ("noise.exr", noise(), damaged("integer conversion failed: value out of range")),
        ("bomb.png", png_of(65_536, 65_536), "the image is too large: 65536×65536 pixels need 32.0 GiB\n  hint: decoding may take 4.0 GiB; `--memory SIZE` changes the limit".into()),
        ("endless.png", png_of(0x7fff_ffff, 1), "the image is too large: its header says 2147483647×1 pixels\n  hint: a side may have at most 65536 pixels".into()),
        ("nothing.png", png_of(0, 9), damaged("Invalid image dimensions")),
        ("cut.png", cut(&png(), 600), SHORT.into()),
        ("flipped.png", png_with_a_flipped_bit(), damaged("CRC error: expected 0xa65ed078 have 0x97269e57 while decoding ChunkType { type: IDAT, critical: true, private: false, reserved: false, safecopy: false } chunk.")),
        ("bomb.hdr", hdr(60_000, 60_000, 0), "the image is too large: 60000×60000 pixels need 93.9 GiB\n  hint: decoding may take 4.0 GiB; `--memory SIZE` changes the limit".into()),
        ("cut.hdr", hdr(7, 40, 100), SHORT.into()),
        ("header.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y many +X 7\n".to_vec(), damaged("Format error decoding Hdr: Cannot parse height dimension value as u32: invalid digit found in string")),
    ];
    let mut wrong = Vec::new();
    for (name, bytes, words) in &table {
        folder.with(name, bytes);
        let outcome = folder.run(&format!("render {{glare}} {name} -o out.png --memory 4G"));
        let expected = format!("error: {name}: {words}");
        if (outcome.status, outcome.err.trim_end()) != (Some(1), &expected) {
            wrong.push(format!("{name}: status {:?}\n{}", outcome.status, outcome.err));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let left = folder.names().into_iter().filter(|name| name.contains("out.png") || name.ends_with(".part"));
    assert_eq!(left.collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_image_larger_than_the_device_names_the_limit() {
    let folder = Folder::new("large");
    let width = 65_000;
    let picture = Picture::new(width, 1, Pixels::Float(vec![0.5; width as usize * 4]));
    write_image(&folder.file("long.exr"), &picture, &Encoding::EXR).expect("a picture of a test can be written");
    let outcome = folder.run("render {glare} long.exr -o out.png");
    outcome.fails_saying(1, &[".exr: the image is 65000x1, but `", "pixels a side", "hint: scale it down"]);
    // Larger than memory, too: its rows would be read one after another.
    folder.with("heavy.exr", &window("displayWindow", [0, 0, 29_999, 39_999]));
    let outcome = folder.run("render {glare} heavy.exr -o out.png --memory 4G");
    outcome.fails_saying(1, &["heavy.exr: the image is 30000x40000, but `", "pixels a side", "hint: scale it down"]);
    assert_eq!(folder.names(), ["heavy.exr", "long.exr"]);
}
