//! JPEG XL in. The files are of cjxl 0.7, without loss, from codes that djxl gives back.

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};
use afterimage_media::{Budget, ErrorKind, ReadOptions, Source, read_description, read_within};

use super::decoders::{check_alpha, check_cut_and_changed, read_apart};
use super::{Folder, bytes};

/// `cjxl -d 0` of 16 bits.
const SRGB: &str = "\
    0000000c4a584c200d0a870a00000014667479706a786c20000000006a786c20000000096a786c6c0a0000004e6a786c\
    63ff0a0840fc0014170208020100dc004b12c58285249ae136c4f70b84d06c1d80040060462c217fb1fc2fb46cfa7fb9\
    a467e62f8fdcbbdecd87b4ff4d72d509499516c66d8d1f";
/// With `-x color_space=RGB_D65_202_Rel_PeQ`.
const PQ: &str = "\
    0000000c4a584c200d0a870a00000014667479706a786c20000000006a786c20000000096a786c6c0a000000556a786c\
    63ff0a0840013f0079f488c3010000002008020100dc004b12c58285249ae136c4f70b84d06c1d80040060462c217fb1\
    fc2fb46cfa7fb9a467e62f8fdcbbdecd87b4ff4d72d509499516c66d8d1f";
/// With `-x color_space=RGB_D65_DCI_Rel_Lin`.
const LINEAR: &str = "\
    0000000c4a584c200d0a870a00000014667479706a786c20000000006a786c20000000096a786c6c0a0000004e6a786c\
    63ff0a0840fc0064d22208020100dc004b12c58285249ae136c4f70b84d06c1d80040060462c217fb1fc2fb46cfa7fb9\
    a467e62f8fdcbbdecd87b4ff4d72d509499516c66d8d1f";
/// Eight bits with alpha.
const ALPHA: &str = "\
    0000000c4a584c200d0a870a00000014667479706a786c20000000006a786c20000000406a786c63ff0a0840b0a0b810\
    08081000a8004b12c582852456713b000046e6cabf0f00a5412f186831c48f06090eb8ca71156dba12a742c96c050641";

const CODES: [[u16; 3]; 6] =
    [[0, 1, 65535], [1000, 30000, 50000], [65535, 0, 257], [5, 6, 7], [40000, 40001, 39999], [12345, 54321, 33333]];
const ALPHA_CODES: [[u8; 4]; 6] = [
    [207, 21, 45, 60],
    [46, 205, 222, 149],
    [10, 24, 85, 110],
    [159, 122, 67, 40],
    [177, 188, 8, 29],
    [115, 100, 227, 132],
];

#[test]
fn codes_of_every_space_are_those_that_were_encoded() {
    let folder = Folder::new("jxl");
    let hdr = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 10000.0);
    for (file, color, unit) in [
        (SRGB, Colorimetry::SRGB, 1.0),
        (PQ, hdr, 10000.0 / 203.0),
        (LINEAR, Colorimetry::linear(Chromaticities::DISPLAY_P3), 1.0),
    ] {
        let picture = read_apart(&folder, "a.jxl", &bytes(file));
        assert_eq!((picture.width, picture.height, picture.stated), (3, 2, Some(color)));
        let matrix = color.primaries.conversion(&Chromaticities::REC709);
        for (pixel, codes) in picture.pixels.to_f32().as_chunks::<4>().0.iter().zip(CODES) {
            let light = codes.map(|code| color.transfer.to_light(f64::from(code) / 65535.0) * unit);
            let expected = matrix * glam::DVec3::from(light);
            for (found, expected) in pixel.iter().zip(expected.to_array().into_iter().chain([1.0])) {
                assert!((f64::from(*found) - expected).abs() < 1e-5 * unit, "{color:?}: {found} is not {expected}");
            }
        }
        let described = read_description(&Source::file(folder.file("a.jxl"))).unwrap();
        assert_eq!(
            (described.format, described.color, described.stated_by),
            ("JPEG XL", Some(color), Some("color encoding"))
        );
    }
}

#[test]
fn alpha_is_straight_and_multiplied_where_it_is_asked_for() {
    check_alpha(&Folder::new("jxl-alpha"), "a.jxl", &bytes(ALPHA), &ALPHA_CODES);
}

#[test]
fn a_file_that_is_cut_or_changed_is_read_or_refused() {
    let folder = Folder::new("jxl-hostile");
    check_cut_and_changed(&folder, [SRGB, PQ, LINEAR, ALPHA].map(bytes));
    let options = ReadOptions { ..Budget(64).into() };
    let error = read_within(&Source::file(folder.with("b.jxl", &bytes(SRGB))), options).unwrap_err();
    assert_eq!(error.kind, ErrorKind::TooLarge);
}
