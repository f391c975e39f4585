//! TIFF in and out. `tests/oracles.sh` lets tifffile write and read others.

use afterimage_base::color::{Chromaticities, Colorimetry, Transfer};
use afterimage_media::{
    Alpha, Encoding, ErrorKind, Image, ImageFile, ImageFormat, Samples, Source, encode, read, read_description,
};

use super::{Folder, ODD_SIZES, message_and_hint, numbers};

const TIFF: Encoding =
    Encoding { format: ImageFormat::Tiff, dither: None, premultiplied: false, alpha: Alpha::Keep, ..Encoding::PNG };

/// Numbers from 0 to 1.
fn signals(size: (u32, u32)) -> Vec<f32> {
    numbers(size.0, size.1).iter().map(|x| (x / 32.0 + 0.5).abs().fract()).collect()
}

#[test]
fn codes_and_floats_come_back_in_every_size() {
    let folder = Folder::new("tiff-round");
    for size in ODD_SIZES {
        for bits in [8, 16, 32] {
            let signals = signals(size);
            let color =
                Colorimetry::new(Chromaticities::REC2020, if bits == 32 { Transfer::Linear } else { Transfer::Srgb });
            let encoding = Encoding { bits, color: Some(color), ..TIFF };
            let bytes = encode((size, Samples::Float(&signals)), &encoding).unwrap();
            let options =
                afterimage_media::ReadOptions { premultiplied: false, ..afterimage_media::Budget(1 << 30).into() };
            let picture = afterimage_media::read_within(&Source::file(folder.with("a.tif", &bytes)), options).unwrap();
            assert_eq!((picture.width, picture.height), size);
            let stated = picture.stated.expect("it has a profile");
            assert!(stated.primaries.close_to(&Chromaticities::REC2020, 1e-3) && stated.transfer == color.transfer);
            let matrix = Chromaticities::REC2020.conversion(&Chromaticities::REC709);
            for (found, signal) in picture.pixels.to_f32().as_chunks::<4>().0.iter().zip(signals.as_chunks::<4>().0) {
                let light = [0, 1, 2].map(|channel| color.transfer.to_light(signal[channel].into()));
                let expected = matrix * glam::DVec3::from(light);
                let tolerance = [0.012, 4e-4, 2e-4][[8, 16, 32].iter().position(|known| *known == bits).unwrap()];
                for (found, expected) in found.iter().zip(expected.to_array().into_iter().chain([signal[3].into()])) {
                    assert!((f64::from(*found) - expected).abs() < tolerance, "{bits}: {found} is not {expected}");
                }
            }
        }
    }
}

#[test]
fn floats_keep_their_bits_and_rows_make_the_same_file() {
    let folder = Folder::new("tiff-floats");
    let (size, values) = ((70, 200), numbers(70, 200));
    let color = Some(Colorimetry::linear(Chromaticities::REC709));
    let encoding = Encoding { bits: 32, color, ..TIFF };
    let bytes = encode((size, Samples::Float(&values)), &encoding).unwrap();
    let picture = read(&Source::file(folder.with("a.tif", &bytes))).unwrap();
    assert!(picture.pixels.to_f32() == values, "associated alpha and linear Rec.709 stay");
    let mut file = ImageFile::begin(&folder.file("rows.tif"), size, &encoding, None).unwrap();
    // Strips have 64 rows.
    for rows in [3, 64, 100, 33].iter().scan(0, |at, rows| Some((std::mem::replace(at, *at + rows), *rows))) {
        file.write(Samples::Float(&values[rows.0 * 280..(rows.0 + rows.1) * 280])).unwrap();
    }
    file.finish().unwrap();
    assert!(std::fs::read(folder.file("rows.tif")).unwrap() == bytes);
    let described = read_description(&Source::file(folder.file("rows.tif"))).unwrap();
    let part = &described.parts[0];
    assert_eq!((described.format, part.channels[0].samples, &*part.compression), ("TIFF", "float", "deflate"));
    let opaque = Encoding { alpha: Alpha::WhereNeeded, bits: 16, ..TIFF };
    let image = Image { size: (1, 1), samples: Samples::Float(&[0.5, 0.5, 0.5, 1.0]), meta: None, hdr: None };
    folder.with("rgb.tif", &encode(image, &opaque).unwrap());
    assert_eq!(read_description(&Source::file(folder.file("rgb.tif"))).unwrap().parts[0].channels.len(), 3);
}

