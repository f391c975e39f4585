//! What PNG files state about their colors, chunk by chunk, and their alpha.

use std::io::Cursor;

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};
use moxcms::{ColorProfile, ToneReprCurve};

use crate::codec::{decode, describe, icc};
use crate::*;

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), |crc, _| step(crc));
    !bytes.iter().fold(!0, byte)
}

fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [name, data].concat();
    [&(data.len() as u32).to_be_bytes()[..], &body, &crc32(&body).to_be_bytes()].concat()
}

/// A PNG of one pixel with these chunks before it.
fn with(chunks: &[Vec<u8>]) -> Vec<u8> {
    let pixel = [64, 192, 32, 255];
    let options = Encoding { color: None, ..Encoding::PNG };
    let file = encode(((1, 1), Samples::Byte(&pixel)), &options).unwrap();
    [&file[..33], &chunks.concat(), &file[33..]].concat()
}

fn read(file: &[u8]) -> Picture {
    decode(Cursor::new(file), None, Budget(1 << 30)).unwrap()
}

fn profile(change: impl Fn(&mut ColorProfile)) -> Vec<u8> {
    let bytes = icc::write(&Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb)).unwrap();
    let mut profile = ColorProfile::new_from_slice(&bytes).unwrap();
    change(&mut profile);
    let packed = fdeflate::compress_to_vec(&profile.encode().unwrap());
    chunk(b"iCCP", &[b"p\0\0", &packed[..]].concat())
}

fn light(color: Colorimetry) -> [f64; 3] {
    let light = [64.0, 192.0, 32.0].map(|code| color.transfer.to_light(code / 255.0));
    (color.primaries.conversion(&Chromaticities::REC709) * glam::DVec3::from(light)).to_array()
}

#[test]
fn a_text_of_any_length_is_passed_over() {
    let p3 = chunk(b"cICP", &[12, 13, 0, 1]);
    let short = read(&with(&[chunk(b"tEXt", b"a\0b"), p3.clone()]));
    assert!(short == read(&with(&[chunk(b"tEXt", &vec![b'a'; (1 << 24) + 9]), p3])) && short.stated.is_some());
}

/// PNG, third edition, 4.3: the first chunk that is understood counts.
#[test]
fn a_chunk_that_is_not_understood_gives_way_to_the_next() {
    let p3 = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);
    let gamma = Colorimetry::new(Chromaticities::REC709, Transfer::Gamma(1.8.into()));
    let cicp = |codes: [u8; 4]| chunk(b"cICP", &codes);
    let srgb = || chunk(b"sRGB", &[0]);
    let gama = || chunk(b"gAMA", &55556_u32.to_be_bytes());
    let mut damaged = profile(|_| {});
    *damaged.last_mut().unwrap() ^= 1;
    let no_profile = chunk(b"iCCP", b"p\0\0no deflate");
    type Row = (Vec<Vec<u8>>, Colorimetry, Option<&'static str>, usize);
    let table: Vec<Row> = vec![
        (vec![cicp([12, 13, 0, 1]), srgb()], p3, Some("cICP"), 0),
        (vec![cicp([1, 1, 0, 1]), gama()], Colorimetry::SRGB, Some("cICP"), 1),
        (vec![cicp([12, 17, 0, 1]), srgb()], Colorimetry::SRGB, Some("sRGB"), 1),
        (vec![cicp([12, 13, 1, 1]), gama()], gamma, Some("gAMA"), 1),
        (vec![cicp([12, 13, 0, 2]), profile(|_| {})], p3, Some("iCCP"), 1),
        (vec![chunk(b"cICP", &[1, 13, 0])], Colorimetry::SRGB, None, 2),
        (vec![damaged, gama()], gamma, Some("gAMA"), 1),
        (vec![no_profile, srgb()], Colorimetry::SRGB, Some("sRGB"), 1),
        (vec![chunk(b"cHRM", &[0; 32])], Colorimetry::SRGB, None, 2),
        (vec![chunk(b"cHRM", &[0; 32]), gama()], gamma, Some("gAMA"), 1),
        (vec![chunk(b"gAMA", &[0; 4])], Colorimetry::SRGB, None, 2),
        (vec![], Colorimetry::SRGB, None, 0),
    ];
    for (chunks, color, stated_by, notes) in table {
        let names: Vec<_> = chunks.iter().map(|chunk| String::from_utf8_lossy(&chunk[4..12]).into_owned()).collect();
        let picture = read(&with(&chunks));
        let expected = light(color);
        assert!((0..3).all(|c| (f64::from(picture.pixel(0, 0)[c]) - expected[c]).abs() < 1e-3), "{names:?}");
        assert_eq!(picture.notes.len(), notes, "{names:?}: {:?}", picture.notes);
        assert_eq!(describe(Cursor::new(with(&chunks)), None).unwrap().stated_by, stated_by, "{names:?}");
    }
}

