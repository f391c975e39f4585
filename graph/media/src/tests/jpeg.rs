//! JPEG: markers and the profile, by a parser of our own; files of another encoder are read.

use std::io::Cursor;

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use crate::codec::{decode, describe, icc};
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
    encode(((24, 16), Samples::Float(&values)), &Encoding { color: Some(color), ..Encoding::JPEG })
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
    let long = encode(((65536, 1), Samples::Byte(&vec![0; 65536 * 4])), &Encoding::JPEG);
    assert_eq!(long.unwrap_err().kind, ErrorKind::TooLarge);
}

/// Slow ripples, which also halved chroma holds within a few codes.
fn ripples(channels: usize) -> Vec<u8> {
    let ripple = |at: usize| (128.0 + 90.0 * (at as f64 / 40.0).sin()).round() as u8;
    let pixel = |at: usize| (0..channels).map(move |channel| ripple(at % 96 + at / 96 + 30 * channel));
    (0..96 * 64).flat_map(pixel).collect()
}

fn file(color: ColorType, channels: usize, factor: SamplingFactor, is_progressive: bool) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, 100);
    encoder.set_sampling_factor(factor);
    encoder.set_progressive(is_progressive);
    encoder.encode(&ripples(channels), 96, 64, color).unwrap();
    file
}

fn read(file: &[u8]) -> Result<Picture, CodecError> {
    decode(Cursor::new(file), None, Budget(1 << 30))
}

/// The codes of a picture in sRGB, by the definition of its curve.
fn codes(picture: &Picture) -> Vec<f64> {
    let Pixels::Half(values) = &picture.pixels else { panic!("a JPEG is read in halves") };
    values.iter().map(|value| 255.0 * Transfer::Srgb.to_signal(f64::from(value.to_f32()))).collect()
}

#[test]
fn all_usual_forms_are_read() {
    for (color, channels) in [(ColorType::Rgb, 3), (ColorType::Luma, 1)] {
        for factor in [SamplingFactor::F_1_1, SamplingFactor::F_2_1, SamplingFactor::F_2_2] {
            for is_progressive in [false, true] {
                let picture = read(&file(color, channels, factor, is_progressive)).unwrap();
                assert_eq!((picture.width, picture.height, picture.stated), (96, 64, None));
                let found = codes(&picture);
                let mut sum = 0.0;
                for (at, pixel) in ripples(channels).chunks(channels).enumerate() {
                    for (channel, code) in found[4 * at..4 * at + 3].iter().enumerate() {
                        let off = (code - f64::from(pixel[channel % channels])).abs();
                        sum += off;
                        // As with libjpeg-turbo, whose largest difference is 4.
                        assert!(off <= 6.0, "{channels}, {factor:?}, {is_progressive}: {off} at {at}");
                    }
                    assert_eq!(picture.pixel(at as u32 % 96, at as u32 / 96)[3], 1.0);
                }
                assert!(sum <= f64::from(96 * 64 * 3), "{channels}, {factor:?}, {is_progressive}: {sum}");
            }
        }
    }
}

#[test]
fn its_profile_is_applied_and_told() {
    let p3 = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);
    let red: Vec<f32> = [1.0, 0.0, 0.0, 1.0].repeat(16 * 16);
    let options = Encoding { quality: 100, dither: None, color: Some(p3), ..Encoding::JPEG };
    let picture = read(&encode(((16, 16), Samples::Float(&red)), &options).unwrap()).unwrap();
    let stated = picture.stated.expect("the profile states it");
    assert!(stated.primaries.close_to(&Chromaticities::DISPLAY_P3, 1e-3) && stated.transfer == Transfer::Srgb);
    // Red of Display P3 in Rec.709: 1.2249, -0.0420, -0.0197 (Rec.709 and P3 primaries, D65).
    for (found, expected) in picture.pixel(8, 8).into_iter().zip([1.2249, -0.0420, -0.0197, 1.0]) {
        assert!((found - expected).abs() < 0.02, "{found} {expected}");
    }
    let described = describe(Cursor::new(encoded(p3).unwrap()), None).unwrap();
    assert_eq!((described.format, described.stated_by), ("JPEG", Some("ICC profile")));
}

