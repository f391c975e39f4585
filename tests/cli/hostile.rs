//! Images that are broken or lie: each is refused in its own words, soon, and nothing is written.

use afterimage::files::{ExrOptions, Picture, Pixels, write_exr};

use super::Folder;
use super::broken::{
    block_twice, cut, deep, endless_attribute, exr, hdr, noise, png, png_of, png_with_a_flipped_bit, subsampled,
    unknown_compression, unknown_type, window,
};

const SHORT: &str = "the file ends too early\n  hint: it was cut short or is still being written; copy or render it again";

#[test]
fn every_broken_image_has_its_words() {
    let folder = Folder::new("hostile");
    let table: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty.exr", Vec::new(), "the file is empty"),
        ("text.exr", b"Please find the render attached.".to_vec(), "?"),
        ("photo.exr", b"\xff\xd8\xff\xe0\0\x10JFIF\0".to_vec(), "?"),
        ("scan.exr", b"II*\0\x08\0\0\0".to_vec(), "?"),
        ("magic.exr", cut(&exr(), 4), SHORT),
        ("header.exr", cut(&exr(), 150), SHORT),
        ("pixels.exr", cut(&exr(), 900), SHORT),
        ("huge.exr", window("dataWindow", [0, 0, 999_999_999, 999_999_999]), "?"),
        ("heavy.exr", window("displayWindow", [0, 0, 29_999, 39_999]), "?"),
        ("wide.exr", window("dataWindow", [0, 0, 70_000, 16]), "?"),
        ("tall.exr", window("dataWindow", [0, 0, 32, 60_000]), SHORT),
        ("backwards.exr", window("dataWindow", [0, 0, -5, -5]), "?"),
        ("overflow.exr", window("dataWindow", [i32::MIN, i32::MIN, i32::MAX, i32::MAX]), "?"),
        ("deep.exr", deep(), "?"),
        ("subsampled.exr", subsampled(), "?"),
        ("type.exr", unknown_type(), "?"),
        ("compression.exr", unknown_compression(), "?"),
        ("attribute.exr", endless_attribute(), "?"),
        ("twice.exr", block_twice(), "?"),
        ("noise.exr", noise(), "?"),
        ("bomb.png", png_of(65_536, 65_536), "?"),
        ("endless.png", png_of(0x7fff_ffff, 1), "?"),
        ("nothing.png", png_of(0, 9), "?"),
        ("cut.png", cut(&png(), 600), "?"),
        ("flipped.png", png_with_a_flipped_bit(), "?"),
        ("bomb.hdr", hdr(60_000, 60_000, 0), "?"),
        ("cut.hdr", hdr(7, 40, 100), SHORT),
        ("header.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y many +X 7\n".to_vec(), "?"),
    ];
    let mut wrong = Vec::new();
    for (name, bytes, words) in &table {
        folder.with(name, bytes);
        let told = folder.run(&format!("render {{glare}} {name} -o out.png"));
        let expected = format!("error: {name}: {words}");
        if (told.status, told.err.trim_end()) != (Some(1), &expected) {
            wrong.push(format!("{name}: status {:?}\n{}", told.status, told.err));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let left = folder.names().into_iter().filter(|name| name.contains("out.png") || name.ends_with(".part"));
    assert_eq!(left.collect::<Vec<_>>(), Vec::<String>::new());
}

#[test]
fn an_image_larger_than_the_device_names_the_limit() {
    let folder = Folder::new("large");
    let width = 65_000;
    let picture = Picture::new(width, 1, Pixels::Float(vec![0.5; width as usize * 4]));
    write_exr(&folder.file("long.exr"), &picture, &ExrOptions::default()).expect("a picture of a test can be written");
    let told = folder.run("render {glare} long.exr -o out.png");
    told.fails_saying(1, &["the image is 65000x1, but `", "pixels a side", "hint: scale it down"]);
    assert_eq!(folder.names(), [".cache", "long.exr"]);
}