#[test]
fn codes_of_video_are_scaled() {
    let picture = read(&with(&[chunk(b"cICP", &[1, 13, 0, 0])]));
    for (found, code) in picture.pixel(0, 0).into_iter().zip([64.0, 192.0, 32.0]) {
        let expected = Transfer::Srgb.to_light((code - 16.0) / 219.0);
        assert!((f64::from(found) - expected).abs() < 1e-3, "{found} {expected}");
    }
}

#[test]
fn every_curve_and_table_of_a_profile_is_applied() {
    let curve: Vec<u16> = (0..256).map(|at| (f64::from(at) / 255.0).powi(3)).map(|x| (x * 65535.0) as u16).collect();
    let table = profile(|profile| {
        let curve = Some(ToneReprCurve::Lut(curve.clone()));
        (profile.red_trc, profile.green_trc, profile.blue_trc) = (curve.clone(), curve.clone(), curve);
    });
    let picture = read(&with(&[table]));
    let cubes = glam::DVec3::new(64.0, 192.0, 32.0) / 255.0;
    let expected = Chromaticities::DISPLAY_P3.conversion(&Chromaticities::REC709) * (cubes * cubes * cubes);
    assert!((0..3).all(|c| (f64::from(picture.pixel(0, 0)[c]) - expected[c]).abs() < 1e-3), "{picture:?}");
    assert!(picture.notes.is_empty() && picture.stated.is_none());
}

/// The bytes of a profile by hand: `mft2` tables of two entries in each direction, from RGB to XYZ.
#[test]
fn tables_of_a_profile_are_interpolated_and_gray_may_be_lightness() {
    let colorants = Chromaticities::REC2020.to_xyz();
    let adapted = afterimage_base::color::Cones::Bradford
        .adaptation(Chromaticities::REC2020.white.to_xyz(), glam::DVec3::new(0.9642, 1.0, 0.8249))
        * colorants;
    let fixed = |number: f64| ((number * 65536.0).round() as i32).to_be_bytes();
    let word = |number: f64| ((number * 32768.0).round() as u16).to_be_bytes();
    let mut tables = [b"mft2\0\0\0\0".as_slice(), &[3, 3, 2, 0]].concat();
    tables.extend([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0].map(fixed).as_flattened());
    tables.extend([0, 2, 0, 2]);
    tables.extend([[0, 0, 255, 255]; 3].as_flattened());
    for corner in 0..8 {
        let rgb = glam::DVec3::from([4, 2, 1].map(|bit| f64::from(u8::from(corner & bit != 0))));
        tables.extend((adapted * rgb).to_array().map(word).as_flattened());
    }
    tables.extend([[0, 0, 255, 255]; 3].as_flattened());
    let gray = [b"curv\0\0\0\0\0\0\0\x01\x01\0".as_slice(), &[0, 0]].concat();
    let made = |space: &[u8; 4], pcs: &[u8; 4], tag: &[u8; 4], data: &[u8]| {
        let mut file = vec![0; 128];
        file[8..24].copy_from_slice(&[&[4, 0x40, 0, 0], &b"mntr"[..], space, pcs].concat());
        file[36..40].copy_from_slice(b"acsp");
        file[68..80].copy_from_slice([0.9642, 1.0, 0.8249].map(fixed).as_flattened());
        let data = [data, &[0; 3]].concat();
        let length = data.len() / 4 * 4;
        file.extend([&[0, 0, 0, 1], &tag[..], &144_u32.to_be_bytes(), &(length as u32).to_be_bytes()].concat());
        file.extend(&data[..length]);
        let all = file.len() as u32;
        file[..4].copy_from_slice(&all.to_be_bytes());
        chunk(b"iCCP", &[b"p\0\0", &fdeflate::compress_to_vec(&file)[..]].concat())
    };
    let picture = read(&with(&[made(b"RGB ", b"XYZ ", b"A2B0", &tables)]));
    let expected =
        Chromaticities::REC2020.conversion(&Chromaticities::REC709) * (glam::DVec3::new(64.0, 192.0, 32.0) / 255.0);
    let found = picture.pixel(0, 0);
    assert!(
        (0..3).all(|c| (f64::from(found[c]) - expected[c]).abs() < 2e-3),
        "{found:?} {expected} {:?}",
        picture.notes
    );
    let profile = made(b"GRAY", b"Lab ", b"kTRC", &gray);
    let pixel = [&[0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0][..]].concat();
    let data = chunk(b"IDAT", &fdeflate::compress_to_vec(&[0, 128]));
    let file = [&b"\x89PNG\r\n\x1a\n"[..], &chunk(b"IHDR", &pixel), &profile, &data, &chunk(b"IEND", b"")].concat();
    // Lightness 50.196 (CIE 15).
    let lightness = read(&file).pixel(0, 0)[0];
    assert!((lightness - ((50.196_f32 + 16.0) / 116.0).powi(3)).abs() < 1e-3, "{lightness}");
}

