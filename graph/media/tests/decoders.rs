//! Checks of the decoders that are features.

use afterimage_base::color::Transfer;
use afterimage_media::{Budget, ErrorKind, Picture, ReadOptions, Source, read_within};

use super::Folder;

/// The picture of a file, with straight alpha.
pub(super) fn read_apart(folder: &Folder, name: &str, file: &[u8]) -> Picture {
    let options = ReadOptions { premultiplied: false, ..Budget(1 << 30).into() };
    read_within(&Source::file(folder.with(name, file)), options).unwrap_or_else(|error| panic!("{error}"))
}

/// Compares straight and premultiplied light of a file with codes of sRGB and their alpha.
pub(super) fn check_alpha(folder: &Folder, name: &str, file: &[u8], codes: &[[u8; 4]]) {
    let apart = read_apart(folder, name, file).pixels.to_f32();
    let picture = folder.read(file).unwrap().pixels.to_f32();
    let pixels = apart.as_chunks::<4>().0.iter().zip(picture.as_chunks::<4>().0).zip(codes);
    for ((apart, multiplied), codes) in pixels {
        let alpha = f32::from(codes[3]) / 255.0;
        for channel in 0..3 {
            let light = Transfer::Srgb.to_light(f64::from(codes[channel]) / 255.0) as f32;
            assert!((apart[channel] - light).abs() < 1e-5, "{apart:?} {codes:?}");
            assert!((multiplied[channel] - light * alpha).abs() < 1e-5, "{multiplied:?} {codes:?}");
        }
        assert!((apart[3] - alpha).abs() < 1e-6 && multiplied[3] == apart[3]);
    }
}

/// Reads files that are cut at every length or have another byte at every place: they are read or refused.
pub(super) fn check_cut_and_changed<const N: usize>(folder: &Folder, files: [Vec<u8>; N]) {
    for file in files {
        for length in 12..file.len() {
            let kind = folder.read(&file[..length]).map_err(|error| error.kind);
            assert!(matches!(kind, Ok(_) | Err(ErrorKind::Broken)), "{length}: {kind:?}");
        }
        assert!(folder.read(&file[..file.len() / 2]).is_err());
        for at in 12..file.len() {
            for value in [0, 0xff, file[at] ^ 0x41] {
                let mut changed = file.clone();
                changed[at] = value;
                let _ = folder.read(&changed);
            }
        }
    }
}
