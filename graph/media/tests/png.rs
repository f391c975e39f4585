//! PNG: codes, dither, color chunks, and back to light.

use ::png::{BitDepth, ColorType, Encoder, ScaledFloat};
use afterimage_base::color::Colorimetry;
use half::f16;

use super::{Folder, ODD_SIZES};
use afterimage_media::*;

const PLAIN: Encoding = Encoding {
    bits: 8,
    alpha: Alpha::Keep,
    premultiplied: false,
    dither: None,
    color: Some(Colorimetry::SRGB),
    ..Encoding::PNG
};

fn encoded(size: (u32, u32), pixels: Samples<'_>, options: &Encoding) -> Vec<u8> {
    encode((size, pixels), options).unwrap()
}

/// Codes as another reader sees them.
fn codes(file: &[u8]) -> (ColorType, BitDepth, Vec<u8>) {
    let mut decoder = ::png::Decoder::new(std::io::Cursor::new(file));
    decoder.ignore_checksums(false);
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    bytes.truncate(info.buffer_size());
    (info.color_type, info.bit_depth, bytes)
}

#[test]
fn codes_without_dither_are_the_nearest() {
    for (width, height) in ODD_SIZES {
        let count = (width * height * 4) as usize;
        let bytes: Vec<u8> = (0..count).map(|i| (i * 7 % 256) as u8).collect();
        let floats: Vec<f32> = bytes.iter().map(|b| f32::from(*b) / 255.0 + 0.0015).collect();
        let halves: Vec<f16> = bytes.iter().map(|b| f16::from_f32(f32::from(*b) / 255.0)).collect();
        let inputs = [Samples::Byte(&bytes), Samples::Float(&floats), Samples::Half(&halves)];
        for input in inputs {
            let file = encoded((width, height), input, &PLAIN);
            assert_eq!(codes(&file), (ColorType::Rgba, BitDepth::Eight, bytes.clone()));
            let file = encoded((width, height), input, &Encoding { alpha: Alpha::Drop, ..PLAIN });
            let rgb: Vec<u8> = bytes.chunks(4).flat_map(|p| p[..3].to_vec()).collect();
            assert_eq!(codes(&file), (ColorType::Rgb, BitDepth::Eight, rgb));
        }
    }
}

#[test]
fn sixteen_bits_are_exact_and_never_dithered() {
    let values = [0.0, 1.0, 0.5, f32::NAN, 2.0, -1.0, 1.0 / 65535.0, 12345.0 / 65535.0];
    let options = Encoding { bits: 16, dither: Some(3), ..PLAIN };
    let file = encoded((2, 1), Samples::Float(&values), &options);
    let (_, depth, bytes) = codes(&file);
    let words: Vec<u16> = bytes.chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
    assert_eq!(depth, BitDepth::Sixteen);
    assert_eq!(words, [0, 65535, 32768, 0, 65535, 0, 1, 12345]);
    let file = encoded((1, 1), Samples::Byte(&[0, 255, 128, 1]), &options);
    assert_eq!(codes(&file).2, [0, 0, 255, 255, 128, 128, 1, 1]);
}

#[test]
fn dither_keeps_the_mean_and_leaves_the_ends_solid() {
    let options = Encoding { dither: Some(1), ..PLAIN };
    for value in [0.3007_f32, 0.0701, 0.9003] {
        let file = encoded((256, 256), Samples::Float(&[value; 256 * 256 * 4]), &options);
        let (_, _, bytes) = codes(&file);
        for channel in 0..3 {
            let all = bytes[channel..].iter().step_by(4).map(|code| f64::from(*code));
            let mean = all.sum::<f64>() / 65536.0;
            // The deviation of 65536 codes of deviation 1/2 is 0.002.
            assert!((mean - f64::from(value) * 255.0).abs() < 0.01, "{value}: {mean}");
        }
        let same = bytes.chunks(4).filter(|p| p[0] == p[1] && p[1] == p[2]).count();
        assert!(same < 40_000, "channels are dithered alike: {same}");
        let alpha = (f64::from(value) * 255.0).round() as u8;
        assert!(bytes.chunks(4).all(|pixel| pixel[3] == alpha));
    }
    for (value, code) in [(0.0, 0), (1.0, 255)] {
        let file = encoded((64, 64), Samples::Float(&[value; 64 * 64 * 4]), &options);
        assert!(codes(&file).2.iter().all(|c| *c == code));
    }
}

