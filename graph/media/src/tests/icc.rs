//! ICC profiles against published colorants.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer, Xy};

use moxcms::{ColorProfile, ToneReprCurve};

use crate::codec::icc::{self, Profile};

/// The tags of a profile by a parser of our own.
pub(super) fn tag(profile: &[u8], name: &[u8; 4]) -> Vec<u8> {
    let word = |at: usize| u32::from_be_bytes(profile[at..at + 4].try_into().unwrap()) as usize;
    let entry = (0..word(128)).map(|tag| 132 + 12 * tag).find(|at| &profile[*at..*at + 4] == name).unwrap();
    profile[word(entry + 4)..word(entry + 4) + word(entry + 8)].to_vec()
}

/// Numbers with 16 bits behind the point, after the type and the reserved bytes.
pub(super) fn numbers(tag: &[u8]) -> Vec<f64> {
    let fixed = |word: &[u8; 4]| f64::from(i32::from_be_bytes(*word)) / 65536.0;
    tag[8..].as_chunks::<4>().0.iter().map(fixed).collect()
}

/// The space that a profile of colors states.
pub(super) fn space(profile: &[u8]) -> Option<(Chromaticities, Transfer)> {
    match icc::read(profile, 3) {
        Ok(Profile::Space(primaries, transfer)) => Some((primaries, transfer)),
        _ => None,
    }
}

#[test]
fn the_profile_of_display_p3_has_the_published_colorants() {
    let profile = icc::write(&Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb)).unwrap();
    assert_eq!((&profile[12..24], &profile[36..40]), (&b"mntrRGB XYZ "[..], &b"acsp"[..]));
    // Display P3 as published with the ICC's registry, adapted to D50.
    let published = [
        (b"rXYZ", [0.51512, 0.24120, -0.00105]),
        (b"gXYZ", [0.29198, 0.69225, 0.04189]),
        (b"bXYZ", [0.15710, 0.06657, 0.78407]),
        (b"wtpt", [0.9642, 1.0, 0.8249]),
    ];
    for (name, expected) in published {
        let found = numbers(&tag(&profile, name));
        let is_close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4);
        assert!(is_close, "{}: {found:?} is not {expected:?}", String::from_utf8_lossy(name));
    }
    let curve = tag(&profile, b"rTRC");
    assert_eq!((&curve[..4], &curve[8..10]), (&b"para"[..], &[0, 3][..]));
    assert!((numbers(&curve)[1] - 2.4).abs() < 1e-4, "{:?}", numbers(&curve));
}

#[test]
fn a_profile_is_read_back_as_what_it_was_made_of() {
    let gamma = Transfer::Gamma(Decimal::new(2.4));
    let named = [Chromaticities::REC709, Chromaticities::DISPLAY_P3, Chromaticities::REC2020];
    for primaries in named.into_iter().chain([Chromaticities::ACES_CG, Chromaticities::ACES_AP0]) {
        for transfer in [Transfer::Linear, Transfer::Srgb, gamma] {
            let profile = icc::write(&Colorimetry::new(primaries, transfer)).unwrap();
            let (found, curve) = space(&profile).unwrap();
            assert_eq!((found, curve), (primaries, transfer));
        }
    }
    // One without a name keeps its numbers, with D65.
    let other = Chromaticities { red: Xy::new(0.66, 0.33), ..Chromaticities::REC709 };
    let (found, _) = space(&icc::write(&Colorimetry::new(other, gamma)).unwrap()).unwrap();
    assert!(found != other && found.close_to(&other, 1e-3), "{found:?}");
    assert_eq!(icc::write(&Colorimetry::new(Chromaticities::REC2020, Transfer::Pq)), None);
}

#[test]
fn a_curve_may_be_a_table_that_is_interpolated() {
    let profile = icc::write(&Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb)).unwrap();
    let mut profile = ColorProfile::new_from_slice(&profile).unwrap();
    let entry = |at: u32| (Transfer::Srgb.to_light(f64::from(at) / 63.0) * 65535.0).round() as u16;
    let curve = Some(ToneReprCurve::Lut((0..64).map(entry).collect()));
    [profile.red_trc, profile.green_trc, profile.blue_trc] = [curve.clone(), curve.clone(), curve];
    let (_, transfer) = space(&profile.encode().unwrap()).unwrap();
    assert_eq!(transfer, Transfer::Srgb);
}

#[test]
fn what_is_no_profile_says_why() {
    let profile = icc::write(&Colorimetry::SRGB).unwrap();
    for bytes in [&b"no profile"[..], &[], &profile[..200]] {
        assert_eq!(icc::read(bytes, 3).err(), Some(icc::UNREADABLE));
    }
    assert_eq!(icc::read(&profile, 4).err(), Some("it is for another number of channels than the picture has"));
    assert!(icc::read(&profile, 1).is_ok(), "gray is a color of RGB");
}

#[test]
fn profiles_have_a_fixed_date_and_lengths_that_readers_accept() {
    let gammas = [1.8, 2.2, 2.4].map(|gamma| Transfer::Gamma(Decimal::new(gamma)));
    for primaries in [Chromaticities::REC709, Chromaticities::DISPLAY_P3, Chromaticities::REC2020] {
        for transfer in gammas.into_iter().chain([Transfer::Linear, Transfer::Srgb]) {
            let profile = icc::write(&Colorimetry::new(primaries, transfer)).unwrap();
            let stated = u32::from_be_bytes(profile[..4].try_into().unwrap()) as usize;
            assert_eq!((stated, profile.len() % 4), (profile.len(), 0), "{primaries:?}, {transfer:?}");
            let tags = u32::from_be_bytes(profile[128..132].try_into().unwrap()) as usize;
            let starts = (0..tags).map(|tag| u32::from_be_bytes(profile[136 + 12 * tag..][..4].try_into().unwrap()));
            assert!(starts.into_iter().all(|start| start.is_multiple_of(4)), "{primaries:?}, {transfer:?}");
            assert_eq!(profile[24..36], [7, 234, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0], "1 January 2026, 0:00");
        }
    }
}
