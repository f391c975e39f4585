//! Which codes of a PNG become which pixels, and which chunks decide what they mean.

use ::png::{BitDepth, ColorType, Encoder};
use afterimage_base::color::{Chromaticities, Colorimetry, Decimal, Transfer};
use half::f16;

use super::Folder;
use super::labels::{chunk, crc, without};
use afterimage_media::*;

/// Light of a code by IEC 61966-2-1.
fn srgb(code: u32, last: u32) -> f32 {
    let signal = f64::from(code) / f64::from(last);
    (if signal <= 0.04045 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) }) as f32
}

fn assert_close(found: [f32; 4], expected: [f32; 4], what: &str) {
    let is_close =
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= 1e-3 * expected.abs());
    assert!(is_close, "{what}: {found:?} is not {expected:?}");
}

/// A kind of PNG, the bytes of its pixels, those of a chunk `tRNS`, and the codes that the two pixels mean.
type Layout = (ColorType, BitDepth, &'static [u8], Option<&'static [u8]>, [[u32; 4]; 2]);

/// Two pixels of every kind: what the bytes are, and which codes of red, green, blue and alpha they mean.
#[test]
fn every_kind_of_png_is_read_pixel_by_pixel() {
    use BitDepth::{Eight, Four, One, Sixteen};
    use ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
    let folder = Folder::new("layouts-png");
    let table: [Layout; 10] = [
        (Grayscale, One, &[0b0100_0000], None, [[0, 0, 0, 255], [255, 255, 255, 255]]),
        (Grayscale, Eight, &[60, 200], None, [[60, 60, 60, 255], [200, 200, 200, 255]]),
        (Grayscale, Eight, &[60, 200], Some(&[0, 60]), [[60, 60, 60, 0], [200, 200, 200, 255]]),
        (GrayscaleAlpha, Eight, &[60, 51, 200, 255], None, [[60, 60, 60, 51], [200, 200, 200, 255]]),
        (Rgb, Eight, &[10, 20, 30, 200, 100, 50], None, [[10, 20, 30, 255], [200, 100, 50, 255]]),
        (Rgba, Eight, &[10, 20, 30, 51, 200, 100, 50, 7], None, [[10, 20, 30, 51], [200, 100, 50, 7]]),
        (Indexed, Four, &[0x10], None, [[40, 50, 60, 255], [10, 20, 30, 255]]),
        (Indexed, Four, &[0x10], Some(&[51]), [[40, 50, 60, 255], [10, 20, 30, 51]]),
        (GrayscaleAlpha, Sixteen, &[1, 0, 2, 0, 3, 0, 4, 0], None, [[256, 256, 256, 512], [768, 768, 768, 1024]]),
        (
            Rgb,
            Sixteen,
            &[1, 0, 2, 0, 3, 0, 0x81, 0, 0x82, 0, 0x83, 1],
            None,
            [[256, 512, 768, 65535], [0x8100, 0x8200, 0x8301, 65535]],
        ),
    ];
    for (color, depth, bytes, trns, expected) in table {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == Indexed {
            encoder.set_palette(vec![10, 20, 30, 40, 50, 60]);
        }
        if let Some(trns) = trns {
            encoder.set_trns(trns.to_vec());
        }
        encoder.write_header().unwrap().write_image_data(bytes).unwrap();
        let picture = folder.read(&file).unwrap();
        let last = if depth == Sixteen { 65535 } else { 255 };
        let what = format!("{color:?} {depth:?} {trns:?}");
        assert_eq!(picture.pixels.bytes_per_channel(), if depth == Sixteen { 4 } else { 2 }, "{what}");
        for (x, [r, g, b, a]) in (0..).zip(expected) {
            let alpha = a as f32 / last as f32;
            let light = [srgb(r, last) * alpha, srgb(g, last) * alpha, srgb(b, last) * alpha, alpha];
            assert_close(picture.pixel(x, 0), light, &what);
        }
    }
}

/// Rows and columns of a picture that is not square, and primaries applied to halves as to floats.
#[test]
fn pixels_of_both_depths_lie_in_their_places_and_are_converted_alike() {
    let folder = Folder::new("layouts-places");
    let bytes: Vec<u8> = (0..3 * 2).flat_map(|at| [200 - at * 10, 40 + at * 20, 90, 255 - at]).collect();
    for primaries in [Chromaticities::REC709, Chromaticities::REC2020] {
        let color = Some(Colorimetry::new(primaries, Transfer::Srgb));
        for bits in [8, 16] {
            let options =
                Encoding { bits, alpha: Alpha::Keep, premultiplied: false, dither: None, color, ..Encoding::PNG };
            let picture = folder.read(&encode(((3, 2), Samples::Byte(&bytes)), &options).unwrap()).unwrap();
            assert_eq!((picture.width, picture.height), (3, 2));
            for (at, code) in bytes.as_chunks::<4>().0.iter().enumerate() {
                let [r, g, b] = [0, 1, 2].map(|channel| f64::from(srgb(code[channel].into(), 255)));
                let light = primaries.conversion(&Chromaticities::REC709) * glam::DVec3::new(r, g, b);
                let light = light * f64::from(code[3]) / 255.0;
                let found = picture.pixel(at as u32 % 3, at as u32 / 3).map(f64::from);
                let is_close = glam::DVec3::new(found[0], found[1], found[2]).abs_diff_eq(light, 1e-3);
                assert!(is_close && (found[3] - f64::from(code[3]) / 255.0).abs() < 1e-3, "{at}: {found:?}, {light}");
            }
        }
    }
}

