//! Data windows that are not the display window.

use std::io::Cursor;

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::IntegerBounds;

use crate::codec::decode;
use crate::*;

fn bounds(x: i32, y: i32, width: usize, height: usize) -> IntegerBounds {
    IntegerBounds { position: Vec2(x, y), size: Vec2(width, height) }
}

/// A file of 8x6 pixels, numbered in red, whose display window is `display`.
fn file(position: Vec2<i32>, display: IntegerBounds) -> Vec<u8> {
    let pixels = (0..48).flat_map(|at| [at as f32, 0.0, 0.0, 1.0]).collect();
    let mut picture = Picture::new(8, 6, Pixels::Float(pixels));
    picture.meta.image.display_window = display;
    picture.meta.layer.layer_position = position;
    picture.meta.data_size = Some((8, 6));
    encode(&picture, &Encoding { bits: 32, ..Encoding::EXR }).unwrap()
}

fn read(file: &[u8], data_window: bool) -> Picture {
    decode(Cursor::new(file), None, ReadOptions { data_window, ..Budget(1 << 30).into() }).unwrap()
}

fn windows(file: &[u8]) -> (IntegerBounds, IntegerBounds) {
    let meta = MetaData::read_from_buffered(file, true).unwrap();
    (meta.headers[0].shared_attributes.display_window, meta.headers[0].data_window())
}

#[test]
fn overscan_and_parts_pass_through() {
    for (display, position) in [
        // Two pixels more on each side.
        (bounds(0, 0, 4, 2), Vec2(-2, -2)),
        // A part of a larger picture.
        (bounds(0, 0, 20, 10), Vec2(5, 3)),
        // Of the same size, and beside it.
        (bounds(0, 0, 8, 6), Vec2(3, 0)),
        (bounds(10, 20, 8, 6), Vec2(10, 20)),
    ] {
        let first = file(position, display);
        assert_eq!(windows(&first), (display, bounds(position.0, position.1, 8, 6)));
        let picture = read(&first, true);
        assert_eq!((picture.width, picture.height), (8, 6));
        assert!((0..48).all(|at| picture.pixel(at % 8, at / 8)[0] == at as f32));
        assert!(picture.notes.is_empty(), "{:?}", picture.notes);
        let again = encode(&picture, &Encoding { bits: 32, ..Encoding::EXR }).unwrap();
        assert_eq!(windows(&again), windows(&first));
        let shown = read(&first, false);
        assert_eq!((shown.width as usize, shown.height as usize), (display.size.0, display.size.1));
    }
    for data_window in [true, false] {
        let first = file(Vec2(-2, -2), bounds(0, 0, 12, 9));
        let whole = read(&first, data_window);
        let rows = ReadOptions { data_window, rows: Some([2, 4]), ..Budget(1 << 30).into() };
        let part = decode(Cursor::new(&first), None, rows).unwrap();
        assert_eq!((part.width, part.height, part.whole_height()), (whole.width, 4, whole.height));
        assert!((0..4).all(|y| (0..part.width).all(|x| part.pixel(x, y) == whole.pixel(x, y + 2))));
    }
    let overscan = read(&file(Vec2(-2, -2), bounds(0, 0, 4, 2)), false);
    assert_eq!(overscan.pixel(0, 0)[0], (2 * 8 + 2) as f32);
    assert_eq!(overscan.notes, ["pixels outside the display window are left out"]);
}

/// A picture of another size is not that data window any more.
#[test]
fn a_picture_of_another_size_has_windows_of_its_own() {
    let picture = read(&file(Vec2(-2, -2), bounds(0, 0, 4, 2)), true).fitted(4, 3);
    let again = encode(&picture, &Encoding::EXR).unwrap();
    assert_eq!(windows(&again), (bounds(0, 0, 4, 3), bounds(0, 0, 4, 3)));
}