/// A TIFF of gray codes of 20x18 pixels in four tiles of 16x16, with further entries of its directory.
fn tiled(more: &[(u16, u32)]) -> Vec<u8> {
    let mut bytes = b"MM\0*\0\0\0\0".to_vec();
    for tile in 0..4_u32 {
        for (y, x) in (0..16).flat_map(|y| (0..16).map(move |x| (y, x))) {
            bytes.push((tile / 2 * 160 + tile % 2 * 16 + y * 10 + x) as u8);
        }
    }
    let places: Vec<u8> = (0..4_u32).flat_map(|tile| (8 + 256 * tile).to_be_bytes()).collect();
    let lengths = 256_u32.to_be_bytes().repeat(4);
    let [at_places, at_lengths] = [bytes.len() as u32, bytes.len() as u32 + 16];
    bytes.extend(places);
    bytes.extend(lengths);
    let directory = bytes.len() as u32;
    bytes[4..8].copy_from_slice(&directory.to_be_bytes());
    let mut entries = vec![
        (256, 1, 20),
        (257, 1, 18),
        (258, 1, 8),
        (259, 1, 1),
        (262, 1, 1),
        (277, 1, 1),
        (322, 1, 16),
        (323, 1, 16),
        (324, 4, at_places),
        (325, 4, at_lengths),
    ];
    entries.extend(more.iter().map(|(tag, value)| (*tag, 1, *value)));
    entries.sort_unstable();
    bytes.extend((entries.len() as u16).to_be_bytes());
    for (tag, count, value) in entries {
        bytes.extend(tag.to_be_bytes());
        bytes.extend(4_u16.to_be_bytes());
        bytes.extend((count as u32).to_be_bytes());
        bytes.extend(value.to_be_bytes());
    }
    bytes.extend([0; 4]);
    bytes
}

#[test]
fn tiles_and_orientations_are_read_and_small_copies_are_not() {
    let folder = Folder::new("tiff-tiles");
    let picture = folder.read(&tiled(&[])).unwrap();
    assert_eq!((picture.width, picture.height), (20, 18));
    let light = |x: u32, y: u32| {
        Transfer::Srgb.to_light(f64::from((y / 16 * 160 + x / 16 * 16 + y % 16 * 10 + x % 16) as u8) / 255.0)
    };
    for (x, y) in [(0, 0), (15, 15), (16, 0), (19, 3), (2, 17), (19, 17)] {
        assert!((f64::from(picture.pixel(x, y)[1]) - light(x, y)).abs() < 1e-3, "{x} {y}");
    }
    let turned = folder.read(&tiled(&[(274, 6)])).unwrap();
    assert_eq!((turned.width, turned.height, turned.pixel(17, 0)), (18, 20, picture.pixel(0, 0)));
    let described = read_description(&Source::file(folder.with("a.tif", &tiled(&[])))).unwrap();
    assert_eq!((described.parts[0].tiles, &*described.parts[0].compression), (Some([16, 16]), "none"));
    // The first picture of a raw file of a camera.
    let error = folder.read(&tiled(&[(254, 1)])).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Unsupported);
    assert!(message_and_hint(&error).contains("a small copy of another one; save it again"), "{error}");
    for end in [4, 8, 300, 1100] {
        let error = folder.read(&tiled(&[])[..end]).unwrap_err();
        assert!(matches!(error.kind, ErrorKind::Broken | ErrorKind::Unsupported), "{end}: {error}");
    }
    let hdr = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 1000.0);
    let refused =
        encode(((1, 1), Samples::Byte(&[0; 4])), &Encoding { bits: 16, color: Some(hdr), ..TIFF }).unwrap_err();
    assert_eq!(refused.message, "no TIFF states PQ or HLG");
}
