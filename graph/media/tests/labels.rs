//! What files state about their colors: chunks of PNG and attributes of EXR, for all transfer functions and primaries.

use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer, Xy};

use super::{Folder, picture};
use afterimage_media::*;

const SPACES: [(Chromaticities, u8); 3] =
    [(Chromaticities::REC709, 1), (Chromaticities::DISPLAY_P3, 12), (Chromaticities::REC2020, 9)];

const TRANSFERS: [(Transfer, Option<u8>); 7] = [
    (Transfer::Srgb, Some(13)),
    (Transfer::Linear, Some(8)),
    (Transfer::Gamma(Decimal::new(2.2)), Some(4)),
    (Transfer::Gamma(Decimal::new(2.8)), Some(5)),
    (Transfer::Gamma(Decimal::new(2.4)), None),
    (Transfer::Pq, Some(16)),
    (Transfer::Hlg, Some(18)),
];

/// The chunks of a file by a parser of our own, in order: names and data.
fn chunks(file: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut rest = &file[8..];
    while rest.len() >= 12 {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        found.push((String::from_utf8(rest[4..8].to_vec()).unwrap(), rest[8..8 + length].to_vec()));
        rest = &rest[12 + length..];
    }
    found
}

pub(super) fn chunk(file: &[u8], name: &str) -> Option<Vec<u8>> {
    chunks(file).into_iter().find(|(found, _)| found == name).map(|(_, data)| data)
}

fn words(data: &[u8]) -> Vec<u32> {
    data.as_chunks::<4>().0.iter().map(|word| u32::from_be_bytes(*word)).collect()
}

fn color(primaries: Chromaticities, transfer: Transfer) -> Colorimetry {
    let color = Colorimetry::new(primaries, transfer);
    if color.is_hdr() { color.nits(203.0, 1000.0) } else { color }
}

/// 16-bit file of one row.
fn file(color: Colorimetry, values: &[f32]) -> Vec<u8> {
    let options = Encoding { bits: 16, color: Some(color), ..Encoding::PNG };
    encode((((values.len() / 4) as u32, 1), Samples::Float(values)), &options).unwrap()
}

#[test]
fn every_label_states_the_colors_and_no_chunk_contradicts_it() {
    for (primaries, code) in SPACES {
        for (transfer, transfer_code) in TRANSFERS {
            let file = file(color(primaries, transfer), &[0.5, 0.25, 0.75, 1.0]);
            let names: Vec<String> = chunks(&file).into_iter().map(|(name, _)| name).collect();
            let has = |name: &str| names.iter().any(|found| found == name);
            let what = format!("{:?}, {transfer:?}: {names:?}", primaries.name());
            let cicp = transfer_code.map(|transfer| vec![code, transfer, 0, 1]);
            assert_eq!(chunk(&file, "cICP"), cicp, "{what}");
            let is_hdr = matches!(transfer, Transfer::Pq | Transfer::Hlg);
            let is_srgb = transfer == Transfer::Srgb;
            assert_eq!(has("sRGB"), is_srgb && code == 1, "{what}");
            assert_eq!(has("iCCP"), is_srgb && code != 1, "{what}");
            assert_eq!(has("gAMA") && has("cHRM"), !is_hdr && !has("iCCP"), "{what}");
            assert_eq!(has("gAMA"), has("cHRM"), "{what}");
            assert_eq!([has("mDCV"), has("cLLI")], [is_hdr; 2], "{what}");
            let data = names.iter().position(|name| name == "IDAT").unwrap();
            assert!(names[..data].iter().all(|name| name != "IDAT") && data == names.len() - 2, "{what}");
        }
    }
}