#[test]
fn rows_in_pieces_have_the_codes_of_the_whole() {
    let folder = Folder::new("png-rows");
    // Several strips, and one that is not full; the noise of sixteen bits cannot be packed.
    let (width, height) = (3001, 160);
    let noise = |i: u32| f32::from((i.wrapping_mul(2_654_435_761) >> 16) as u16) / 65535.0;
    let values: Vec<f32> = (0..4 * width as u32 * height).map(noise).collect();
    let smooth: Vec<f32> = (0..4 * width as u32 * height).map(|i| (i / 997 % 256) as f32 / 255.0).collect();
    for (bits, alpha, values) in [(8, Alpha::Drop, smooth), (16, Alpha::Keep, values)] {
        let options = Encoding { bits, alpha, dither: Some(5), ..Encoding::PNG };
        let (size, path) = ((width as u32, height), folder.file("rows.png"));
        let mut rows = ImageFile::begin(&path, size, &options, None).unwrap();
        for piece in [0..7, 7..8, 8..133, 133..160] {
            rows.write(Samples::Float(&values[4 * width * piece.start..4 * width * piece.end])).unwrap();
        }
        rows.finish().unwrap();
        let whole = encoded(size, Samples::Float(&values), &options);
        assert!(std::fs::read(path).unwrap() == whole, "{bits}: the bytes are those of the whole");
        let (codes, channels) = png_codes(size, Samples::Float(&values), &options).unwrap();
        let (_, _, bytes) = self::codes(&whole);
        let raw = channels * width * height as usize * if bits == 8 { 1 } else { 2 };
        assert!(whole.len() < raw * 1002 / 1000, "{bits}: {} of {raw} bytes", whole.len());
        let read: Vec<u16> = match bits {
            8 => bytes.iter().map(|code| u16::from(*code)).collect(),
            _ => bytes.as_chunks().0.iter().map(|code| u16::from_be_bytes(*code)).collect(),
        };
        assert!(read == codes, "{bits}: the codes are those that were written");
    }
    assert!(Encoding { alpha: Alpha::WhereNeeded, ..Encoding::PNG }.needs_all_rows());
}

#[test]
fn a_seed_decides_the_noise() {
    let gray = [0.5_f32; 64 * 64 * 4];
    let with = |seed| {
        let options = Encoding { dither: Some(seed), ..PLAIN };
        encoded((64, 64), Samples::Float(&gray), &options)
    };
    assert_eq!(with(5), with(5));
    assert_ne!(codes(&with(5)).2, codes(&with(6)).2);
    let (_, _, bytes) = codes(&with(5));
    assert_ne!(bytes[..64 * 4], bytes[64 * 4..128 * 4], "rows differ");
}

#[test]
fn alpha_is_written_where_it_is_not_one() {
    let kinds = |alpha: Alpha, values: &[f32; 8]| {
        let pixels = Samples::Float(values);
        codes(&encoded((2, 1), pixels, &Encoding { alpha, ..PLAIN })).0
    };
    let (opaque, clear) = ([0.5, 0.5, 0.5, 1.0, 0.25, 0.25, 0.25, 0.999], [0.5, 0.5, 0.5, 1.0, 0.25, 0.25, 0.25, 0.9]);
    assert_eq!(kinds(Alpha::WhereNeeded, &opaque), ColorType::Rgb, "0.999 is code 255");
    assert_eq!(kinds(Alpha::WhereNeeded, &clear), ColorType::Rgba);
    assert_eq!([kinds(Alpha::Keep, &opaque), kinds(Alpha::Drop, &clear)], [ColorType::Rgba, ColorType::Rgb]);
}

/// Mean and variance, in codes, of the error against the numbers before quantization.
fn error(values: &[f32], found: &[u8]) -> (f64, f64) {
    let errors: Vec<f64> = values.iter().zip(found).map(|(v, c)| f64::from(*c) - f64::from(*v) * 255.0).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    (mean, errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / errors.len() as f64)
}

