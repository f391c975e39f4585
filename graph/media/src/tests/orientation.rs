//! The orientations of EXIF, by the table of the standard: where the first row and the first column of a file are seen.

use std::io::Cursor;

use jpeg_encoder::{ColorType, Encoder};

use crate::codec::{Description, decode, describe};
use crate::*;

/// Where the first row and the first column of the file are (CIPA DC-008, 4.6.5.1.6).
const SEEN: [(u16, &str, &str); 8] = [
    (1, "top", "left"),
    (2, "top", "right"),
    (3, "bottom", "right"),
    (4, "bottom", "left"),
    (5, "left", "top"),
    (6, "right", "top"),
    (7, "right", "bottom"),
    (8, "left", "bottom"),
];

/// A gray JPEG of 32x16 pixels with an EXIF block, brighter in the first row and in the first column of its blocks.
fn file(exif: &[u8]) -> Vec<u8> {
    let gray = |x: usize, y: usize| {
        if y < 8 {
            240
        } else if x < 8 {
            120
        } else {
            0
        }
    };
    let codes: Vec<u8> = (0..16).flat_map(|y| (0..32).map(move |x| gray(x, y))).collect();
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, 100);
    encoder.add_app_segment(1, [b"Exif\0\0", exif].concat()).unwrap();
    encoder.encode(&codes, 32, 16, ColorType::Luma).unwrap();
    file
}

/// A block with one entry in its directory.
fn block(orientation: u16, is_little: bool) -> Vec<u8> {
    let short = |x: u16| if is_little { x.to_le_bytes() } else { x.to_be_bytes() };
    let long = |x: u32| if is_little { x.to_le_bytes() } else { x.to_be_bytes() };
    let start: &[u8] = if is_little { b"II*\0" } else { b"MM\0*" };
    let entry = [&short(0x0112)[..], &short(3), &long(1), &short(orientation), &[0, 0]].concat();
    [start, &long(8), &short(1), &entry, &[0; 4]].concat()
}

fn read(exif: &[u8]) -> (Picture, Description) {
    let file = file(exif);
    let picture = decode(Cursor::new(&file), None, Budget(1 << 30)).unwrap();
    (picture, describe(Cursor::new(&file), None).unwrap())
}

/// The mean light along a side.
fn along(picture: &Picture, side: &str) -> f32 {
    let (width, height) = (picture.width, picture.height);
    let places: Vec<(u32, u32)> = match side {
        "top" => (0..width).map(|x| (x, 0)).collect(),
        "bottom" => (0..width).map(|x| (x, height - 1)).collect(),
        "left" => (0..height).map(|y| (0, y)).collect(),
        _ => (0..height).map(|y| (width - 1, y)).collect(),
    };
    places.iter().map(|(x, y)| picture.pixel(*x, *y)[0]).sum::<f32>() / places.len() as f32
}

#[test]
fn pictures_are_upright() {
    for (orientation, row, column) in SEEN {
        for is_little in [true, false] {
            let (picture, described) = read(&block(orientation, is_little));
            let size = if orientation < 5 { (32, 16) } else { (16, 32) };
            assert_eq!((picture.width, picture.height), size, "{orientation}");
            let Window { width, height, .. } = described.parts[0].display;
            assert_eq!((width, height), (size.0.into(), size.1.into()), "{orientation}");
            assert!(along(&picture, row) > 0.8, "{orientation}: the first row is at the {row}");
            let dimmer = along(&picture, column);
            assert!((0.2..0.8).contains(&dimmer), "{orientation}: the first column is at the {column}: {dimmer}");
            assert_eq!(picture.notes.len(), usize::from(orientation != 1), "{:?}", picture.notes);
        }
    }
}

#[test]
fn broken_blocks_state_nothing() {
    let good = block(6, true);
    for length in 0..18 {
        assert_eq!(read(&good[..length]).0.width, 32, "{length} bytes");
    }
    for block in [block(0, true), block(9, false), [b"II*\0\xff\xff\xff\xff", &good[8..]].concat()] {
        assert_eq!(read(&block).0.width, 32);
    }
}