#[test]
fn gamma_and_chromaticities_are_in_hundred_thousandths() {
    let gamma = Transfer::Gamma(Decimal::new(2.4));
    let file = file(color(Chromaticities::DISPLAY_P3, gamma), &[0.5; 4]);
    assert_eq!(words(&chunk(&file, "gAMA").unwrap()), [41667]);
    let white_first = [31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000];
    assert_eq!(words(&chunk(&file, "cHRM").unwrap()), white_first);
    let linear = self::file(color(Chromaticities::REC709, Transfer::Linear), &[0.5; 4]);
    assert_eq!(words(&chunk(&linear, "gAMA").unwrap()), [100_000]);
    let srgb = encode(((1, 1), Samples::Byte(&[1, 2, 3, 255])), &Encoding::PNG).unwrap();
    assert_eq!(chunk(&srgb, "sRGB"), Some(vec![0]));
    assert_eq!(words(&chunk(&srgb, "gAMA").unwrap()), [45455]);
    let unstated = Encoding { color: None, ..Encoding::PNG };
    let unstated = encode(((1, 1), Samples::Byte(&[1, 2, 3, 255])), &unstated).unwrap();
    assert_eq!(chunks(&unstated).len(), 3, "IHDR, IDAT and IEND");
}

/// ST 2084 by its own formula: cd/m2 to the signal.
fn pq(nits: f64) -> f32 {
    let y = (nits / 10000.0).powf(0.1593017578125);
    ((0.8359375 + 18.8515625 * y) / (1.0 + 18.6875 * y)).powf(78.84375) as f32
}

#[test]
fn hdr_files_state_the_display_and_the_light_of_their_pixels() {
    let values = [pq(203.0), pq(100.0), pq(1.0), 1.0, pq(4.0), pq(950.0), pq(4.0), 1.0];
    let file = file(color(Chromaticities::REC2020, Transfer::Pq), &values);
    let display = chunk(&file, "mDCV").unwrap();
    let points: Vec<u16> = display[..16].as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
    assert_eq!(points, [35400, 14600, 8500, 39850, 6550, 2300, 15635, 16450]);
    assert_eq!(words(&display[16..]), [10_000_000, 1], "1000 cd/m2 and the least");
    let level: Vec<f64> = words(&chunk(&file, "cLLI").unwrap()).iter().map(|word| f64::from(*word) / 1e4).collect();
    assert!((level[0] - 950.0).abs() < 0.2, "MaxCLL {}", level[0]);
    assert!((level[1] - (203.0 + 950.0) / 2.0).abs() < 0.2, "MaxFALL {}", level[1]);
}

/// The mean is over pixels, whether they have an alpha or not.
#[test]
fn alpha_does_not_change_the_light_level() {
    let pair = [pq(200.0), pq(100.0), pq(1.0), 0.5, pq(4.0), pq(600.0), pq(4.0), 0.25];
    let values = [pair; 6].concat();
    for alpha in [Alpha::Keep, Alpha::Drop] {
        let color = Some(color(Chromaticities::REC2020, Transfer::Pq));
        let options = Encoding { bits: 16, alpha, premultiplied: false, color, ..Encoding::PNG };
        let file = encode(((12, 1), Samples::Float(&values)), &options).unwrap();
        let level: Vec<f64> = words(&chunk(&file, "cLLI").unwrap()).iter().map(|word| f64::from(*word) / 1e4).collect();
        assert!((level[0] - 600.0).abs() < 0.2 && (level[1] - 400.0).abs() < 0.2, "{alpha:?}: {level:?}");
    }
}

#[test]
fn the_light_level_of_hlg_is_that_of_its_display() {
    // BT.2408: 75 % is 203 cd/m2 on a display with a peak of 1000, and 100 % is the peak.
    let file = file(color(Chromaticities::REC2020, Transfer::Hlg), &[0.75, 0.75, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0]);
    let level: Vec<f64> = words(&chunk(&file, "cLLI").unwrap()).iter().map(|word| f64::from(*word) / 1e4).collect();
    assert!((level[0] - 1000.0).abs() < 0.1 && (level[1] - 601.5).abs() < 0.5, "{level:?}");
}