/// The file with a chunk more, right after its header.
fn with(file: &[u8], name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [&name[..], data].concat();
    let made = [&(data.len() as u32).to_be_bytes()[..], &body, &crc(&body).to_be_bytes()].concat();
    [&file[..33], &made, &file[33..]].concat()
}

fn gray(code: u8) -> Vec<u8> {
    let options = Encoding { color: None, ..Encoding::PNG };
    encode(((1, 1), Samples::Byte(&[code, code, code, 255])), &options).unwrap()
}

#[test]
fn a_chunk_of_a_higher_priority_wins() {
    let folder = Folder::new("layouts-priority");
    let linear = with(&gray(51), b"gAMA", &100_000_u32.to_be_bytes());
    let value = |file: &[u8]| folder.read(file).unwrap().pixel(0, 0)[0];
    let is = |found: f32, expected: f32| (found - expected).abs() < 1e-4;
    assert!(is(value(&linear), 0.2));
    assert!(is(value(&with(&linear, b"sRGB", &[0])), srgb(51, 255)), "sRGB before gAMA");
    let coded = with(&with(&gray(51), b"sRGB", &[0]), b"cICP", &[1, 8, 0, 1]);
    assert!(is(value(&coded), 0.2), "cICP before sRGB");
    let mut unknown = ::png::Info::with_size(1, 1);
    unknown.color_type = ColorType::Rgb;
    unknown.icc_profile = Some(vec![7; 200].into());
    unknown.source_gamma = Some(::png::ScaledFloat::new(1.0));
    let mut file = Vec::new();
    let mut writer = Encoder::with_info(&mut file, unknown).unwrap().write_header().unwrap();
    writer.write_image_data(&[51; 3]).unwrap();
    writer.finish().unwrap();
    let picture = folder.read(&file).unwrap();
    assert!(is(picture.pixel(0, 0)[0], 0.2), "gAMA after iCCP");
    assert_eq!(picture.notes, ["its `iCCP` chunk is passed over: it is damaged, or of a kind that is not known"]);
}

#[test]
fn a_gamma_out_of_range_is_taken_as_srgb() {
    let folder = Folder::new("layouts-gamma");
    // Gamma in hundred thousandths, and the light of code 51, a fifth.
    let power = |gamma: f64| 0.2_f64.powf(1.0 / gamma) as f32;
    let table = [
        (45455, srgb(51, 255)),
        (45500, srgb(51, 255)),
        (45700, power(0.457)),
        (45200, power(0.452)),
        (55556, power(0.55556)),
        (100_000, 0.2),
        (1_000_000, power(10.0)),
        (1_000_100, srgb(51, 255)),
        (500, srgb(51, 255)),
    ];
    for (stated, light) in table {
        let file = with(&gray(51), b"gAMA", &u32::to_be_bytes(stated));
        let found = folder.read(&file).unwrap().pixel(0, 0)[0];
        assert!((found - light).abs() <= 1e-3 * light, "{stated}: {found} is not {light}");
    }
}

/// `mDCV` states the peak in steps of 0.0001 cd/m2; BT.2100 has displays up to 10000.
#[test]
fn a_peak_that_no_display_has_is_ignored() {
    let folder = Folder::new("layouts-peak");
    let volume = |peak: f64| {
        let points: Vec<u8> = [35400_u16, 14600, 8500, 39850, 6550, 2300, 15635, 16450].map(u16::to_be_bytes).concat();
        [points, ((peak * 1e4) as u32).to_be_bytes().to_vec(), 1_u32.to_be_bytes().to_vec()].concat()
    };
    for (peak, heeded) in [(100.0, true), (99.0, false), (4000.0, true), (10000.0, true), (10001.0, false)] {
        for (code, default) in [(18, Some(1000.0)), (16, None)] {
            let file = with(&with(&gray(255), b"mDCV", &volume(peak)), b"cICP", &[9, code, 0, 1]);
            let picture = folder.read(&file).unwrap();
            let expected = if heeded { Some(peak) } else { default };
            let stated = picture.stated.unwrap();
            assert_eq!(stated.peak_nits, expected.map(Decimal::new), "{code} {peak}");
            assert_eq!(stated.white_nits, Some(Decimal::new(203.0)));
            let white = if code == 18 { expected.unwrap() / 203.0 } else { 10000.0 / 203.0 };
            let found = f64::from(picture.pixel(0, 0)[1]);
            assert!((found / white - 1.0).abs() < 1e-3, "{code} {peak}: {found} is not {white}");
        }
    }
}

