//! Curves and texts of ICC profiles by their definitions, and what JPEG files have besides their profile.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};
use glam::{DMat3, DVec3};
use moxcms::{ColorProfile, ToneReprCurve};

use super::icc::{numbers, space, tag};
use super::jpeg::segments;
use crate::codec::icc::{self, Profile};
use crate::*;

fn with_curves(curves: [ToneReprCurve; 3]) -> Vec<u8> {
    let profile = icc::write(&Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb)).unwrap();
    let mut profile = ColorProfile::new_from_slice(&profile).unwrap();
    [profile.red_trc, profile.green_trc, profile.blue_trc] = curves.map(Some);
    profile.encode().unwrap()
}

fn all(curve: ToneReprCurve) -> Vec<u8> {
    with_curves([curve.clone(), curve.clone(), curve])
}

/// ICC.1:2022, 10.18: each form of a curve, with numbers that make it a known function, or one that is none.
#[test]
fn every_form_of_a_curve_is_evaluated() {
    let gamma = |power: f32| Some(Transfer::Gamma(Decimal::from(power)));
    let (a, b) = (1.0 / 1.055, 0.055 / 1.055);
    let table: [(&[f32], Option<Transfer>); 13] = [
        (&[2.2], gamma(2.2)),
        (&[1.0], Some(Transfer::Linear)),
        (&[2.4, 1.0, 0.0], gamma(2.4)),
        (&[2.4, 1.0, -0.5], None),
        (&[2.4, 0.9, 0.0], None),
        (&[2.2, 1.0, 0.0, 0.0], gamma(2.2)),
        (&[2.2, 1.0, 0.0, 0.01], None),
        (&[2.4, a, b, 1.0 / 12.92, 0.04045], Some(Transfer::Srgb)),
        (&[2.4, a, b, 1.0 / 12.92, 0.4], None),
        (&[2.4, a, b, 1.0 / 12.92, 0.04045, 0.0, 0.0], Some(Transfer::Srgb)),
        (&[2.4, a, b, 1.0 / 12.92, 0.04045, 0.01, 0.0], None),
        (&[2.4, a, b, 1.0 / 12.92, 0.04045, 0.0, 0.01], None),
        (&[1.0, 1.0, 0.0, 1.0, 0.5], Some(Transfer::Linear)),
    ];
    for (numbers, expected) in table {
        let found = space(&all(ToneReprCurve::Parametric(numbers.to_vec()))).map(|(_, transfer)| transfer);
        let is_same = match (found, expected) {
            (Some(Transfer::Gamma(found)), Some(Transfer::Gamma(expected))) => {
                (found.get() - expected.get()).abs() < 1e-4
            }
            (found, expected) => found == expected,
        };
        assert!(is_same, "{numbers:?}: {found:?}");
    }
    let table: [(&[u16], Option<Transfer>); 5] = [
        (&[], Some(Transfer::Linear)),
        (&[0x0200], Some(Transfer::Gamma(Decimal::new(2.0)))),
        (&[0x0100], Some(Transfer::Linear)),
        (&[0, 65535], Some(Transfer::Linear)),
        (&[65535, 0], None),
    ];
    for (entries, expected) in table {
        let found = space(&all(ToneReprCurve::Lut(entries.to_vec()))).map(|(_, transfer)| transfer);
        assert_eq!(found, expected, "{entries:?}");
    }
}

#[test]
fn curves_without_a_name_are_applied_by_channel() {
    let curve = |power: f32| ToneReprCurve::Parametric(vec![power]);
    let Ok(Profile::Curves(primaries, curves)) = icc::read(&with_curves([2.4, 2.2, 1.8].map(curve)), 3) else {
        panic!("three powers are no known transfer function")
    };
    assert!(primaries.close_to(&Chromaticities::DISPLAY_P3, 1e-3), "{primaries:?}");
    for (curve, power) in curves.iter().zip([2.4, 2.2, 1.8]) {
        assert!((curve.linear(0.5) - 0.5_f64.powf(power)).abs() < 1e-4);
    }
    // The power of a negative number.
    let undefined = all(ToneReprCurve::Parametric(vec![2.4, 1.0, -0.5, 1.0, 0.0]));
    assert_eq!(icc::read(&undefined, 3).err(), Some("its curves are not defined for all codes"));
}