/// The light of a signal in units of SDR white, by formulas of the tests.
fn light(transfer: Transfer, signal: f64) -> f64 {
    match transfer {
        Transfer::Linear => signal,
        Transfer::Srgb => ((signal + 0.055) / 1.055).powf(2.4),
        Transfer::Gamma(gamma) => signal.powf(gamma.get()),
        Transfer::Pq => {
            let p = signal.powf(1.0 / 78.84375);
            ((p - 0.8359375) / (18.8515625 - 18.6875 * p)).powf(1.0 / 0.1593017578125) * 10000.0 / 203.0
        }
        // Gray: the light of the scene to the power of the system gamma of 1.2.
        Transfer::Hlg => {
            (((signal - 0.55991073) / 0.17883277).exp() + 0.28466892).powf(1.2) / 12_f64.powf(1.2) * 1000.0 / 203.0
        }
    }
}

#[test]
fn what_is_written_is_read_back_as_light() {
    let folder = Folder::new("labels-light");
    for (primaries, _) in SPACES {
        for (transfer, _) in TRANSFERS {
            let color = color(primaries, transfer);
            let back = folder.read(&file(color, &[0.6, 0.6, 0.6, 1.0, 0.6, 0.0, 0.0, 1.0])).unwrap();
            let what = format!("{:?}, {transfer:?}", primaries.name());
            assert_eq!(back.stated.map(|stated| stated.primaries), Some(primaries), "{what}");
            let is_same = match (back.stated.unwrap().transfer, transfer) {
                (Transfer::Gamma(found), Transfer::Gamma(expected)) => (found.get() - expected.get()).abs() < 1e-4,
                (found, expected) => found == expected,
            };
            assert!(is_same, "{what}: {:?}", back.stated);
            let expected = light(transfer, 0.6);
            for value in &back.pixel(0, 0)[..3] {
                assert!((f64::from(*value) / expected - 1.0).abs() < 2e-4, "{what}: {value} is not {expected}");
            }
            let [red, green, _, _] = back.pixel(1, 0);
            assert_eq!(green < -1e-4, primaries != Chromaticities::REC709, "{what}: wide colors stay wide: {green}");
            assert!(red > 0.0, "{what}");
        }
    }
}

/// The file without the chunks of that name.
pub(super) fn without(file: &[u8], name: &str) -> Vec<u8> {
    let mut kept = file[..8].to_vec();
    let mut rest = &file[8..];
    while rest.len() >= 12 {
        let (chunk, after) = rest.split_at(12 + u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize);
        if &chunk[4..8] != name.as_bytes() {
            kept.extend_from_slice(chunk);
        }
        rest = after;
    }
    kept
}

#[test]
fn the_chunk_srgb_is_enough() {
    let bare = file(Colorimetry::SRGB, &[0.5; 4]);
    let bare = ["cICP", "gAMA", "cHRM"].iter().fold(bare, |file, name| without(&file, name));
    assert!(chunk(&bare, "sRGB").is_some());
    let folder = Folder::new("labels-srgb");
    assert_eq!(folder.read(&bare).unwrap().stated, Some(Colorimetry::SRGB));
    assert_eq!(folder.read(&without(&bare, "sRGB")).unwrap().stated, None);
}

/// Only with the primaries of sRGB does a gamma of 1/2.2 stand for its curve.
#[test]
fn a_gamma_with_wide_primaries_is_a_power() {
    let folder = Folder::new("labels-gamma");
    let gamma = Transfer::Gamma(Decimal::new(2.2));
    for (primaries, _) in SPACES {
        let file = without(&file(color(primaries, gamma), &[0.1, 0.1, 0.1, 1.0]), "cICP");
        assert_eq!(words(&chunk(&file, "gAMA").unwrap()), [45455]);
        let is_srgb = primaries == Chromaticities::REC709;
        let back = folder.read(&file).unwrap();
        let expected = if is_srgb { light(Transfer::Srgb, 0.1) } else { light(gamma, 0.1) };
        let found = f64::from(back.pixel(0, 0)[1]);
        assert!((found / expected - 1.0).abs() < 5e-4, "{:?}: {found} is not {expected}", primaries.name());
    }
}

#[test]
fn the_peak_of_hlg_is_read_from_the_file() {
    let folder = Folder::new("labels-hlg");
    let color = Colorimetry::new(Chromaticities::REC2020, Transfer::Hlg).nits(203.0, 4000.0);
    let back = folder.read(&file(color, &[1.0; 4])).unwrap();
    assert!((back.pixel(0, 0)[0] - 4000.0 / 203.0).abs() < 1e-3, "{:?}", back.pixel(0, 0));
    assert_eq!(back.stated, Some(color));
}