#[test]
fn alpha_of_a_file_is_straight_and_light_of_a_picture_is_multiplied_by_it() {
    let half = Transfer::Srgb.to_signal(0.5) as f32;
    let pixels = [[half, half, half, 0.5], [0.5, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.25], [half, 0.0, 1.0, 1.0]];
    let options = Encoding { alpha: Alpha::Keep, dither: None, ..Encoding::PNG };
    let (codes, channels) = png_codes((4, 1), Samples::Float(pixels.as_flattened()), &options).unwrap();
    assert_eq!(channels, 4);
    // Light beyond coverage is cut; without coverage there is none.
    let expected = [[255, 255, 255, 128], [0, 0, 0, 0], [255, 255, 255, 64], [188, 0, 255, 255]];
    assert_eq!(codes, expected.as_flattened());
    let apart = Encoding { premultiplied: false, ..options };
    let (codes, _) = png_codes((4, 1), Samples::Float(pixels.as_flattened()), &apart).unwrap();
    assert_eq!(codes[..4], [188, 188, 188, 128]);
}

#[test]
fn straight_codes_come_back_as_they_were() {
    let alphas = [1, 2, 5, 16, 64, 128, 200, 254, 255_u8];
    let codes: Vec<u8> =
        alphas.iter().flat_map(|alpha| (0..=255).flat_map(|code| [code, code, code, *alpha])).collect();
    let options = Encoding { alpha: Alpha::Keep, dither: None, premultiplied: false, ..Encoding::PNG };
    let size = (256, alphas.len() as u32);
    let picture = read(&encode((size, Samples::Byte(&codes)), &options).unwrap());
    let Pixels::Half(light) = &picture.pixels else { panic!("eight bits are read in halves") };
    let signal = |(at, value): (usize, &half::f16)| {
        if at % 4 == 3 { value.to_f32() } else { Transfer::Srgb.to_signal(value.to_f32().into()) as f32 }
    };
    let signals: Vec<f32> = light.iter().enumerate().map(signal).collect();
    let again = Encoding { premultiplied: true, ..options };
    let (found, _) = png_codes(size, Samples::Float(&signals), &again).unwrap();
    let expected: Vec<u16> = codes.iter().map(|code| u16::from(*code)).collect();
    assert!(found == expected, "{:?}", found.iter().zip(&expected).enumerate().find(|(_, (a, b))| a != b));
    // A mask stays apart.
    let options = ReadOptions { premultiplied: false, ..Budget(1 << 30).into() };
    let file = encode(
        ((1, 1), Samples::Byte(&[255, 255, 255, 0])),
        &Encoding { alpha: Alpha::Keep, premultiplied: false, ..Encoding::PNG },
    );
    assert_eq!(decode(Cursor::new(file.unwrap()), None, options).unwrap().pixel(0, 0), [1.0, 1.0, 1.0, 0.0]);
}