#[test]
fn the_error_has_the_variance_of_one_quantization() {
    // A ramp over 200 codes, one number for all channels of a pixel, alpha 1.
    let (width, height) = (512_u32, 256_u32);
    let at = |pixel: u32| 0.1 + 0.8 * pixel as f32 / (width * height) as f32;
    let values: Vec<f32> = (0..width * height).flat_map(|pixel| [at(pixel), at(pixel), at(pixel), 1.0]).collect();
    let colors: Vec<f32> = values.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
    for (dither, variance) in [(Some(9), 0.25), (None, 1.0 / 12.0)] {
        let options = Encoding { dither, alpha: Alpha::WhereNeeded, ..PLAIN };
        let (_, _, found) = codes(&encoded((width, height), Samples::Float(&values), &options));
        let (mean, found) = error(&colors, &found);
        assert!(mean.abs() < 0.005 && (found - variance).abs() < 0.004, "{dither:?}: mean {mean}, variance {found}");
    }
}

#[test]
fn codes_are_read_as_linear_light() {
    let folder = Folder::new("png-light");
    let bytes = [0, 10, 11, 128, 188, 255, 64, 255];
    let picture = folder.read(&encoded((2, 1), Samples::Byte(&bytes), &PLAIN)).unwrap();
    assert_eq!(picture.pixels.bytes_per_channel(), 2);
    let [r, g, b, a] = picture.pixel(0, 0);
    // IEC 61966-2-1: 10/255 lies on the line, 11/255 on the curve.
    for (value, expected) in [(r, 0.0), (g / a, 0.0030353), (b / a, 0.0033465), (a, 0.50196)] {
        assert!((value - expected).abs() <= expected * 6e-4, "{value} is not {expected}");
    }
    assert!((picture.pixel(1, 0)[0] - 0.502886).abs() < 3e-4);
    assert_eq!(picture.pixel(1, 0)[1], 1.0);
    let options = Encoding { bits: 16, ..PLAIN };
    let values = [0.5, 0.04, 1.0, 0.25];
    let picture = folder.read(&encoded((1, 1), Samples::Float(&values), &options)).unwrap();
    assert_eq!(picture.pixels.bytes_per_channel(), 4);
    assert!((picture.pixel(0, 0)[0] - 0.25 * 0.214041).abs() < 1e-5);
}

fn written(set: impl FnOnce(&mut Encoder<'_, &mut Vec<u8>>), data: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, 2, 1);
    set(&mut encoder);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    file
}

#[test]
fn other_kinds_of_png_are_read() {
    let folder = Folder::new("png-kinds");
    let gray = written(|e| e.set_color(ColorType::Grayscale), &[255, 0]);
    assert_eq!(folder.read(&gray).unwrap().pixel(0, 0), [1.0, 1.0, 1.0, 1.0]);
    assert_eq!(folder.read(&gray).unwrap().pixel(1, 0), [0.0, 0.0, 0.0, 1.0]);
    let palette = written(
        |e| {
            e.set_color(ColorType::Indexed);
            e.set_depth(BitDepth::Four);
            e.set_palette(vec![255, 0, 0, 0, 0, 255]);
        },
        &[0x10],
    );
    assert_eq!(folder.read(&palette).unwrap().pixel(0, 0), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(folder.read(&palette).unwrap().pixel(1, 0), [1.0, 0.0, 0.0, 1.0]);
    let linear = written(
        |e| {
            e.set_color(ColorType::Grayscale);
            e.set_source_gamma(ScaledFloat::new(1.0));
        },
        &[51, 0],
    );
    assert!((folder.read(&linear).unwrap().pixel(0, 0)[0] - 0.2).abs() < 1e-4);
}

#[test]
fn chromaticities_that_describe_no_color_space_are_passed_over() {
    let folder = Folder::new("png-chromaticities");
    let collinear = ::png::SourceChromaticities::new((0.31, 0.33), (0.3, 0.3), (0.3, 0.3), (0.15, 0.06));
    let file = written(
        |e| {
            e.set_color(ColorType::Grayscale);
            e.set_source_gamma(ScaledFloat::new(0.45455));
            e.set_source_chromaticities(collinear);
        },
        &[255, 0],
    );
    let picture = folder.read(&file).unwrap();
    assert_eq!(picture.stated, Some(Colorimetry::SRGB));
    assert_eq!(picture.notes, ["its `cHRM` chunk is passed over: it describes no color space"]);
}