#[test]
fn what_is_cut_short_or_for_a_printer_is_refused() {
    for is_progressive in [false, true] {
        let whole = file(ColorType::Rgb, 3, SamplingFactor::F_2_2, is_progressive);
        for length in [20, 400, whole.len() / 2, whole.len() - 40] {
            let error = read(&whole[..length]).expect_err("a part is no picture");
            assert_eq!(error.kind, ErrorKind::Broken, "{is_progressive}, {length}: {error}");
        }
    }
    let error = read(&file(ColorType::Cmyk, 4, SamplingFactor::F_1_1, false)).unwrap_err();
    let message = "this JPEG is for a printer (CMYK), without a profile that states its colors";
    assert_eq!((error.kind, &*error.message), (ErrorKind::Unsupported, message));
}

/// The profile of a printer (ICC.1:2022, 10.11): the lightness of paper is 100, cyan alone leaves 40 of it, magenta and
/// yellow 60 and 80, and black none; inks multiply.
fn of_printer() -> Vec<u8> {
    let curve: Vec<u8> = (0..=255).collect();
    let mut tag = [&b"mft1\0\0\0\0\x04\x03\x02\0"[..], &[0; 36]].concat();
    // The matrix, of which only that of XYZ counts, is the identity.
    [12, 28, 44].into_iter().for_each(|at| tag[at + 1] = 1);
    tag.extend(curve.repeat(4));
    for corner in 0..16 {
        let shares = [(8, 0.4), (4, 0.6), (2, 0.8), (1, 0.0)];
        let lightness: f64 = shares.iter().map(|(ink, share)| if corner & ink == 0 { 1.0 } else { *share }).product();
        tag.extend([(255.0 * lightness).round() as u8, 128, 128]);
    }
    tag.extend(curve.repeat(3));
    let word = |number: usize| (number as u32).to_be_bytes();
    let mut profile = vec![0; 128];
    profile[..4].copy_from_slice(&word(144 + tag.len()));
    profile[8..24].copy_from_slice(b"\x02\x40\0\0prtrCMYKLab ");
    profile[36..40].copy_from_slice(b"acsp");
    profile[68..80].copy_from_slice(&[0, 0, 0xf6, 0xd6, 0, 1, 0, 0, 0, 0, 0xd3, 0x2d]);
    [profile, word(1).to_vec(), b"A2B0".to_vec(), word(144).to_vec(), word(tag.len()).to_vec(), tag].concat()
}

/// Adobe's programs store 255 for no ink, and mark that with a segment; without it, 255 is all of an ink (libjpeg).
#[test]
fn inks_are_what_they_are_however_they_are_stored() {
    let of_inks = |color: ColorType, inks: [u8; 4], is_marked: bool| {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 100);
        encoder.add_icc_profile(&of_printer()).unwrap();
        encoder.encode(&inks.repeat(64), 8, 8, color).unwrap();
        if !is_marked {
            let at = file.windows(9).position(|bytes| bytes.starts_with(&[0xff, 0xee]) && bytes.ends_with(b"Adobe"));
            let at = at.expect("the encoder marks it");
            let length = usize::from(u16::from_be_bytes([file[at + 2], file[at + 3]]));
            file.drain(at..at + 2 + length);
        }
        let [red, green, blue, alpha] = read(&file).unwrap().pixel(4, 4);
        assert!((red - green).abs().max((green - blue).abs()) < 0.02 && alpha == 1.0, "{inks:?}: {red} {green} {blue}");
        green
    };
    for (inks, lightness) in [
        ([0; 4], 100.0),
        ([255, 0, 0, 0], 40.0),
        ([0, 255, 0, 0], 60.0),
        ([0, 0, 255, 0], 80.0),
        ([255, 255, 0, 0], 24.0),
        ([0, 0, 0, 255], 0.0),
        ([0, 0, 0, 51], 80.0),
    ] {
        // The luminance of a lightness (CIE 15).
        let expected = if lightness > 8.0 { ((lightness + 16.0_f32) / 116.0).powi(3) } else { lightness / 903.3 };
        let stored = [
            of_inks(ColorType::Cmyk, inks, true),
            of_inks(ColorType::CmykAsYcck, inks, true),
            of_inks(ColorType::Cmyk, inks.map(|ink| 255 - ink), false),
        ];
        assert!(stored.iter().all(|found| (found - expected).abs() < 0.02), "{inks:?}: {stored:?} is not {expected}");
    }
}