/// CRC-32 of PNG, bit by bit.
pub(super) fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

#[test]
fn colors_that_no_chunk_states_are_refused() {
    let acescg = |transfer| {
        let options = Encoding { color: Some(color(Chromaticities::ACES_CG, transfer)), ..Encoding::PNG };
        encode(((1, 1), Samples::Float(&[0.5; 4])), &options)
    };
    assert_eq!(acescg(Transfer::Pq).unwrap_err().kind, ErrorKind::Unsupported);
    assert!(chunk(&acescg(Transfer::Linear).unwrap(), "cHRM").is_some());
    assert!(chunk(&acescg(Transfer::Srgb).unwrap(), "iCCP").is_some());
}

/// `cHRM` has no negative numbers, and AP0 has a blue below 0.
#[test]
fn negative_primaries_are_stated_by_a_profile() {
    for transfer in [Transfer::Linear, Transfer::Gamma(Decimal::new(2.6))] {
        let file = file(color(Chromaticities::ACES_AP0, transfer), &[0.5, 0.25, 0.75, 1.0]);
        let has = |name: &str| chunk(&file, name).is_some();
        assert_eq!([has("iCCP"), has("cHRM"), has("gAMA")], [true, false, false], "{transfer:?}");
        let stated = Folder::new("labels-ap0").read(&file).unwrap().stated.unwrap().primaries;
        assert!(stated.blue.y.get() < -0.05, "{stated:?}");
    }
}

#[test]
fn an_exr_states_its_primaries_and_luminance() {
    let folder = Folder::new("labels-exr");
    let neutral = Xy::new(0.34, 0.35);
    for (primaries, _) in SPACES {
        let color = Colorimetry { adopted_white: Some(neutral), ..Colorimetry::linear(primaries).nits(203.0, 1000.0) };
        let options = Encoding { color: Some(color), bits: 32, ..Encoding::EXR };
        let source = picture(3, 2);
        let bytes = encode(&source, &options).unwrap();
        for name in [&b"chromaticities\0chromaticities\0"[..], b"whiteLuminance\0float\0", b"adoptedNeutral\0v2f\0"] {
            assert!(bytes.windows(name.len()).any(|window| window == name), "{}", String::from_utf8_lossy(name));
        }
        let back = folder.read(&bytes).unwrap();
        let stated = back.stated.unwrap();
        assert_eq!((stated.primaries, stated.adopted_white), (primaries, Some(neutral)));
        assert_eq!((stated.white_nits, stated.transfer), (Some(Decimal::new(203.0)), Transfer::Linear));
        assert_eq!(back.meta.layer.white_luminance, Some(203.0));
        // The numbers are those of linear Rec.709, so white and the adopted neutral keep their place.
        let same = primaries == Chromaticities::REC709;
        assert_eq!(back.pixel(1, 1) == source.pixel(1, 1), same, "{:?}", primaries.name());
        let back = back.meta.layer.adopted_neutral.unwrap();
        assert!((back.0 - 0.34).abs() < 1e-5 && (back.1 - 0.35).abs() < 1e-5, "{back:?}");
    }
}

#[test]
fn an_adopted_neutral_is_adapted_with_the_pixels() {
    let white = Chromaticities::ACES_CG.white;
    let color = Colorimetry { adopted_white: Some(white), ..Colorimetry::linear(Chromaticities::ACES_CG) };
    let options = Encoding { color: Some(color), ..Encoding::EXR };
    let back = Folder::new("labels-neutral").read(&encode(&picture(2, 2), &options).unwrap()).unwrap();
    let found = back.meta.layer.adopted_neutral.unwrap();
    assert!((found.0 - 0.3127).abs() < 1e-5 && (found.1 - 0.3290).abs() < 1e-5, "{found:?}");
    assert_eq!(back.stated.unwrap().adopted_white, Some(white), "what the file states is kept");
}
