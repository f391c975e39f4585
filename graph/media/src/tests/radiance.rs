//! Headers of Radiance files.

use std::io::Cursor;

use crate::codec::{decode, describe};
use crate::*;

/// Three by two pixels, whose mantissas count in the order of the file.
fn file(size: &str, ending: &str) -> Vec<u8> {
    let lines = ["#?RADIANCE", "# made by hand", "FORMAT=32-bit_rle_rgbe", "EXPOSURE=1", "", size];
    let header: String = lines.iter().map(|line| format!("{line}{ending}")).collect();
    let pixels = (0..6).flat_map(|at| [128 + at, 0, 0, 128]);
    header.into_bytes().into_iter().chain(pixels).collect()
}

fn reds(file: &[u8]) -> Vec<f32> {
    let picture = decode(Cursor::new(file), None, Budget(1 << 30)).unwrap();
    let described = describe(Cursor::new(file), None).unwrap();
    assert_eq!(
        (described.parts[0].display.width, described.parts[0].display.height),
        (picture.width.into(), picture.height.into())
    );
    (0..picture.height)
        .flat_map(|y| (0..picture.width).map(move |x| (x, y)))
        .map(|(x, y)| picture.pixel(x, y)[0] * 256.0 - 128.0)
        .collect()
}

#[test]
fn lines_may_end_as_those_of_windows_do() {
    let unix = reds(&file("-Y 2 +X 3", "\n"));
    assert_eq!(unix.iter().map(|red| red.round()).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(reds(&file("-Y 2 +X 3", "\r\n")), unix);
}

/// The Radiance file format: the first axis is that of the rows.
#[test]
fn rows_and_pixels_run_in_any_direction() {
    let table: [(&str, [u8; 6]); 8] = [
        ("-Y 2 +X 3", [0, 1, 2, 3, 4, 5]),
        ("-Y 2 -X 3", [2, 1, 0, 5, 4, 3]),
        ("+Y 2 +X 3", [3, 4, 5, 0, 1, 2]),
        ("+Y 2 -X 3", [5, 4, 3, 2, 1, 0]),
        ("+X 3 -Y 2", [0, 2, 4, 1, 3, 5]),
        ("-X 3 -Y 2", [4, 2, 0, 5, 3, 1]),
        ("+X 3 +Y 2", [1, 3, 5, 0, 2, 4]),
        ("-X 3 +Y 2", [5, 3, 1, 4, 2, 0]),
    ];
    for (size, expected) in table {
        let found: Vec<u8> = reds(&file(size, "\n")).iter().map(|red| red.round() as u8).collect();
        assert_eq!(found, expected, "{size}");
    }
}

#[test]
fn a_header_that_does_not_end_is_refused() {
    let long = [&b"#?RADIANCE\n"[..], &b"x\n".repeat(1 << 16)].concat();
    for (file, message) in
        [(&long[..], "the file is damaged: its header is too long"), (&long[..99], "the file ends too early")]
    {
        assert_eq!(decode(Cursor::new(file), None, Budget(1 << 30)).unwrap_err().message, message);
    }
}