/// Tags `desc` and `cprt` are one record of UTF-16 in American English.
fn words(tag: &[u8]) -> String {
    assert_eq!((&tag[..4], &tag[8..20]), (&b"mluc"[..], &b"\0\0\0\x01\0\0\0\x0cenUS"[..]));
    let letters: Vec<u16> = tag[28..].as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
    String::from_utf16(&letters).unwrap().trim_end_matches(['\0', ' ']).to_owned()
}

#[test]
fn a_profile_says_what_it_is_and_how_it_was_adapted() {
    let gamma = Transfer::Gamma(Decimal::new(2.4));
    let table = [
        (Chromaticities::DISPLAY_P3, gamma, "DisplayP3, gamma 2.4"),
        (Chromaticities::REC2020, Transfer::Linear, "Rec2020, Linear"),
        (Chromaticities::REC709, Transfer::Srgb, "Rec709, Srgb"),
    ];
    for (primaries, transfer, description) in table {
        let profile = icc::write(&Colorimetry::new(primaries, transfer)).unwrap();
        assert_eq!(words(&tag(&profile, b"desc")), description);
        assert_eq!(words(&tag(&profile, b"cprt")), "No copyright, use freely");
        // `chad` turns the white of the colors, D65, into that of the profile, D50.
        let adapt: [f64; 9] = numbers(&tag(&profile, b"chad")).try_into().unwrap();
        let white = DMat3::from_cols_array(&adapt).transpose() * DVec3::new(0.95046, 1.0, 1.08906);
        assert!(white.abs_diff_eq(DVec3::new(0.9642, 1.0, 0.8249), 1e-3), "{white}");
        for name in [b"rTRC", b"gTRC", b"bTRC"] {
            let curve = tag(&profile, name);
            match transfer {
                Transfer::Linear => assert_eq!(curve[..12], *b"curv\0\0\0\0\0\0\0\0"),
                Transfer::Srgb => {
                    let expected = [2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045];
                    let found = &numbers(&curve)[1..6];
                    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
                }
                _ => assert!(curve[8..10] == [0, 0] && (numbers(&curve)[1] - 2.4).abs() < 1e-4, "{curve:?}"),
            }
        }
    }
    let unnamed = Chromaticities { white: afterimage_base::color::Xy::new(0.31, 0.33), ..Chromaticities::REC709 };
    let profile = icc::write(&Colorimetry::new(unnamed, Transfer::Linear)).unwrap();
    assert_eq!(words(&tag(&profile, b"desc")), "RGB, Linear");
}

/// The quantization tables are fine where the quality is high, and the quality is from 1 to 100.
#[test]
fn the_quality_of_a_jpeg_decides_its_tables() {
    let pixels: Vec<f32> = (0..16 * 8 * 4).map(|i| (i % 61) as f32 / 60.0).collect();
    let with = |quality, color, dither| {
        encode(((16, 8), Samples::Float(&pixels)), &Encoding { quality, dither, color, ..Encoding::JPEG }).unwrap()
    };
    let tables = |quality| -> Vec<u32> {
        let found = segments(&with(quality, None, None)).into_iter().filter(|(marker, _)| *marker == 0xdb);
        found.flat_map(|(_, data)| data.into_iter().map(u32::from)).collect()
    };
    let sum = |quality| tables(quality).iter().sum::<u32>();
    assert!(sum(100) < sum(92) && sum(92) < sum(50) && sum(50) < sum(1));
    assert_eq!((tables(0), tables(255)), (tables(1), tables(100)));
    let bare = segments(&with(90, None, None));
    assert!(bare.iter().all(|(marker, _)| *marker != 0xe2), "no profile");
    assert_ne!(with(100, None, None), with(100, None, Some(1)), "noise");
    assert_ne!(with(100, None, Some(2)), with(100, None, Some(1)), "the seed decides");
    let long = encode(((1, 65536), Samples::Byte(&vec![0; 65536 * 4])), &Encoding::JPEG);
    assert_eq!(long.unwrap_err().message, "a JPEG has at most 65535 pixels in a row or column");
}
