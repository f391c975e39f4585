//! JPEG: markers and the profile, by a parser of our own.

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};

use crate::codec::icc;
use crate::*;

/// The segments before the image data: markers and data.
pub(super) fn segments(file: &[u8]) -> Vec<(u8, Vec<u8>)> {
    assert_eq!(file[..2], [0xff, 0xd8]);
    let mut found = Vec::new();
    let mut rest = &file[2..];
    while rest[1] != 0xda {
        let length = usize::from(u16::from_be_bytes([rest[2], rest[3]]));
        found.push((rest[1], rest[4..2 + length].to_vec()));
        rest = &rest[2 + length..];
    }
    found
}

fn encoded(color: Colorimetry) -> Result<Vec<u8>, CodecError> {
    let values: Vec<f32> = (0..24 * 16 * 4).map(|i| (i % 97) as f32 / 96.0).collect();
    encode_jpeg((24, 16), EncodedPixels::Float(&values), &JpegOptions { color: Some(color), ..JpegOptions::default() })
}

#[test]
fn a_jpeg_has_its_size_full_chroma_and_a_profile() {
    let p3 = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);
    for color in [Colorimetry::SRGB, p3] {
        let segments = segments(&encoded(color).unwrap());
        let frame = &segments.iter().find(|(marker, _)| *marker == 0xc0).unwrap().1;
        assert_eq!(frame[..6], [8, 0, 16, 0, 24, 3], "eight bits, height, width, three components");
        assert_eq!([frame[7], frame[10], frame[13]], [0x11; 3], "no subsampling");
        let stated = segments.iter().find(|(marker, _)| *marker == 0xe2).map(|(_, data)| data);
        let profile = icc::write(&color).unwrap();
        assert_eq!(stated, Some(&[&b"ICC_PROFILE\0\x01\x01"[..], &profile].concat()));
    }
}

#[test]
fn hdr_and_long_rows_do_not_fit_into_a_jpeg() {
    let pq = encoded(Colorimetry::new(Chromaticities::REC2020, Transfer::Pq)).unwrap_err();
    assert_eq!(pq.kind, ErrorKind::Unsupported);
    let long = encode_jpeg((65536, 1), EncodedPixels::Byte(&vec![0; 65536 * 4]), &JpegOptions::default());
    assert_eq!(long.unwrap_err().kind, ErrorKind::TooLarge);
}