/// BT.2100: the light of HLG depends on the luminance of the pixel, so a pure color is darker than white.
#[test]
fn hlg_is_shown_by_luminance() {
    let folder = Folder::new("layouts-hlg");
    let color = Colorimetry::new(Chromaticities::REC2020, Transfer::Hlg).nits(203.0, 1000.0);
    let options = Encoding { bits: 16, color: Some(color), ..Encoding::PNG };
    let pixels = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0];
    let file = encode(((3, 1), Samples::Float(&pixels)), &options).unwrap();
    let picture = folder.read(&file).unwrap();
    assert_eq!(picture.pixel(0, 0), [0.0, 0.0, 0.0, 1.0]);
    // Luminance of the primaries of Rec.2020, and the first two columns of ITU-R BT.2087's matrix to Rec.709.
    for (x, luminance, to_rec709) in [(1, 0.2627_f64, 1.6605), (2, 0.6780, 1.1329)] {
        let light = luminance.powf(0.2) * 1000.0 / 203.0 * to_rec709;
        let found = f64::from(picture.pixel(x, 0)[x as usize - 1]);
        assert!((found / light - 1.0).abs() < 1e-3, "{x}: {found} is not {light}");
    }
    // The brightest channel of the brightest pixel, and the mean over all three.
    let level: Vec<f64> = chunk(&file, "cLLI")
        .unwrap()
        .as_chunks::<4>()
        .0
        .iter()
        .map(|w| f64::from(u32::from_be_bytes(*w)) / 1e4)
        .collect();
    let [red, green] = [0.2627_f64, 0.6780].map(|luminance| luminance.powf(0.2) * 1000.0);
    assert!(
        (level[0] / green - 1.0).abs() < 1e-3 && (level[1] / ((red + green) / 3.0) - 1.0).abs() < 1e-3,
        "{level:?}"
    );
}

#[test]
fn alpha_is_looked_at_in_every_kind_of_pixels() {
    let kind = |pixels: Samples<'_>, bits| {
        let options = Encoding { bits, alpha: Alpha::WhereNeeded, ..Encoding::PNG };
        encode(((2, 1), pixels), &options).unwrap()[25]
    };
    for (alpha, byte, eight, sixteen) in [(1.0, 255, 2, 2), (0.9995, 254, 2, 6), (0.5, 128, 6, 6)] {
        let floats = [0.5, 0.5, 0.5, 1.0, 0.5, 0.5, 0.5, alpha];
        let halves = floats.map(f16::from_f32);
        for (bits, expected) in [(8, eight), (16, sixteen)] {
            assert_eq!(kind(Samples::Float(&floats), bits), expected, "{alpha} {bits}");
            assert_eq!(kind(Samples::Half(&halves), bits), expected, "{alpha} {bits}");
        }
        let bytes = [9, 9, 9, 255, 9, 9, 9, byte];
        assert_eq!(kind(Samples::Byte(&bytes), 8), if byte == 255 { 2 } else { 6 }, "{byte}");
    }
}

/// Widths and heights of PNG and JPEG are not exchanged, and defaults are those that the manual states.
#[test]
fn sizes_and_defaults_are_written() {
    let file = encode(((3, 2), Samples::Byte(&[255; 24])), &Encoding::PNG).unwrap();
    let header = [0, 0, 0, 3, 0, 0, 0, 2, 8, 2, 0, 0, 0];
    assert_eq!(chunk(&file, "IHDR").unwrap(), header, "eight bits, RGB, not interlaced");
    let options = Encoding::PNG;
    assert_eq!((options.dither, options.color, options.alpha), (Some(0), Some(Colorimetry::SRGB), Alpha::Drop));
    let options = Encoding::JPEG;
    assert_eq!((options.quality, options.dither, options.color), (92, Some(0), Some(Colorimetry::SRGB)));
    let options = Encoding::EXR;
    assert_eq!((options.bits, options.alpha, options.compression), (16, Alpha::Keep, ExrCompression::Zip));
    assert_eq!(options.color, Some(Colorimetry::linear(Chromaticities::REC709)));
    let bare = without(&file, "cICP");
    assert!(chunk(&bare, "cICP").is_none() && bare.len() == file.len() - 16);
}
